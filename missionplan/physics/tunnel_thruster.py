"""A tunnel thruster on a vehicle under way (Palmer, Hearn & Stevenson 2009).

The jet bends back along the hull and sucks at it: the vehicle feels less force than the thruster makes, and a
moment that is not the force times the thruster's lever. Everything depends on the speed ratio u/u_j.
Forces are those on the vehicle, positive in the thruster's direction; levers are positive ahead of the pivot.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Scalars
from missionplan.physics.drag import disc_area

LEAST_FORCE_FACTOR = 0.07
"""Least K_F in the measurements that the paper shows, a loss of 93 % (Beveridge's submersible, its Fig. 2).

Where the exponential falls below it the force has passed its minimum, and the model its range.
"""

INDUCED_DRAG_LIMIT = 0.75
"""Speed ratio at which a jet no longer stands in the flow like a cylinder: assumed, the paper shows a figure alone."""


@dataclass(frozen=True)
class TunnelThruster:
    """A thruster in a through-body tunnel.

    Attributes
    ----------
    diameter : float
        Of the tunnel [m].
    thrust_constant : float or array
        K_3: static thrust over shaft rate squared, with the rate in rev/s [N s²] (Palmer et al. 2009b, Eq. 10).
    decay : float or array
        c of Eq. 4: about 7 for the forward thruster, 3 for the aft one of the model; 6.69 for Autosub's.
    position : float
        x_T, of the thruster ahead of the vehicle's pivot [m].
    suction_gradient : float
        k of Eq. 6: the centre of suction lies k D u/u_j aft of the thruster.
    suction_offset : float
        How far aft of the thruster the centre of suction lies whatever the speed [m]; the aft thruster of the model
        has a constant centre.
    """

    diameter: float
    thrust_constant: Scalars
    decay: Scalars
    position: float = 0.0
    suction_gradient: float = 0.0
    suction_offset: float = 0.0

    @property
    def area(self) -> float:
        """Of the tunnel [m²]."""
        return float(disc_area(self.diameter))


def static_thrust(thrust_constant: Scalars, revolutions: Scalars) -> Scalars:
    """Thrust at rest, K_3 n|n| (Palmer et al. 2009b, Eq. 10), from n in rev/s [N]."""
    return thrust_constant * revolutions * np.abs(revolutions)


def revolutions_for(thrust_constant: Scalars, static: Scalars) -> Scalars:
    """Shaft rate that makes a static thrust [N], the inverse of `static_thrust` [rev/s]; 10.85 for 105.9 N at 0.90."""
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
    """|u|/u_j; without a jet it is infinite, and nothing else is asked of it than e^(-∞)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.abs(speed) / np.asarray(jet)
    ratio = np.where(np.isnan(ratio), 0.0, ratio)
    return ratio if ratio.ndim else float(ratio)


def force_factor(ratio: Scalars, decay: Scalars) -> Scalars:
    """K_F = exp(-c(u/u_j)²), the share of the static force that the vehicle feels (Eq. 4).

    It falls to nothing for high ratios, where ships' thrusters recover: see `out_of_range`.
    """
    factor: Scalars = np.exp(-decay * ratio**2)
    return factor


def highest_ratio(decay: Scalars) -> Scalars:
    """Speed ratio up to which `force_factor` may be used, 0.63 for c = 6.69 and 0.94 for c = 3 [-]."""
    ratio: Scalars = np.sqrt(-math.log(LEAST_FORCE_FACTOR) / np.asarray(decay))
    return ratio


def out_of_range(ratio: Scalars, decay: Scalars) -> NDArray[np.bool_]:
    """Whether a speed ratio lies beyond the force minimum, where the exponential goes on falling and ships recover."""
    return np.asarray(ratio) > highest_ratio(decay)


def suction_force(static: Scalars, factor: Scalars) -> Scalars:
    """F_S = F_T(0, n) - F_T(u, n) (Eq. 2a) [N]: how much of the static force suction takes away, of the same sign."""
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
    """What the vehicle feels: `force` [N], `moment` about its pivot [N m], and the speed `ratio` at which."""

    force: Scalars
    moment: Scalars
    ratio: Scalars


def thruster_load(thruster: TunnelThruster, revolutions: Scalars, speed: Scalars, density: Scalars) -> ThrusterLoad:
    """Force and moment of a thruster on a vehicle under way.

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


def induced_drag_coefficient(ratio: Scalars, at_rest: Scalars, vanishes_at: float = INDUCED_DRAG_LIMIT) -> Scalars:
    """Increase of the volumetric drag coefficient that a jet brings, largest at low speed ratios (Fig. 11).

    The paper prints the trend alone, as a figure: a fall that is linear in u/u_j is assumed, and its size at u = 0
    must be given.

    Parameters
    ----------
    ratio : float or array
        u/u_j.
    at_rest : float or array
        ΔC_D on ∇^(2/3) as u/u_j goes to nothing.
    vanishes_at : float
        u/u_j from which there is none.
    """
    drop: Scalars = at_rest * np.clip(1.0 - ratio / vanishes_at, 0.0, 1.0)
    return drop


def thruster_power(static: Scalars, area: Scalars, density: Scalars, performance: Scalars = 0.55) -> Scalars:
    """Power of a thruster that makes a static thrust, F^(3/2)/(2α^(3/2)√(ρA)) (2009b, Eq. 13) [W].

    About 240 W for the 105.9 N that hold Autosub, with A of a 0.196 m tunnel and the paper's α = 0.55.

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
    """Power of some equal thrusters that share a force at rest [W]: two of the same diameter need 1/√2 (sect. 7.2)."""
    return float(thrusters * thruster_power(force / thrusters, area, density))


def diameter_for_same_power(diameter: float, thrusters: int) -> float:
    """Diameter of each of some thrusters that together draw what one of `diameter` draws, D/√thrusters [m]."""
    return diameter / math.sqrt(thrusters)
