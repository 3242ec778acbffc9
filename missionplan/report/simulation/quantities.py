"""Quantities, requirements and failures of a simulated mission: in words, in the headline, and in their section."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.report.page import PageSection, Table
from missionplan.report.quantities import Unit, si_per_unit, span, unit_for
from missionplan.report.wording import in_words, listed, number, percent, phase_in_words, share
from missionplan.results.entries import Failure
from missionplan.results.simulation import Attrition, Outcome, PhaseOutcome, RequirementOutcome

_FAILURES: Mapping[str, str] = {
    Failure.NOT_ARRIVED: "missed arrivals",
    Failure.NOT_DOWN: "anchors that do not reach the seafloor",
    Failure.OUTSIDE: "anchors outside the radius",
    Failure.STRUCK: "strikes on the seafloor",
    Failure.DRAGGED: "anchors that drag",
    Failure.GROUNDED: "vehicles that touch the seafloor in the hold",
    Failure.FLOODED_EARLY: "anchors that flood before their release, which sink the vehicle nose first",
    Failure.LINE_PARTED: "lines that part",
    Failure.NOT_SURFACED: "vehicles that do not surface",
    Failure.OUT_OF_ENERGY: "empty batteries",
    Failure.LEFT_RECORD: "missions that leave the record of the current",
    Failure.OUTRUN: "currents faster than the vehicle",
    Failure.AGROUND: "vehicles that run aground",
    Failure.ON_LAND: "vehicles that end on land",
    Failure.KEEP_OUT: "vehicles in zones to keep out of",
    Failure.EQUIPMENT: "equipment that fails",
    Failure.UNCHARTED: "missions that leave the grid of depths",
    Failure.TOO_SHALLOW: "lines too long for the depth of the water",
    Failure.TOO_LIGHT: "anchors too light to sink the vehicle",
}


LEAST_SPREAD = 1e-3
"""Standard deviation over mean below which a quantity is one value to anybody who reads it."""


def relative_spread(statistic: Statistic) -> float:
    """Standard deviation of a quantity over its mean."""
    return statistic.sd / max(abs(statistic.mean), 1e-300)


def unit_of(outcome: Outcome, phase: PhaseOutcome, key: str) -> Unit:
    """Find the unit in which to show a quantity of a phase."""
    return unit_for(phase.name, key, outcome.provenance.data, typical=phase.quantities[key].p50)


def range_in_words(outcome: Outcome, phase: PhaseOutcome, key: str) -> str:
    """Write the range of nine trials in ten: ``82.4 to 88.1 min``."""
    statistic = phase.quantities.get(key)
    if statistic is None or not math.isfinite(statistic.p50):
        return "–"
    unit = unit_of(outcome, phase, key)
    low, _, high = span(statistic, unit)
    return f"{low} to {high}{unit.suffix}"


def of_those_that_end(outcome: Outcome, key: str, before: str) -> str:
    """Write of which missions a quantity of the whole is: ``of the 76 % that end``; nothing where all do."""
    ended, trials = outcome.total.quantities[key].count, outcome.provenance.trials
    return f"{before}the {share(wilson(ended, trials))} that end" if 0 < ended < trials else ""


def worst_step(outcome: Outcome) -> Attrition | None:
    """Find the step at which most trials fail; None where none fails."""
    worst = max(outcome.attrition, key=lambda step: step.lost.value, default=None)
    return None if worst is None or worst.lost.value == 0.0 else worst


def failure_in_words(step: str) -> str:
    """Write a step at which missions fail as a plural: ``missed arrivals (ingress)``."""
    phase, _, what = step.rpartition(": ")
    words = _FAILURES.get(what, f"“{what}”")
    return f"{words} ({phase_in_words(phase)})" if phase else words


def requirement_in_words(outcome: Outcome, requirement: RequirementOutcome) -> str:
    """Write a requirement with its limit in the mission's unit: ``offset of the anchor (moor) at most 75 ft``."""
    name = in_words(requirement.quantity)
    if requirement.bound is None or requirement.limit is None:
        return name
    phase, _, quantity = requirement.quantity.partition(".")
    key = next((key for key in _keys(outcome, phase) if key.rpartition(quantity)[1]), quantity)
    unit = unit_for(phase, key, outcome.provenance.data, typical=requirement.limit)
    limit = unit(requirement.limit / si_per_unit(key))
    return f"{name} {requirement.bound_in_words} {number(limit)}{unit.suffix}"


def _keys(outcome: Outcome, phase: str) -> Sequence[str]:
    return next((tuple(item.quantities) for item in (*outcome.phases, outcome.total) if item.name == phase), ())


def requirement_on(outcome: Outcome, phase: PhaseOutcome, key: str) -> RequirementOutcome | None:
    """Find the first requirement that limits a quantity of a phase."""
    for requirement in outcome.requirements:
        name, _, quantity = requirement.quantity.partition(".")
        if name == phase.name and requirement.bound is not None and key.startswith(f"{quantity}_"):
            return requirement
    return None


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
    return f"Of its {len(items)} requirements {listed(parts)}; {_remedy(undecided)}."


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
    """Name the requirement, of several that are met, that is nearest to being missed, and what is reached of it."""
    if len(outcome.requirements) < 2:
        return "Every requirement is met"
    tight = min(outcome.requirements, key=lambda item: item.slack)
    words = f"Every requirement is met; the tightest is {requirement_in_words(outcome, tight)}"
    if tight.limit is None or tight.reached is None:
        return f"{words}, reached in {percent(tight.probability)}"
    reached = requirement_in_words(outcome, replace(tight, limit=tight.reached)).rpartition(tight.bound_in_words)[2]
    return f"{words}: {100.0 * tight.required:g} of 100 missions reach {tight.bound_in_words} {reached.strip()}"


def _met(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if item.met and not item.undecided]


def _missed(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if not item.met and not item.undecided]


def _undecided(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if item.undecided]
