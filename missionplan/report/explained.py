"""What an answer hangs on: explanations, members of an ensemble, assumptions; and whether to find out which holds.

Words on a recommendation that was judged: the mission with it, simulated with fresh draws.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from missionplan.montecarlo.statistics import Probability
from missionplan.report.page import Page, PageSection, Table
from missionplan.report.quantities import in_reader_units, span, unit_for
from missionplan.report.simulation.quantities import requirement_in_words
from missionplan.report.wording import in_words, listed, percent, portion_in_words, share
from missionplan.results.decision import Assumption, ExplainedOutcome, MemberOutcome, differ, label
from missionplan.results.simulation import Outcome, Sensitivity

DIFFER = "Which member of the current's ensemble spoils the {}"


def members_in_words(members: Sequence[MemberOutcome], does: str) -> str:
    """Write in a sentence which member spoils what a plan `does`; empty without an ensemble."""
    if len(members) < 2:
        return ""
    worst, best = (pick(members, key=lambda member: member.good.value) for pick in (min, max))
    low, high = share(worst.good), share(best.good)
    if differ([member.good for member in members]):
        return f"It depends on the forecast: it {does} {low} of the time in {worst.name} and {high} in {best.name}."
    ends = f"{low} to {high}" if low != high else f"in {low} of the trials"
    return f"In each member of the current's ensemble it {does} as often, as far as the trials can tell ({ends})."


def members_section(members: Sequence[MemberOutcome], plan: str, good: str, note: str) -> Iterator[PageSection]:
    """Tabulate the members, the worst first; `plan` and `good` are words for the heading and a column."""
    if not members:
        return
    rows = [
        [member.name, portion_in_words(member.probability, 1), percent(member.good)]
        for member in sorted(members, key=lambda member: member.good.value)
    ]
    heading = (
        DIFFER.format(plan) if differ([member.good for member in members]) else "Members of the current's ensemble"
    )
    yield PageSection(heading, [Table(("member", "probability", good), rows, note)])


UNLIKELY = 0.05
"""Probability of an explanation or a member below which it turns no answer."""
SMALL = 0.05
"""Share of a variance below which it is not worth finding out which explanation holds."""
_COLUMNS = ("probability", "success (95 % interval)", "duration (5–95 %)", "energy (5–95 %)")
_MATTERS = ("total.success", "total.duration_s", "total.energy_wh")


def explanation_in_words(outcome: Outcome) -> str:
    """Write in a sentence whether success depends on the explanation; empty for a mission without doubts."""
    tried = sorted((case for case in outcome.explanations if case.trials), key=lambda case: case.success.value)
    if len(tried) < 2:
        return ""
    worst, best = tried[0], tried[-1]
    low, high = share(worst.success), share(best.success)
    if differ([case.success for case in tried]):
        ends = f"{low} of the time with {label(worst.causes)}, {high} with {label(best.causes)}"
        return f"It depends on which explanation holds: it succeeds {ends}."
    ends = f" ({low} to {high})" if low != high else ""
    return f"Whichever explanation holds, it succeeds as often, as far as the trials can tell{ends}."


def doubt_sections(outcome: Outcome) -> Iterator[PageSection]:
    """Tabulate explanations, and members of the current's ensemble, the worst first; say what each doubt accounts for.

    How much of the variance is due to which of them holds is told of each of the mission's doubts.
    """
    sailed = sorted(outcome.members, key=lambda case: case.success.value if case.trials else 2.0)
    is_spoilt = differ([case.success for case in sailed if case.trials])
    heading = DIFFER.format("mission") if is_spoilt else "Members of the current's ensemble"
    explains = "Each trial draws which explanation holds; a row has the trials in which it does."
    sails = "Each trial sails in one member of the ensemble; a row has the trials that sail in it."
    doubts: tuple[tuple[str, str, Sequence[ExplainedOutcome], str, str], ...] = (
        ("Which explanation holds", "explanation", outcome.explanations, "cause", explains),
        (heading, "member", sailed, "member", sails),
    )
    for title, column, cases, what, note in doubts:
        places = dict.fromkeys(case.place for case in cases)
        influences = [
            [s for s in outcome.sensitivities if s.source == place and s.output in _MATTERS] for place in places
        ]
        words, rows = [_worth(outcome, influence, what) for influence in influences if influence], []
        for case in cases:
            ranges = []
            for key, statistic in (("duration_s", case.duration), ("energy_wh", case.energy)):
                unit = unit_for("total", key, outcome.provenance.data, typical=statistic.p50)
                low, _, high = span(statistic, unit)
                ranges.append("–" if not statistic.count else f"{low} to {high}{unit.suffix}")
            name = case.causes[0] if column == "member" else label(case.causes)
            rows.append((name, portion_in_words(case.probability, 1), percent(case.success), *ranges))
        if rows:
            yield PageSection(title, [*words, Table((column, *_COLUMNS), rows, note)])


def _worth(outcome: Outcome, sensitivities: list[Sensitivity], what: str) -> str:
    """Say for which share of the variance it matters which explanation holds, and whether to find out."""
    shares = []
    for sensitivity in sensitivities:
        shares.append(
            f"{portion_in_words(sensitivity.first_order)} of the variance of the {in_words(sensitivity.output)}"
        )
    words = f"Which {what} it is accounts for {listed(shares)}"
    if all(sensitivity.first_order < SMALL for sensitivity in sensitivities) and not outcome_hangs_on_doubt(outcome):
        return f"{words}: no need to find out."
    return f"{words}: find out what you can before you rely on the plan."


def hangs_on_doubt(
    whole: Probability, doubts: Sequence[tuple[float, Probability]], required: float | None = None
) -> bool:
    """Whether an explanation or a member of an ensemble could turn the answer, as an assumption could.

    `whole`: how often it does well over all of them. `doubts`: how likely each is, and how often it does well then.
    `required`: of that; None where nothing is.
    """
    for likely, rate in doubts:
        missed = ("",) if required is not None and rate.value < required <= whole.value else ()
        put_off = Assumption("", "", rate.value - whole.value, rate.value, missed, is_required=required is not None)
        if put_off.turns and likely >= UNLIKELY and differ([rate, whole]):
            return True
    return False


def outcome_hangs_on_doubt(outcome: Outcome | None) -> bool:
    """Whether a simulated mission's success does."""
    if outcome is None:
        return False
    required = [item.required for item in outcome.requirements if item.quantity == "total.success"]
    doubts = [(case.probability, case.success) for case in (*outcome.explanations, *outcome.members) if case.trials]
    return hangs_on_doubt(outcome.total.events["success"], doubts, max(required, default=None))


