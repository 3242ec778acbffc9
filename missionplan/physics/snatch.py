"""The snatch, in which a line goes taut between a falling anchor and a vehicle at rest: bodies and peak tension."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars


@dataclass(frozen=True)
class LineSpring:
    """What bears the snatch; each number is a float or an array over trials, shape (n,)."""

    stiffness: Scalars
    """Of the whole line [N/m]."""
    nose_mass: Scalars
    """Effective mass of the level vehicle at its nose (`mass_at_nose`) [kg]."""
    strength: Scalars = np.inf
    """Tension at which the line, or the galvanic link in it, parts [N]."""


@dataclass(frozen=True)
class PitchingBody:
    """The vehicle as a rigid body that pitches; each number is a float or an array over trials, shape (n,)."""

    lateral_mass: Scalars
    inertia: Scalars
    """Across its axis [kg], and about its centre of mass [kg m²], added masses included."""
    length: Scalars
    centre: Scalars
    """Of the body, and from its nose to the centre of mass [m]."""
    ahead: Scalars
    below: Scalars
    """Of the centre of buoyancy, ahead of the centre of mass along the axis and below it [m]."""
    buoyancy: Scalars
    """Of the whole body [N]."""
    drag_per_length: Scalars
    """½ ρ C_d d of the flow across it [N s²/m³]."""


def mass_at_nose(lateral_mass: Scalars, length: Scalars, centre: Scalars | None = None) -> Scalars:
    """Effective mass of a level slender body that is pulled at its nose across its axis.

    The pull moves the centre of mass and turns the body about it: 1/m = 1/M + x²/I with I = M l²/12, of a slender body
    whose mass, added mass included, is spread evenly.

    Parameters
    ----------
    lateral_mass : float or array
        M, with the added mass across the axis [kg].
    length : float or array
        l [m].
    centre : float or array, optional
        x, of the centre of mass from the nose; by default l/2 [m].

    Returns
    -------
    float or array
        M/(1 + 12 x²/l²) [kg]: a quarter of M for the default.
    """
    share = 0.5 if centre is None else centre / length
    return lateral_mass / (1.0 + 12.0 * share**2)


def peak_tension(
    stiffness: Scalars, speed: Scalars, masses: tuple[Scalars, Scalars], pull: Scalars, resistance: Scalars = 0.0
) -> Scalars:
    """Greatest tension of a massless spring between two bodies, from the moment at which it goes taut.

    With the reduced mass μ and the relative acceleration a that the forces alone would give, the stretch x obeys
    x'' = a - k x/μ from x = 0 and x' = v, so that its greatest tension is μa + √((μa)² + μ k v²).

    Parameters
    ----------
    stiffness : float or array
        k [N/m].
    speed : float or array
        v, at which the bodies move apart [m/s].
    masses : tuple of float or array
        Of the anchor and, as the line finds it, of the vehicle [kg].
    pull, resistance : float or array
        Forces that move the anchor away and that keep the vehicle from following, at that moment [N].

    Returns
    -------
    float or array
        [N]. Without damping, drag of the vehicle and mass of the line: an upper estimate.
    """
    anchor, vehicle = masses
    reduced = anchor * vehicle / (anchor + vehicle)
    steady = reduced * (pull / anchor + resistance / vehicle)
    return steady + np.sqrt(steady**2 + reduced * stiffness * np.square(speed))
