"""Quantities, requirements and failures of a simulated mission, in words."""

import math
from collections.abc import Sequence

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.report.numbers import number, share
from missionplan.report.quantities import Unit, si_per_unit, span, unit_for
from missionplan.report.wording import in_words, phase_in_words
from missionplan.results.simulation import Attrition, Outcome, PhaseOutcome, RequirementOutcome

_FAILURES = {
    "not arrived": "missed arrivals",
    "anchor did not reach the seafloor": "anchors that do not reach the seafloor",
    "anchor outside the radius": "anchors outside the radius",
    "struck the seafloor": "strikes on the seafloor",
    "anchor dragged": "anchors that drag",
    "grounded in the hold": "vehicles that touch the seafloor in the hold",
    "anchor flooded before its release": "anchors that flood before their release, which sink the vehicle nose first",
    "line parted": "lines that part",
    "did not surface": "vehicles that do not surface",
    "out of energy": "empty batteries",
    "left the record of the current": "missions that leave the record of the current",
    "current faster than the vehicle": "currents faster than the vehicle",
    "ran aground": "vehicles that run aground",
    "line and vehicle longer than the water is deep": "lines too long for the depth of the water",
    "anchor too light to sink the vehicle": "anchors too light to sink the vehicle",
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
    return f"{name} {requirement.bound.replace('_', ' ')} {number(limit)}{unit.suffix}"


def _keys(outcome: Outcome, phase: str) -> Sequence[str]:
    return next((tuple(item.quantities) for item in (*outcome.phases, outcome.total) if item.name == phase), ())


def requirement_on(outcome: Outcome, phase: PhaseOutcome, key: str) -> RequirementOutcome | None:
    """Find the first requirement that limits a quantity of a phase."""
    for requirement in outcome.requirements:
        name, _, quantity = requirement.quantity.partition(".")
        if name == phase.name and requirement.bound is not None and key.startswith(f"{quantity}_"):
            return requirement
    return None
