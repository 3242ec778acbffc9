"""A set of causes linearised about given coordinates, as the likelihood of a log takes it, and effects held there.

What likelihoods share is computed once: inner products at many hyperparameters, and the whitened columns of all sets,
side by side.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.inference.evidence_approximations import student_marginal
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, GramMatrix, Marginal
from missionplan.diagnosis.legs.likelihood.hyperparameters import SLAB_SCALE, HyperparameterValues
from missionplan.diagnosis.legs.likelihood.markov_covariance import MarkovCovariance, WhitenedColumns
from missionplan.diagnosis.legs.likelihood.modulation import Modulation
from missionplan.phases.hooks import Leg, MarkovProcess, TransitEffect
from missionplan.results.learned.evidence import Causes


@dataclass(frozen=True)
class CoordinatePrior:
    """Normal prior of k coordinates: mean, shape (k,), and lower factor L of the covariance L Lᵀ, shape (k, k)."""

    mean: Array
    factor: Array

    def posterior(self, marginal: Marginal) -> tuple[Array, Array]:
        """Return mean (k,) and covariance (k, k) of the coordinates from those of the standardised coefficients."""
        k = len(self.mean)
        mean = self.mean + self.factor @ marginal.mean[:k]
        return mean, self.factor @ marginal.covariance[:k, :k] @ self.factor.T


@dataclass(frozen=True)
class LinearisedLegs:
    """Linearised model of a set of causes: y ≈ columns·coefficients + noise, coefficients ~ N(0, 1) and independent."""

    about: Array
    """Coordinates about which it is linearised, shape (k,)."""
    prior: CoordinatePrior
    """Of the k coordinates, which are its mean plus its factor times the first k coefficients."""
    y: Array
    """Velocity errors less those at the prior means, on the principal axes, shape (2, n) [m/s]."""
    columns: Array
    """Of the coefficients: k for the coordinates, then m of the functions that modulate oscillations, shape (2, n, k +
    m)."""
    slabs: Mapping[str, list[int]]
    """By cause, the coefficients whose prior standard deviation its slab scale multiplies."""
    modulations: tuple[Modulation, ...]
    """Whose functions follow the coordinates, in their order."""

    def prior_sd(self, values: HyperparameterValues) -> Array:
        """Prior standard deviations of the coefficients, 1 but for slabs and modulations, shape (k + m,)."""
        sd = np.ones(len(self.about))
        for effect, places in self.slabs.items():
            sd[places] = values.get((effect, SLAB_SCALE), 1.0)
        for modulation in self.modulations:
            if modulation.effect in self.slabs:
                sd[self.slabs[modulation.effect]] *= modulation.mean_sd(values[modulation.keys[1]])
        of_functions = [modulation.sd(*(values[key] for key in modulation.keys)) for modulation in self.modulations]
        return np.concatenate([sd, *of_functions])

    @cached_property
    def joined(self) -> Array:
        """Columns and, last, data, shape (2, n, k + m + 1)."""
        return np.concatenate([self.columns, self.y[:, :, None]], axis=2)


class HeldEffect(TransitEffect):
    """An effect whose hooks for the legs of a log are computed once."""

    def __init__(self, effect: TransitEffect, leg: Leg) -> None:
        self._effect, self._leg = effect, leg

    @cached_property
    def _velocity(self) -> Array | float:
        return self._effect.velocity(self._leg)

    @cached_property
    def _factor(self) -> NDArray[np.complex128] | Scalars:
        return self._effect.course_factor(self._leg)

    def velocity(self, leg: Leg) -> Array | float:
        """Return the mean velocity error."""
        return self._velocity

    def course_factor(self, leg: Leg) -> NDArray[np.complex128] | Scalars:
        """Return the factor on the velocity through the water."""
        return self._factor

    @property
    def answers_current(self) -> bool:
        """Whether the effect does."""
        return self._effect.answers_current

    def answer_to_current(self, leg: Leg, water: Array) -> Array | float:
        """Return the answer to this current."""
        return self._effect.answer_to_current(leg, water)

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array | float:
        """Return the drift at the surface."""
        return self._effect.surface_velocity(t, duration, position)


MIN_DOF = 2.02
"""Degrees of freedom at and below which a Student-t error has practically no variance."""
KEPT_GRAMS = 8
"""Most inner products kept: a gradient by differences needs those of a point and of each step along a noise."""
NoiseKey = tuple[float | MarkovProcess | None, ...]


@dataclass(frozen=True)
class NoiseComponents:
    """Parts of the errors' covariance."""

    white: Array
    """Variance of the velocity error that is the same on every leg, on each axis, shape (2,) [m²/s²]."""
    walk: float
    """Growth of the variance of the position error under way, each axis [m²/s]."""
    fix_sd: float
    """Standard deviation of a fix, each axis [m]."""
    process: MarkovProcess | None
    """Error that persists from leg to leg."""
    dof: float
    """Degrees of freedom of the errors; infinite: normal."""

    @cached_property
    def key(self) -> NoiseKey:
        """What distinguishes it from other noises of normal errors."""
        return (*self.white.tolist(), self.walk, self.fix_sd, self.process)

    def independent(self, under_way: Array) -> Array:
        """Variance of the velocity error that no other leg shares, fixes apart, shape (2, n) [m²/s²]."""
        return np.asarray(self.white[:, None] + self.walk / under_way)


