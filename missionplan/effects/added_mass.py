"""Water that is carried along and was not counted."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
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
    what="Flooded spaces and added mass that the drawings do not show: the train gathers speed more slowly.",
    sizes=(
        "Free-flooding volume of a hull is 10 to 80 % of its dry mass. Less than drawn is only water that is not "
        "there, some tenth of the train: what was weighed remains."
    ),
    confused_with=("broadside-start", "slow-flooding", "clock-offset"),
    distinguished_by=(
        "Anchors of different weight: a mass error scales with 1/weight, a time constant of the start does not."
    ),
)
