"""Sections of the report of a simulated mission."""

import math
from collections.abc import Iterator

from missionplan.montecarlo.statistics import wilson
from missionplan.report.geography.plan_view import Ring, rings
from missionplan.report.numbers import has_spread, number, percent, share
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import reader_unit, span, with_error
from missionplan.report.simulation.close_ups import close_ups
from missionplan.report.simulation.figures import timeline_figure
from missionplan.report.simulation.histograms import histogram_figure
from missionplan.report.simulation.maps import track_map
from missionplan.report.simulation.quantities import (
    LEAST_SPREAD,
    failure_in_words,
    of_those_that_end,
    range_in_words,
    relative_spread,
    requirement_on,
    unit_of,
    worst_step,
)
from missionplan.report.wording import capitalised, in_words, phase_in_words
from missionplan.results.simulation import Outcome, PhaseOutcome

_ALWAYS_DRAWN = {"moor": ("offset_m", "lowest_altitude_m", "nose_altitude_m"), "total": ("duration_s", "energy_wh")}
"""Quantities whose distribution is drawn even without a requirement on them, by kind of phase."""


def failed_blocks(outcome: Outcome) -> Iterator[PageSection]:
    """Name the blocks of trials that failed numerically, if any."""
    count = len(outcome.failed_blocks)
    if count:
        words = "1 block of trials" if count == 1 else f"{count} blocks of trials"
        text = "They are left out of everything on this page. Each can be run again alone:"
        yield PageSection(f"{words} failed numerically", [text, *outcome.failed_blocks], is_summary=True)


def tracks(outcome: Outcome) -> Iterator[PageSection]:
    """Draw the tracks from above, and where each phase ends about its goal; nothing where nothing moves over ground."""
    if all(radius == 0.0 for _, radius in outcome.tracks.targets.values()):
        return
    drawn = list(rings(outcome))
    unit = reader_unit("m", max(ring.radius for ring in drawn))
    rows = [(phase_in_words(ring.phase), ring.kind, _share(ring), unit.cell(ring.radius, ".3g")) for ring in drawn]
    caption = "Circles are about the goal; for an ellipse, the radius of the circle of equal area."
    table = Table(("phase", "line", "holds", f"radius{unit.axis}"), rows, caption, text_columns=2)
    close = close_ups(outcome)
    figures: list[Block] = [track_map(outcome), *([close] if close else [])]
    yield PageSection("Where the trials end", [*figures, table])


def _share(ring: Ring) -> str:
    return "" if math.isnan(ring.share) else f"{100.0 * ring.share:.0f}\u00a0%"


def timeline(outcome: Outcome) -> PageSection:
    """Draw when each phase begins and ends."""
    duration = range_in_words(outcome, outcome.total, "duration_s")
    which = of_those_that_end(outcome, "duration_s", " of ")
    return PageSection(f"Nine missions in ten{which} take {duration}", [timeline_figure(outcome)])


def distributions(outcome: Outcome) -> PageSection:
    """Draw the distributions that matter, or name the value of a quantity that does not vary."""
    blocks = [
        _distribution(outcome, phase, key)
        for phase in (outcome.total, *outcome.phases)
        for key in phase.quantities
        if _is_drawn(outcome, phase, key)
    ]
    blocks.sort(key=lambda block: isinstance(block, str))  # figures side by side on paper, sentences below
    which = of_those_that_end(outcome, "duration_s", "") or "the missions"
    return PageSection(f"Half of {which} need no more than {_medians(outcome)}", blocks)


def _is_drawn(outcome: Outcome, phase: PhaseOutcome, key: str) -> bool:
    matters = requirement_on(outcome, phase, key) is not None or key in _ALWAYS_DRAWN.get(phase.kind, ())
    return matters and math.isfinite(phase.quantities[key].p50)


def _distribution(outcome: Outcome, phase: PhaseOutcome, key: str) -> Block:
    statistic = phase.quantities[key]
    if relative_spread(statistic) > LEAST_SPREAD:
        return histogram_figure(outcome, phase, key)
    value = with_error(statistic.mean, 0.0, unit_of(outcome, phase, key))
    return f"The {in_words(f'{phase.name}.{key}')} is {value} in every trial that reached it."


def _medians(outcome: Outcome) -> str:
    parts = []
    for key in ("duration_s", "energy_wh"):
        statistic = outcome.total.quantities.get(key)
        if statistic is not None and math.isfinite(statistic.p50):
            unit = unit_of(outcome, outcome.total, key)
            parts.append(f"{span(statistic, unit)[1]}{unit.suffix}")
    return " and ".join(parts)


def attrition(outcome: Outcome) -> PageSection:
    """Tabulate what is lost at each step."""
    rows = [(step.step, percent(step.lost), percent(step.surviving)) for step in outcome.attrition]
    worst = worst_step(outcome)
    heading = "No trial failed"
    if worst is not None:
        heading = f"{capitalised(failure_in_words(worst.step))} cost {percent(worst.lost)} of the trials"
    return PageSection(heading, [Table(("step", "lost here", "still good"), rows, "Shares of all trials.")])


def quantities(outcome: Outcome) -> PageSection:
    """Tabulate every quantity of every phase."""
    trials = outcome.provenance.trials
    rows = [
        (in_words(f"{phase.name}.{key}"), share(wilson(statistic.count, trials)), *_statistic(outcome, phase, key))
        for phase in (*outcome.phases, outcome.total)
        for key, statistic in phase.quantities.items()
    ]
    columns = ("quantity", "trials that reached it", "their mean ± standard error", "sd", "5 %", "50 %", "95 %")
    return PageSection("Every quantity, phase by phase", [Table(columns, rows)])


def _statistic(outcome: Outcome, phase: PhaseOutcome, key: str) -> tuple[str, ...]:
    statistic = phase.quantities[key]
    unit = unit_of(outcome, phase, key)
    mean = with_error(statistic.mean, statistic.standard_error, unit)
    sd = statistic.sd if has_spread(statistic.mean, statistic.sd) else 0.0
    return mean, number(unit(sd), unit(0.1 * sd)), *span(statistic, unit)
