"""Added mass and floodwater beyond those of the drawings."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class AddedMass(DescentEffect):
    """Joint mass times ``1 + fraction``, in the snatch too."""

    fraction: Scalars = 0.0

    def mass_factor(self) -> Scalars:
        """Return the factor on the joint mass."""
        return 1.0 + self.fraction


INFO = EffectInfo(
    id="added-mass",
    phase="descent",
    tier="physical",
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
