"""Report of a simulated mission: will it work, what makes it fail, and what to measure better."""

import math
from collections.abc import Iterator, Mapping

from missionplan.report.geography.geojson import track_geojson
from missionplan.report.geography.kml import track_kml
from missionplan.report.numbers import number, percent, share
from missionplan.report.page import Page, Terminal
from missionplan.report.simulation import sections
from missionplan.report.simulation.figures import waterfall
from missionplan.report.simulation.quantities import failure_in_words, range_in_words, worst_step
from missionplan.report.simulation.requirements import requirements_in_words, requirements_section, verdict
from missionplan.report.simulation.sensitivities import sensitivity_sections
from missionplan.report.wording import in_words
from missionplan.results.simulation import Outcome


def page(outcome: Outcome) -> Page:
    """Build the page of a simulated mission."""
    return Page(
        title=f"Simulation: {outcome.provenance.mission or outcome.provenance.file}",
        answer=answer(outcome),
        figure=waterfall(outcome),
        numbers=_numbers(outcome),
        sections=[
            *sections.failed_blocks(outcome),
            *requirements_section(outcome),
            sections.tracks(outcome),
            sections.timeline(outcome),
            sections.distributions(outcome),
            *sensitivity_sections(outcome),
            sections.attrition(outcome),
            sections.quantities(outcome),
        ],
        verdict=verdict(outcome),
        files=_files(outcome),
    )


def terminal(outcome: Outcome) -> Terminal:
    """Build the terminal's view: the answer, and one row per phase that fits 80 columns."""
    rows = []
    for phase in (*outcome.phases, outcome.total):
        events = [f"{in_words(name)} {share(probability)}" for name, probability in phase.events.items()]
        ranges = (range_in_words(outcome, phase, key) for key in ("duration_s", "energy_wh"))
        rows.append((phase.name, events[0] if events else "", *ranges))
    columns = ("phase", "of the trials", "duration (5–95 %)", "energy (5–95 %)")
    return Terminal(answer(outcome), columns, rows, verdict=verdict(outcome))


def _files(outcome: Outcome) -> dict[str, str]:
    """Return `track.geojson` and `track.kml` where the mission has an origin on Earth."""
    written = {"track.geojson": track_geojson(outcome), "track.kml": track_kml(outcome)}
    return {name: text for name, text in written.items() if text is not None}


def answer(outcome: Outcome) -> str:
    """Write how often the mission works, what fails it most, and how many requirements are met."""
    parts = (_success_in_words(outcome), *_limits_in_words(outcome), requirements_in_words(outcome))
    return " ".join(part for part in parts if part)


_LIMITS = {
    "current_faster": "the current is faster than the vehicle",
    "left_record": "the mission leaves the record of the current",
}
_BEYOND = {"hold": "; its last values are held there", "zero": "; no current is assumed there"}


def _limits_in_words(outcome: Outcome) -> Iterator[str]:
    """Write in which share of the trials the mission met a limit of the world."""
    site = outcome.provenance.data.get("site")
    current = site.get("current") if isinstance(site, Mapping) else None
    outside = str(current.get("outside", "")) if isinstance(current, Mapping) else ""
    for limit, probability in outcome.limits.items():
        if probability.value > 0.0:
            beyond = _BEYOND.get(outside, "; such trials fail") if limit == "left_record" else ""
            yield f"In {share(probability)} of the trials {_LIMITS[limit]}{beyond}."


def _success_in_words(outcome: Outcome) -> str:
    success = outcome.total.events["success"]
    worst = worst_step(outcome)
    if worst is None:
        trials = number(outcome.provenance.trials)
        return f"This mission works: none of {trials} trials failed, so that P(success) is {percent(success)}."
    most = "most" if worst.lost.value > 0.5 * (1.0 - success.value) else "the commonest"
    return f"This mission works {percent(success)} of the time; {most} failures are {failure_in_words(worst.step)}."


def _numbers(outcome: Outcome) -> list[tuple[str, str]]:
    labels = {"duration_s": "Duration of nine missions in ten", "energy_wh": "Energy of nine missions in ten"}
    shown = [("Mission succeeds (95 % interval)", percent(outcome.total.events["success"]))]
    for key, label in labels.items():
        statistic = outcome.total.quantities.get(key)
        if statistic is not None and math.isfinite(statistic.p50):
            shown.append((label, range_in_words(outcome, outcome.total, key)))
    return shown
