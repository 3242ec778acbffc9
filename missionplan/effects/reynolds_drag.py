"""A drag coefficient that changes with the Reynolds number."""

from dataclasses import dataclass

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankEffect


@dataclass(frozen=True)
class ReynoldsDrag(TankEffect):
    """Drag coefficient times (Re/Re₀)^`exponent`, Re₀ being where the vehicle's coefficient is stated."""

    exponent: Scalars = 0.0

    def drag_factor(self, reynolds_ratio: Array) -> Array | float:
        """Return the factor on the drag coefficient."""
        return reynolds_ratio**self.exponent


INFO = EffectInfo(
    id="reynolds-drag",
    phase="tank",
    tier="physical",
    effect=ReynoldsDrag,
    parameters={
        "exponent": Parameter("", "exponent of C_D in Re, negative where C_D falls", -1.0, 1.0, scale=0.15, spike=0.01)
    },
    what="Friction, or a boundary layer that is not yet turbulent: C_D depends on the towing speed.",
    finding=Finding(
        "exponent",
        "the drag coefficient rises with the towing speed, as its power {size}",
        "the drag coefficient falls as the towing speed rises, as its power −{size}",
        remedy="enter the exponent with the drag in the vehicle file, and tow at the speeds of the mission",
    ),
    sizes="Turbulent friction varies as Re to the power -1/6, laminar friction -1/2; for bluff bodies 0.",
    confused_with=("drag-bias",),
    distinguished_by="Towing over a wider range of speeds: a bias is the same at all speeds.",
    changes_plan=False,
    tank=("drag",),
    vehicle_key="drag.exponent",
)