@dataclass(frozen=True)
class SelectedLegs:
    """Some legs of a linearised log."""

    linear: LinearisedLegs
    """The log."""
    legs: MarkovCovariance
    """Covariance between the n legs."""
    joined: Array
    """Their columns and, last, data, shape (2, n, k + 1)."""
    _grams: dict[NoiseKey, tuple[Array, float]] = field(default_factory=dict)

    def gram(self, noise: NoiseComponents) -> tuple[Array, float]:
        """Inner products of whitened columns and data, and ln |covariance|; those of the last few noises are kept."""
        if noise.key not in self._grams:
            while len(self._grams) >= KEPT_GRAMS:
                del self._grams[next(iter(self._grams))]
            independent = noise.independent(self.legs.under_way)
            self._grams[noise.key] = self.legs.gram(self.joined, independent, noise.fix_sd, noise.process)
        return self._grams[noise.key]

    def student(self, noise: NoiseComponents, prior_sd: Array) -> Marginal:
        """Marginalise the coefficients under errors with heavy tails."""
        if noise.dof <= MIN_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = noise.independent(self.legs.under_way) + noise.fix_sd**2 * self.legs.fix_variance()
        return student_marginal(self.joined[:, :, -1], self.joined[:, :, :-1], prior_sd, variance, noise.dof)


@dataclass(frozen=True)
class LinearisedGroup:
    """The model of a group of sets, linearised."""

    about: Array
    """Point about which it is, shape (k,)."""
    linear: LinearisedLegs
    columns: Array
    """Raw columns and those of modulations before their sizes, and, last, the data less what is there without them,
    shape (2, n, c + 1)."""


TOGETHER, SIDE_BY_SIDE, LARGE = 512, 64, 32768
"""Columns of terms that are whitened together, and terms, or numbers, side by side from which they are not copied."""


