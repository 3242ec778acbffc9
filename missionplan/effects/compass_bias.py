"""A constant compass error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CompassBias(TransitEffect):
    """The course made through the water is turned clockwise by `angle` [rad] from the assumed one."""

    angle: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.exp(-1j * np.asarray(self.angle))


INFO = EffectInfo(
    id="compass-bias",
    phase="transit",
    tier="physical",
    effect=CompassBias,
    parameters={
        "angle": Parameter(
            "rad", "angle of the true course from the assumed one, clockwise", -0.8, 0.8, scale=0.08, spike=0.0026
        )
    },
    what="A misaligned compass, a wrong declination, or magnetisation that turns with the hull.",
    finding=Finding(
        "angle",
        "the compass reads {size} low",
        "the compass reads {size} high",
        remedy="swing it, or enter the correction",
    ),
    sizes="1 to 10°, either sign.",
    ageing="jumps",
    upkeep="find what turns the compass further from mission to mission",
    confused_with=("compass-deviation", "mean-current"),
    distinguished_by="Legs on at least three headings.",
    linear=False,
    instrument=Instrument("a swing of the compass on land, all round", "angle", 0.009),
)
