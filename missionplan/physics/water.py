"""Density and viscosity of sea water."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars

REFERENCE_SALINITY_RATIO = 35.16504 / 35.0
"""Absolute (reference) salinity [g/kg] over practical salinity, TEOS-10."""


@dataclass(frozen=True)
class Water:
    """Density and viscosity of water.

    Attributes
    ----------
    density : float or array, shape (n,)
        ρ [kg/m³].
    viscosity : float or array, shape (n,)
        Kinematic viscosity ν [m²/s].
    """

    density: Scalars
    viscosity: Scalars


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
