"""Dive logs and the descent phase linearised: all causes' columns, the covariance of the rest, the likelihood."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.coordinates import Coordinate, coordinates_of
from missionplan.diagnose.descent_fit import jacobian_settings
from missionplan.diagnose.descent_forward import DescentForward
from missionplan.diagnose.descent_noise import DIVE_SD, Noise, caricature, dive_covariance, grid
from missionplan.diagnose.likelihood import Marginal, marginal_of
from missionplan.diagnose.model import Causes
from missionplan.effects import effects_of

Array = NDArray[np.float64]

WEIGHT_STEP = 0.01
SHIFT = 0.3
"""Shift of the separation at which the readings' bend is taken [s]: 3 standard deviations of its scatter."""


@dataclass(frozen=True)
class Linear:
    """The model linearised at a set's best coordinates.

    Attributes
    ----------
    at : array, shape (k,)
        Coordinates.
    y : array, shape (N,)
        Data less the model there, plus columns times the distance of `at` from the priors' centres.
    columns : array, shape (N, k)
        Of all coordinates; shapes of effects that are no causes have none (zero).
    sensitivities : array, shape (N, 4)
        Of the readings to what differs from dive to dive.
    readings : array, shape (N,)
        The model there [m].
    bend : array, shape (N,)
        What the scatter of the separation does to the readings beyond the linear: large where the line goes taut
        and the vehicle starts with a jerk [m]. Taken at a shift by `SHIFT`, so that it reaches far enough.
    shaped : array, shape (N,)
        What the causes with a shape of their own add to the readings [m].
    """

    at: Array
    y: Array
    columns: Array
    sensitivities: Array
    readings: Array
    bend: Array
    shaped: Array


@dataclass(frozen=True)
class Evidence:
    """Whitened inner products of a linearisation: its likelihood at each noise of the grid, for any of the dives.

    Attributes
    ----------
    grams : array, shape (g, d, k + 2, k + 2)
        For g noises and d dives: of the columns, the shared bend and the data.
    log_determinants : array, shape (g, d)
        Of each dive's covariance.
    counts : array of int, shape (d,)
        Readings of each dive.
    """

    grams: Array
    log_determinants: Array
    counts: NDArray[np.int_]

    def marginals(self, prior_sd: Array, dives: NDArray[np.int_] | slice = slice(None)) -> list[Marginal]:
        """Marginalise all coordinates at each noise; dives are independent given them.

        The scatter of the separation smooths the jerk of every dive to the same side: a column that they share.

        Parameters
        ----------
        prior_sd : array, shape (k,)
            Of the coordinates.
        dives : array of int or slice
            Dives to use; default all.
        """
        return [self.marginal(index, prior_sd, dives) for index in range(len(self.grams))]

    def marginal(self, index: int, prior_sd: Array, dives: NDArray[np.int_] | slice = slice(None)) -> Marginal:
        """Marginalise all coordinates at one noise of the grid."""
        gram, log_determinant = self.grams[index, dives].sum(axis=0), float(self.log_determinants[index, dives].sum())
        prior = np.append(prior_sd, grid()[index].scatter)
        found = marginal_of(gram, prior, log_determinant, int(self.counts[dives].sum()))
        return Marginal(found.log_density, found.mean[:-1], found.covariance[:-1, :-1])


