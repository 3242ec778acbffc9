"""A tunnel thruster on a vehicle under way (Palmer, Hearn & Stevenson 2009).

The jet bends aft along the hull and lowers the pressure on it: the force on the vehicle is less than the thruster's
static thrust, and the moment is not that force times the thruster's lever. Both depend on the speed ratio u/u_j.
Forces are those on the vehicle, positive in the thruster's direction; levers are positive ahead of the pivot.

Static thrust of a thruster against its command, ahead and astern (Avila et al., section 5).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.physics.drag import disc_area

LEAST_FORCE_FACTOR = 0.07
"""Least K_F in the measurements that the paper shows, a loss of 93 % (Beveridge's submersible, its Fig. 2).

Where the exponential falls below it, the force has passed its minimum and the model is out of its range.
"""


@dataclass(frozen=True)
class TunnelThruster:
    """A thruster in a through-body tunnel."""

    diameter: float
    """Of the tunnel [m]."""
    thrust_constant: Scalars
    """K_3: static thrust over shaft rate squared, with the rate in rev/s [N s²] (Palmer et al. 2009b, Eq. 10)."""
    decay: Scalars
    """c of Eq. 4: about 7 for the forward and 3 for the aft thruster of the model; 6.69 for Autosub's."""
    position: float = 0.0
    """x_T, of the thruster ahead of the vehicle's pivot [m]."""
    suction_gradient: float = 0.0
    """k of Eq. 6: the centre of suction lies k D u/u_j aft of the thruster."""
    suction_offset: float = 0.0
    """Distance of the centre of suction aft of the thruster at any speed [m]; that of the model's aft thruster is
    constant."""

    @property
    def area(self) -> float:
        """Of the tunnel [m²]."""
        return float(disc_area(self.diameter))


def static_thrust(thrust_constant: Scalars, revolutions: Scalars) -> Scalars:
    """Thrust at rest, K_3 n|n| (Palmer et al. 2009b, Eq. 10), from n in rev/s [N]."""
    return thrust_constant * revolutions * np.abs(revolutions)


def revolutions_for(thrust_constant: Scalars, static: Scalars) -> Scalars:
    """Shaft rate for a static thrust [N], the inverse of `static_thrust` [rev/s]; 10.85 for 105.9 N and K_3 = 0.90."""
    revolutions: Scalars = np.sign(static) * np.sqrt(np.abs(static) / thrust_constant)
    return revolutions


def jet_speed(static: Scalars, area: Scalars, density: Scalars) -> Scalars:
    """Speed of the jet where it leaves the tunnel, u_j = √(F_T(0, n)/(ρA)) (Eq. 1c) [m/s].

    Parameters
    ----------
    static : float or array
        Static thrust [N]; its sign does not matter.
    area : float or array
        Of the tunnel [m²].
    density : float or array
        ρ [kg/m³].
    """
    speed: Scalars = np.sqrt(np.abs(static) / (density * area))
    return speed


def speed_ratio(speed: Scalars, jet: Scalars) -> Scalars:
    """|u|/u_j; infinite without a jet, 0 where vehicle and jet are both at rest."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.abs(speed) / np.asarray(jet)
    ratio = np.where(np.isnan(ratio), 0.0, ratio)
    return ratio if ratio.ndim else float(ratio)


def force_factor(ratio: Scalars, decay: Scalars) -> Scalars:
    """K_F = exp(-c(u/u_j)²), the share of the static force that acts on the vehicle (Eq. 4).

    It vanishes at high ratios, where the force of ships' thrusters recovers: see `out_of_range`.
    """
    factor: Scalars = np.exp(-decay * ratio**2)
    return factor


def highest_ratio(decay: Scalars) -> Scalars:
    """Speed ratio up to which `force_factor` may be used, 0.63 for c = 6.69 and 0.94 for c = 3 [-]."""
    ratio: Scalars = np.sqrt(-math.log(LEAST_FORCE_FACTOR) / np.asarray(decay))
    return ratio


def out_of_range(ratio: Scalars, decay: Scalars) -> NDArray[np.bool_]:
    """Whether a speed ratio is beyond the force minimum, where ships' thrusters recover but the model does not."""
    return np.asarray(ratio) > highest_ratio(decay)


def suction_force(static: Scalars, factor: Scalars) -> Scalars:
    """F_S = F_T(0, n) - F_T(u, n) (Eq. 2a) [N]: the part of the static force lost to suction, with its sign."""
    return static * (1.0 - factor)


def suction_centre(thruster: TunnelThruster, ratio: Scalars) -> Scalars:
    """x_S ahead of the pivot [m]: x_T - k D u/u_j (Eq. 6, forward thruster) less a constant offset (aft thruster)."""
    return thruster.position - thruster.suction_offset - thruster.suction_gradient * thruster.diameter * ratio


def moment(static: Scalars, factor: Scalars, position: Scalars, centre: Scalars) -> Scalars:
    """Moment on the vehicle, F_T(0, n) x_T - F_S x_S [N m].

    From Eqs. 2 and 3; Eq. 5 has a plus, with which its F_S would be negative. K_N = 1 - (1 - K_F) x_S/x_T.

    Parameters
    ----------
    static, factor : float or array
        Static thrust [N] and K_F.
    position, centre : float or array
        x_T and x_S ahead of the pivot [m].
    """
    return static * position - suction_force(static, factor) * centre


def moment_factor(factor: Scalars, centre_over_position: Scalars) -> Scalars:
    """K_N = 1 - (1 - K_F) x_S/x_T (Eqs. 1b to 3); with c = 3 it changes sign at u/u_j = 0.5 for x_S = 1.9 x_T."""
    return 1.0 - (1.0 - factor) * centre_over_position


@dataclass(frozen=True)
class ThrusterLoad:
    """`force` on the vehicle [N], `moment` about its pivot [N m], and the speed `ratio`."""

    force: Scalars
    moment: Scalars
    ratio: Scalars


def thruster_load(thruster: TunnelThruster, revolutions: Scalars, speed: Scalars, density: Scalars) -> ThrusterLoad:
    """Force and moment of a tunnel thruster on a vehicle under way.

    Parameters
    ----------
    revolutions : float or array
        n [rev/s], either sign.
    speed : float or array
        Along the hull, through the water [m/s].
    density : float or array
        ρ [kg/m³].
    """
    static = static_thrust(thruster.thrust_constant, revolutions)
    ratio = speed_ratio(speed, jet_speed(static, thruster.area, density))
    factor = force_factor(ratio, thruster.decay)
    centre = suction_centre(thruster, np.where(np.isfinite(ratio), ratio, 0.0))
    return ThrusterLoad(static * factor, moment(static, factor, thruster.position, centre), ratio)


def thruster_power(static: Scalars, area: Scalars, density: Scalars, performance: Scalars = 0.55) -> Scalars:
    """Power of a thruster at a static thrust, F^(3/2)/(2α^(3/2)√(ρA)) (2009b, Eq. 13) [W].

    About 240 W for the 105.9 N that keep Autosub at depth, with a 0.196 m tunnel and the paper's α = 0.55.

    Parameters
    ----------
    static : float or array
        Static thrust [N], either sign.
    area, density : float or array
        Of the tunnel [m²], and ρ [kg/m³].
    performance : float or array
        α of the paper: 1 for an ideal thruster.
    """
    power: Scalars = np.abs(static) ** 1.5 / (2.0 * performance**1.5 * np.sqrt(density * area))
    return power


def hover_power(force: float, area: float, density: float, thrusters: int = 1) -> float:
    """Power of several equal thrusters that share a force at rest [W]: two need 1/√2 of one's power (sect. 7.2)."""
    return float(thrusters * thruster_power(force / thrusters, area, density))


def bollard_pull(command: Scalars, ahead: Scalars, astern: Scalars, deadband: Scalars = 0.0) -> Scalars:
    """Thrust in bollard pull, τ = cV|V| with a constant for each direction and a deadband.

    Avila et al., Eq. 6, with V reduced by the deadband: τ = ±c(|V| - V₀)², and zero inside it, so that thrust is
    continuous.

    Parameters
    ----------
    command : float or array
        Voltage [V] or shaft rate [rad/s]; positive ahead.
    ahead, astern : float or array
        c for positive and for negative commands [N per command²]; 9.423 and 6.551 for the URS's thruster, printed
        in N/V².
    deadband : float or array
        V₀ ≥ 0, in units of the command.

    Returns
    -------
    float or array
        Thrust, positive ahead [N].
    """
    beyond = np.maximum(np.abs(command) - deadband, 0.0)
    thrust: Scalars = np.where(np.asarray(command) >= 0.0, ahead, -np.asarray(astern)) * beyond**2
    return thrust
