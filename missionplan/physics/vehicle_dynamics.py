"""Rigid-body motion of the vehicle in the vertical plane, and the snatch of a line that goes taut.

Surge, heave and pitch of a submerged vehicle are those of Palmer, Hearn & Stevenson, Eqs. 4 to 6. Body axes with z down
and the pitch θ nose up; forces on the vehicle are positive along the axes, the moment nose up. Subscripts of the
printed equations are damaged: the cross-flow terms are read in the Gertler-Hagen form, Z'_w|w| w|w|, Z'_w|q| w|q| and
M'_|w|q |w|q. For small angles of attack, not for broadside motion.

In the snatch a line goes taut between a falling anchor and a vehicle at rest: bodies and peak tension.
"""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars

GRAVITY = 9.81
"""Gravity for which 0.3 % of 3600 kg is the paper's 105.9 N [m/s²]."""


@dataclass(frozen=True)
class Derivatives:
    """Hydrodynamic derivatives, made dimensionless by ½ρ and powers of the length; floats or arrays over trials.

    Names are those of Eqs. 4 to 6: ``z_uud`` is Z'_uuδS, ``m_qdot`` is M'_q̇, ``z_w_abs_q`` is Z'_w|q|. The default is
    zero.
    """

    x_uu: Scalars = 0.0
    x_ww: Scalars = 0.0
    x_uudd: Scalars = 0.0
    x_udot: Scalars = 0.0
    x_wq: Scalars = 0.0
    x_qq: Scalars = 0.0
    z_uw: Scalars = 0.0
    z_ww: Scalars = 0.0
    z_uud: Scalars = 0.0
    z_wdot: Scalars = 0.0
    z_uq: Scalars = 0.0
    z_uqd: Scalars = 0.0
    z_w_abs_q: Scalars = 0.0
    z_qdot: Scalars = 0.0
    m_uw: Scalars = 0.0
    m_ww: Scalars = 0.0
    m_uud: Scalars = 0.0
    m_wdot: Scalars = 0.0
    m_uq: Scalars = 0.0
    m_uqd: Scalars = 0.0
    m_abs_w_q: Scalars = 0.0
    m_qdot: Scalars = 0.0


@dataclass(frozen=True)
class Body:
    """A vehicle in the vertical plane; floats or arrays over trials."""

    length: float
    mass: float
    """[m], [kg], flooded."""
    inertia: float
    """About the y axis through the origin [kg m²]."""
    excess_buoyancy: Scalars
    """Buoyancy less weight [N]."""
    x_g: Scalars
    z_g: Scalars
    """Centre of gravity, ahead of and below the origin, which is the centre of buoyancy [m]."""
    density: float
    """Of the water [kg/m³]."""
    derivatives: Derivatives
    """Dimensionless."""

    @property
    def weight(self) -> float:
        """Weight [N]."""
        return self.mass * GRAVITY

    def scale(self, power: int) -> float:
        """½ρ times a power of the length."""
        return 0.5 * self.density * self.length**power


@dataclass(frozen=True)
class Motion:
    """Surge and heave velocity along the body's axes [m/s], pitch rate [rad/s] and pitch [rad]: arrays over trials."""

    u: Array
    w: Array
    q: Array
    pitch: Array


@dataclass(frozen=True)
class Load:
    """Surge and heave force [N] and pitch moment [N m] on the vehicle."""

    x: Scalars
    z: Scalars
    m: Scalars

    def __add__(self, other: "Load") -> "Load":
        """Add two loads."""
        return Load(self.x + other.x, self.z + other.z, self.m + other.m)


def hydrodynamic_load(body: Body, motion: Motion, sternplane: Scalars) -> Load:
    """Velocity-dependent hydrodynamic forces and moment [N, N m], right sides of Eqs. 4 to 6 without accelerations.

    Parameters
    ----------
    sternplane : float or array
        δS [rad], trailing edge down positive: it lifts the stern and puts the nose down.
    """
    d, u, w, q = body.derivatives, motion.u, motion.w, motion.q
    two, three, four = body.scale(2), body.scale(3), body.scale(4)
    aq, aw = np.abs(q), np.abs(w)
    x = two * (d.x_uu * u * np.abs(u) + d.x_ww * w**2 + d.x_uudd * (u * sternplane) ** 2)
    x = x + three * d.x_wq * w * q + four * d.x_qq * q**2
    z = two * (d.z_uw * u * w + d.z_ww * w * aw + d.z_uud * u**2 * sternplane)
    z = z + three * (d.z_uq * u * q + d.z_uqd * u * aq * sternplane + d.z_w_abs_q * w * aq)
    m = three * (d.m_uw * u * w + d.m_ww * w * aw + d.m_uud * u**2 * sternplane)
    m = m + four * (d.m_uq * u * q + d.m_uqd * u * aq * sternplane + d.m_abs_w_q * aw * q)
    return Load(x, z, m)


