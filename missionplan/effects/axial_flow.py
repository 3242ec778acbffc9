"""Dynamics of the axial flow through the propeller disc (Blanke, Lindegaard & Fossen 2000)."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankEffect


@dataclass(frozen=True)
class AxialFlow(TankEffect):
    """Flow in the disc as a state of its own, with mass `mass_factor`·ρ A_p D (γ of the paper's m_f)."""

    mass_factor: Scalars = 1.0

    def flow_mass_factor(self) -> Scalars:
        """Return m_f over ρ A_p D."""
        return self.mass_factor


INFO = EffectInfo(
    id="axial-flow",
    phase="tank",
    tier="physical",
    effect=AxialFlow,
    parameters={
        "mass_factor": Parameter(
            "", "water that moves with the disc over ρ A_p D", 0.02, 50.0, median=1.0, factor=3.0, default=1.0
        )
    },
    what="After a change of shaft rate the thrust overshoots until the flow in the disc has adjusted.",
    finding=Finding(
        "mass_factor",
        "after each change of shaft rate the thrust overshoots, as the propeller sets {size} discs' diameters of water "
        "in motion",
        remedy="take flow_mass from `identify` into the vehicle file, and change the shaft rate in ramps",
    ),
    sizes="The paper does not give the factor; one disc diameter of water is 1.",
    confused_with=(),
    distinguished_by="Steps of shaft rate, thrust sampled several times within the flow's settling time.",
    changes_plan=False,
    tank=("propeller-transient",),
)
