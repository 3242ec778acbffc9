"""What an answer takes for granted, on every page: in the headline where it could turn it, and in a table."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from missionplan.report.page import Page, PageSection, Table, Terminal
from missionplan.report.wording import in_words
from missionplan.results.decision import Assumption

_LEAST_CHANGE = 0.02
"""Change of P(success) below which an assumption is not said to matter."""


def with_assumptions(page: Page, assumed: Sequence[Assumption]) -> Page:
    """Tell of what is taken for granted: a page is marked good only while none of it could turn the answer."""
    if not assumed:
        return page
    words, glance, write = _turning_in_words(assumed), page.glance, page.write
    verdict = _verdict(page.verdict, assumed)

    def glanced() -> Terminal:
        shown = glance()
        return replace(shown, sentence=f"{shown.sentence}{words}", verdict=_verdict(shown.verdict, assumed))

    def written() -> list[PageSection]:
        sections = list(write())
        place = next((at for at, each in enumerate(sections) if not each.is_summary), len(sections))
        return [*sections[:place], *_section(assumed), *sections[place:]]

    return replace(page, answer=f"{page.answer}{words}", verdict=verdict, glance=glanced, write=written)


def _verdict(verdict: str, assumed: Sequence[Assumption]) -> str:
    return "undecided" if verdict == "good" and any(each.turns for each in assumed) else verdict


def _turning_in_words(assumed: Sequence[Assumption]) -> str:
    """Write which assumptions could turn the answer; nothing where none could."""
    turning = [each for each in assumed if each.turns]
    if not turning:
        return ""
    first, others = turning[0], len(turning) - 1
    words = (
        f" But this assumes that {first.what}: with {first.otherwise} it succeeds {100.0 * first.success:.0f} % of the "
        "time"
    )
    if first.missed:
        words += f" and misses what it requires of {', '.join(in_words(each) for each in first.missed)}"
    if not others:
        return f"{words}."
    return f"{words}; {others} more such {'assumption' if others == 1 else 'assumptions'} below."


def _section(assumed: Sequence[Assumption]) -> Iterator[PageSection]:
    """Tabulate them, what matters most first."""
    rows = [
        (
            each.what,
            each.otherwise,
            "" if math.isnan(each.success) else f"{100.0 * each.success:.3g}\u00a0%",
            "could not be run" if math.isnan(each.worth) else f"{100.0 * each.worth:+.2g}\u00a0%",
            "could turn the answer" if each.turns else "",
        )
        for each in assumed
    ]
    columns = ("taken for granted", "instead", "success then", "change", "")
    caption = "Each alone, on 400 trials of the same random numbers. What is not in the mission cannot be put off."
    yield PageSection(_heading(assumed), [Table(columns, rows, caption, text_columns=2)], is_summary=True)


def _heading(assumed: Sequence[Assumption]) -> str:
    """Name what the assumptions could do: turn the answer, or change P(success) most."""
    turning = sum(each.turns for each in assumed)
    if turning:
        return f"{turning} of its assumptions could turn this"
    most = max(assumed, key=lambda each: 0.0 if math.isnan(each.worth) else abs(each.worth))
    if math.isnan(most.worth) or abs(most.worth) < _LEAST_CHANGE:
        return "None of these assumptions alone could turn this"
    return f"Of its assumptions, that {most.what} matters most: {100.0 * most.worth:+.2g}\u00a0% otherwise"