@dataclass(frozen=True)
class JointColumns:
    """Columns of some groups of sets, and of some terms beside them."""

    values: Array
    """Those that are the same in all groups, then each group's own with its data, shape (2, n, m)."""
    places: Mapping[Causes, NDArray[np.int_]]
    """Of each group's columns and, last, its data."""
    terms: tuple[tuple[int, Array], ...]
    """Columns of some terms of the same number q together, smaller ones first: q, and shape (2, n, b·q)."""

    @classmethod
    def of(
        cls, groups: Mapping[Causes, LinearisedGroup], differ: NDArray[np.bool_], terms: Sequence[Array]
    ) -> "JointColumns":
        """Join columns.

        `groups`: by the effects that are not linear. `differ`, shape (c + 1,): which of a group's columns are its own.
        `terms`, shape (2, n, q).
        """
        distinct, alike = np.flatnonzero(differ), np.flatnonzero(~differ)
        any_group = next(iter(groups.values()))
        parts, places, first = [any_group.columns[:, :, alike]], {}, len(alike)
        for name, group in groups.items():
            parts.append(group.columns[:, :, distinct])
            places[name] = np.empty(len(differ), dtype=int)
            places[name][alike], places[name][distinct] = np.arange(len(alike)), first + np.arange(len(distinct))
            first += len(distinct)
        together = []
        for (size, side_by_side), alike_terms in itertools.groupby(
            sorted(terms, key=lambda term: term.shape[2]), key=_lies
        ):
            of_size, count = list(alike_terms), max(1, TOGETHER // size)
            whole = of_size[0].base
            if side_by_side and whole is not None and whole.size == sum(term.size for term in of_size):
                together.append((size, whole.reshape(*of_size[0].shape[:2], -1)))
                continue
            parts_of_size = (of_size[start : start + count] for start in range(0, len(of_size), count))
            together += [(size, np.concatenate(some, axis=2)) for some in parts_of_size]
        return cls(np.concatenate(parts, axis=2), places, tuple(together))

    def grams(self, whiten: Callable[[Array], WhitenedColumns], scale: Array) -> dict[Causes, GramMatrix]:
        """Inner products of each group's columns and the terms' under a noise, a group's columns times a scale."""
        white = whiten(self.values)
        ((further, inner),) = self._with_terms([white], whiten)
        core = white.products(white)
        normaliser = -0.5 * (white.log_determinant + self.values[:, :, 0].size * LOG_2PI)
        return {
            group: GramMatrix(
                core[np.ix_(rows, rows)] * np.outer(scale, scale), normaliser, further[rows] * scale[:, None], inner
            )
            for group, rows in self.places.items()
        }

    def heavy_tailed(
        self, scale: Array, variance: Array, bounds: Mapping[Causes, "TailBound"]
    ) -> dict[Causes, GramMatrix]:
        """Return inner products of each group's columns under normal lower bounds of errors with heavy tails."""
        weights = np.stack([bound.weight / variance for bound in bounds.values()], axis=1)
        whites = [
            WhitenedColumns(self.values[:, :, self.places[group]], weights[:, [place]], 0.0)
            for place, group in enumerate(bounds)
        ]
        with_terms = self._with_terms(whites, lambda columns: WhitenedColumns(columns, weights, 0.0))
        return {
            group: GramMatrix(
                white.products(white) * np.outer(scale, scale), bound.log_normaliser, further * scale[:, None], inner
            )
            for (group, bound), white, (further, inner) in zip(bounds.items(), whites, with_terms, strict=True)
        }

    def _with_terms(
        self, whites: Sequence[WhitenedColumns], whiten: Callable[[Array], WhitenedColumns]
    ) -> list[tuple[Array, tuple[Array, ...]]]:
        """Inner products of whitened columns with the terms', and of each term's own, by their sizes.

        `whites`: under each of the covariances by which `whiten` whitens.
        """
        further = [[np.empty((white.ahead.shape[2], 0))] for white in whites]
        inner: dict[int, list[Array]] = {}
        for size, columns in self.terms:
            some = whiten(columns)
            inner.setdefault(size, []).append(some.products_of_blocks(size))
            for parts, white in zip(further, whites, strict=True):
                parts.append(white.products(some))
        by_size = [np.concatenate(blocks, axis=1) for blocks in inner.values()]
        return [(np.concatenate(parts, axis=1), tuple(gram[i] for gram in by_size)) for i, parts in enumerate(further)]


def _lies(columns: Array) -> tuple[int, int]:
    """Number of columns, and which array they are part of, where they lie in it side by side with many others."""
    whole = columns.base
    most = min(SIDE_BY_SIDE * columns.size, LARGE)
    return columns.shape[2], id(whole) if whole is not None and whole.size >= most else 0


@dataclass(frozen=True)
class TailBound:
    """A normal lower bound of Student-t errors that touches them where a reference set is likeliest.

    ln t of a leg is at least a parabola in its residuals with the weight (ν + 2)/(ν − 2 + q) of iterated least squares
    (Lange, Little & Taylor 1989; Jaakkola & Jordan 2000, *Stat. Comput.* 10).
    """

    weight: Array
    """Shape (n,)."""
    log_normaliser: float

    @classmethod
    def at(cls, y: Array, white: Array, variance: Array, dof: float) -> "TailBound":
        """Touch them at the likeliest coefficients, of standard normal priors, of columns (2, n, k) in data (2, n)."""
        marginal = student_marginal(y, white, np.ones(white.shape[2]), variance, dof)
        squared = np.sum((y - white @ marginal.mean) ** 2 / variance, axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
        log_normaliser = len(squared) * constant - 0.5 * float(np.log(variance).sum())
        log_normaliser += float(np.sum(0.5 * weight * squared - 0.5 * (dof + 2.0) * np.log1p(squared / (dof - 2.0))))
        return cls(np.asarray(weight), log_normaliser)
