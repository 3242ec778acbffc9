"""How sure a diagnosis is, in plain words: what else could be behind it, and what it predicts that it has not seen."""

import math

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.causes import enumerated, names, part, percent
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import CLAIM, Coverage

WORTH_TELLING = 1.0
"""Score of a cause that is not claimed from which it is told [nat]."""
_MILLION = math.log(1e6)
_ALIKE = 5e-4
"""Difference of probabilities that is rounding."""


def how_sure(diagnosis: Diagnosis) -> list[str]:
    """Write the paragraphs; the sections below them have the statistics."""
    words = [
        _among_the_tried(diagnosis),
        _not_considered(diagnosis),
        _shared_words(diagnosis),
        _held_out(diagnosis),
        _coverage_words(diagnosis.coverage),
    ]
    return [each for each in words if each]


def _among_the_tried(diagnosis: Diagnosis) -> str:
    best = diagnosis.best
    if best is None:
        return "Nothing of the catalogue could be fitted to these data."
    other = f"that none of these is behind it has a probability of {percent(diagnosis.none_of_these)}"
    if not diagnosis.causes:
        if diagnosis.verdict == "unexplained":
            return f"Of the explanations tried none fits what the data show; {other}."
        if best.score > WORTH_TELLING:
            times = f"{math.exp(best.score):.0f}" if best.score < _MILLION else "over a million"
            return (
                f"Of the explanations tried none is claimed: the likeliest, {names(best.causes)}, makes the data "
                f"{times} times more probable, and a claim needs {math.exp(CLAIM):.0f} times and "
                f"better predictions of what it has not seen. In doubt, {other}."
            )
        return f"Of the explanations tried none is needed: the data look as the mission expects. In doubt, {other}."
    if best.posterior is None:
        return f"Among the explanations tried, {names(best.causes)} fits best; {other}."
    return (
        f"Among the explanations tried, {names(best.causes)} has a probability of {percent(best.posterior)}; {other}."
    )


def _not_considered(diagnosis: Diagnosis) -> str:
    """Say that a physical cause was not weighed against errors that merely persist or scatter, where there is one."""
    descriptions = (effect for effect in diagnosis.untestable if CATALOGUE[effect].tier == "statistical")
    first = next(descriptions, None)
    if first is None or not diagnosis.causes:
        return ""
    return f"That the errors merely persist or scatter was not considered: {diagnosis.untestable[first]}."


def _shared_words(diagnosis: Diagnosis) -> str:
    """Say why sets that the data cannot separate have other probabilities in the extended mission than above."""
    best = diagnosis.best
    own = next((each for each in diagnosis.explanations if best is not None and each.causes == best.causes), None)
    if best is None or best.posterior is None or own is None or abs(own.probability - best.posterior) < _ALIKE:
        return ""
    alike = [each for each in diagnosis.explanations if abs(each.probability - own.probability) < _ALIKE]
    if len(alike) < 2:
        return ""
    equal = "both" if len(alike) == 2 else "these"
    others = enumerated([names(each.causes) for each in alike if each is not own])
    return (
        f"Such data cannot tell {names(best.causes)} from {others}, whichever it is: what speaks for one of them is "
        f"mostly how large each usually is. In the extended mission, and for the next trial, {equal} are "
        f"therefore equally probable, {percent(own.probability)} each."
    )


def _held_out(diagnosis: Diagnosis) -> str:
    best = diagnosis.best
    if not diagnosis.causes or best is None or best.held_out is None:
        return ""
    gain = best.held_out
    return (
        f"Each part of the data was left out in turn and predicted from the others: {gain.groups_improved} of "
        f"{gain.groups} parts are predicted better with what was found than without."
    )


def intervals_that_miss(coverage: Coverage | None) -> str:
    """Say in a sentence that 90 % intervals do not hold 90 %, where chance does not explain it; else nothing."""
    if coverage is None or not coverage.is_off:
        return ""
    wide = "narrow" if coverage.scale > 1.0 else "wide"
    return (
        f"Its 90 % intervals are too {wide}: they hold {part(coverage.inside / coverage.count)} of what was held out."
    )


def _coverage_words(coverage: Coverage | None) -> str:
    """Say by how much the extended mission's random errors are scaled for its intervals to hold."""
    if coverage is None or not coverage.is_off:
        return ""
    share, scaled = (part(inside / coverage.count) for inside in (coverage.inside, coverage.inside_scaled))
    return (
        f"90 % intervals hold {share} of what was held out. With random errors {coverage.scale:.2f} times as "
        f"large, as in the extended mission, they hold {scaled}: the factor is assessed on other legs than it is "
        "fitted to."
    )
