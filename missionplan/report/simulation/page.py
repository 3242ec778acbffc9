"""Report of a simulated mission: will it work, what spoils it, and what to measure better."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby

from missionplan.montecarlo.statistics import Probability
from missionplan.report.geography.geojson import track_geojson
from missionplan.report.geography.kml import track_kml
from missionplan.report.geography.plan_view import rings
from missionplan.report.numbers import has_spread, number, percent, plain, si_per_unit, span, unit_for, with_error
from missionplan.report.page import Block, Page, PageSection, Table, Terminal
from missionplan.report.simulation.figures import histogram_figure, sensitivity_bars, timeline, waterfall
from missionplan.report.simulation.maps import close_ups, track_map
from missionplan.results.simulation import Outcome, PhaseOutcome, RequirementOutcome, Sensitivity

_FAILURES = {
    "not arrived": "missed arrivals",
    "anchor did not reach the seafloor": "anchors that do not reach the seafloor",
    "anchor outside the radius": "anchors outside the radius",
    "struck the seafloor": "strikes on the seafloor",
    "did not surface": "vehicles that do not surface",
    "out of energy": "empty batteries",
}
_SHOWN = {"moor": ("offset_m", "lowest_altitude_m"), "total": ("duration_s", "energy_wh")}
"""Quantities whose distribution is always drawn, by kind of phase."""
_MOST_INPUTS = 5
_MOST_FIGURES = 4
_LEAST_SHOWN = 0.01


def page(outcome: Outcome) -> Page:
    """Lay out the report."""
    sections = [
        *_failed_blocks(outcome),
        *_requirements(outcome),
        _map(outcome),
        _timeline(outcome),
        _distributions(outcome),
        *_sensitivities(outcome),
        _attrition(outcome),
        _quantities(outcome),
    ]
    return Page(
        title=f"Simulation: {outcome.provenance.mission or outcome.provenance.file}",
        answer=f"{_answer(outcome)} {_judgement(outcome)}".strip(),
        figure=waterfall(outcome),
        numbers=_numbers(outcome),
        sections=sections,
        verdict=_verdict(outcome),
    )


def terminal(outcome: Outcome) -> Terminal:
    """Give the answer, and a row a phase that fits 80 columns."""
    rows = []
    for phase in (*outcome.phases, outcome.total):
        events = [f"{plain(name)} {_short(probability)}" for name, probability in phase.events.items()]
        ranges = (_range(outcome, phase, key) for key in ("duration_s", "energy_wh"))
        rows.append((phase.name, events[0] if events else "", *ranges))
    sentence = f"{_answer(outcome)} {_judgement(outcome)}".strip()
    return Terminal(sentence, ("phase", "of the trials", "duration (5–95 %)", "energy (5–95 %)"), rows)


def _short(probability: Probability) -> str:
    """Write a probability without its interval, never rounded to certainty."""
    value = 100.0 * probability.value
    return f"{value:.0f}\u00a0%" if value in (0.0, 100.0) else f"{min(max(value, 0.01), 99.99):.4g}\u00a0%"


def files(outcome: Outcome) -> dict[str, str]:
    """Give `track.geojson` and `track.kml`, when the mission says where on Earth it is."""
    written = {"track.geojson": track_geojson(outcome), "track.kml": track_kml(outcome)}
    return {name: text for name, text in written.items() if text is not None}


def _answer(outcome: Outcome) -> str:
    success = outcome.total.events["success"]
    works = f"This mission works {percent(success)} of the time"
    worst = max(outcome.attrition, key=lambda step: step.lost.value, default=None)
    if worst is None or worst.lost.value == 0.0:
        trials = number(outcome.provenance.trials)
        return f"This mission works: none of {trials} trials failed, so that P(success) is {percent(success)}."
    most = "most" if worst.lost.value > 0.5 * (1.0 - success.value) else "the commonest"
    return f"{works}; {most} failures are {_failure(worst.step)}."


def _failure(step: str) -> str:
    phase, _, what = step.rpartition(": ")
    words = _FAILURES.get(what, f"“{what}”")
    return f"{words} ({phase})" if phase else words


def _judgement(outcome: Outcome) -> str:
    """Say how many requirements are met, where there are any."""
    count, met = len(outcome.requirements), sum(requirement.met for requirement in outcome.requirements)
    if not count:
        return ""
    if met == count:
        words = "Its requirement is met" if count == 1 else f"All {count} requirements are met"
    elif met == 0:
        words = "Its requirement is not met" if count == 1 else f"None of its {count} requirements is met"
    else:
        words = f"{met} of its {count} requirements {'is' if met == 1 else 'are'} met"
    undecided = sum(requirement.undecided for requirement in outcome.requirements)
    more = f"; for {undecided} of them more trials would be needed to tell" if undecided else ""
    return f"{words}{more}."


def _verdict(outcome: Outcome) -> str:
    if not outcome.requirements:
        return ""
    return "good" if outcome.requirements_met else "bad"


def _numbers(outcome: Outcome) -> list[tuple[str, str]]:
    shown = [("Mission succeeds (95 % interval)", percent(outcome.total.events["success"]))]
    for key, label in (("duration_s", "Duration, nine in ten"), ("energy_wh", "Energy, nine in ten")):
        if key in outcome.total.quantities:
            shown.append((label, _range(outcome, outcome.total, key)))
    return shown


def _range(outcome: Outcome, phase: PhaseOutcome, key: str) -> str:
    """Write the range of nine trials in ten."""
    statistic = phase.quantities.get(key)
    if statistic is None or not math.isfinite(statistic.p50):
        return "–"
    unit = unit_for(phase.name, key, outcome.provenance.data, typical=statistic.p50)
    low, _, high = span(statistic, unit)
    return f"{low} to {high}{unit.suffix}"


def _failed_blocks(outcome: Outcome) -> Iterator[PageSection]:
    count = len(outcome.failed_blocks)
    if count:
        words = "1 block of trials" if count == 1 else f"{count} blocks of trials"
        text = "They are left out of everything on this page. Each may be run again alone:"
        yield PageSection(f"{words} failed numerically", [text, *outcome.failed_blocks])


def _requirements(outcome: Outcome) -> Iterator[PageSection]:
    if outcome.requirements:
        rows = [
            (_in_words(outcome, item), judged(item), f"{100.0 * item.required:g}\u00a0%", percent(item.probability))
            for item in outcome.requirements
        ]
        yield PageSection(
            _requirements_heading(outcome),
            [Table(("requirement", "verdict", "asked", "reached"), rows, words=2)],
        )


def _requirements_heading(outcome: Outcome) -> str:
    missed = [_in_words(outcome, item) for item in outcome.requirements if not item.met]
    if not missed:
        return "Every requirement is met"
    return f"Not met: {'; '.join(missed)}"


def _in_words(outcome: Outcome, requirement: RequirementOutcome) -> str:
    name = plain(requirement.quantity)
    if requirement.bound is None or requirement.limit is None:
        return name
    phase, _, quantity = requirement.quantity.partition(".")
    key = next((key for key in _keys(outcome, phase) if key.rpartition(quantity)[1]), quantity)
    unit = unit_for(phase, key, outcome.provenance.data, typical=requirement.limit)
    limit = unit(requirement.limit / si_per_unit(key))
    return f"{name} {requirement.bound.replace('_', ' ')} {number(limit)}{unit.suffix}"


def judged(requirement: RequirementOutcome) -> str:
    """Give the verdict in words."""
    words = "met" if requirement.met else "not met"
    return f"{words}, but undecided" if requirement.undecided else words


def _keys(outcome: Outcome, phase: str) -> Sequence[str]:
    return next((tuple(item.quantities) for item in (*outcome.phases, outcome.total) if item.name == phase), ())


def _map(outcome: Outcome) -> PageSection:
    outer = [ring for ring in rings(outcome) if ring.kind == "CEP" and ring.share == 0.95]
    heading = "Where the trials go"
    if outer:
        allowed = {name: radius for name, (_, radius) in outcome.tracks.targets.items()}
        tight = max(outer, key=lambda ring: ring.radius / allowed[ring.phase])
        heading = (
            f"{_sentence(tight.phase)} is the tightest: 95\u00a0% end within {tight.radius:.3g}\u00a0m of the goal, "
            f"{allowed[tight.phase]:.3g}\u00a0m are allowed"
        )
    rows = [
        (
            ring.phase,
            ring.kind,
            "" if math.isnan(ring.share) else f"{100.0 * ring.share:.0f}\u00a0%",
            f"{ring.radius:.3g}",
        )
        for ring in rings(outcome)
    ]
    caption = "Circles about the goal; of an ellipse, the radius of the circle of equal area."
    close = close_ups(outcome)
    figures: list[Block] = [track_map(outcome), *([close] if close else [])]
    return PageSection(heading, [*figures, Table(("phase", "line", "holds", "radius (m)"), rows, caption, words=2)])


def _timeline(outcome: Outcome) -> PageSection:
    return PageSection(f"Nine missions in ten take {_range(outcome, outcome.total, 'duration_s')}", [timeline(outcome)])


def _distributions(outcome: Outcome) -> PageSection:
    drawn: list[Block] = []
    for phase in (outcome.total, *outcome.phases):
        for key, statistic in phase.quantities.items():
            found = next((item for item in outcome.requirements if _is_on(item, phase, key)), None)
            if not math.isfinite(statistic.p50) or (found is None and key not in _SHOWN.get(phase.kind, ())):
                continue
            if has_spread(statistic.mean, statistic.sd):
                drawn.append(histogram_figure(phase, key, outcome, found))
            else:
                unit = unit_for(phase.name, key, outcome.provenance.data, typical=statistic.p50)
                value = with_error(statistic.mean, 0.0, unit)
                drawn.append(f"{_sentence(plain(f'{phase.name}.{key}'))} is {value} in every trial that came so far.")
    return PageSection(f"Half of the missions are over within {_median(outcome)}", drawn)


def _is_on(requirement: RequirementOutcome, phase: PhaseOutcome, key: str) -> bool:
    name, _, quantity = requirement.quantity.partition(".")
    return name == phase.name and requirement.bound is not None and key.startswith(f"{quantity}_")


def _median(outcome: Outcome) -> str:
    parts = []
    for key in ("duration_s", "energy_wh"):
        statistic = outcome.total.quantities.get(key)
        if statistic is not None:
            unit = unit_for("total", key, outcome.provenance.data, typical=statistic.p50)
            parts.append(f"{span(statistic, unit)[1]}{unit.suffix}")
    return " and ".join(parts)


def _sensitivities(outcome: Outcome) -> Iterator[PageSection]:
    groups = [
        (output, [influence for influence in found if influence.first_order > 2.0 * influence.standard_error])
        for output, found in groupby(outcome.sensitivities, key=lambda influence: influence.output)
    ]
    groups = [(output, found[:_MOST_INPUTS]) for output, found in groups if found]
    if not groups:
        return
    asked = tuple(item.quantity for item in outcome.requirements)
    # What the mission is judged by comes first, then what it costs as a whole.
    pictured = sorted(groups, key=lambda group: (not group[0].startswith(asked), not group[0].startswith("total")))
    pictured = [
        (output, [influence for influence in found if influence.first_order > _LEAST_SHOWN] or found[:1])
        for output, found in pictured[:_MOST_FIGURES]
    ]
    output, (first, *_) = max(pictured, key=lambda group: group[1][0].first_order)
    rows = [_influence_row(influence) for _, found in groups for influence in found]
    yield PageSection(
        f"{_sentence(plain(first.source))} matters most: it makes {100.0 * first.first_order:.0f}\u00a0% of the "
        f"variance of {plain(output)}",
        [
            "What to measure better: the share of a key figure's variance that would go if an input were known. "
            "Inputs that cannot be told from no influence are not listed.",
            sensitivity_bars(pictured),
            Table(("key figure", "input", "share of variance (%)", "rank correlation"), rows, words=2),
        ],
    )


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]


def _influence_row(influence: Sensitivity) -> tuple[str, str, str, str]:
    share, error = 100.0 * influence.first_order, 100.0 * influence.standard_error
    correlation = f"{influence.rank_correlation:+.2f}".replace("-", "−")
    return (
        plain(influence.output),
        plain(influence.source),
        f"{number(share, error)} ± {number(error, error)}",
        correlation,
    )


def _attrition(outcome: Outcome) -> PageSection:
    rows = [(step.step, percent(step.lost), percent(step.surviving)) for step in outcome.attrition]
    worst = max(outcome.attrition, key=lambda step: step.lost.value, default=None)
    heading = "No trial failed"
    if worst is not None and worst.lost.value > 0.0:
        heading = f"{_sentence(_failure(worst.step))} cost {percent(worst.lost)} of the trials"
    return PageSection(heading, [Table(("step", "lost here", "still good"), rows, "Shares of all trials.")])


def _quantities(outcome: Outcome) -> PageSection:
    rows = [
        (plain(f"{phase.name}.{key}"), *_statistic(outcome, phase, key))
        for phase in (*outcome.phases, outcome.total)
        for key in phase.quantities
    ]
    return PageSection(
        "Every quantity, phase by phase",
        [
            Table(("quantity", "mean ± standard error", "sd", "5 %", "50 %", "95 %"), rows),
            "Of the trials that reached the quantity.",
        ],
    )


def _statistic(outcome: Outcome, phase: PhaseOutcome, key: str) -> tuple[str, ...]:
    statistic = phase.quantities[key]
    unit = unit_for(phase.name, key, outcome.provenance.data, typical=statistic.p50)
    mean = with_error(statistic.mean, statistic.standard_error, unit)
    return mean, number(unit(statistic.sd), unit(0.1 * statistic.sd)), *span(statistic, unit)
