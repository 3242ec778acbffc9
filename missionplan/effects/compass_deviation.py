"""A compass error that varies with the heading."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Likeness, Parameter
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CompassDeviation(TransitEffect):
    """The course is turned clockwise by ``amplitude·cos(heading − phase)`` [rad], heading clockwise from north."""

    amplitude: Scalars = 0.0
    phase: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        east, north = leg.along
        angle = self.amplitude * (np.cos(self.phase) * north + np.sin(self.phase) * east)
        return np.exp(-1j * np.asarray(angle))


INFO = EffectInfo(
    id="compass-deviation",
    phase="transit",
    tier="physical",
    effect=CompassDeviation,
    parameters={
        "amplitude": Parameter("rad", "greatest deviation", 0.0, 0.8, scale=0.08, spike=0.0026),
        "phase": Parameter("rad", "heading at which the deviation is greatest, clockwise from north"),
    },
    what="Hard iron near the compass: the error is a sine of the heading (semicircular deviation).",
    finding=Finding(
        "amplitude",
        "the compass errs by up to {size}, by its heading",
        "the compass errs by up to {size}, by its heading",
        remedy="swing it all round and enter the table of deviations",
    ),
    sizes="2 to 15° for a compass that was not calibrated (swung).",
    ageing="jumps",
    confused_with=("compass-bias", "mean-current", "speed-scale"),
    distinguished_by="Legs on headings all round the compass.",
    polar=(("amplitude", "phase"),),
    linear=False,
    likeness=Likeness(
        "amplitude", math.radians(10.0), "an error that depends on heading, as a compass deviation would"
    ),
    instrument=Instrument("a swing of the compass on land, all round", "amplitude", 0.009),
)
