"""How sure a diagnosis is, in plain words: what else could be behind it, and what it predicts that it has not seen."""

from missionplan.report.diagnosis.causes import names, percent
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import Coverage


def how_sure(diagnosis: Diagnosis) -> list[str]:
    """Write the paragraphs; the sections below them have the statistics."""
    words = [_among_the_tried(diagnosis), _held_out(diagnosis), _coverage_words(diagnosis.coverage)]
    return [each for each in words if each]


def _among_the_tried(diagnosis: Diagnosis) -> str:
    best = diagnosis.best
    if best is None:
        return "Nothing of the catalogue could be fitted to these data."
    other = f"that none of these is behind it has a probability of {percent(diagnosis.none_of_these)}"
    if not diagnosis.causes:
        return f"Of the explanations tried none is needed: the data look as the mission expects. In doubt, {other}."
    if best.posterior is None:
        return f"Among the explanations tried, {names(best.causes)} fits best; {other}."
    return (
        f"Among the explanations tried, {names(best.causes)} has a probability of {percent(best.posterior)}; {other}."
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


def _coverage_words(coverage: Coverage | None) -> str:
    """Say that 90 % intervals do not hold 90 %, where chance does not explain it."""
    if coverage is None or not coverage.is_off:
        return ""
    wide = "narrow" if coverage.scale > 1.0 else "wide"
    return (
        f"The mission's 90 % intervals are too {wide}: they hold {100.0 * coverage.inside / coverage.count:.0f} % of "
        f"what was held out. With random errors {coverage.scale:.2f} times as large, as in the extended mission, they "
        f"hold {100.0 * coverage.inside_scaled / coverage.count:.0f} %."
    )
