"""An inertial current: one that rotates with the local inertial period."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, LegRecord, Parameter
from missionplan.effects.oscillation import (
    MODULATION_PARAMETERS,
    USUAL_TIME,
    Oscillation,
    inertial_frequency,
    mean_phasor,
    polar,
    wave,
)
from missionplan.phases.hooks import DriftParts, Leg


@dataclass(frozen=True)
class InertialCurrent(Oscillation):
    """Current of constant speed `amplitude` [m/s] that rotates clockwise in the northern hemisphere.

    At the mission's start it flows toward the angle `phase` [rad], counted counter-clockwise from east. Its angular
    frequency is f = 2Ω sin(latitude): period 12 h/sin(latitude) of a sidereal day, 25.97 h at 27.4° N.
    """

    amplitude: Scalars = 0.0
    phase: Scalars = 0.0
    modulation: Scalars = 0.0
    coherence_time: Scalars = USUAL_TIME

    def later(self) -> Self:
        """Return the current with its phase a quarter of a period later."""
        return replace(self, phase=self.phase + 0.5 * np.pi)

    def velocity(self, leg: Leg) -> Array:
        """Return the mean inertial velocity over each leg, shape (2, n) [m/s].

        Raises
        ------
        ValueError
            When the coordinates' origin has no latitude.
        """
        if not np.isfinite(leg.latitude):
            raise ValueError("inertial-current needs the latitude of site.origin")
        cosine, sine = mean_phasor(leg, inertial_frequency(leg.latitude))
        return np.stack(
            [wave(cosine, sine, self.amplitude, self.phase), wave(-sine, cosine, self.amplitude, self.phase)]
        )

    def drift(self) -> DriftParts:
        """Return the turning current."""
        turning = np.stack(np.broadcast_arrays(*polar(self.amplitude, self.phase)))
        return DriftParts(inertial=turning, modulation=(self.modulation, self.coherence_time))


def _lacking(record: LegRecord) -> str:
    known = math.isfinite(record.latitude)
    return "" if known else "needs the latitude: site.origin in the mission, or positions by latitude"


INFO = EffectInfo(
    id="inertial-current",
    phase="transit",
    tier="physical",
    effect=InertialCurrent,
    parameters={
        "amplitude": Parameter("m/s", "speed of the rotating current", 0.0, 3.0, scale=0.15, spike=0.002),
        "phase": Parameter("rad", "direction at the mission's start, counter-clockwise from east"),
        **MODULATION_PARAMETERS,
    },
    belongs_to="day",
    what="Water set in motion by a wind that has ceased rotates by the Coriolis force alone.",
    finding=Finding(
        "amplitude",
        "a current of {size} turns with the inertial period",
        "a current of {size} turns with the inertial period",
        remedy="plan with the extended mission, or with a forecast that has such a current",
    ),
    sizes="0.05 to 0.5 m/s for days after a storm.",
    confused_with=("tidal-current", "persistent-error", "mean-current"),
    distinguished_by="A record of two inertial periods or more; both components, which are in quadrature.",
    polar=(("amplitude", "phase"),),
    frequency_of=lambda phase, latitude: inertial_frequency(latitude),
    is_modulated=True,
    lacking=_lacking,
    needs_latitude=True,
)
