"""Fixes that are less accurate than the mission assumes."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import TransitEffect


@dataclass(frozen=True)
class FixError(TransitEffect):
    """Extra standard deviation `sd` [m] of every fix, each axis."""

    sd: Scalars = 0.0

    def fix_variance(self) -> Scalars:
        """Return the extra variance of a fix, each axis [m²]."""
        return np.square(self.sd)


INFO = EffectInfo(
    id="fix-error",
    phase="transit",
    tier="statistical",
    effect=FixError,
    parameters={
        "sd": Parameter("m", "extra standard deviation of a fix, each axis", 0.0, 2000.0, median=25.0, factor=2.0)
    },
    what="Few satellites, waves over the antenna, outdated ephemerides: fixes scatter more than assumed.",
    finding=Finding(
        "sd",
        "a fix errs by {size} more than stated",
        remedy="wait longer at the surface for better fixes, or raise the antenna",
    ),
    sizes="10 to 100 m for a first fix with a wet antenna at the waterline.",
    confused_with=("heavy-tails",),
    distinguished_by=(
        "Legs of very different duration, as a fix error matters on short legs alone; a minute of fixes on land."
    ),
    part="covariance",
    instrument=Instrument("an hour of fixes with the vehicle at a known place in the water", "sd", 3.0),
)
