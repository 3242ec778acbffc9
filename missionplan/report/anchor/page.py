"""The anchor to build under each explanation that the mission carries, and whether the doubt changes the choice."""

import math

import numpy as np
from matplotlib.axes import Axes

from missionplan.report.anchor import sections
from missionplan.report.anchor.drawing import drawing, hold_section
from missionplan.report.anchor.figures import descent_profile, draw_depths, draw_drag, mark_lowest_point
from missionplan.report.anchor.sections import numbers_table
from missionplan.report.axes import name_axis
from missionplan.report.explained import (
    first_do,
    hangs_on_doubt,
    judged_in_words,
    members_in_words,
    members_section,
    what_would_tell,
)
from missionplan.report.page import Page, PageSection, Table
from missionplan.report.quantities import in_reader_units, quantity, reader_unit
from missionplan.report.wording import listed, percent, phase_in_words, share
from missionplan.results.anchor_sizing import AnchorSizing
from missionplan.results.decision import label
from missionplan.results.sized_anchor import SizedAnchor

_SAILED = "With the anchor to build, and all trials in one member."
SAME_WEIGHT = 0.02
"""Ratio less one within which two wet weights are the same choice."""


def explanation_in_words(sizing: AnchorSizing) -> str:
    """Say in a sentence whether what is in doubt changes the choice; nothing for a mission without doubts."""
    explanations = sorted(sizing.explanations, key=lambda explanation: explanation.good.value)
    if not explanations:
        return ""
    needed = [explanation.needed for explanation in explanations if explanation.needed is not None]
    if sizing.probable is not None and len(needed) == len(explanations):
        if max(needed) <= (1.0 + SAME_WEIGHT) * min(needed):
            return f" Whichever explanation holds, the same anchor is best, to {100.0 * SAME_WEIGHT:.0f}\u00a0%."
        light, heavy = (pick(explanations, key=lambda explanation: explanation.needed or 0.0) for pick in (min, max))
        return (
            f" The doubt changes the choice: with {label(light.causes)} {quantity(light.needed, 'N', '.2f')} would do, "
            f"with {label(heavy.causes)} it takes {quantity(heavy.needed, 'N', '.2f')}. First find out which holds."
        )
    worst, best = explanations[0], explanations[-1]
    if worst.good.high < best.good.low:
        ends = f"{share(worst.good)} with {label(worst.causes)}, {share(best.good)} with {label(best.causes)}"
        return f" It depends on which explanation holds: {ends}."
    return " Whichever explanation holds, it does as well, as far as the trials can tell."


def _hangs(sizing: AnchorSizing) -> bool:
    """Whether an explanation or a member of the ensemble would have another anchor, or spoils its dives."""
    doubts = [(explanation.probability, explanation.good) for explanation in sizing.explanations]
    doubts += [(member.probability, member.good) for member in sizing.members]
    if not doubts:
        return False
    required = sizing.probable.required if sizing.probable is not None else None
    needed = [explanation.needed for explanation in sizing.explanations if explanation.needed is not None]
    return hangs_on_doubt(sizing.to_build.probabilities.good, doubts, required) or (
        bool(needed) and max(needed) > (1.0 + SAME_WEIGHT) * min(needed)
    )


def explanation_section(sizing: AnchorSizing) -> list[PageSection]:
    """Tabulate what the anchor to build achieves under each explanation, and which one would do."""
    asked = any(explanation.needed is not None for explanation in sizing.explanations)
    unit = reader_unit("N", 0.0)
    rows = [
        [
            label(explanation.causes),
            f"{100.0 * explanation.probability:.1f}\u00a0%",
            percent(explanation.good),
            "–" if explanation.needed is None and asked else unit.cell(explanation.needed, ".2f") if asked else "",
        ]
        for explanation in sizing.explanations
    ]
    columns = (
        "explanation",
        "probability",
        "dives that succeed with the anchor to build",
        f"lightest that would do{unit.axis}",
    )
    note = "Each explanation known to hold in turn, on the same random numbers."
    return [PageSection("Which explanation holds", [Table(columns, rows, note)])] if rows else []


def page(sizing: AnchorSizing) -> Page:
    """Build the page of a sizing."""
    anchor = sizing.to_build
    dives_well = anchor.touched_down and anchor.nominal.lowest_altitude > 0.0 and anchor.nominal.offset <= sizing.radius
    works, design = sizing.succeeds and dives_well, anchor.design
    built = design if design is not None and design.feasible else None
    return Page(
        title=f"Anchor for {phase_in_words(sizing.phase)}: {sizing.provenance.mission}",
        answer=answer(sizing),
        # the anchor where it can be built, else its dive where there is one
        draw=lambda: drawing(built) if built else descent_profile(anchor) if anchor.touched_down else None,
        numbers=[
            ("Wet weight", quantity(anchor.wet_weight, "N", ".2f")),
            ("Terminal velocity it is sized for", quantity(anchor.terminal_velocity, "m/s", ".2f")),
            (
                f"Dives within {quantity(sizing.radius, 'm', '.1f')} and clear of the "
                f"bottom{sections.holding_in_words(anchor)}",
                percent(anchor.probabilities.good),
            ),
        ],
        write=lambda: [
            *sections.problems(anchor),
            *sections.probable(sizing),
            *explanation_section(sizing),
            *members_section(sizing.members, "dives", "dives that succeed (95 % interval)", _SAILED),
            sections.probabilities(sizing),
            *sections.dive(sizing),
            *([hold_section(sizing.held)] if sizing.held is not None else []),
            *sections.trim(sizing),
            sections.drag(sizing),
            PageSection("All numbers", [Table(*numbers_table(sizing))]),
        ],
        verdict="bad" if not works else "undecided" if _drags_in_words(sizing) or _hangs(sizing) else "good",
        table=lambda: numbers_table(sizing),
        plots={"descent": descent, "drag": drag},
    )


