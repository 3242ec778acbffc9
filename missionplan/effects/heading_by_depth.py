"""A heading error that grows with depth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, LegRecord, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class HeadingByDepth(TransitEffect):
    """The course is turned clockwise by `rate` [rad/m] times the mean depth of the leg."""

    rate: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.asarray(np.exp(-1j * np.asarray(self.rate * np.where(np.isfinite(leg.depth), leg.depth, 0.0))))


def _needs_depths(record: LegRecord) -> str:
    return "" if record.depths > 2.0 else "needs the depth of the legs (column depth_m), and different ones"


INFO = EffectInfo(
    id="heading-by-depth",
    phase="transit",
    tier="physical",
    effect=HeadingByDepth,
    parameters={
        "rate": Parameter(
            "rad/m",
            "angle of the true course from the assumed one, clockwise, for each metre of depth",
            -0.02,
            0.02,
            scale=1e-3,
            spike=2e-6,
            extent_scale=0.08,
        )
    },
    what="Pressure bends what holds the compass, or a hull that is squeezed moves iron beside it.",
    finding=Finding(
        "rate",
        "the compass reads {size} lower for each 100 m of depth",
        "the compass reads {size} higher for each 100 m of depth",
        remedy="swing it at depth, or enter the correction by depth",
        each=100.0,
        unit="rad",
    ),
    sizes="1 to 10° over 100 to 1000 m.",
    confused_with=("compass-bias",),
    distinguished_by="Legs on the same headings at several depths.",
    lacking=_needs_depths,
    linear=False,
    terms=(Term(("rate",)),),
)
