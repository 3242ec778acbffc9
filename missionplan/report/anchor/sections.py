"""Sections of the report of a sizing."""

import math
from collections.abc import Callable, Iterator

from missionplan.montecarlo.statistics import wilson
from missionplan.physics.anchor import AnchorDesign
from missionplan.report.anchor.drawing import drawing
from missionplan.report.anchor.figures import descent_profile, drag_bars, drift_figure
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import in_reader_units, quantity, reader_unit
from missionplan.report.wording import capitalised, number, percent, share
from missionplan.results.anchor_sizing import AnchorSizing, ProbableAnchor
from missionplan.results.sized_anchor import SizedAnchor

_WORST_CASE = (
    "The worst case takes every layer at its design speed and all of them aligned, but leaves out the release, the "
    "pay-out of the line and the time to gather speed: its anchor can be too heavy or too light."
)


def problems(anchor: SizedAnchor) -> Iterator[PageSection]:
    """List why the anchor cannot be built, where it cannot."""
    if anchor.problems:
        blocks: list[Block] = [f"{capitalised(problem)}." for problem in anchor.problems]
        if anchor.design is not None and anchor.design.cylinder_length > 0.0:
            blocks.append(drawing(anchor.design))
        yield PageSection("Why it cannot be built, and what would allow it", blocks)


def probable(sizing: AnchorSizing) -> Iterator[PageSection]:
    """Present the lightest anchor that does what is asked of its dives, where anything is."""
    if sizing.probable is None:
        return
    wanted, anchor = asked_in_words(sizing.probable), sizing.probable.anchor
    if anchor is None:
        words = [f"{capitalised(in_reader_units(sizing.probable.reason))}."]
        if sizing.probable.line_length is not None:
            line, weight = sizing.probable.line_length, sizing.probable.line_anchor_weight
            words.append(
                f"A line of {quantity(line, 'm', '.1f')}, instead of {quantity(sizing.line_length, 'm', '.1f')}, "
                f"with an anchor of {quantity(weight, 'N', '.1f')} would do."
            )
        yield PageSection(f"No anchor does {wanted}", words)
        return
    worst, margins = sizing.anchor, []
    difference = anchor.wet_weight - worst.wet_weight
    compared = (
        f"The {'lightest' if sizing.probable.lighter is None else 'lightest buildable'} anchor that does {wanted} "
        f"weighs {weight_in_words(anchor)} wet, {quantity(abs(difference), 'N', '.1f')} "
        f"{'lighter' if difference < 0.0 else 'heavier'} than the worst-case anchor, which reaches "
        f"{percent(worst.probabilities.good)}. It is {dive_in_words(anchor)}."
    )
    for margin in sizing.probable.margins:  # anchors a little lighter and heavier
        dives, missed = margin.probabilities, f"; missed: {', '.join(margin.misses)}" if margin.misses else ""
        ends = f"{percent(dives.good)} of dives succeed, {percent(dives.struck)} strike the seafloor"
        margins.append(f"With {quantity(margin.weight, 'N', '.2f')} {ends}{missed}.")
    problems = [f"{capitalised(problem)}." for problem in anchor.problems]
    heading = f"For {wanted} the anchor weighs {weight_in_words(anchor)}"
    yield PageSection(heading, [compared, _WORST_CASE, *margins, *problems])


def asked_in_words(probable: ProbableAnchor) -> str:
    """Write what is asked of dives: ``95 % of dives that succeed``, or what the mission requires."""
    share = "" if probable.required is None else f"{100 * probable.required:g}\u00a0% of dives that succeed"
    return share or "all that the mission requires of its dives"


def weight_in_words(anchor: SizedAnchor) -> str:
    """Write the wet weight: ``11.8 N``."""
    return quantity(anchor.wet_weight, "N", ".1f" if anchor.wet_weight >= 1.0 else ".2f")


def dive_in_words(anchor: SizedAnchor) -> str:
    """Write where and when the nominal dive ends."""
    if not anchor.touched_down:
        return "not able to take the vehicle to the seafloor"
    down = (
        f"at the seafloor {anchor.nominal.time:.0f}\u00a0s after separation, "
        f"{quantity(anchor.nominal.offset, 'm', '.0f')} from the last fix"
    )
    if anchor.nominal.lowest_altitude > 0.0:
        return f"{down}; the vehicle stops {quantity(anchor.nominal.lowest_altitude, 'm', '.1f')} above the bottom"
    missing = quantity(-anchor.nominal.lowest_altitude, "m", ".1f")
    return f"{down}; the vehicle strikes the bottom: the line is {missing} too short"