def answer(sizing: AnchorSizing) -> str:
    """Write which anchor to build and what it achieves, what that of the worst case would, and whether it drags."""
    sailed = members_in_words(sizing.members, "succeeds")
    heavier = sizing.probable.margins[-1] if sizing.probable is not None and sizing.probable.margins else None
    missed = ""
    if heavier is not None and heavier.misses:  # by an anchor that turns out a tenth heavier
        missed = (
            f" Built heavier, with {quantity(heavier.weight, 'N', '.2f')}, it would miss {', '.join(heavier.misses)}."
        )
    which = f"{_which(sizing)}{missed}{judged_in_words(sizing.judged)}"
    doubts, others = f"{explanation_in_words(sizing)}{sailed and f' {sailed}'}", ""
    if sizing.others:  # the mission moors elsewhere too
        names = [phase_in_words(name) for name in (sizing.phase, *sizing.others)]
        others = f" It is sized for {names[0]} alone, not for {listed(names[1:])}."
    settles = f" first {what_would_tell(sizing.explanations)};"
    first = first_do(sizing.judged, sizing.phase) or (settles if _hangs(sizing) else None)
    if first is not None and sizing.succeeds:
        which = f"Nothing to build yet:{first} as the mission stands, {which[0].lower()}{which[1:]}"
    return f"{which}{doubts}{_drags_in_words(sizing)}{others}"


def _which(sizing: AnchorSizing) -> str:
    """Write which anchor to build and what it achieves, then what that of the worst case would."""
    anchor, radius = sizing.to_build, quantity(sizing.radius, "m", ".1f")
    dives = f"dives stay within {radius} and clear of the bottom{sections.holding_in_words(anchor)}"
    built = f"{_anchor_in_words(anchor)} {percent(anchor.probabilities.good)} of {dives}."
    probable = sizing.probable
    if probable is None:
        return built
    if probable.anchor is None:
        return f"No anchor does {sections.asked_in_words(probable)}: {in_reader_units(probable.reason)}. {built}"
    if probable.lighter is not None:
        built += (
            f" For {sections.asked_in_words(probable)}, {quantity(probable.lighter, 'N', '.2f')} would do, but these "
            "parts make no lighter anchor."
        )
    worst = f"The worst-case anchor of Eq. 1, {sections.weight_in_words(sizing.anchor)} wet, reaches "
    return f"{built} {worst}{percent(sizing.anchor.probabilities.good)}."


def _drags_in_words(sizing: AnchorSizing) -> str:
    """Write that the anchor would drag, where the mission does not say how it holds."""
    hold = sizing.held
    if hold is None or not hold.friction_assumed or all(state.holding_margin >= 0.0 for state in hold.states):
        return ""
    state = next(state for state in hold.states if state.holding_margin < 0.0)
    return (
        f" With an assumed holding factor of {hold.friction:g} the anchor to build would drag in the {state.current}, "
        f"{quantity(state.speed, 'm/s', '.2f')}, which is not counted."
    )


def _anchor_in_words(anchor: SizedAnchor) -> str:
    design = anchor.design
    weight = sections.weight_in_words(anchor)
    if design is None:
        return f"An anchor of {weight} wet: {sections.dive_in_words(anchor)}."
    if not design.feasible:
        failures = "; ".join(failure.words for failure in design.failures)
        return f"An anchor of {weight} wet cannot be built from these parts: {failures}."
    built = f"{quantity(design.dry_mass, 'kg', '.2f')} dry, {design.length * 1e3:.0f}\u00a0mm long"
    if math.isfinite(design.trim_position):
        built += f", ring of {quantity(design.trim_mass, 'kg', '.2f')} at {design.trim_position * 1e3:.0f}\u00a0mm"
    return f"An anchor of {weight} wet, {built}: {sections.dive_in_words(anchor)}."


def descent(axes: Axes, sizing: AnchorSizing) -> None:
    """Draw the depths of anchor and vehicle in the nominal dive of the anchor to build."""
    anchor = sizing.to_build
    seafloor = float(np.asarray(anchor.dive.site_depth))
    draw_depths(axes, anchor.profile, seafloor)
    mark_lowest_point(axes, anchor.profile, seafloor, anchor.nominal.lowest_altitude)
    axes.set(xlabel="Time since the last fix (s)", ylim=(1.06 * seafloor, 0.0))
    name_axis(axes.yaxis, "Depth", "m")


def drag(axes: Axes, sizing: AnchorSizing) -> None:
    """Draw the drag of each part at terminal velocity."""
    draw_drag(axes, sizing.to_build)