@dataclass(frozen=True)
class DescentLinear:
    """Base model of a mission's descent and every cause of the catalogue, bound to dive logs and linearised."""

    forward: DescentForward

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue on a descent."""
        return tuple(info.id for info in effects_of("descent"))

    @property
    def untestable(self) -> Mapping[str, str]:
        """Every effect can show in a dive log."""
        return {}

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes."""
        return tuple(c for info in effects_of("descent") for c in coordinates_of(info))

    @cached_property
    def y(self) -> Array:
        """Readings of all dives, one after the other, shape (N,) [m]."""
        return np.concatenate([log.depth for log in self.forward.logs])

    @cached_property
    def parts(self) -> tuple[NDArray[np.int_], ...]:
        """Rows of each dive."""
        lengths = [len(log.t) for log in self.forward.logs]
        return tuple(np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1]))

    @cached_property
    def centre(self) -> Array:
        """Prior means of the coordinates, shape (k,)."""
        return np.array([coordinate.centre for coordinate in self.coordinates])

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviation of each coordinate: slab for a cause, spike otherwise (0 for a shape)."""
        return np.array([c.slab if c.effect in causes else c.spike for c in self.coordinates])

    def free(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes."""
        return np.flatnonzero([coordinate.effect in causes for coordinate in self.coordinates])

    @cached_property
    def base(self) -> Linear:
        """The base model, linearised."""
        return self.linearise([((), self.centre)])[0]

    def linearise(self, wanted: Sequence[tuple[Causes, Array]]) -> list[Linear]:
        """Linearise the phase for several sets in one call: all strengths, the causes' shapes, the dives' scatter."""
        settings, factors, plans = [], [], []
        for causes, at in wanted:
            chosen = [i for i, c in enumerate(self.coordinates) if c.kind != "shape" or c.effect in causes]
            ahead, steps = jacobian_settings(self.coordinates, at, np.array(chosen))
            shifted = np.repeat(at[:, None], 2, axis=1)
            shifted[self._clock] += np.array([SHIFT, -SHIFT])
            settings += [at[:, None], np.repeat(at[:, None], 2, axis=1), shifted, self._unshaped(at), ahead]
            factors += [np.ones(1), 1.0 + WEIGHT_STEP * np.array([1.0, -1.0]), np.ones(3 + ahead.shape[1])]
            plans.append((chosen, steps))
        readings = self.forward.readings(self.coordinates, np.concatenate(settings, axis=1), np.concatenate(factors))
        found, column = [], 0
        for (causes, at), (chosen, steps) in zip(wanted, plans, strict=True):
            here = readings[:, column]
            weight = (readings[:, column + 1] - readings[:, column + 2]) / (2.0 * WEIGHT_STEP)
            columns = np.zeros((len(self.y), len(self.coordinates)))
            columns[:, chosen] = (readings[:, column + 6 : column + 6 + len(chosen)] - here[:, None]) / steps
            both = readings[:, column + 3] + readings[:, column + 4] - 2.0 * here
            bend = 0.5 * np.abs(both) * DIVE_SD["release"] / SHIFT
            shaped = here - readings[:, column + 5]
            column += 6 + len(chosen)
            found.append(self._linear(causes, at, here, columns, weight, bend, shaped))
        return found

    @cached_property
    def _clock(self) -> int:
        return [coordinate.effect for coordinate in self.coordinates].index("clock-offset")

    def _unshaped(self, at: Array) -> Array:
        """Coordinates without the effects that have a shape of their own, shape (k, 1)."""
        effects = {c.effect for c in self.coordinates if c.kind == "shape"}
        return np.where([c.effect in effects for c in self.coordinates], self.centre, at)[:, None]

    def _linear(
        self, causes: Causes, at: Array, here: Array, columns: Array, weight: Array, bend: Array, shaped: Array
    ) -> Linear:
        free = self.free(causes)
        y = self.y - here + columns[:, free] @ (at - self.centre)[free]
        names = [coordinate.effect for coordinate in self.coordinates]
        release, drag = columns[:, self._clock], columns[:, names.index("drag-bias")]
        return Linear(
            at, y, columns, np.stack([release, np.ones_like(release), drag, weight], axis=1), here, bend, shaped
        )

    def covariances(self, linear: Linear, noises: Sequence[Noise]) -> list[Array]:
        """Covariance of each dive's readings beside the catalogue's coordinates, at each of g noises: (g, m, m) [m²].

        A cause with a shape of its own is a caricature of what it names: what it adds to the readings is uncertain
        by a smooth factor, `SHAPE_SD`.
        """
        return [
            dive_covariance(log.t, log.sd, linear.sensitivities[rows], linear.bend[rows], noises)
            + caricature(log.t, linear.shaped[rows])
            for log, rows in zip(self.forward.logs, self.parts, strict=True)
        ]

    def total_covariance(self, linear: Linear, noise: Noise, prior_sd: Array) -> Array:
        """Covariance of all readings with the coordinates' priors, shape (N, N) [m²]."""
        scaled = np.concatenate([linear.columns * prior_sd, noise.scatter * linear.bend[:, None]], axis=1)
        total = scaled @ scaled.T
        for rows, block in zip(self.parts, self.covariances(linear, [noise]), strict=True):
            total[np.ix_(rows, rows)] += block[0]
        return np.asarray(total)

    def evidence(self, linear: Linear) -> Evidence:
        """Whiten a linearisation's columns and data at every noise of the grid.

        Raises
        ------
        numpy.linalg.LinAlgError
            When a covariance is not positive definite.
        """
        both = np.concatenate([linear.columns, linear.bend[:, None], linear.y[:, None]], axis=1)
        grams, log_determinants = [], []
        for rows, covariance in zip(self.parts, self.covariances(linear, grid()), strict=True):
            factor = np.linalg.cholesky(covariance)
            white = np.linalg.solve(factor, both[rows])
            grams.append(np.swapaxes(white, 1, 2) @ white)
            log_determinants.append(2.0 * np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1))
        counts = np.array([len(rows) for rows in self.parts])
        return Evidence(np.stack(grams, axis=1), np.stack(log_determinants, axis=1), counts)
