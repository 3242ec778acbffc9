"""The best fit of a model of tank data to data and normal priors: Gauss-Newton, the noise's size following."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

STEP = 1e-4
"""Step of the derivatives, of a coordinate's prior standard deviation."""
MOST_STEPS = 25
HALVINGS = 8
SETTLED = 1e-3
"""Gain of a step below which the climb ends [nats]."""


@dataclass(frozen=True)
class Reached:
    """Where a climb ended.

    Attributes
    ----------
    objective : float
        Negative log posterior there, but for a constant; infinite where the model has no value.
    at : array, shape (k,)
        Coordinates.
    here : array, shape (N,)
        What the model predicts.
    columns : array, shape (N, a)
        Its derivatives along the active coordinates.
    """

    objective: float
    at: Array
    here: Array
    columns: Array


@dataclass(frozen=True)
class Climb:
    """A fit to be made.

    Attributes
    ----------
    predict : callable
        The model, (k, m) → (N, m).
    y, sd : array, shape (N,)
        Data, and the standard deviation of their noise before its factor.
    centre : array, shape (k,)
        Prior means.
    active : array of int, shape (a,)
        Coordinates that move.
    prior : array, shape (a,)
        Their prior standard deviations.
    factors : tuple of float
        Least and greatest factor on the noise.
    """

    predict: Callable[[Array], Array]
    y: Array
    sd: Array
    centre: Array
    active: NDArray[np.int_]
    prior: Array
    factors: tuple[float, float]

    def climb(self, start: Array) -> Reached:
        """Climb from a start: full steps where they gain, else the best of their halves."""
        at, (here, columns) = start, self._linearised(start)
        for _ in range(MOST_STEPS):
            if not np.all(np.isfinite(here)) or not np.all(np.isfinite(columns)):
                return Reached(np.inf, at, here, columns)
            factor = self._factor(here)
            before = self._objective(at, here, factor)
            step = self._step(at, here, columns, factor)
            # nearly always the full step gains: its derivatives come with its value
            moved = self._moved(at, step)
            ahead, slopes = self._linearised(moved)
            after = self._objective(moved, ahead, factor)
            if not after < before:
                moved = self._halved(at, step, before, factor)
                ahead, slopes = self._linearised(moved)
                after = self._objective(moved, ahead, factor)
            at, here, columns = moved, ahead, slopes
            if not after < before - SETTLED:
                break
        factor = self._factor(here)
        return Reached(self._objective(at, here, factor) + len(here) * float(np.log(factor)), at, here, columns)

    def _linearised(self, at: Array) -> tuple[Array, Array]:
        """Prediction, shape (N,), and its derivatives along the active coordinates, shape (N, a)."""
        steps = STEP * self.prior
        moved = np.repeat(at[:, None], 1 + 2 * len(steps), axis=1)
        moved[self.active, 1 + 2 * np.arange(len(steps))] += steps
        moved[self.active, 2 + 2 * np.arange(len(steps))] -= steps
        found = self.predict(moved)
        return found[:, 0], (found[:, 1::2] - found[:, 2::2]) / (2.0 * steps)

    def _factor(self, here: Array) -> float:
        """Size of the noise, as a factor, that would leave what is left."""
        return float(np.clip(np.sqrt(np.mean(((self.y - here) / self.sd) ** 2)), *self.factors))

    def _objective(self, at: Array, here: Array, factor: float) -> float:
        left = (self.y - here) / self.sd / factor
        away = (at - self.centre)[self.active] / self.prior
        return 0.5 * float(left @ left) + 0.5 * float(away @ away)

    def _step(self, at: Array, here: Array, columns: Array, factor: float) -> Array:
        white = columns * self.prior / (factor * self.sd)[:, None]
        away = (at - self.centre)[self.active] / self.prior
        gradient = white.T @ ((self.y - here) / self.sd / factor) - away
        return self.prior * np.linalg.solve(np.eye(len(away)) + white.T @ white, gradient)

    def _moved(self, at: Array, step: Array) -> Array:
        moved = at.copy()
        moved[self.active] += step
        return moved

    def _halved(self, at: Array, step: Array, before: float, factor: float) -> Array:
        """The best of the halves of a step; the place itself if none gains."""
        places = np.stack([self._moved(at, step * 0.5**k) for k in range(1, HALVINGS)], axis=1)
        found = self.predict(places)
        after = [self._objective(places[:, k], found[:, k], factor) for k in range(HALVINGS - 1)]
        best = int(np.argmin(np.nan_to_num(after, nan=np.inf)))
        return places[:, best] if after[best] < before else at
