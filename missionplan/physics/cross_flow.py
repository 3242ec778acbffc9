"""Drag and moving mass of upright bodies in a horizontal current: the cross-flow principle (Hoerner, ch. III).

The force across a slender body depends on the velocity across it alone, and that along it on the velocity along it.
"""

import math

import numpy as np

from missionplan.arrays import Scalars

HULL_COEFFICIENT = 1.1
"""C_d of a long circular cylinder across the flow, subcritical, on length × diameter (Hoerner, ch. III)."""
ANCHOR_COEFFICIENT = 0.7
"""C_d of a circular cylinder one to three diameters long, free at both ends: 0.64 to 0.74 (as above)."""


def drag_factor(coefficient: float, area: Scalars, density: Scalars) -> Scalars:
    """Factor ½ ρ C_d A [N s²/m²] of the drag k w|w|, from an area [m²] and the water's density [kg/m³]."""
    return 0.5 * density * coefficient * area


def lateral_coefficient(axial: Scalars) -> Scalars:
    """Lamb's k₂ of a prolate spheroid across its axis, from its k₁ along it: 1/(1 + 2k₁).

    As α₀ + 2β₀ = 2 (Lamb, Hydrodynamics, art. 114). 1/2 for a sphere, 1 for a long cylinder.
    """
    return 1.0 / (1.0 + 2.0 * axial)


def round_nosed_length(volume: Scalars, diameter: Scalars) -> Scalars:
    """Length of a cylinder with one hemispherical end, at least its diameter, from volume [m³] and diameter [m] [m].

    The shape of an anchor whose parts are not given.
    """
    r = np.asarray(diameter) / 2.0
    tube = (volume - 2.0 / 3.0 * math.pi * r**3) / (math.pi * r**2)
    return np.maximum(tube, r) + r


def round_nosed_silhouette(length: Scalars, diameter: Scalars) -> Scalars:
    """Area that a cylinder with one hemispherical end presents across its axis [m²]."""
    r = np.asarray(diameter) / 2.0
    return (length - r) * diameter + 0.5 * math.pi * r**2
