"""An anchor on the seafloor: the current above and near the bed, what pulls on the anchor, and what holds it.

Vectors are east, north and up; trials are the last axis.
"""

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array, Scalars

ROUGHNESS = 2e-4
"""z₀ of mud [m] (Soulsby 1997, Dynamics of Marine Sands, Table 7); 0.05 mm silt, 0.4 mm flat sand, 6 mm ripples. Of the
beds with a table entry only silt lets a faster current reach the anchor."""
REFERENCE_HEIGHT = 1.0
"""Height above the bed from which on the current is that of its layer [m], as for the drag coefficient C₁₀₀."""
FRICTION = 0.4
"""Holding force over normal force of an anchor that lies on the seafloor, between 0.2 on clay and 0.6 on sand, those of
a pipeline (DNV-RP-F109, 2010, sect. 3.4.6); no value of this anchor has been measured."""
_FINENESS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0)
_LATERAL = (0.64, 0.68, 0.72, 0.74, 0.82, 0.91, 0.98)


@dataclass(frozen=True)
class Slope:
    """Slope of the seafloor: angle, and the direction in which it falls, clockwise from north [rad]."""

    angle: Scalars = 0.0
    toward: Scalars = 0.0

    @property
    def normal(self) -> Array:
        """Unit vector out of the seafloor, shape (3,) or (3, n)."""
        east, north = np.sin(self.toward), np.cos(self.toward)
        sine, cosine = np.sin(self.angle), np.cos(self.angle)
        return np.stack(np.broadcast_arrays(sine * east, sine * north, cosine))

    def fall(self, place: Array) -> Array:
        """How far the seafloor lies below that at the anchor, at places of shape (2, n) from it, shape (n,) [m]."""
        along = place[0] * np.sin(self.toward) + place[1] * np.cos(self.toward)
        return np.asarray(np.tan(self.angle) * along)


@dataclass(frozen=True)
class LyingAnchor:
    """An anchor that lies on the seafloor; each number is a float or an array of shape (n,)."""

    wet_weight: Scalars
    """Wet weight [N]."""
    diameter: Scalars
    length: Scalars
    """[m]."""
    friction: Scalars = FRICTION
    """Holding force over the force with which it presses on the seafloor."""


def lateral_coefficient(fineness: Scalars) -> Scalars:
    """C_d of a short cylinder across the flow, on length × diameter, both ends free, from length over diameter.

    White, Fluid Mechanics, Table 7.3, after Hoerner: 0.64 at 1 to 0.98 at 40, at Re above 10⁴ and laminar.
    """
    coefficient = np.interp(np.log(fineness), np.log(_FINENESS), _LATERAL)
    return coefficient if np.ndim(coefficient) else float(coefficient)


def near_bed_share(height: Scalars, roughness: Scalars = ROUGHNESS) -> Scalars:
    """Mean square of the current over a body that lies on the bed, over that of the layer above.

    The current is u(z) = u ln(z/z₀)/ln(1 m/z₀) (the logarithmic layer), 0 below z₀.

    Parameters
    ----------
    height : float or array
        Of the body, at most 1 m [m]; a higher one is given the share at 1 m.
    roughness : float or array
        z₀ [m].
    """
    top = np.clip(np.asarray(height) / roughness, 1.0, REFERENCE_HEIGHT / roughness)
    log = np.log(top)
    # the integral of ln² is x(ln² x - 2 ln x + 2)
    share = (top * (log**2 - 2.0 * log + 2.0) - 2.0) / (top * np.log(REFERENCE_HEIGHT / roughness) ** 2)
    return share if np.ndim(share) else float(share)


def anchor_drag_on_bed(anchor: LyingAnchor, velocity: Array, density: Scalars, roughness: Scalars = ROUGHNESS) -> Array:
    """Drag of an anchor that lies across the current, shape (2, n) [N].

    Parameters
    ----------
    velocity : array, shape (2, n)
        Of the lowest layer of the current [m/s].
    density : float or array
        [kg/m³]
    roughness : float or array
        z₀ [m].
    """
    coefficient = lateral_coefficient(anchor.length / anchor.diameter) * near_bed_share(anchor.diameter, roughness)
    factor = 0.5 * density * coefficient * anchor.diameter * anchor.length
    return np.asarray(factor * np.hypot(velocity[0], velocity[1]) * velocity)


