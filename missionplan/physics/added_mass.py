"""Added masses of the hull and of the anchor along their axes."""

import numpy as np

from missionplan.arrays import Scalars


def lamb_axial_coefficient(fineness: Scalars) -> Scalars:
    """Lamb's k₁: added mass of a prolate spheroid along its axis, over the mass that it displaces.

    Parameters
    ----------
    fineness : float or array
        Length over diameter, ≥ 1.

    Returns
    -------
    float or array
        k₁ = α₀/(2 - α₀), α₀ = 2(1 - e²)/e³ · (artanh e - e), e the eccentricity (Lamb, Hydrodynamics, art. 114).
        1/2 for a sphere, 0.210 at l/d 2, 0.122 at 3, 0.0233 at 9.26.

    Raises
    ------
    ValueError
        When a fineness is below 1: an oblate body has another formula.
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
