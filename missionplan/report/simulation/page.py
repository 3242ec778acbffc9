"""Report of a simulated mission: will it work, what makes it fail, and what to measure better."""

import math
from collections.abc import Iterator

from matplotlib.axes import Axes

from missionplan.errors import InputError, Problem, counted, did_you_mean, shown
from missionplan.exporters.plan_json import plan_json
from missionplan.exporters.table import waypoints_csv
from missionplan.montecarlo.statistics import wilson
from missionplan.report.anchor.drawing import hold_section
from missionplan.report.explained import (
    doubt_sections,
    explanation_in_words,
    members_in_words,
    outcome_hangs_on_doubt,
)
from missionplan.report.page import Cells, Page, PageSection, Table
from missionplan.report.plan_view import rings
from missionplan.report.quantities import quantity, reader_unit, span, with_error
from missionplan.report.simulation.figures import (
    draw_histogram,
    draw_profile,
    draw_tracks,
    draw_waterfall,
    histograms,
    mission_figure,
    moves_over_ground,
    waterfall,
)
from missionplan.report.simulation.overdue import overdue_section, search_areas_geojson
from missionplan.report.simulation.quantities import (
    LEAST_SPREAD,
    failure_in_words,
    relative_spread,
    requirement_on,
    requirements_in_words,
    requirements_section,
    sensitivity_sections,
    unit_of,
    verdict,
    worst_step,
)
from missionplan.report.simulation.tracks import track_geojson, track_kml
from missionplan.report.wording import capitalised, in_words, listed, number, percent, phase_in_words, share, shortened
from missionplan.results.entries import mapping
from missionplan.results.simulation import Outcome, PhaseOutcome

FEW = 45
"""Trials below which the least and the greatest are told, as nine in ten may not lie between them (0.95⁴⁵ = 0.1)."""
_ALWAYS_DRAWN = ("total.duration_s", "total.energy_wh")
"""Quantities whose distribution is drawn even without a requirement on them."""


def failed_section(outcome: Outcome) -> Iterator[PageSection]:
    """Name the blocks of trials that failed numerically, if any."""
    count = len(outcome.failed_blocks)
    if count:
        words = "1 block of trials" if count == 1 else f"{count} blocks of trials"
        text = "They are left out of everything on this page. Each can be run again alone:"
        yield PageSection(f"{words} failed numerically", [text, *outcome.failed_blocks], is_summary=True)


def ends_section(outcome: Outcome) -> Iterator[PageSection]:
    """Tabulate where each phase ends about its goal; nothing where nothing moves over ground."""
    if not moves_over_ground(outcome):
        return
    drawn = list(rings(outcome))
    unit = reader_unit("m", max(ring.radius for ring in drawn))
    kinds = list(dict.fromkeys(ring.name for ring in drawn))
    rows = []
    for phase in dict.fromkeys(ring.phase for ring in drawn):
        radii = {ring.name: unit.cell(ring.radius, ".3g") for ring in drawn if ring.phase == phase}
        rows.append((phase_in_words(phase), *(radii.get(kind, "") for kind in kinds)))
    caption = (
        f"Radii{unit.axis}, about the goal, of what holds that share of the trials that reach it, or of an equal area."
    )
    yield PageSection("Where the trials end", [Table(("phase", *kinds), rows, caption)])


def distributions_section(outcome: Outcome) -> PageSection:
    """Draw the distributions that matter, or name the value of a quantity that does not vary."""
    shown = [
        (phase, key)
        for phase in (outcome.total, *outcome.phases)
        for key in phase.quantities
        if requirement_on(outcome, phase, key) is not None or f"{phase.name}.{key}" in _ALWAYS_DRAWN
        if math.isfinite(phase.quantities[key].p50)
    ]
    varying = [(phase, key) for phase, key in shown if relative_spread(phase.quantities[key]) > LEAST_SPREAD]
    fixed, medians = [], []
    for phase, key in (pair for pair in shown if pair not in varying):
        value = with_error(phase.quantities[key].mean, 0.0, unit_of(outcome, phase, key))
        fixed.append(f"The {in_words(f'{phase.name}.{key}')} is {value} in every trial that reached it.")
    for key in ("duration_s", "energy_wh"):
        statistic = outcome.total.quantities.get(key)
        if statistic is not None and math.isfinite(statistic.p50):
            unit = unit_of(outcome, outcome.total, key)
            medians.append(f"{span(statistic, unit)[1]}{unit.suffix}")
    ended = outcome.total.quantities["duration_s"].count
    which = of_those_that_end(outcome, "duration_s", "") or "the missions"
    which = which if ended >= FEW else f"the {ended} trials that end"
    need = "The one trial that ends needs" if ended == 1 else f"Half of {which} need no more than"
    heading = f"{need} {' and '.join(medians)}" if medians else "No mission comes to its end"
    return PageSection(heading, [*([histograms(outcome, varying)] if varying else []), *fixed])


