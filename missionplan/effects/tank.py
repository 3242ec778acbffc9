"""Effects that tank data alone show."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, Parameter, TankEffect, TankRecord
from missionplan.physics.tunnel_thruster import force_factor


@dataclass(frozen=True)
class ReynoldsDrag(TankEffect):
    """Drag coefficient times (Re/Re₀)^`exponent`, Re₀ being where the vehicle's coefficient is stated."""

    exponent: Scalars = 0.0

    def drag_factor(self, reynolds_ratio: Array) -> Array | float:
        """Return the factor on the drag coefficient."""
        return reynolds_ratio**self.exponent


REYNOLDS_DRAG = EffectInfo(
    id="reynolds-drag",
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


@dataclass(frozen=True)
class QuadraticDamping(TankEffect):
    """Deceleration `rate`·ẋ|ẋ| of the oscillating mass [1/m]: the drag ½ρAC_D over mass and added mass."""

    rate: Scalars = 0.0

    def damping(self) -> Scalars:
        """Return β of ẍ + 2δẋ + βẋ|ẋ| + ω²x = 0 [1/m]."""
        return self.rate


QUADRATIC_DAMPING = EffectInfo(
    id="quadratic-damping",
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


@dataclass(frozen=True)
class JetSuction(TankEffect):
    """Static force times exp(-`decay`·(u/u_j)²), Eq. 4."""

    decay: Scalars = 0.0

    def thrust_factor(self, command: Array, jet_ratio: Array) -> Array | float:
        """Return the share of the static force that acts on the vehicle."""
        return force_factor(jet_ratio, self.decay)


def _needs_jet_speed(record: TankRecord) -> str:
    if not record.has_jet_speed:
        return "it needs the shaft rate (rpm) and the tunnel's diameter (geometry)"
    return "" if record.is_under_way else "there is no row under way"


JET_SUCTION = EffectInfo(
    id="jet-suction",
    effect=JetSuction,
    parameters={"decay": Parameter("", "c of K_F = exp(-c(u/u_j)²)", 0.0, 50.0, scale=5.0, spike=0.05)},
    what="Under way the jet lowers the pressure on the hull beside it, so that less than the static thrust acts.",
    finding=Finding(
        "decay",
        "under way the jet's suction on the hull takes thrust away: exp(−c·(u/u_j)²) of it is left, with c = {size}",
        remedy="enter that decay with the thruster in the vehicle file, and slow down before it has to hold depth",
    ),
    sizes="c of 3 for an aft thruster to 7 for a forward one (Palmer et al.).",
    confused_with=("thrust-asymmetry",),
    distinguished_by="Thrust at rest and at two speeds ahead, with the same shaft rates in both directions.",
    changes_plan=False,
    tank=("thruster",),
    lacking_in_tank=_needs_jet_speed,
)


@dataclass(frozen=True)
class ThrustAsymmetry(TankEffect):
    """Thrust for negative commands times 1 - `fraction`."""

    fraction: Scalars = 0.0

    def thrust_factor(self, command: Array, jet_ratio: Array) -> Array | float:
        """Return the factor on the static force."""
        return np.where(command < 0.0, 1.0 - np.asarray(self.fraction), 1.0)


THRUST_ASYMMETRY = EffectInfo(
    id="thrust-asymmetry",
    effect=ThrustAsymmetry,
    parameters={
        "fraction": Parameter(
            "", "share of the thrust ahead that is missing astern", -2.0, 0.95, scale=0.25, spike=0.01
        )
    },
    what="Blades, nozzle and hub are designed for one direction: the same command gives a different thrust astern.",
    finding=Finding(
        "fraction",
        "astern, {size} of the thrust ahead is missing",
        "astern, the thrust is {size} greater than ahead",
        remedy="enter the thrust astern in the vehicle file",
        in_percent=True,
    ),
    sizes="0 to 40 % less astern; a third for the thruster of Avila et al.",
    confused_with=("jet-suction",),
    distinguished_by="Bollard pull with the same commands ahead and astern.",
    changes_plan=False,
    tank=("thruster",),
    lacking_in_tank=lambda record: "" if record.has_both_signs else "the commands have one sign",
)


@dataclass(frozen=True)
class AxialFlow(TankEffect):
    """Flow in the disc as a state of its own, with mass `mass_factor`·ρ A_p D (γ of the paper's m_f)."""

    mass_factor: Scalars = 1.0

    def flow_mass_factor(self) -> Scalars:
        """Return m_f over ρ A_p D."""
        return self.mass_factor


AXIAL_FLOW = EffectInfo(
    id="axial-flow",
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
