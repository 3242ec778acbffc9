"""How the vehicle of a mooring stands on its line in a mean and in a worst current, and what would mend it."""

import math
from dataclasses import dataclass
from typing import Annotated

from missionplan.arrays import Array
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class HeldState(Record):
    """The vehicle on its line in one current."""

    current: Annotated[str, Entry("which, such as ``mean current``")]
    speed: Annotated[float, Entry("of the lowest layer", "m/s")]
    nose_altitude: Annotated[float, Entry("of the nose above the seafloor below it", "m")]
    tail_altitude: Annotated[float, Entry("of the tail above the seafloor below it", "m")]
    clearance: float
    """Of the hull's lowest point above the seafloor below it [m]."""
    excursion: Annotated[float, Entry("horizontal distance of the nose from the anchor", "m")]
    pitch: Annotated[float, Entry("elevation of the tail seen from the nose", "rad")]
    line_angle: Annotated[float, Entry("of the line to the vertical at the anchor", "rad")]
    tension_at_nose: Annotated[float, Entry("of the line at the nose", "N")]
    tension_at_anchor: Annotated[float, Entry("of the line at the anchor", "N")]
    anchor_drag: Annotated[float, Entry("the anchor's own", "N")]
    friction_needed: float
    """Holding factor with which the anchor just holds; infinite where none does."""
    holding_margin: Annotated[float, Entry("see `seafloor.holding_margin`")]
    least_weight: Annotated[
        float, Entry("wet weight with which an anchor of this size just holds", "N", "least_wet_weight")
    ]
    line: Array
    """From the anchor to the nose: downstream and up; shape (k, 2) [m]."""
    tail: tuple[float, float]
    """Downstream and up from the anchor [m]."""
    uphill: float
    """Rise of the seafloor over a metre downstream."""

    @property
    def least_friction(self) -> Annotated[float | None, Entry(key="friction_needed")]:
        """Holding factor with which the anchor just holds; None where none does."""
        return self.friction_needed if math.isfinite(self.friction_needed) else None

    @property
    def grounded(self) -> Annotated[bool, Entry()]:
        """Whether the hull lies on the seafloor."""
        return self.clearance <= 0.0


@dataclass(frozen=True)
class HeldVehicle(Record):
    """A mooring's vehicle on its line, distributions at their means.

    Attributes
    ----------
    length, diameter : float
        Of the hull [m].
    anchor_length, anchor_diameter, anchor_weight : float
        [m, m, N].
    friction_given, centres_given : bool
        Whether the vehicle file says how the anchor holds, and where the centres of gravity and buoyancy are.
    """

    phase: Annotated[str, Entry("name of the mooring")]
    length: float
    diameter: float
    anchor_length: float
    anchor_diameter: float
    anchor_weight: float
    line_length: float
    """Line length [m]."""
    friction: Annotated[float, Entry("friction coefficient of the anchor on the seafloor", key="holding_factor")]
    friction_given: bool
    centres_given: bool
    if_polyester: Annotated[
        float | None,
        Entry(
            "in the worst current were the line, taken as weightless, of polyester; null where its weight is known, or "
            "it has no diameter",
            "m",
            "nose_altitude_if_polyester",
        ),
    ]
    states: Annotated[tuple[HeldState, ...], Entry("in the mean and in the worst current")]
    remedies: Annotated[
        tuple[str, ...], Entry("what is wrong in the worst current, and what would mend it, a sentence each")
    ]

    @property
    def friction_assumed(self) -> Annotated[bool, Entry(key="holding_factor_assumed")]:
        """Whether the vehicle file does not say how the anchor holds."""
        return not self.friction_given

    @property
    def centres_assumed(self) -> Annotated[bool, Entry()]:
        """Whether the vehicle file does not say where the centres of gravity and buoyancy are."""
        return not self.centres_given

    @property
    def line_weight_assumed(self) -> Annotated[bool, Entry()]:
        """Whether the line is taken as weightless."""
        return self.if_polyester is not None
