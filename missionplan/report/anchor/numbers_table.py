"""All numbers of the anchors of a sizing, side by side."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from missionplan.physics.anchor import AnchorDesign
from missionplan.report.numbers import percent
from missionplan.report.quantities import quantity
from missionplan.results.mooring.sized_anchor import SizedAnchor
from missionplan.results.mooring.sizing import AnchorSizing


@dataclass(frozen=True)
class _Row:
    """A number of an anchor: label, SI value (None where the anchor has no construction), digits, and shown unit."""

    label: str
    value: Callable[[SizedAnchor], float | None]
    digits: int
    unit: str
    scale: float = 1.0

    def cell(self, anchor: SizedAnchor) -> str:
        value = self.value(anchor)
        if value is None or not math.isfinite(value):
            return "–"
        return quantity(value * self.scale, self.unit, f".{self.digits}f")


def _of_design(value: Callable[[AnchorDesign], float]) -> Callable[[SizedAnchor], float | None]:
    """Take a number of an anchor's design, where it has one."""
    return lambda anchor: None if anchor.design is None else value(anchor.design)


_ROWS = (
    _Row("Wet weight", lambda anchor: anchor.wet_weight, 2, "N"),
    _Row("Terminal velocity sized for", lambda anchor: anchor.terminal_velocity, 3, "m/s"),
    _Row("Dry mass = displaced mass", _of_design(lambda design: design.dry_mass), 4, "kg"),
    _Row("Flooded mass", _of_design(lambda design: design.flooded_mass), 3, "kg"),
    _Row("Length", _of_design(lambda design: design.length), 1, "mm", 1e3),
    _Row("Tube length C", _of_design(lambda design: design.cylinder_length), 2, "mm", 1e3),
    _Row("Trim ring's mass", _of_design(lambda design: design.trim_mass), 4, "kg"),
    _Row("Trim ring from the tip", _of_design(lambda design: design.trim_position), 1, "mm", 1e3),
    _Row("Centre of gravity from the tip", _of_design(lambda design: design.centre_of_gravity), 1, "mm", 1e3),
    _Row("Centre of buoyancy from the tip", _of_design(lambda design: design.centre_of_buoyancy), 1, "mm", 1e3),
    _Row("Separation to touchdown", lambda anchor: anchor.descent_time, 2, "s"),
    _Row("of which until the line is taut", lambda anchor: anchor.payout_time, 2, "s"),
    _Row("Peak tension of the snatch", lambda anchor: anchor.snatch.get("snatch_tension_n"), 0, "N"),
    _Row("Taut line to nose down", lambda anchor: anchor.snatch.get("nose_down_time_s"), 2, "s"),
    _Row("Depth lost meanwhile", lambda anchor: anchor.snatch.get("depth_lost_m"), 2, "m"),
    _Row("Terminal velocity of the dive", lambda anchor: anchor.dive_terminal_velocity, 3, "m/s"),
    _Row("Speed at touchdown", lambda anchor: anchor.touchdown_speed, 3, "m/s"),
    _Row("Anchor from the last fix", lambda anchor: anchor.offset, 2, "m"),
    _Row("Vehicle's lowest altitude", lambda anchor: anchor.lowest_altitude, 2, "m"),
)


def numbers_table(sizing: AnchorSizing) -> tuple[list[str], list[list[str]]]:
    """Return the column heads, an anchor each, and the rows."""
    anchors = {"Worst case": sizing.anchor}
    if sizing.probable is not None and sizing.probable.anchor is not None:
        anchors[f"{100 * sizing.probable.required:g} %"] = sizing.probable.anchor
    rows = [
        [row.label, *(row.cell(anchor) for anchor in anchors.values())]
        for row in _ROWS
        if row.value(sizing.anchor) is not None
    ]
    good = [percent(anchor.probabilities.good) for anchor in anchors.values()]
    return ["", *anchors], [*rows, ["Within the radius and not struck", *good]]