_FEW_STEPS = 3
"""Steps that are named though no trial fails at them."""


def attrition_section(outcome: Outcome) -> Iterator[PageSection]:
    """Draw and tabulate what is lost at each step at which any trial is; the others are named."""
    worst = worst_step(outcome)
    if worst is None:
        return
    losing = [step for step in outcome.attrition if step.lost.value > 0.0]
    spared = [failure_in_words(step.step) for step in outcome.attrition if step.lost.value == 0.0]
    none = [f"No trial fails by {listed(spared, 'or')}."] if 0 < len(spared) <= _FEW_STEPS else []
    if len(spared) > _FEW_STEPS:
        none = [f"No trial fails at any of the other {len(spared)} steps, which summary.json names."]
    rows = [(failure_in_words(step.step), percent(step.lost), percent(step.surviving)) for step in losing]
    table = [Table(("step", "lost here", "still good"), rows, "Shares of all trials.")] if len(rows) > 1 else []
    heading = f"{capitalised(failure_in_words(worst.step))} cost {percent(worst.lost)} of the trials"
    yield PageSection(heading, [waterfall(outcome), *table, *none], is_summary=True)


def quantities_section(outcome: Outcome) -> PageSection:
    """Tabulate every quantity of every phase."""
    trials = outcome.provenance.trials
    rows = []
    for phase in (*outcome.phases, outcome.total):
        for key, statistic in phase.quantities.items():
            reached = "" if statistic.count == trials else share(wilson(statistic.count, trials))
            unit = unit_of(outcome, phase, key)
            rows.append((in_words(f"{phase.name}.{key}"), *span(statistic, unit), unit.name, reached))
    least, most = ("least", "most") if trials < FEW else ("5 %", "95 %")
    columns = ("quantity", least, "50 %", most, "", "trials that reached it")
    caption = "Of the trials that reached it; means, their errors and standard deviations are in quantities.csv."
    return PageSection("Every quantity, phase by phase", [Table(columns, rows, caption)])


def page(outcome: Outcome) -> Page:
    """Build the page of a simulated mission."""
    return Page(
        title=f"Simulation: {outcome.provenance.mission or outcome.provenance.file}",
        answer=answer(outcome),
        draw=lambda: mission_figure(outcome),
        numbers=_numbers(outcome),
        write=lambda: [
            *failed_section(outcome),
            *requirements_section(outcome),
            *doubt_sections(outcome),
            *attrition_section(outcome),
            *ends_section(outcome),
            *overdue_section(outcome),
            *(hold_section(hold, alone=len(outcome.held) == 1) for hold in outcome.held),
            distributions_section(outcome),
            *sensitivity_sections(outcome),
            quantities_section(outcome),
        ],
        verdict="undecided" if verdict(outcome) != "bad" and outcome_hangs_on_doubt(outcome) else verdict(outcome),
        export=lambda: _files(outcome),
        table=lambda: _cells(outcome),
        plots={"profile": draw_profile, "tracks": draw_tracks, "waterfall": draw_waterfall, "histogram": histogram},
    )


