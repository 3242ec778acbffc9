"""A steady side force, which the hull balances by going somewhat sideways."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, LegRecord, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class Sideslip(TransitEffect):
    """The course is turned clockwise by ``angle/U²``, U the speed in m/s: lift of the hull balances the force.

    Lift of a slender body at small angles grows as ½ρU² times the angle (Hoerner & Borst 1975, *Fluid-Dynamic Lift*).
    """

    angle: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.exp(-1j * np.asarray(self.angle / np.maximum(leg.speed, 0.1) ** 2))


def _needs_speeds(record: LegRecord) -> str:
    return "" if record.speeds > 0.1 else "needs legs at different speeds: at one speed it is a compass bias"


INFO = EffectInfo(
    id="sideslip",
    phase="transit",
    tier="physical",
    effect=Sideslip,
    parameters={
        "angle": Parameter("rad", "angle to starboard of the heading at 1 m/s", -0.8, 0.8, scale=0.06, spike=0.001)
    },
    what="Bent fins, an antenna or trim to one side push the vehicle sideways; slowly it slips more.",
    finding=Finding(
        "angle",
        "the vehicle slips {size} to starboard at 1 m/s, less when it is faster",
        "the vehicle slips {size} to port at 1 m/s, less when it is faster",
        remedy="trim the fins",
    ),
    sizes="1 to 5° at 1 m/s.",
    confused_with=("compass-bias",),
    distinguished_by="Legs at two speeds on several headings: a compass errs as much at any speed.",
    lacking=_needs_speeds,
    linear=False,
    terms=(Term(("angle",)),),
)
