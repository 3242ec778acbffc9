"""A compass that jumps at an unknown moment."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CompassJump(TransitEffect):
    """From `moment` [s] on the course is turned clockwise by `angle` [rad]; for a part of its leg, by that part."""

    angle: Scalars = 0.0
    moment: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.asarray(np.exp(-1j * np.asarray(self.angle * leg.share_after(self.moment))))


INFO = EffectInfo(
    id="compass-jump",
    phase="transit",
    tier="physical",
    effect=CompassJump,
    parameters={
        "angle": Parameter(
            "rad", "jump of the true course from the assumed one, clockwise", -1.0, 1.0, scale=0.1, spike=1e-4
        ),
        "moment": Parameter("s", "when", 0.0, median=21600.0, factor=4.0, searched="time"),
    },
    what="Something magnetic shifts in the hull, the vehicle is knocked, or a filter of the compass loses its place.",
    finding=Finding(
        "angle",
        "the compass jumped at {at} and reads {size} lower since",
        "the compass jumped at {at} and reads {size} higher since",
        remedy="find what moved, and swing the compass",
    ),
    sizes="2 to 20°, either sign.",
    confused_with=("compass-bias", "compass-deviation", "persistent-error"),
    distinguished_by="Legs on several headings before and after it.",
    linear=False,
    terms=(Term(("angle",), "moment"),),
)
