"""How the vehicle of a mooring stands on its line in a mean and in a worst current, and what would mend it."""

import math
from dataclasses import dataclass

from missionplan.arrays import Array


@dataclass(frozen=True)
class HeldState:
    """The vehicle on its line in one current.

    Attributes
    ----------
    current : str
        Which, such as ``mean current``.
    speed : float
        Of the lowest layer [m/s].
    nose_altitude, tail_altitude, clearance : float
        Of nose, tail and the hull's lowest point above the seafloor below them [m].
    excursion : float
        Horizontal distance of the nose from the anchor [m].
    pitch : float
        Elevation of the tail seen from the nose [rad].
    line_angle : float
        Of the line to the vertical at the anchor [rad].
    tension_at_nose, tension_at_anchor : float
        [N]
    anchor_drag : float
        The anchor's own [N].
    friction_needed : float
        Holding factor with which the anchor just holds.
    holding_margin : float
        See `seafloor.holding_margin`.
    least_weight : float
        Wet weight with which an anchor of this size just holds [N].
    line : array, shape (k, 2)
        From the anchor to the nose: downstream and up [m].
    tail : (float, float)
        Downstream and up from the anchor [m].
    uphill : float
        Rise of the seafloor over a metre downstream.
    """

    current: str
    speed: float
    nose_altitude: float
    tail_altitude: float
    clearance: float
    excursion: float
    pitch: float
    line_angle: float
    tension_at_nose: float
    tension_at_anchor: float
    anchor_drag: float
    friction_needed: float
    holding_margin: float
    least_weight: float
    line: Array
    tail: tuple[float, float]
    uphill: float

    def summary(self) -> dict[str, object]:
        """Return an entry of ``summary.json``."""
        return {
            "current": self.current,
            "speed_m_s": self.speed,
            "nose_altitude_m": self.nose_altitude,
            "tail_altitude_m": self.tail_altitude,
            "excursion_m": self.excursion,
            "pitch_rad": self.pitch,
            "line_angle_rad": self.line_angle,
            "tension_at_nose_n": self.tension_at_nose,
            "tension_at_anchor_n": self.tension_at_anchor,
            "anchor_drag_n": self.anchor_drag,
            "friction_needed": self.friction_needed if math.isfinite(self.friction_needed) else None,
            "holding_margin": self.holding_margin,
            "least_wet_weight_n": self.least_weight,
            "grounded": self.clearance <= 0.0,
        }


@dataclass(frozen=True)
class HeldVehicle:
    """A mooring's vehicle on its line, distributions at their means.

    Attributes
    ----------
    phase : str
        Name of the mooring.
    length, diameter : float
        Of the hull [m].
    anchor_length, anchor_diameter, anchor_weight : float
        [m, m, N].
    line_length : float
        [m].
    friction : float
        Holding factor.
    friction_given, centres_given : bool
        Whether the vehicle file says how the anchor holds, and where the centres of gravity and buoyancy are.
    if_polyester : float or None
        Altitude of the nose in the worst current were the line, taken as weightless, of polyester [m]; None where its
        weight is known, or it has no diameter.
    states : tuple of HeldState
        In the mean and in the worst current.
    remedies : tuple of str
        What is wrong in the worst current, and what would mend it, a sentence each.
    """

    phase: str
    length: float
    diameter: float
    anchor_length: float
    anchor_diameter: float
    anchor_weight: float
    line_length: float
    friction: float
    friction_given: bool
    centres_given: bool
    if_polyester: float | None
    states: tuple[HeldState, ...]
    remedies: tuple[str, ...]

    def summary(self) -> dict[str, object]:
        """Return the section `hold` of ``summary.json``."""
        return {
            "phase": self.phase,
            "holding_factor": self.friction,
            "holding_factor_assumed": not self.friction_given,
            "centres_assumed": not self.centres_given,
            "line_weight_assumed": self.if_polyester is not None,
            "nose_altitude_if_polyester_m": self.if_polyester,
            "states": [state.summary() for state in self.states],
            "remedies": list(self.remedies),
        }