def holding_margin(anchor: LyingAnchor, pull: Array, drag: Array, slope: Slope) -> Array:
    """What is left of an anchor's holding force, over what it holds with nothing pulling.

    It holds while the force along the seafloor is at most friction × the force into it. On level ground the margin is
    1 - (T_v + H/μ)/W, with the vertical pull T_v and the horizontal force H: the share of the wet weight to spare.

    Parameters
    ----------
    pull : array, shape (3, n)
        Of the line [N].
    drag : array, shape (2, n)
        Of the anchor [N].

    Returns
    -------
    array, shape (n,)
        1 where nothing pulls on level ground, 0 where the anchor just holds, negative where it drags.
    """
    normal = slope.normal.reshape(3, -1)
    force = pull.copy()
    force[:2] += drag
    force[2] -= anchor.wet_weight
    into = -(force * normal).sum(axis=0)
    along = np.sqrt(((force + into * normal) ** 2).sum(axis=0))
    return np.asarray((into - along / anchor.friction) / (anchor.wet_weight * normal[2]))


def least_weight(friction: Scalars, pull: Array, drag: Array, slope: Slope) -> Array:
    """Wet weight with which an anchor of the same size just holds.

    The larger root of (1 + μ²)(F·n)² = F², with the force F = pull + drag - weight and the seafloor's normal n.

    Parameters
    ----------
    friction : float or array
        μ.
    pull, drag, slope
        As for `holding_margin`.

    Returns
    -------
    array, shape (n,)
        [N]; infinite where the seafloor is steeper than the friction angle.
    """
    normal, factor = slope.normal.reshape(3, -1), 1.0 + np.square(friction)
    load = pull.copy()
    load[:2] += drag
    into = (load * normal).sum(axis=0)
    square = factor * normal[2] ** 2 - 1.0
    half = factor * into * normal[2] - load[2]
    rest = factor * into**2 - (load**2).sum(axis=0)
    root = np.sqrt(np.maximum(half**2 - square * rest, 0.0))
    return np.asarray(np.where(square > 0.0, (half + root) / np.where(square > 0.0, square, 1.0), np.inf))


_EDGE = 0.1
"""Thickness over which one layer passes into the next, so that no pull is undecided at an edge [m]."""


@dataclass(frozen=True)
class LayersAbove:
    """Layers of the current above the anchor, from the seafloor up, with edges `_EDGE` thick between them."""

    tops: Array
    """Upper ends above the anchor, increasing; the last one does not count; shape (k, n) [m]."""
    velocity: Array
    """East and north, shape (k, 2, n) [m/s]."""

    def at(self, altitude: Array) -> Array:
        """Velocity at altitudes of shape (m, n) [m], shape (2, m, n) [m/s]."""
        profile = np.broadcast_to(self.velocity[-1][:, None], (2, *altitude.shape))
        for top, velocity in zip(self.tops[-2::-1], self.velocity[-2::-1], strict=True):
            share = np.clip((altitude - top) / _EDGE + 0.5, 0.0, 1.0)
            profile = velocity[:, None] + (profile - velocity[:, None]) * share
        return np.asarray(profile)

    def with_shear(self, altitude: Array) -> tuple[Array, Array]:
        """Velocity as `at` gives it, and how it changes with the altitude, shape (2, m, n) [1/s]."""
        profile = np.broadcast_to(self.velocity[-1][:, None], (2, *altitude.shape))
        shear = np.zeros((2, 1, 1))
        for top, velocity in zip(self.tops[-2::-1], self.velocity[-2::-1], strict=True):
            share = (altitude - top) / _EDGE + 0.5
            between, rise = (share > 0.0) & (share < 1.0), profile - velocity[:, None]
            share = np.clip(share, 0.0, 1.0)
            shear = shear * share + rise * (between / _EDGE)
            profile = velocity[:, None] + rise * share
        return np.asarray(profile), shear


@dataclass(frozen=True)
class ProfileAbove(LayersAbove):
    """A current that is linear between altitudes at equal distances, `tops`, the first of them 0."""

    @override
    def at(self, altitude: Array) -> Array:
        """Velocity at altitudes of shape (m, n) [m], shape (2, m, n) [m/s]."""
        below, rise, share = self._between(altitude)
        rise *= share
        rise += below
        return rise

    @override
    def with_shear(self, altitude: Array) -> tuple[Array, Array]:
        below, rise, share = self._between(altitude)
        return below + rise * share, rise / self.tops[1]

    def _between(self, altitude: Array) -> tuple[Array, Array, Array]:
        """Velocity at the altitude given below each, its rise to the next, and the share of the way there."""
        last, trials = len(self.tops) - 1, altitude.shape[-1]
        place = np.clip(altitude / self.tops[1], 0.0, last * (1.0 - 1e-12))
        below = place.astype(np.intp)
        place -= below
        below *= 2 * trials
        below += np.arange(trials)
        velocity, rise = np.empty((2, *altitude.shape)), np.empty((2, *altitude.shape))
        for side, (low, high) in enumerate(zip(velocity, rise, strict=True)):
            at = below + side * trials if side else below
            self.velocity.take(at, out=low, mode="clip")
            self.velocity.take(at + 2 * trials, out=high, mode="clip")
            high -= low
        return velocity, rise, place
