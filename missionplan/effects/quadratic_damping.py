"""Quadratic damping of an oscillation."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankEffect


@dataclass(frozen=True)
class QuadraticDamping(TankEffect):
    """Deceleration `rate`·ẋ|ẋ| of the oscillating mass [1/m]: the drag ½ρAC_D over mass and added mass."""

    rate: Scalars = 0.0

    def damping(self) -> Scalars:
        """Return β of ẍ + 2δẋ + βẋ|ẋ| + ω²x = 0 [1/m]."""
        return self.rate


INFO = EffectInfo(
    id="quadratic-damping",
    phase="tank",
    tier="physical",
    effect=QuadraticDamping,
    parameters={"rate": Parameter("1/m", "quadratic damping over the total mass", 0.0, 50.0, scale=2.0, spike=0.02)},
    what="Separated flow: large swings decay faster than small ones.",
    finding=Finding(
        "rate",
        "large swings lose more of their height than small ones, with a quadratic damping of {size}",
        remedy="take added mass and damping from a fit that has it, and release from small displacements too",
    ),
    sizes="C_D/4 over the body's length: 0.1 to 5 1/m for models of 0.2 to 1 m.",
    confused_with=("added-mass",),
    distinguished_by="Releases from several displacements: linear damping removes the same share of every swing.",
    changes_plan=False,
    tank=("free-oscillation",),
)