def probabilities(sizing: AnchorSizing) -> PageSection:
    """Present how often dives stay within the radius and clear of the bottom."""
    dives, trials = sizing.to_build.probabilities, sizing.provenance.trials
    holding, radius = holding_in_words(sizing.to_build), quantity(sizing.radius, "m", ".1f")
    heading = f"{percent(dives.good)} of dives stay within {radius} and clear of the bottom{holding}"
    offset, lowest = dives.offset, dives.lowest_altitude.p05
    drawn = f"{number(trials)} dive{'' if trials == 1 else 's'} drawn from the mission's distributions"
    if offset.count == 0:
        return PageSection(heading, [f"In none of {drawn} does the anchor reach the seafloor."])
    of_which = f"Over {drawn}"
    if offset.count < trials:
        landed = share(wilson(offset.count, trials))
        of_which = f"Of {drawn}, in {landed} the anchor reaches the seafloor; in these"
    unit = reader_unit("m", offset.p95)
    middle, far = unit(offset.p50), unit(offset.p95)
    words = (
        f"{of_which} the anchor comes down {number(middle, unit(offset.standard_error))}{unit.suffix} from the last "
        f"fix in the median and {number(far, unit(2.0 * offset.standard_error))}{unit.suffix} at the 95th percentile. "
        f"The vehicle strikes the seafloor in {percent(dives.struck)}"
    )
    if lowest > 0.0:
        words += f"; in one dive of twenty it stops within {quantity(lowest, 'm', '.2f')} of it"
    return PageSection(heading, [f"{words}."])


def dive(sizing: AnchorSizing) -> Iterator[PageSection]:
    """Draw the nominal dive, where it reaches the seafloor."""
    anchor = sizing.to_build
    if not anchor.touched_down:
        yield PageSection("The anchor does not reach the seafloor", [_layers_in_words(sizing)])
        return
    if anchor.design is not None and anchor.design.feasible:
        stops = f"The vehicle stops {quantity(anchor.nominal.lowest_altitude, 'm', '.1f')} above the bottom"
        heading = stops if anchor.nominal.lowest_altitude > 0.0 else "The vehicle strikes the bottom"
        yield PageSection(heading, [descent_profile(anchor)])
    inside = "inside" if anchor.nominal.offset <= sizing.radius else "outside"
    heading = (
        f"The anchor comes down {quantity(anchor.nominal.offset, 'm', '.1f')} from the last fix, {inside} the radius"
    )
    yield PageSection(heading, [drift_figure(sizing), _layers_in_words(sizing)])


def _layers_in_words(sizing: AnchorSizing) -> str:
    layers = "; ".join(
        f"{quantity(layer.thickness, 'm', '.1f')} at {quantity(layer.speed, 'm/s', '.2f')}" for layer in sizing.layers
    )
    required = quantity(sizing.required_velocity, "m/s", ".3f")
    words = f"Sized for {layers}, all aligned (Eq. 1), which requires {required} downward over the ground."
    if sizing.vector_velocity is not None:
        words += f" With the layers' own directions {quantity(sizing.vector_velocity, 'm/s', '.3f')} would do."
    return words


def holding_in_words(anchor: SizedAnchor) -> str:
    """Write that the dives counted are those whose anchor holds, where that counts."""
    return "" if anchor.probabilities.holds is None else ", with an anchor that holds"


def trim(sizing: AnchorSizing) -> Iterator[PageSection]:
    """Tabulate how the vehicle lies in the water in the paper's three configurations."""
    if not sizing.trim:
        return
    rows = [
        (
            state.configuration,
            state.verdict,
            quantity(state.net_force, "N", "+.2f"),
            "–" if state.moment == 0.0 and not state.centres_known else f"{state.moment:+.2f} N m",
            "–" if state.pitch is None else f"{math.degrees(state.pitch):+.1f} °",
        )
        for state in sizing.trim
    ]
    columns = ("configuration", "lies", "net force, up", "moment, nose down", "pitch, nose down")
    released = sizing.trim[-1]
    lies = f"The released vehicle is {released.verdict}"
    if released.pitch is None:
        lies = "How the released vehicle lies depends on its centres of gravity and buoyancy"
    yield PageSection(lies, [Table(columns, rows, text_columns=2)])


