"""Drag of hull, sail and anchor by the methods of Briggs et al., section III (Eqs. 2–13)."""

import numpy as np

from missionplan.arrays import Scalars

REYNOLDS_HELD = 1e4
"""Below it C_f is held constant: the ITTC line is singular at Re = 100, which every dive passes."""
REYNOLDS_TURBULENT = 5e5
"""Above it a smooth plate's boundary layer is turbulent, as the ITTC line assumes."""
REYNOLDS_HIGHEST = 1e10
"""Largest Reynolds number of ships, and of the data behind the ITTC line."""
FORM_CONSTANTS = {"briggs": 2.643, "hoerner": 1.0}
"""First term of Eq. 5: as printed (C_d = 0.431 at 1.6 m/s; a REMUS has 0.42), and for Hoerner's streamlined body."""
ANCHOR_FINENESS = (2.0, 10.0)
"""Fineness ratios for which Hoerner gives the blunt cylinder with a round front C_d = 0.2."""


def reynolds_number(speed: Scalars, length: Scalars, viscosity: Scalars) -> Scalars:
    """Reynolds number v l/ν (Eqs. 3, 9) of a speed [m/s], a length [m] and a kinematic viscosity [m²/s]."""
    return np.abs(speed) * length / viscosity


def friction_coefficient(reynolds: Scalars) -> Scalars:
    """Skin friction by the 1957 ITTC line, 0.075/(log₁₀ Re - 2)² (Eqs. 4, 10).

    Constant below `REYNOLDS_HELD`. The line is for turbulent flow, Re above about 5e5; between the two it overestimates
    the friction of a smooth body.

    Parameters
    ----------
    reynolds : float or array
        Re ≥ 0.

    Returns
    -------
    float or array
        C_f on the wetted area; 0.004298 at 1.504e6.
    """
    return 0.075 / (np.log10(np.maximum(reynolds, REYNOLDS_HELD)) - 2.0) ** 2


def form_factor(length: Scalars, diameter: Scalars, constant: Scalars = FORM_CONSTANTS["briggs"]) -> Scalars:
    """Drag of the body over that of a flat plate of its wetted area (Eq. 5).

    Parameters
    ----------
    length, diameter : float or array
        Of the body [m].
    constant : float or array
        First term: 2.643 as printed, found in no other source, or 1 after Hoerner (`FORM_CONSTANTS`).

    Returns
    -------
    float or array
        FF; 2.705 for the prototype.
    """
    ratio = diameter / length
    return constant + 1.5 * ratio**1.5 + 7.0 * ratio**3


def body_drag_coefficient(friction: Scalars, factor: Scalars, length: Scalars, diameter: Scalars) -> Scalars:
    """C_d of the body on its frontal area, C_f · 4l/d · FF (Eqs. 6–7), for a cylinder with hemispherical ends."""
    return friction * (4.0 * length / diameter) * factor


def sail_drag_coefficient(friction: Scalars, chord: Scalars, thickness: Scalars) -> Scalars:
    """C_d of the sail on chord × span, 2[1 + 2 t/c + 60 (t/c)⁴] C_f (Eq. 11), from Hoerner's airfoil sections."""
    ratio = thickness / chord
    return 2.0 * (1.0 + 2.0 * ratio + 60.0 * ratio**4) * friction


def drag_force(speed: Scalars, coefficient: Scalars, area: Scalars, density: Scalars) -> Scalars:
    """Drag ½ ρ v|v| A C_d [N] (Eqs. 2, 8, 12), with the sign of the speed.

    Parameters
    ----------
    speed : float or array
        Through the water [m/s].
    coefficient : float or array
        C_d on `area`.
    area : float or array
        Reference area [m²].
    density : float or array
        ρ [kg/m³].
    """
    return 0.5 * density * area * coefficient * speed * np.abs(speed)


def disc_area(diameter: Scalars) -> Scalars:
    """Area π d²/4 [m²] of a disc of a diameter [m]: a body of revolution from the front, a propeller, a tunnel."""
    return np.pi * diameter**2 / 4.0
