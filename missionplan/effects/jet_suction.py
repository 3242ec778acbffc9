"""Suction of a tunnel thruster's jet on the hull under way (Palmer, Hearn & Stevenson 2009)."""

from dataclasses import dataclass

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankEffect, TankRecord
from missionplan.physics.tunnel_thruster import force_factor


@dataclass(frozen=True)
class JetSuction(TankEffect):
    """Static force times exp(-`decay`·(u/u_j)²), Eq. 4."""

    decay: Scalars = 0.0

    def thrust_factor(self, command: Array, jet_ratio: Array) -> Array | float:
        """Return the share of the static force that acts on the vehicle."""
        return force_factor(jet_ratio, self.decay)


def _lacking_in_tank(record: TankRecord) -> str:
    if not record.has_jet_speed:
        return "it needs the shaft rate (rpm) and the tunnel's diameter (geometry)"
    return "" if record.is_under_way else "there is no row under way"


INFO = EffectInfo(
    id="jet-suction",
    phase="tank",
    tier="physical",
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
    lacking_in_tank=_lacking_in_tank,
)