def drag(sizing: AnchorSizing) -> PageSection:
    """Draw where the drag comes from, with the notes on the formulae."""
    anchor = sizing.to_build
    if float(anchor.drag.total) == 0.0:
        return PageSection(
            "At terminal velocity there is no drag: vehicle and anchor together are neutral", [*sizing.notes]
        )
    part = float(anchor.drag.anchor) / float(anchor.drag.total)
    heading = f"The vehicle makes {100 * (1 - part):.0f}\u00a0% of the drag, the anchor {100 * part:.0f}\u00a0%"
    return PageSection(heading, [drag_bars(anchor), *sizing.notes])


def _of_design(value: Callable[[AnchorDesign], float]) -> Callable[[SizedAnchor], float | None]:
    """Take a number of an anchor's design, where it has one."""
    return lambda anchor: None if anchor.design is None else value(anchor.design)


_ROWS: tuple[tuple[str, Callable[[SizedAnchor], float | None], int, str], ...] = (
    ("Wet weight", lambda anchor: anchor.wet_weight, 2, "N"),
    ("Terminal velocity sized for", lambda anchor: anchor.terminal_velocity, 3, "m/s"),
    ("Dry mass = displaced mass", _of_design(lambda design: design.dry_mass), 4, "kg"),
    ("Flooded mass", _of_design(lambda design: design.flooded_mass), 3, "kg"),
    ("Length", _of_design(lambda design: design.length), 1, "mm"),
    ("Tube length C", _of_design(lambda design: design.cylinder_length), 2, "mm"),
    ("Trim ring's mass", _of_design(lambda design: design.trim_mass), 4, "kg"),
    ("Trim ring from the tip", _of_design(lambda design: design.trim_position), 1, "mm"),
    ("Centre of gravity from the tip", _of_design(lambda design: design.centre_of_gravity), 1, "mm"),
    ("Centre of buoyancy from the tip", _of_design(lambda design: design.centre_of_buoyancy), 1, "mm"),
    ("Separation to touchdown", lambda anchor: anchor.nominal.time, 2, "s"),
    ("of which until the line is taut", lambda anchor: anchor.nominal.payout_time, 2, "s"),
    ("Peak tension of the snatch", lambda anchor: anchor.nominal.snatch_tension, 0, "N"),
    ("Taut line to nose down", lambda anchor: anchor.nominal.nose_down_time, 2, "s"),
    ("Depth lost meanwhile", lambda anchor: anchor.nominal.depth_lost, 2, "m"),
    ("Terminal velocity of the dive", lambda anchor: anchor.nominal.terminal_velocity, 3, "m/s"),
    ("Speed at touchdown", lambda anchor: anchor.nominal.touchdown_speed, 3, "m/s"),
    ("Anchor from the last fix", lambda anchor: anchor.nominal.offset, 2, "m"),
    ("Vehicle's lowest altitude", lambda anchor: anchor.nominal.lowest_altitude, 2, "m"),
)
"""Label, SI value (None where the anchor has no construction), digits, and shown unit."""


def numbers_table(sizing: AnchorSizing) -> tuple[list[str], list[list[str]]]:
    """Return the column heads, an anchor each, and the rows."""
    anchors = {"Worst case": sizing.anchor}
    if sizing.probable is not None and sizing.probable.anchor is not None:
        required = sizing.probable.required
        anchors["as required" if required is None else f"{100 * required:g} %"] = sizing.probable.anchor
    rows = []
    for label, value_of, digits, unit in _ROWS:
        if value_of(sizing.anchor) is None:
            continue
        row = [label]
        for anchor in anchors.values():
            value = value_of(anchor)
            is_finite = value is not None and math.isfinite(value)
            scaled = (value or 0.0) * (1e3 if unit == "mm" else 1.0)
            row.append(quantity(scaled, unit, f".{digits}f") if is_finite else "–")
        rows.append(row)
    good = [percent(anchor.probabilities.good) for anchor in anchors.values()]
    return ["", *anchors], [*rows, ["Dives that succeed", *good]]