def what_would_tell(explanations: Sequence[object]) -> str:
    """Say what settles a doubt: which explanation holds where there are some, else a forecast of one mind."""
    return "find out which explanation holds" if explanations else "take a forecast whose members agree"


def first_do(judged: Outcome | None, phase: str) -> str | None:
    """Say what is to be done before a choice for a phase is an order: None where it may be one, empty where unknown.

    It may be one where what is required of the phase is met, come what may. What fails of the whole because another
    phase fails is told, and hangs on no choice for this one.
    """
    if judged is None:
        return None
    groups = [({item.phase for item in judged.requirements if not item.met}, "")]
    groups += [(assumption.turned, assumption.first and f" first {assumption.first};") for assumption in judged.assumed]
    return next((first for phases, first in groups if phase in phases or phases == {"total"}), None)


_TELLING = 0.8
"""Share of the trials that arrive, by its interval, below which so few trials are no ground for an order."""


def too_few(arrived: Probability) -> str:
    """Say to run more trials before choosing legs with which these arrive; empty where they are enough."""
    return " first run more trials;" if arrived.low < _TELLING else ""


def works(judged: Outcome | None) -> bool:
    """Whether a mission meets what it requires and succeeds as often as not; so too where nothing was judged."""
    return judged is None or (judged.requirements_met and judged.total.events["success"].value >= 0.5)