def hydrostatic_load(body: Body, pitch: Scalars) -> Load:
    """Buoyancy and weight, last lines of Eqs. 4 to 6 [N, N m], with the centre of buoyancy at the origin."""
    sine, cosine = np.sin(pitch), np.cos(pitch)
    moment = -body.weight * (body.x_g * cosine + body.z_g * sine)
    return Load(body.excess_buoyancy * sine, -body.excess_buoyancy * cosine, moment)


def rigid_body_load(body: Body, motion: Motion) -> Load:
    """Centrifugal terms of the left sides of Eqs. 4 to 6, moved to the right [N, N m]."""
    u, w, q = motion.u, motion.w, motion.q
    return Load(
        -body.mass * (w * q - body.x_g * q**2),
        body.mass * (u * q + body.z_g * q**2),
        -body.mass * (body.z_g * w * q + body.x_g * u * q),
    )


def inverse_inertia(body: Body) -> Array:
    """Inverse of mass, added mass and their couplings, shape (3, 3) or (3, 3, n): surge, heave, pitch."""
    d, m = body.derivatives, body.mass
    entries = (
        [m - body.scale(3) * d.x_udot, 0.0, m * body.z_g],
        [0.0, m - body.scale(3) * d.z_wdot, -m * body.x_g - body.scale(4) * d.z_qdot],
        [m * body.z_g, -m * body.x_g - body.scale(4) * d.m_wdot, body.inertia - body.scale(5) * d.m_qdot],
    )
    flat = np.broadcast_arrays(*(entry for row in entries for entry in row))
    matrix = np.array(flat, dtype=float).reshape(3, 3, *flat[0].shape)
    inverse: Array = np.moveaxis(np.linalg.inv(np.moveaxis(matrix, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    return inverse


def accelerations(inverse: Array, load: Load) -> tuple[Array, Array, Array]:
    """u̇ [m/s²], ẇ [m/s²] and q̇ [rad/s²] of a total load, with `inverse_inertia`."""
    x, z, m = (np.asarray(component) for component in (load.x, load.z, load.m))
    du, dw, dq = (row[0] * x + row[1] * z + row[2] * m for row in inverse)
    return du, dw, dq


def depth_rate(motion: Motion) -> Array:
    """Rate at which depth grows, w cos θ - u sin θ [m/s]."""
    rate: Array = motion.w * np.cos(motion.pitch) - motion.u * np.sin(motion.pitch)
    return rate


@dataclass(frozen=True)
class Trim:
    """Level flight at a steady speed: `pitch` and `sternplane` [rad], arrays."""

    pitch: Array
    sternplane: Array


def level_trim(body: Body, speed: Scalars) -> Trim:
    """Pitch and sternplane that keep depth at a speed without thrusters: equilibrium of Eqs. 5 and 6.

    Newton's method from level pitch; the sternplane enters linearly and is eliminated by the heave equation. Raises
    ArithmeticError when no trim is found: no deflection keeps the vehicle at depth at that speed.

    Parameters
    ----------
    speed : float or array
        Surge velocity u > 0 [m/s].
    """
    d = body.derivatives
    u = np.asarray(speed, dtype=float) + 0.0 * np.asarray(body.excess_buoyancy + body.x_g + body.z_g)
    still = np.zeros_like(u)

    def balance(pitch: Array) -> tuple[Array, Array]:
        motion = Motion(u, u * np.tan(pitch), still, pitch)
        free = hydrodynamic_load(body, motion, 0.0) + hydrostatic_load(body, pitch)
        plane = -np.asarray(free.z) / (body.scale(2) * d.z_uud * u**2)
        return np.asarray(free.m) + body.scale(3) * d.m_uud * u**2 * plane, plane

    pitch, step = np.zeros_like(u), 1e-6
    for _ in range(50):
        here, ahead = balance(pitch)[0], balance(pitch + step)[0]
        change = -here * step / (ahead - here)
        pitch = pitch + np.clip(change, -0.1, 0.1)
        if np.all(np.abs(change) < 1e-10):
            return Trim(pitch, balance(pitch)[1])
    raise ArithmeticError("no level trim was found at this speed")


def propeller_force(body: Body, coefficients: tuple[float, float, float], speed: Array, command: Array) -> Array:
    """Force of the stern propeller, Eq. 3 without its singularity at rest.

    ½ρl²(b₁u|u| + b₂u|c| + b₃c|c|), with the command c in place of n'u: the printed form for motion ahead, finite at
    u = 0, and odd in (u, c), so that a propeller astern brakes (as in Blanke et al., Eq. 28).

    Parameters
    ----------
    coefficients : (float, float, float)
        b₁, b₂, b₃ with b₁ + b₂ + b₃ = -X'_uu, so that a steady speed equals its command.
    speed, command : array
        u, and the steady speed of the shaft rate [m/s].
    """
    one, two, three = coefficients
    force: Array = body.scale(2) * (
        one * speed * np.abs(speed) + two * speed * np.abs(command) + three * command * np.abs(command)
    )
    return force


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
