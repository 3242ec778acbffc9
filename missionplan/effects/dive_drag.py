"""Effects on the drag and the inertia of a dive."""

from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Scalars
from missionplan.effects.info import EffectInfo, Finding, Parameter, TankRecord
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


def _lacking_in_tank(record: TankRecord) -> str:
    return "" if record.has_vehicle_drag else "the vehicle file has no drag from a tank to lay the data against"


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
    lacking_in_tank=_lacking_in_tank,
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
    """Both bodies' drag times ``1 + extra_drag·exp(−t/time)``, t since the line is taut."""

    extra_drag: Scalars = 0.0
    time: Scalars = 1.5

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 + self.extra_drag * np.exp(-np.maximum(since_taut, 0.0) / self.time)


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
