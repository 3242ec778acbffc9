"""Effects on the drag and inertia of a dive, on weight and lift, and on the water that it goes through."""

from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Scalars
from missionplan.effects.info import EffectInfo, Finding, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class DragBias(DescentEffect):
    """Both bodies' drag times ``1 + fraction``, in the anchor's free fall too."""

    fraction: Scalars = 0.0

    def lone_drag_factor(self) -> Scalars:
        """Return the factor on the anchor's drag while it falls alone."""
        return 1.0 + self.fraction

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 + self.fraction


DRAG_BIAS = EffectInfo(
    id="drag-bias",
    effect=DragBias,
    parameters={
        # a drag measured in one tank holds in another to 2 %
        "fraction": Parameter(
            "", "relative error of the drag, more drag positive", -0.7, 2.0, scale=0.3, spike=0.01, tank_spike=0.02
        )
    },
    what=(
        "Form factor, roughness, fins, line and fittings: the drag of vehicle and anchor is wrong by a constant factor."
    ),
    finding=Finding(
        "fraction",
        "vehicle and anchor have {size} more drag than the model",
        "vehicle and anchor have {size} less drag than the model",
        remedy="plan with the extended mission, and measure the drag by a tow",
        in_percent=True,
    ),
    sizes="Drag build-ups of streamlined bodies are wrong by 10 to 40 %; Table I of Briggs et al. requires 60 to 80 %.",
    ageing="drifts",
    upkeep=("clean the hull", "check that no fitting is lost, and the anchors' weights"),
    confused_with=("depth-scale", "vertical-current", "trapped-gas", "drag-crisis"),
    distinguished_by=(
        "A depth calibration; dives with a much lighter anchor (a current shifts every speed alike, drag does not)."
    ),
    scatter="drag",
    tank=("drag",),
    lacking_in_tank=lambda record: (
        "" if record.has_vehicle_drag else "the vehicle file has no drag from a tank to lay the data against"
    ),
    vehicle_key="drag.coefficient",
)


@dataclass(frozen=True)
class DragCrisis(DescentEffect):
    """Both bodies' drag falls by `fraction` about a critical `speed` through the water [m/s].

    The factor is ``1 − fraction·½(1 + tanh((U − speed)/width))``.
    """

    fraction: Scalars = 0.0
    speed: Scalars = 1.2
    width: Scalars = 0.1

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 - self.fraction * scipy.special.expit(2.0 * (speed - self.speed) / self.width)


DRAG_CRISIS = EffectInfo(
    id="drag-crisis",
    effect=DragCrisis,
    parameters={
        "fraction": Parameter("", "share of the drag lost above the critical speed", 0.0, 0.9, scale=0.3, spike=0.005),
        "speed": Parameter("m/s", "critical speed through the water", 0.1, 5.0, median=1.2, factor=1.5, default=1.2),
        "width": Parameter("m/s", "half width of the change", 0.01, 2.0, median=0.12, factor=2.0, default=0.1),
    },
    what="The boundary layer of the anchor's blunt nose turns turbulent and the wake narrows.",
    finding=Finding(
        "fraction",
        "above a critical speed {size} of the drag is lost",
        remedy="plan dives that stay clear of that speed, or with the extended mission",
        in_percent=True,
    ),
    sizes="Spheres lose up to 80 % near Re 3e5, blunt anchors 10 to 50 %, at 0.8 to 1.8 m/s for this size.",
    confused_with=("drag-bias", "stratification"),
    distinguished_by="Anchor weights whose terminal speeds lie well below and well above the critical speed.",
)


@dataclass(frozen=True)
class BroadsideStart(DescentEffect):
    """Both bodies' drag times ``1 + extra_drag·sin³θ``, θ the angle of the hull to its way, with sin θ = sech(t/time).

    Across the flow at first, t since the line is taut: the law of a cylinder's cross-flow drag (Hoerner 1965, ch. III),
    and the turn of a hull whose nose is pulled by a steady force and whose water resists in proportion to the rate.
    """

    extra_drag: Scalars = 0.0
    time: Scalars = 1.5

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        turned = np.exp(-np.maximum(since_taut, 0.0) / self.time)
        return 1.0 + self.extra_drag * (2.0 * turned / (1.0 + np.square(turned))) ** 3


BROADSIDE_START = EffectInfo(
    id="broadside-start",
    effect=BroadsideStart,
    parameters={
        "extra_drag": Parameter(
            "", "extra drag when the line goes taut, as a factor", 0.0, 60.0, scale=4.0, spike=0.05
        ),
        "time": Parameter("s", "time constant of the pitching", 0.1, 8.0, median=2.0, factor=1.9, default=1.5),
    },
    what="The line pulls a level vehicle down: until it pitches nose down, the water meets its side and not its nose.",
    finding=Finding(
        "extra_drag",
        "while the line goes taut the vehicle lies across its way, with {size} more drag",
        remedy="give the line more room to pay out before it goes taut, or plan with the longer dive",
        in_percent=True,
    ),
    sizes=(
        "The cross-flow drag of a slender hull is 10 to 30 times its axial drag; it pitches nose down in 1 to 5 s. A "
        "hull that takes longer has sunk by several lengths meanwhile, and is not about to pitch down."
    ),
    confused_with=("added-mass", "slow-flooding"),
    distinguished_by="Pitch in the log; a dive released nose down; anchors of different weight.",
)


@dataclass(frozen=True)
class AddedMass(DescentEffect):
    """Joint mass times ``1 + fraction``, in the snatch too."""

    fraction: Scalars = 0.0

    def mass_factor(self) -> Scalars:
        """Return the factor on the joint mass."""
        return 1.0 + self.fraction


ADDED_MASS = EffectInfo(
    id="added-mass",
    effect=AddedMass,
    parameters={
        "fraction": Parameter(
            "", "relative error of the joint mass, heavier positive", -0.1, 3.0, scale=0.4, spike=0.03
        )
    },
    what="Flooded spaces and added mass that the drawings do not show: vehicle and anchor accelerate more slowly.",
    finding=Finding(
        "fraction",
        "vehicle, anchor and the water that they move are {size} heavier than the model has them",
        "vehicle, anchor and the water that they move are {size} lighter than the model has them",
        remedy="weigh the flooded vehicle, and plan with the extended mission",
        in_percent=True,
    ),
    sizes=(
        "The free-flooding volume of a hull is 10 to 80 % of its dry mass. A mass below the drawings can only be "
        "missing water, about a tenth of vehicle and anchor together, as their dry masses were weighed."
    ),
    confused_with=("broadside-start", "slow-flooding", "clock-offset"),
    distinguished_by=(
        "Anchors of different weight: the effect of a mass error scales with 1/weight, a time constant does not."
    ),
    follows_law=True,
    tank=("free-oscillation",),
    vehicle_key="added_mass.surge",
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
