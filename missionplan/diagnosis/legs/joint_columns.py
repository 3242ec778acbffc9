"""Columns of all sets of causes of a log, side by side: what they share is whitened once under each noise."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, GramMatrix, student_marginal
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.markov_covariance import WhitenedColumns
from missionplan.results.learned.evidence import Causes


@dataclass(frozen=True)
class LinearisedGroup:
    """The model of a group of sets, linearised."""

    about: Array
    """Point about which it is, shape (k,)."""
    linear: LinearisedLegs
    columns: Array
    """Raw columns and those of modulations before their sizes, and, last, the data less what is there without them,
    shape (2, n, c + 1)."""


@dataclass(frozen=True)
class JointColumns:
    """Columns of some groups of sets, and of some terms beside them."""

    values: Array
    """Those that are the same in all groups, each group's own with its data, and the terms', smaller ones first, shape
    (2, n, m)."""
    places: Mapping[Causes, NDArray[np.int_]]
    """Of each group's columns and, last, its data."""
    first: int
    """Place of the first column of a term."""
    sizes: tuple[int, ...]
    """Of the terms, in their order."""

    @classmethod
    def of(
        cls, groups: Mapping[Causes, LinearisedGroup], differ: NDArray[np.bool_], terms: Sequence[Array]
    ) -> "JointColumns":
        """Join columns.

        Parameters
        ----------
        groups : mapping
            By the effects that are not linear.
        differ : array of bool, shape (c + 1,)
            Which of a group's columns are its own.
        terms : sequence of array, shape (2, n, q)
        """
        own, alike = np.flatnonzero(differ), np.flatnonzero(~differ)
        any_group = next(iter(groups.values()))
        parts, places, first = [any_group.columns[:, :, alike]], {}, len(alike)
        for name, group in groups.items():
            parts.append(group.columns[:, :, own])
            places[name] = np.empty(len(differ), dtype=int)
            places[name][alike], places[name][own] = np.arange(len(alike)), first + np.arange(len(own))
            first += len(own)
        sizes = tuple(term.shape[2] for term in terms)
        parts += [terms[index] for index in np.argsort(sizes, kind="stable")]
        return cls(np.concatenate(parts, axis=2), places, first, sizes)

    def grams(self, white: WhitenedColumns, scale: Array) -> dict[Causes, GramMatrix]:
        """Inner products of each group's columns and the terms' under a noise, a group's columns times a scale."""
        core, further, inner = self._products(white)
        normaliser = -0.5 * (white.log_determinant + self.values[:, :, 0].size * LOG_2PI)
        return {
            group: GramMatrix(
                core[np.ix_(own, own)] * np.outer(scale, scale), normaliser, further[own] * scale[:, None], inner
            )
            for group, own in self.places.items()
        }

    def heavy_tailed(self, group: Causes, scale: Array, variance: Array, bound: "TailBound") -> GramMatrix:
        """Return inner products under a normal lower bound of the density of errors with heavy tails."""
        places = np.append(self.places[group], np.arange(self.first, self.values.shape[2]))
        columns = (self.values * np.sqrt(bound.weight / variance)[:, :, None]).reshape(-1, self.values.shape[2])
        alone = JointColumns(self.values[:, :, places], {group: np.arange(len(scale))}, len(scale), self.sizes)
        core, further, inner = alone._products(WhitenedColumns(columns[:, places], (), 0.0))
        return GramMatrix(core * np.outer(scale, scale), bound.log_normaliser, further * scale[:, None], inner)

    def _products(self, white: WhitenedColumns) -> tuple[Array, Array, tuple[Array, ...]]:
        """Inner products of all groups' columns, of these with the terms', and of each term's own."""
        groups = slice(0, self.first)
        inner, first = [], self.first
        for size, alike in itertools.groupby(sorted(self.sizes)):
            last = first + size * len(list(alike))
            inner.append(white.products_of_blocks(slice(first, last), size))
            first = last
        return white.products(groups, groups), white.products(groups, slice(self.first, None)), tuple(inner)


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
        found = student_marginal(y, white, np.ones(white.shape[2]), variance, dof)
        squared = np.sum((y - white @ found.mean) ** 2 / variance, axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
        log_normaliser = len(squared) * constant - 0.5 * float(np.log(variance).sum())
        log_normaliser += float(np.sum(0.5 * weight * squared - 0.5 * (dof + 2.0) * np.log1p(squared / (dof - 2.0))))
        return cls(np.asarray(weight), log_normaliser)
