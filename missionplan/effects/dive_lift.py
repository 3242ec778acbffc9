"""Effects on the weight, lift and line of a dive, and on the water that it goes through."""

from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Scalars
from missionplan.effects.info import EffectInfo, Finding, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class LinePayout(DescentEffect):
    """Everything after the separation is delayed by `delay_per_length` for each metre of line."""

    delay_per_length: Scalars = 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Return the delay [s]."""
        return self.delay_per_length * line_length


LINE_PAYOUT = EffectInfo(
    id="line-payout",
    effect=LinePayout,
    parameters={"delay_per_length": Parameter("s/m", "delay for each metre of line", 0.0, 5.0, scale=0.2, spike=0.004)},
    what=(
        "Friction or tangling on the spool: the line pays out more slowly than the anchor's free fall would pull it."
    ),
    finding=Finding(
        "delay_per_length",
        "the line takes {size} to pay out",
        remedy="plan with the slower dive, or let the line run more freely",
    ),
    sizes="From zero to about half a second per metre; a delay is positive. Assumed from hand-wound spools.",
    confused_with=("clock-offset",),
    distinguished_by=("Dives with a much longer or shorter line; with one length it is identical to a clock offset."),
)


@dataclass(frozen=True)
class SlowFlooding(DescentEffect):
    """Anchor's wet weight times ``1 − fraction·exp(−t/time)``, t since the separation."""

    fraction: Scalars = 0.0
    time: Scalars = 5.0

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Return the factor on the anchor's wet weight."""
        return 1.0 - self.fraction * np.exp(-np.maximum(since_separation, 0.0) / self.time)


SLOW_FLOODING = EffectInfo(
    id="slow-flooding",
    effect=SlowFlooding,
    parameters={
        "fraction": Parameter("", "share of the wet weight missing at first", 0.0, 1.0, scale=0.3, spike=0.005),
        "time": Parameter("s", "time constant of the flooding", 0.2, 60.0, median=4.0, factor=2.2, default=5.0),
    },
    what="The anchor's tube floods through small holes: it starts light and approaches its wet weight exponentially.",
    finding=Finding(
        "fraction",
        "{size} of the anchor's wet weight is missing when it separates, until it has flooded",
        remedy="open larger flooding holes, or wet the anchor before its release",
        in_percent=True,
    ),
    sizes=(
        "The tube's free volume relative to its wet weight allows 0 to 60 %; holes of a few mm flood it in 1 to 15 s."
    ),
    confused_with=("added-mass", "broadside-start", "trapped-gas"),
    distinguished_by="Anchors with large flooding holes, or a dive with the anchor flooded before release.",
)


ATMOSPHERE = 10.1
"""Depth of water that adds one atmosphere of pressure [m]; 10.07 m in sea water, 10.33 m in fresh."""


@dataclass(frozen=True)
class TrappedGas(DescentEffect):
    """Upward force `lift_at_surface` [N], halved at about 10 m by Boyle's law (isothermal).

    The gas sits `height` [m] above the nose, whose depth is the vehicle's, where the hull hangs nose down.
    """

    lift_at_surface: Scalars = 0.0
    height: Scalars = 0.0

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force at a depth of the nose [N]."""
        return self.lift_at_surface / (1.0 + np.maximum(depth - self.height, 0.0) / ATMOSPHERE)


TRAPPED_GAS = EffectInfo(
    id="trapped-gas",
    effect=TrappedGas,
    parameters={
        "lift": Parameter(
            "N", "upward force of the bubble at the surface", 0.0, 20.0, scale=1.5, spike=0.02, field="lift_at_surface"
        ),
        "height": Parameter(
            "m", "height of the gas above the nose, when the vehicle hangs nose down", 0.0, 10.0, median=0.4, factor=2.0
        ),
    },
    what=(
        "Air under fairings or in the sail buoys the vehicle up and is compressed with depth: the descent accelerates."
    ),
    finding=Finding(
        "lift",
        "gas trapped in the vehicle lifts it by {size} at the surface",
        remedy="vent it before the dive, with the nose down",
    ),
    follows_law=True,
    sizes="0.1 to 0.4 L of air, 1 to 4 N; always upward.",
    confused_with=("stratification", "drag-bias", "slow-flooding"),
    distinguished_by=(
        "A dive twice as deep, or with the vehicle purged by hand; lighter anchors, with which a lift matters more."
    ),
)


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


STRATIFICATION = EffectInfo(
    id="stratification",
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


@dataclass(frozen=True)
class VerticalCurrent(DescentEffect):
    """Water about both bodies that moves down at `speed` [m/s]."""

    speed: Scalars = 0.0

    def water_velocity(self) -> Scalars:
        """Return the downward velocity of the water [m/s]."""
        return self.speed


VERTICAL_CURRENT = EffectInfo(
    id="vertical-current",
    effect=VerticalCurrent,
    parameters={"speed": Parameter("m/s", "of the water, down positive", -1.0, 1.0, scale=0.12, spike=0.003)},
    belongs_to="day",
    what=(
        "Up- or downwelling along a slope, Langmuir circulation, internal waves: the bodies sink through moving water."
    ),
    finding=Finding(
        "speed",
        "the water sinks at {size}",
        "the water rises at {size}",
        remedy="dive at another state of the tide, or plan with the extended mission",
    ),
    sizes="0.02 to 0.3 m/s in coastal water, where more is not known. Either sign.",
    confused_with=("drag-bias", "depth-scale"),
    distinguished_by=(
        "Dives with 0.4 times the anchor's weight: a current shifts slow and fast dives alike, drag does not."
    ),
    instrument=Instrument("a current profiler beside the dives", "speed", 0.02),
)
