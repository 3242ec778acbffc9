"""What a simulated mission's requirements come to: in the headline, its colour, and their own section."""

import math
from collections.abc import Iterator, Sequence

from missionplan.report.numbers import number, percent
from missionplan.report.page import PageSection, Table
from missionplan.report.simulation.quantities import requirement_in_words
from missionplan.results.simulation import Outcome, RequirementOutcome


def requirements_in_words(outcome: Outcome) -> str:
    """Write how many requirements are met, not met and undecided, where there are any."""
    items = outcome.requirements
    if not items:
        return ""
    met, missed, undecided = len(_met(items)), len(_missed(items)), _undecided(items)
    if not undecided:
        return f"{_decided_in_words(met, len(items))}."
    if len(items) == 1:
        return f"Whether its requirement is met is undecided; {_remedy(undecided)}."
    parts = [
        f"{count} {'is' if count == 1 else 'are'} {word}"
        for count, word in ((met, "met"), (missed, "not met"), (len(undecided), "undecided"))
        if count
    ]
    listed = ", ".join(parts[:-1]) + f" and {parts[-1]}" if len(parts) > 1 else parts[0]
    return f"Of its {len(items)} requirements {listed}; {_remedy(undecided)}."


def _decided_in_words(met: int, count: int) -> str:
    if met == count:
        all_of_them = "Both" if count == 2 else f"All {count}"
        return "Its requirement is met" if count == 1 else f"{all_of_them} requirements are met"
    if met == 0:
        none_of_them = "Neither of its" if count == 2 else f"None of its {count}"
        return "Its requirement is not met" if count == 1 else f"{none_of_them} requirements is met"
    return f"{met} of its {count} requirements {'is' if met == 1 else 'are'} met"


def _remedy(undecided: Sequence[RequirementOutcome]) -> str:
    """Write how many trials would decide the requirements that are undecided."""
    needed = [item.trials_to_decide for item in undecided]
    known = [trials for trials in needed if trials is not None]
    if len(known) < len(needed):
        return "what is reached is what is required, so that no number of trials decides"
    return f"about {_rounded_up(max(known))} trials would decide, if the share stays as it is"


def _rounded_up(trials: int) -> str:
    """Write a number of trials to two digits."""
    step = 10 ** max(len(str(trials)) - 2, 0)
    return number(float(math.ceil(trials / step) * step))


def verdict(outcome: Outcome) -> str:
    """Choose how the headline is marked: bad once a requirement is certainly missed, undecided before good.

    Bad, too, is a mission that fails more often than not, or whose anchor cannot be built.
    """
    if not outcome.can_be_built or outcome.total.events["success"].high < 0.5:
        return "bad"
    if not outcome.requirements:
        return ""
    if _missed(outcome.requirements):
        return "bad"
    return "undecided" if _undecided(outcome.requirements) else "good"


def requirements_section(outcome: Outcome) -> Iterator[PageSection]:
    """Tabulate the requirements, where there are any."""
    rows = [
        (
            requirement_in_words(outcome, item),
            percent(item.probability),
            f"{100.0 * item.required:g}\u00a0%",
            judged(item),
        )
        for item in outcome.requirements
    ]
    if rows:
        table = Table(("requirement", "reached", "required", "verdict"), rows)
        yield PageSection(_heading(outcome), [table], is_summary=True)


def judged(requirement: RequirementOutcome) -> str:
    """Write whether a requirement is met, or how many trials would decide."""
    if requirement.undecided:
        return f"undecided: {_remedy([requirement])}"
    return "met" if requirement.met else "not met"


def _heading(outcome: Outcome) -> str:
    groups = {"Not met": _missed(outcome.requirements), "Undecided": _undecided(outcome.requirements)}
    parts = [
        f"{word}: {'; '.join(requirement_in_words(outcome, item) for item in items)}"
        for word, items in groups.items()
        if items
    ]
    return ". ".join(parts) if parts else _tightest(outcome)


def _tightest(outcome: Outcome) -> str:
    """Name the requirement, of several that are met, that has the fewest trials to spare."""
    if len(outcome.requirements) < 2:
        return "Every requirement is met"
    tight = min(outcome.requirements, key=lambda item: item.margin)
    spare = f"{number(tight.margin)} of {number(tight.trials)} trials to spare"
    return f"Every requirement is met; {requirement_in_words(outcome, tight)} is the tightest, with {spare}"


def _met(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if item.met and not item.undecided]


def _missed(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if not item.met and not item.undecided]


def _undecided(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if item.undecided]
