"""Drag that differs from the formulae by a constant factor."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankRecord
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


INFO = EffectInfo(
    id="drag-bias",
    phase="descent",
    tier="physical",
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
    upkeep="clean the hull",
    confused_with=("depth-scale", "vertical-current", "trapped-gas", "drag-crisis"),
    distinguished_by=(
        "A depth calibration; dives with a much lighter anchor (a current shifts every speed alike, drag does not)."
    ),
    scatter="drag",
    tank=("drag",),
    lacking_in_tank=_lacking_in_tank,
    vehicle_key="drag.coefficient",
)