def judged_in_words(judged: Outcome | None) -> str:
    """Write which of the mission's requirements are met on fresh draws; nothing for a mission that requires nothing."""
    if judged is None:
        return ""
    if judged.requirements_met and not works(judged):
        success = percent(judged.total.events["success"])
        return f" But the mission with it fails more often than not: on fresh draws it succeeds in {success}."
    below = [item for item in judged.requirements if not item.met]
    missed = [item for item in below if not item.undecided]
    if not below:
        if not (count := len(judged.requirements)):
            return ""
        met = {1: "its requirement", 2: "both requirements"}.get(count, f"all {count} requirements")
        return f" The mission with it meets {met} on fresh draws."
    words = "; ".join(
        f"{requirement_in_words(judged, item)} in {percent(item.probability)}, "
        f"{100.0 * item.required:g}\u00a0% required"
        for item in missed or below
    )
    if not missed:
        return f" But whether the mission with it meets what is required is undecided on fresh draws: {words}."
    many = "a requirement" if len(missed) == 1 else f"{len(missed)} requirements"
    return f" But the mission with it misses {many} on fresh draws: {words}."


_LEAST_CHANGE = 0.02
"""Change of P(success) below which an assumption is not said to matter."""


def with_assumptions(page: Page, assumed: Sequence[Assumption]) -> Page:
    """Tell of what is taken for granted: a page is undecided while any of it could turn the answer.

    What is bad already turns by that alone without which it would not be.
    """
    if not assumed:
        return page
    is_bad = page.verdict == "bad"
    turning = [assumption for assumption in assumed if (assumption.mends if is_bad else assumption.turns)]
    words, write = _turning_in_words(turning), page.write

    def written() -> list[PageSection]:
        sections = list(write())
        place = next((at for at, section in enumerate(sections) if not section.is_summary), len(sections))
        return [*sections[:place], *_section(assumed, turning), *sections[place:]]

    return replace(
        page,
        answer=f"{page.answer}{words}",
        sentence=page.sentence and f"{page.sentence}{words}",
        verdict="undecided" if turning and not is_bad else page.verdict,
        write=written,
    )


def _turning_in_words(turning: Sequence[Assumption]) -> str:
    """Write which assumptions could turn the answer; nothing where none could."""
    if not turning:
        return ""
    first, others = turning[0], len(turning) - 1
    fails = "fails more often than not: it " if first.success < 0.5 and not first.missed else ""
    words = (
        f" But this assumes that {first.what}: with {in_reader_units(first.otherwise)} it {fails}succeeds "
        f"{100.0 * first.success:.3g} % of the time"
    )
    if first.missed:
        words += f" and misses what is required of {listed([in_words(name) for name in first.missed])}"
    if not others:
        return f"{words}."
    return f"{words}; {others} more such {'assumption' if others == 1 else 'assumptions'} below."


def _section(assumed: Sequence[Assumption], turning: Sequence[Assumption]) -> Iterator[PageSection]:
    """Tabulate them, what matters most first."""
    rows = []
    for assumption in assumed:
        then = "" if math.isnan(assumption.success) else f"{100.0 * assumption.success:.3g}\u00a0%"
        change = f"{100.0 * assumption.worth:+.3g}\u00a0%" if assumption.worth else "none"
        change = "could not be run" if math.isnan(assumption.worth) else change
        rows.append(
            (
                assumption.what,
                in_reader_units(assumption.otherwise),
                then,
                change,
                "could turn the answer" if assumption in turning else "",
            )
        )
    columns = ("taken for granted", "instead", "success then", "change", "")
    caption = "Each alone, on 400 trials of the same random numbers. What is not in the mission cannot be put off."
    yield PageSection(_heading(assumed, len(turning)), [Table(columns, rows, caption, text_columns=2)], is_summary=True)


def _heading(assumed: Sequence[Assumption], turning: int) -> str:
    """Name what the assumptions could do: turn the answer, or change P(success) most."""
    if turning:
        return f"{turning} of its assumptions could turn this"
    most = max(assumed, key=lambda assumption: 0.0 if math.isnan(assumption.worth) else abs(assumption.worth))
    if math.isnan(most.worth) or abs(most.worth) < _LEAST_CHANGE:
        of_those_tried = (
            ", of those that could be tried," if any(math.isnan(assumption.worth) for assumption in assumed) else ""
        )
        return f"None of these assumptions alone{of_those_tried} could turn this"
    return f"Of its assumptions, that {most.what} matters most: {100.0 * most.worth:+.3g}\u00a0% otherwise"