def _cells(outcome: Outcome) -> Cells:
    """Tabulate the phases for a terminal of 80 columns."""
    rows = []
    for phase in (*outcome.phases, outcome.total):
        events = [f"{in_words(name)} {share(probability)}" for name, probability in phase.events.items()]
        ranges = (range_in_words(outcome, phase, key) for key in ("duration_s", "energy_wh"))
        rows.append((shortened(phase.label), events[0] if events else "", *ranges))
    ends = "" if outcome.provenance.trials < FEW else " (5–95 %)"
    columns = ("phase", "of the trials", f"those that end take{ends}", f"and use{ends}")
    return columns, rows


def _files(outcome: Outcome) -> dict[str, str]:
    """Return the plan where there is one, `track.geojson` and `track.kml` where the mission has an origin on Earth."""
    plan = outcome.plan
    written = {
        "waypoints.csv": waypoints_csv(plan) if plan else None,
        "plan.json": plan_json(plan) if plan else None,
        "track.geojson": track_geojson(outcome),
        "track.kml": track_kml(outcome),
        "search-areas.geojson": search_areas_geojson(outcome),
    }
    return {name: text for name, text in written.items() if text is not None}


def answer(outcome: Outcome) -> str:
    """Write how often the mission works, what fails it most, and how many requirements are met."""
    parts = (
        _success_in_words(outcome),
        "" if outcome.holds_equipment else "That is of navigation and physics: nothing breaks in it.",
        explanation_in_words(outcome),
        members_in_words(outcome.sailed, "succeeds"),
        *_anchors_in_words(outcome),
        *_holds_in_words(outcome),
        *_limits_in_words(outcome),
        requirements_in_words(outcome),
    )
    return " ".join(part for part in parts if part)


_WORTH_TELLING = 0.01
"""Share of the trials from which on the answer tells of what fails no trial."""


def _holds_in_words(outcome: Outcome) -> Iterator[str]:
    """Write how often anchors drag and hulls touch the seafloor where, for want of data, that fails no trial."""
    for hold in outcome.held:
        phase = next(phase for phase in outcome.phases if phase.name == hold.phase)
        moored, trials = phase.quantities["holding_margin"].count, outcome.provenance.trials
        dragged = wilson(moored - round(phase.events["anchor_holds"].value * trials), trials)
        grounded = phase.events["grounded"]
        where, factor = phase_in_words(hold.phase), f"with an assumed holding factor of {hold.friction:g}"
        for is_assumed, count, words in (
            (hold.friction_assumed, dragged, f"{factor} the anchor ({where}) drags"),
            (hold.centres_assumed, grounded, f"with its centres assumed the hull touches the seafloor ({where})"),
        ):
            if is_assumed and count.value > _WORTH_TELLING:
                yield f"Not counted as failures: {words} in {share(count)} of the trials."


_SURE = 0.9
"""Least P(success), by its interval, of a mission that is said to work because no trial failed: 35 trials show it."""
_LIMITS = {
    "current_faster": "the current is faster than the vehicle",
    "left_record": "the mission leaves the record of the current",
}
_BEYOND = {"hold": "; its last values are held there", "zero": "; no current is assumed there"}


def _limits_in_words(outcome: Outcome) -> Iterator[str]:
    """Write in which share of the trials the mission met a limit of the world."""
    current = mapping(mapping(outcome.provenance.data.get("site")).get("current"))
    outside = str(current.get("outside", ""))
    for limit, probability in outcome.limits.items():
        if probability.value > 0.0:
            beyond = _BEYOND.get(outside, "; such trials fail") if limit == "left_record" else ""
            yield f"In {share(probability)} of the trials {_LIMITS[limit]}{beyond}."


def _anchors_in_words(outcome: Outcome) -> Iterator[str]:
    """Write what an anchor that is sized achieves, and which anchors cannot be built."""
    for anchor in outcome.anchors:
        weight = f"{quantity(anchor.wet_weight, 'N', '.1f' if anchor.wet_weight >= 1.0 else '.2f')} wet"
        if anchor.is_sized:
            events = next(phase.events for phase in outcome.phases if phase.name == anchor.phase)
            reached = percent(events["within_radius"])
            yield (
                f"The anchor sized for the worst case of Eq. 1 ({phase_in_words(anchor.phase)}), {weight}, comes down "
                f"within the radius in {reached} of the trials."
            )
        if anchor.failures:
            reasons = "; ".join(anchor.failures)
            yield f"An anchor of {weight} ({phase_in_words(anchor.phase)}) cannot be built from its parts: {reasons}."


