"""Covariance of a navigation log's errors: a few hyperparameters, by the effects' own covariance functions."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.likelihood import Marginal, gaussian_marginal, student_marginal
from missionplan.diagnose.model import Causes
from missionplan.diagnose.transit_mean import RANDOM, TransitMean
from missionplan.effects import CATALOGUE
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk

Array = NDArray[np.float64]
Rows = slice | NDArray[np.int_]
ALL = slice(None)

SIGMA_SPREAD = 0.7
"""How far the velocity error's size may lie from the mission's: standard deviation of its logarithm."""
FIX_SPREAD = 0.4
"""The same for a fix error that data set or mission states."""
FIX_UNSTATED = (3.0, 0.7)
"""Median [m] and log-spread of the fix error where neither data set nor mission states one."""
LEAST_DOF = 2.02
"""Below this a Student-t error has practically no variance."""


@dataclass(frozen=True)
class Hyper:
    """A hyperparameter of the covariance, by its logarithm: normal prior about `centre` with `spread`."""

    effect: str
    name: str
    centre: float
    spread: float


@dataclass(frozen=True)
class TransitNoise(TransitMean):
    """The legs with the covariance of their errors, and the likelihood at given hyperparameters."""

    def hypers(self, causes: Causes) -> tuple[Hyper, ...]:
        """Hyperparameters under a set of causes."""
        sigma = math.sqrt(max(0.5 * float(np.trace(self.covariance)), 1e-6))
        stated = self.data.fix_sd or self.fix_error
        fix, spread = (stated, FIX_SPREAD) if stated > 0.0 else FIX_UNSTATED
        found = [Hyper("", "sigma_v", math.log(sigma), SIGMA_SPREAD), Hyper("", "fix_sd", math.log(fix), spread)]
        for name in RANDOM:
            if name in causes:
                parameters = CATALOGUE[name].parameters
                found += [Hyper(name, key, math.log(p.median), math.log(p.factor)) for key, p in parameters.items()]
        return tuple(found)

    @cached_property
    def _fix_pattern(self) -> tuple[Array, Array]:
        """What a fix error of 1 m gives: variances, shape (n,), and covariances of legs that share a fix, (n - 1,)."""
        data = self.data
        shared = np.all(data.end[:, :-1] == data.start[:, 1:], axis=0) & (data.run[:-1] == data.run[1:])
        return 2.0 / data.under_way**2, np.where(shared, -1.0 / (data.under_way[:-1] * data.under_way[1:]), 0.0)

    def noise(self, values: Mapping[tuple[str, str], float]) -> Array:
        """Covariance of the velocity errors beside the causes of the mean [m²/s²].

        Shape (2, n) where legs are independent, (1, n, n) where both axes share it, else (2, n, n).

        Parameters
        ----------
        values : mapping
            Hyperparameters by effect and name, not their logarithms.
        """
        shape = np.linalg.eigvalsh(self.covariance) if np.any(self.covariance) else np.ones(2)
        shape = np.maximum(shape / max(shape.mean(), 1e-12), 1e-6)
        white = values["", "sigma_v"] ** 2 * shape
        fix = values["", "fix_sd"] ** 2 + values.get(("fix-error", "sd"), 0.0) ** 2
        own, beside = (fix * part for part in self._fix_pattern)
        lasting = self._lasting(values)
        if lasting is None and not beside.any():
            return np.asarray(white[:, None] + own)
        shared = np.zeros((self.data.n, self.data.n)) if lasting is None else lasting
        here, after = np.arange(self.data.n), np.arange(1, self.data.n)
        shared[after - 1, after] += beside
        shared[after, after - 1] += beside
        full = shared[None] if np.ptp(shape) == 0.0 else np.stack([shared, shared])
        full[:, here, here] += own + white[: len(full), None]
        return full

    def _lasting(self, values: Mapping[tuple[str, str], float]) -> Array | None:
        effects: list[PersistentError | RandomWalk] = []
        if ("persistent-error", "sigma") in values:
            effects.append(PersistentError(values["persistent-error", "sigma"], values["persistent-error", "time"]))
        if ("random-walk", "rate") in values:
            effects.append(RandomWalk(values["random-walk", "rate"]))
        if not effects:
            return None
        total = np.zeros((self.data.n, self.data.n))
        for legs in self._runs:  # what lasts begins anew with each run
            total[legs] = sum(effect.covariance(self.data.middle[legs[1][0]]) for effect in effects)
        return total

    @cached_property
    def _runs(self) -> tuple[tuple[NDArray[np.int_], ...], ...]:
        """Rows and columns of each run's legs, for a block of a covariance."""
        legs = [np.flatnonzero(self.data.run == run) for run in np.unique(self.data.run)]
        return tuple(np.ix_(own, own) for own in legs)

    def marginal(self, causes: Causes, at: Array, linear: tuple[Array, Array], rows: Rows = ALL) -> Marginal:
        """Marginalise the causes of the mean at given hyperparameters (their logarithms), from some of the legs.

        Raises
        ------
        numpy.linalg.LinAlgError
            When the hyperparameters give no covariance.
        """
        values = self.values(causes, at)
        y, columns = linear[0][:, rows], linear[1][:, rows]
        dof = values.get(("heavy-tails", "dof"))
        noise = self.noise(values)[:, rows]
        noise = noise[:, :, rows] if noise.ndim == 3 else noise
        if dof is None:
            return gaussian_marginal(y, columns, self.prior_sd(causes), noise)
        if dof <= LEAST_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = noise if noise.ndim == 2 else np.diagonal(noise, axis1=1, axis2=2) * np.ones((2, 1))
        return student_marginal(y, columns, self.prior_sd(causes), variance, dof)

    def values(self, causes: Causes, at: Array) -> dict[tuple[str, str], float]:
        """Hyperparameters by effect and name, from their logarithms."""
        return {(h.effect, h.name): math.exp(value) for h, value in zip(self.hypers(causes), at, strict=True)}
