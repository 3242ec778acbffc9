"""Sea water: density and viscosity; submerged bodies: weights, displaced and added masses; the tide's constituents.

Frequencies, Greenwich arguments and nodal corrections of the tide are those of UTide [1]_ (Foreman's tables), which is
imported when first used, because it loads SciPy's signal processing.

References
----------
.. [1] D. L. Codiga, "Unified Tidal Analysis and Prediction Using the UTide Matlab Functions", Technical Report 2011-01,
   Graduate School of Oceanography, University of Rhode Island, 2011; Python version by W. Bowman and others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from missionplan.arrays import Array, Scalars

REFERENCE_SALINITY_RATIO = 35.16504 / 35.0
"""Absolute (reference) salinity [g/kg] over practical salinity, TEOS-10."""


@dataclass(frozen=True)
class Water:
    """Density and viscosity of water."""

    density: Scalars
    """ρ, float or shape (n,) [kg/m³]."""
    viscosity: Scalars
    """Kinematic viscosity ν, float or shape (n,) [m²/s]."""


def sea_water_density(temperature: Scalars, salinity: Scalars) -> Scalars:
    """Density at the surface, TEOS-10, with the reference composition of sea water.

    Parameters
    ----------
    temperature : float or array
        In-situ temperature [°C].
    salinity : float or array
        Practical salinity.

    Returns
    -------
    float or array
        ρ at zero sea pressure [kg/m³]; 1025.98 at 15 °C and S = 35.
    """
    import gsw  # a mission that states the density needs none of it

    absolute = np.multiply(salinity, REFERENCE_SALINITY_RATIO)
    density = gsw.rho_t_exact(absolute, temperature, 0.0)
    return density if np.ndim(density) else float(density)


def sea_water_dynamic_viscosity(temperature: Scalars, salinity: Scalars) -> Scalars:
    """Dynamic viscosity, Sharqawy, Lienhard & Zubair (2010), Eqs. 22–23.

    Parameters
    ----------
    temperature : float or array
        [°C], 0 to 180.
    salinity : float or array
        Practical salinity, 0 to 150; its thousandth stands for the mass fraction [kg/kg].

    Returns
    -------
    float or array
        μ [Pa s], given as within 1.5 % of measurements.
    """
    t, s = temperature, salinity / 1000.0
    pure = 4.2844e-5 + 1.0 / (0.157 * (t + 64.993) ** 2 - 91.296)
    a = 1.541 + 1.998e-2 * t - 9.52e-5 * t**2
    b = 7.974 - 7.561e-2 * t + 4.724e-4 * t**2
    return pure * (1.0 + a * s + b * s**2)


def sea_water(temperature: Scalars, salinity: Scalars) -> Water:
    """Water of a temperature [°C] and practical salinity, at the surface."""
    density = sea_water_density(temperature, salinity)
    return Water(density, sea_water_dynamic_viscosity(temperature, salinity) / density)


STANDARD_GRAVITY = 9.80665
"""g [m/s²], the conventional value."""
LEAD_DENSITY = 11_340.0
"""Of lead, the densest that anchors are made of [kg/m³]."""


def wet_weight(mass: Scalars, material_density: Scalars, water_density: Scalars) -> Scalars:
    """Weight of a solid in water, m (1 - ρ/ρ_i) g [N], from its mass [kg] and the two densities [kg/m³]."""
    return mass * (1.0 - water_density / material_density) * STANDARD_GRAVITY


def lead_mass(weight: Scalars, water_density: Scalars) -> Scalars:
    """Mass of lead of a wet weight W [N] in water of a density ρ [kg/m³], W/g(1 - ρ/ρ_lead) [kg]."""
    return weight / wet_weight(1.0, LEAD_DENSITY, water_density)


def displaced_mass(mass: Scalars, net_buoyancy: Scalars) -> Scalars:
    """Mass of the water that a body displaces, m + B_net/g [kg], from its mass [kg] and net buoyancy [N]."""
    return mass + net_buoyancy / STANDARD_GRAVITY


def flooded_mass(dry_mass: Scalars, weight_in_water: Scalars) -> Scalars:
    """Mass of a neutrally trimmed anchor once it is flooded.

    Attached, the sealed anchor displaces its own mass of water (Eqs. 16–17): ρ∇ = m_dry. Flooded, the water inside has
    mass ρ(∇ - Σ m_i/ρ_i), and with the wet weight W = (m_dry - ρ Σ m_i/ρ_i) g the sum is m_dry + W/g.

    Parameters
    ----------
    dry_mass : float or array
        Of the unflooded anchor [kg].
    weight_in_water : float or array
        Wet weight of the flooded anchor [N].

    Returns
    -------
    float or array
        Mass with the water inside, without added mass [kg].
    """
    return dry_mass + weight_in_water / STANDARD_GRAVITY


def lamb_axial_coefficient(fineness: Scalars) -> Scalars:
    """Lamb's k₁: added mass of a prolate spheroid along its axis, over the mass that it displaces.

    Raises ValueError when a fineness is below 1: an oblate body has another formula.

    Parameters
    ----------
    fineness : float or array
        Length over diameter, ≥ 1.

    Returns
    -------
    float or array
        k₁ = α₀/(2 - α₀), α₀ = 2(1 - e²)/e³ · (artanh e - e), e the eccentricity (Lamb, Hydrodynamics, art. 114).
        1/2 for a sphere, 0.210 at l/d 2, 0.122 at 3, 0.0233 at 9.26.
    """
    ratio = np.asarray(fineness, dtype=float)
    if np.any(ratio < 1.0):
        raise ValueError("Lamb's prolate spheroid has a length of at least its diameter")
    squared = 1.0 - 1.0 / ratio**2
    e = np.sqrt(squared)
    # artanh e - e cancels near the sphere; its series e³(1/3 + e²/5 + e⁴/7 + …) does not.
    series = 1.0 / 3.0 + squared * (1.0 / 5.0 + squared * (1.0 / 7.0 + squared * (1.0 / 9.0 + squared / 11.0)))
    far = squared > 0.01
    safe = np.where(far, e, 0.5)
    bracket = np.where(far, (np.arctanh(safe) - safe) / safe**3, series)
    alpha = 2.0 * (1.0 - squared) * bracket
    k1 = alpha / (2.0 - alpha)
    return k1 if k1.ndim else float(k1)


def lamb_lateral_coefficient(fineness: Scalars) -> Scalars:
    """Lamb's k₂: added mass of a prolate spheroid across its axis, over the mass that it displaces.

    Parameters
    ----------
    fineness : float or array
        Length over diameter, ≥ 1.

    Returns
    -------
    float or array
        k₂ = β₀/(2 - β₀) with α₀ + 2β₀ = 2 (Lamb, art. 114), which is 1/(1 + 2k₁): 1/2 for a sphere, 0.955 at 9.26.
    """
    return 1.0 / (1.0 + 2.0 * lamb_axial_coefficient(fineness))


def anchor_added_mass(radius: Scalars, water_density: Scalars) -> Scalars:
    """Estimate the anchor's axial added mass: half a sphere's and half a disc's, (π/3 + 4/3) ρ r³ = 2.38 ρ r³.

    Half of the sphere's ⅔πρr³ for the rounded front and half of the disc's 8/3 ρr³ for the blunt back: an estimate,
    not validated. The water inside the anchor moves with it and is part of its flooded mass.

    Parameters
    ----------
    radius : float or array
        [m].
    water_density : float or array
        [kg/m³].

    Returns
    -------
    float or array
        [kg]; 0.536 for the prototype's anchor.
    """
    return (np.pi / 3.0 + 4.0 / 3.0) * water_density * radius**3


EPOCH_DAY = 719163.0
"""The 1st of January 1970 in the days of Python's calendar, which UTide counts in [d]."""
DAY = 86400.0
LEAST_LATITUDE = np.radians(5.0)
"""Nearer the equator the nodal corrections of diurnal constituents are those of this latitude, as in UTide [rad]."""


