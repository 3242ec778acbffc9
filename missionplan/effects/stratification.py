"""Denser water below a pycnocline, which buoys the vehicle up."""

from dataclasses import dataclass

import scipy

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class Stratification(DescentEffect):
    """Extra upward force that grows to `lift_below` [N] through a layer `thickness` thick about `depth` [m].

    The profile is ``½·(1 + tanh(2(z − depth)/thickness))``: 76 % of the step lies within the thickness.
    """

    lift_below: Scalars = 0.0
    depth: Scalars = 10.0
    thickness: Scalars = 2.0

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force [N]."""
        return self.lift_below * scipy.special.expit(4.0 * (depth - self.depth) / self.thickness)


INFO = EffectInfo(
    id="stratification",
    phase="descent",
    tier="physical",
    effect=Stratification,
    parameters={
        "lift": Parameter(
            "N", "extra upward force below the layer", 0.0, 20.0, scale=1.5, spike=0.02, field="lift_below"
        ),
        "depth": Parameter("m", "middle of the layer", 0.5, 500.0, median=9.0, factor=2.0, default=10.0),
        "thickness": Parameter("m", "thickness of the layer", 0.05, 100.0, median=2.5, factor=2.0, default=2.0),
    },
    belongs_to="place",
    what="The vehicle is ballasted at the surface; below the pycnocline the denser water buoys it up.",
    finding=Finding(
        "lift",
        "below a layer of denser water the vehicle is {size} lighter",
        "below a layer the vehicle is {size} heavier",
        remedy="measure temperature and salinity to the bottom, and weigh the anchor for the denser water",
    ),
    sizes="Δρ of 1 to 20 kg/m³ on 10 L: 0.1 to 2 N. Water is denser below, so the lift is positive.",
    confused_with=("trapped-gas", "drag-bias", "drag-crisis"),
    distinguished_by="A density profile (CTD), or dives past the layer with a light anchor.",
    instrument=Instrument("a density profile (CTD) at the place of the dives", "lift", 0.15, 20.0),
)
