"""Covariance of a navigation log's errors: a few hyperparameters, by the effects' own covariance functions."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import Marginal, gaussian_marginal, student_marginal
from missionplan.diagnosis.legs.chain import Chain, Lasting, Rows
from missionplan.diagnosis.legs.mean import RANDOM, Linear, TransitMean
from missionplan.effects import CATALOGUE
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk
from missionplan.results.diagnosis import Causes

Values = Mapping[tuple[str, str], float]
ALL = slice(None)

SIGMA_SPREAD = 0.7
"""How far the velocity error's size may lie from the mission's: standard deviation of its logarithm."""
FIX_SPREAD = 0.15
"""The same for a fix error that data set or mission states: one that is worse is no calibration but `fix-error`."""
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
    def _shares(self) -> NDArray[np.bool_]:
        """Whether each leg starts from the very fix with which the leg before it ended, shape (n,)."""
        data = self.data
        shared = np.all(data.end[:, :-1] == data.start[:, 1:], axis=0) & (data.run[:-1] == data.run[1:])
        return np.append(False, shared)

    def chain(self, rows: Rows = ALL) -> Chain:
        """Some of the legs as links of a chain."""
        data, legs = self.data, np.arange(self.data.n)[rows]
        begins = np.array([data.middle[data.run == run].min() for run in np.unique(data.run)])
        since = data.middle[legs] - begins[np.searchsorted(np.unique(data.run), data.run[legs])]
        together = data.run[legs[1:]] == data.run[legs[:-1]]
        elapsed = np.append(np.nan, np.where(together, np.diff(data.middle[legs]), np.nan))
        shares = self._shares[legs] & np.append(False, np.diff(legs) == 1)
        return Chain(data.under_way[legs], since, elapsed, shares)

    @cached_property
    def _whole(self) -> Chain:
        return self.chain()

    @cached_property
    def _anisotropy(self) -> Array:
        """Variance of the velocity error on each principal axis over their mean, shape (2,)."""
        shape = np.linalg.eigvalsh(self.covariance) if np.any(self.covariance) else np.ones(2)
        return np.asarray(np.maximum(shape / max(shape.mean(), 1e-12), 1e-6))

    def parts(self, values: Values) -> tuple[Array, float, Lasting | None]:
        """Variance of the independent error on each axis (2,) [m²/s²], sd of a fix [m], and what lasts.

        Parameters
        ----------
        values : mapping
            Hyperparameters by effect and name, not their logarithms.
        """
        white = values["", "sigma_v"] ** 2 * self._anisotropy
        fix = math.hypot(values["", "fix_sd"], values.get(("fix-error", "sd"), 0.0))
        lasting: Lasting | None = None
        if ("persistent-error", "sigma") in values:
            lasting = PersistentError(values["persistent-error", "sigma"], values["persistent-error", "time"])
        elif ("random-walk", "rate") in values:
            lasting = RandomWalk(values["random-walk", "rate"])
        return white, fix, lasting

    def noise(self, values: Values) -> Array:
        """Covariance of the velocity errors beside the causes of the mean, on each axis, shape (2, n, n) [m²/s²].

        Parameters
        ----------
        values : mapping
            Hyperparameters by effect and name, not their logarithms.
        """
        white, fix, lasting = self.parts(values)
        chain, n = self._whole, self.data.n
        total = np.zeros((n, n))
        if lasting is not None:
            for run in np.unique(self.data.run):  # what lasts begins anew with each run
                legs = np.flatnonzero(self.data.run == run)
                total[np.ix_(legs, legs)] = lasting.covariance(self.data.middle[legs])
        here, after = np.arange(n), np.flatnonzero(chain.shares)
        total[here, here] += fix**2 * chain.fix_variance()
        shared = fix**2 / (chain.under_way[after - 1] * chain.under_way[after])
        total[after - 1, after] -= shared
        total[after, after - 1] -= shared
        return np.asarray(total + white[:, None, None] * np.eye(n))

    def marginal(self, causes: Causes, at: Array, linear: Linear, rows: Rows = ALL) -> Marginal:
        """Marginalise the coefficients of the mean at given hyperparameters (their logarithms), from some of the legs.

        Raises
        ------
        numpy.linalg.LinAlgError
            When the hyperparameters give no covariance.
        """
        values = self.values(causes, at)
        chain = self._whole if rows is ALL else self.chain(rows)
        white, fix, lasting = self.parts(values)
        dof = values.get(("heavy-tails", "dof"))
        if dof is None:
            gram, log_determinant = chain.gram(linear.joined[:, rows], white, fix, lasting)
            return gaussian_marginal(gram, linear.prior_sd, log_determinant, 2 * len(chain.under_way))
        if dof <= LEAST_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = white[:, None] + fix**2 * chain.fix_variance()
        return student_marginal(linear.y[:, rows], linear.columns[:, rows], linear.prior_sd, variance, dof)

    def values(self, causes: Causes, at: Array) -> dict[tuple[str, str], float]:
        """Hyperparameters by effect and name, from their logarithms."""
        return {(h.effect, h.name): math.exp(value) for h, value in zip(self.hypers(causes), at, strict=True)}