@dataclass(frozen=True)
class NodalState:
    """Constituents at a moment, or at d of them.

    The tide of one is ``f·A·cos(V + u − g)`` with the Greenwich phase lag g.
    """

    factor: Array
    """f, by which the node changes the amplitude, shape (k,) or (k, d)."""
    angle: Array
    """u, by which the node changes the phase, shape (k,) or (k, d) [rad]."""
    argument: Array
    """V, the astronomical argument at Greenwich, shape (k,) or (k, d) [rad]."""


def angular_frequencies(names: Sequence[str]) -> Array:
    """Angular frequencies of constituents, shape (k,) [rad/s].

    Raises KeyError when UTide has no such constituent.

    Parameters
    ----------
    names : sequence of str
        Such as ``M2``.
    """
    from utide._ut_constants import ut_constants

    cycles_per_hour = np.asarray(ut_constants["const"].freq, dtype=float)
    return 2.0 * np.pi * cycles_per_hour[_indices(names)] / 3600.0


def nodal_state(names: Sequence[str], moment: Scalars, latitude: float) -> NodalState:
    """Nodal corrections and Greenwich arguments of constituents at a moment.

    They change by less than 1 % in a month, so that one moment serves a mission. Raises KeyError when UTide has no such
    constituent.

    Parameters
    ----------
    names : sequence of str
        Such as ``M2``.
    moment : float or array, shape (d,)
        Seconds since the start of 1970, UTC.
    latitude : float
        [rad]
    """
    from utide.harmonics import FUV

    days = EPOCH_DAY + np.atleast_1d(moment) / DAY
    south = -1.0 if latitude < 0.0 else 1.0
    north = south * max(abs(latitude), LEAST_LATITUDE)
    corrections = FUV(days, days[0], _indices(names), np.degrees(north), [0, 0, 0, 0])
    factor, angle, argument = (correction.T if np.ndim(moment) else correction[0] for correction in corrections)
    return NodalState(factor, 2.0 * np.pi * angle, 2.0 * np.pi * argument)


@cache
def constituent_names() -> tuple[str, ...]:
    """Names of all constituents that UTide knows."""
    from utide._ut_constants import constit_index_dict

    return tuple(constit_index_dict)


def _indices(names: Sequence[str]) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
    from utide._ut_constants import constit_index_dict

    return np.array([constit_index_dict[name] for name in names], dtype=np.intp)