def _success_in_words(outcome: Outcome) -> str:
    """Write how often the mission succeeds; that it works only where it does all that it is asked."""
    success, worst = outcome.total.events["success"], worst_step(outcome)
    works, trials = verdict(outcome) in ("", "good"), outcome.provenance.trials
    none = f"none of {number(trials)} trial{'' if trials == 1 else 's'}"
    if worst is None:
        if works and success.low < _SURE:
            return (
                f"{capitalised(none)} failed, too few to say that the mission works: P(success) is {percent(success)}."
            )
        certain = f"{none} failed, so that P(success) is {percent(success)}"
        return f"This mission works: {certain}." if works else f"{_judged(outcome)}, though {certain}."
    most = "most" if worst.lost.value > 0.5 * (1.0 - success.value) else "the commonest"
    failures = f"{most} failures are {failure_in_words(worst.step)}"
    if success.value == 0.0:
        few = f"{capitalised(none)} succeeded, too few to say that the mission fails"
        return f"{f'This mission fails: {none} succeeded' if success.high < 0.5 else few}; {failures}."
    if success.high < 0.5:
        return f"This mission fails more often than not: it succeeds {percent(success)} of the time; {failures}."
    if works:
        return f"This mission works {percent(success)} of the time; {failures}."
    return f"{_judged(outcome)}; it succeeds {percent(success)} of the time, and {failures}."


def _judged(outcome: Outcome) -> str:
    """First words about a mission that cannot be said to work."""
    if not outcome.can_be_built:
        return "This mission cannot be carried out, as its anchor cannot be built"
    if verdict(outcome) == "bad":
        return "This mission does not do what is required of it"
    return "Whether this mission does what is required of it is undecided"


def _numbers(outcome: Outcome) -> list[tuple[str, str]]:
    labels = {"duration_s": "Duration", "energy_wh": "Energy"}
    scope = "" if outcome.holds_equipment else " of navigation and physics"
    shown = [(f"P(success){scope} (95 % interval)", percent(outcome.total.events["success"]))]
    for key, label in labels.items():
        statistic = outcome.total.quantities.get(key)
        if statistic is not None and math.isfinite(statistic.p50):
            whole = f"{label} of nine missions in ten{of_those_that_end(outcome, key, ', of ')}"
            if statistic.count < FEW:
                whole = f"{label} of the {counted(statistic.count, 'trial')} that end{'s' * (statistic.count == 1)}"
            shown.append((whole, range_in_words(outcome, outcome.total, key)))
    return shown


def histogram(axes: Axes, outcome: Outcome, quantity: str = "total.duration_s") -> None:
    """Draw the distribution of a quantity, such as ``moor.offset_m``, over the trials."""
    phases = {phase.name: phase for phase in (*outcome.phases, outcome.total)}
    choices = {f"{name}.{key}": (phase, key) for name, phase in phases.items() for key in phase.histograms}
    if quantity not in choices:
        problem = Problem(f"given {shown(quantity)}, expected one of {', '.join(choices)}", key="quantity")
        raise InputError([Problem(problem.message, key="quantity", hint=did_you_mean(str(quantity), choices))])
    phase, key = choices[quantity]
    draw_histogram(axes, outcome, phase, key)


def range_in_words(outcome: Outcome, phase: PhaseOutcome, key: str) -> str:
    """Write the range of nine trials in ten: ``82.4 to 88.1 min``."""
    statistic = phase.quantities.get(key)
    if statistic is None or not math.isfinite(statistic.p50):
        return "–"
    unit = unit_of(outcome, phase, key)
    low, _, high = span(statistic, unit)
    return f"{low}{unit.suffix}" if low == high else f"{low} to {high}{unit.suffix}"


def of_those_that_end(outcome: Outcome, key: str, before: str) -> str:
    """Write of which missions a quantity of the whole is: ``of the 76 % that end``; nothing where all do."""
    ended, trials = outcome.total.quantities[key].count, outcome.provenance.trials
    return f"{before}the {share(wilson(ended, trials))} that end" if 0 < ended < trials else ""
