"""A current above an anchor, against altitude."""

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array

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
        found = np.broadcast_to(self.velocity[-1][:, None], (2, *altitude.shape))
        for top, velocity in zip(self.tops[-2::-1], self.velocity[-2::-1], strict=True):
            share = np.clip((altitude - top) / _EDGE + 0.5, 0.0, 1.0)
            found = velocity[:, None] + (found - velocity[:, None]) * share
        return np.asarray(found)

    def with_shear(self, altitude: Array) -> tuple[Array, Array]:
        """Velocity as `at` gives it, and how it changes with the altitude, shape (2, m, n) [1/s]."""
        found = np.broadcast_to(self.velocity[-1][:, None], (2, *altitude.shape))
        shear = np.zeros((2, 1, 1))
        for top, velocity in zip(self.tops[-2::-1], self.velocity[-2::-1], strict=True):
            share = (altitude - top) / _EDGE + 0.5
            between, rise = (share > 0.0) & (share < 1.0), found - velocity[:, None]
            share = np.clip(share, 0.0, 1.0)
            shear = shear * share + rise * (between / _EDGE)
            found = velocity[:, None] + rise * share
        return np.asarray(found), shear


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
        found, rise = np.empty((2, *altitude.shape)), np.empty((2, *altitude.shape))
        for side, (low, high) in enumerate(zip(found, rise, strict=True)):
            at = below + side * trials if side else below
            self.velocity.take(at, out=low, mode="clip")
            self.velocity.take(at + 2 * trials, out=high, mode="clip")
            high -= low
        return found, rise, place
