"""Draws of a mission's named quantities for one block of trials, with correlations."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, LocalProblem, Problem, did_you_mean, key_path
from missionplan.montecarlo.distributions import Distribution, Quantity
from missionplan.montecarlo.normal_transform import NormalTransform
from missionplan.montecarlo.streams import BLOCK, BlockStreams, NormalSource

LEAST_EIGENVALUE = 1e-10
"""Of a matrix of correlations that can be factored reliably."""


@dataclass(frozen=True)
class Correlation:
    """Correlation of two named quantities, between the standard normals from which both are drawn."""

    between: tuple[str, str]
    rho: float


@dataclass(frozen=True)
class JointDistribution:
    """The uncertain quantities of a mission with their correlations, to be drawn block by block."""

    marginals: Mapping[str, NormalTransform]
    """By key path."""
    correlated: Sequence[str]
    """Names of those that are correlated, in alphabetical order."""
    factor: Array
    """Cholesky factor of their correlations, shape (k, k)."""
    streams: Mapping[str, str] = field(default_factory=dict)
    """Names of the streams of those that have another one than their own."""

    @classmethod
    def of(
        cls,
        quantities: Mapping[str, Quantity],
        correlations: Sequence[Correlation],
        streams: Mapping[str, str] | None = None,
    ) -> "JointDistribution":
        """Select the distributions among the quantities; pairs without a correlation are independent.

        Raises
        ------
        InputError
            With everything that is wrong with the correlations (see `correlation_problems`).
        """
        marginals = {name: quantity for name, quantity in quantities.items() if isinstance(quantity, Distribution)}
        return cls(marginals, *correlation_factor(quantities, correlations), streams or {})

    def draw(self, seed: int, block: int, size: int = BLOCK) -> dict[str, Array]:
        """Draw each quantity once per trial.

        Parameters
        ----------
        seed, block : int
            See `stream`.
        size : int
            Trials in use, at most BLOCK: the first ones of a block that is always drawn whole.

        Returns
        -------
        dict of str to array, shape (size,)
        """
        return self.draw_from(BlockStreams(seed, block), size)

    def draw_from(self, source: NormalSource, size: int) -> dict[str, Array]:
        """Draw each quantity once per trial from a source of normals; as `draw`."""
        mixed: dict[str, Array] = {}
        if self.correlated:
            independent = np.stack([self._normals(source, name) for name in self.correlated])
            # einsum, not BLAS: the bits must not depend on the number of BLAS threads
            mixed = dict(zip(self.correlated, np.einsum("ij,jt->it", self.factor, independent), strict=True))
        drawn = {}
        for name, marginal in self.marginals.items():
            normals = mixed[name] if name in mixed else self._normals(source, name)
            drawn[name] = marginal.from_normal(normals[:size])
        return drawn

    def _normals(self, source: NormalSource, name: str) -> Array:
        return source.once(self.streams.get(name, name))


def correlation_factor(
    quantities: Mapping[str, Quantity], correlations: Sequence[Correlation]
) -> tuple[list[str], Array]:
    """Find the correlated quantities, and the Cholesky factor of their correlations.

    Returns
    -------
    names, factor : list of str, array of shape (k, k)
        Names in alphabetical order, so that the order in the file does not matter, and the lower factor.

    Raises
    ------
    InputError
        With everything that is wrong with the correlations (see `correlation_problems`).
    """
    problems = correlation_problems(quantities, correlations)
    if problems:
        raise InputError(
            [Problem(each.message, key=key_path(("correlations", *each.path)), hint=each.hint) for each in problems]
        )
    correlated, matrix = _matrix(correlations)
    return correlated, np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)


def correlation_problems(quantities: Mapping[str, Quantity], correlations: Sequence[Correlation]) -> list[LocalProblem]:
    """List what is wrong with correlations, by key path below them.

    A quantity is unknown or not uncertain, a pair is given twice or joins a quantity to itself, a coefficient is not
    between -1 and 1, or no joint distribution has these correlations together.
    """
    uncertain = [name for name, quantity in quantities.items() if isinstance(quantity, Distribution)]
    problems = [
        problem.within((number,))
        for number, correlation in enumerate(correlations)
        for problem in _pair_problems(quantities, uncertain, correlation)
    ]
    pairs = [frozenset(correlation.between) for correlation in correlations]
    for number, pair in enumerate(pairs):
        if pair in pairs[:number]:
            problems.append(LocalProblem((number, "between"), "this pair is given twice"))
    smallest = _least_eigenvalue(correlations)
    if problems or smallest >= LEAST_EIGENVALUE:
        return problems
    message = f"no quantities can have these correlations together: the matrix's smallest eigenvalue is {smallest:.3g}"
    return [LocalProblem((), message, "make them smaller")]


def _least_eigenvalue(correlations: Sequence[Correlation]) -> float:
    """Least eigenvalue of the matrix of correlations; 1 of none."""
    return float(np.linalg.eigvalsh(_matrix(correlations)[1])[0]) if correlations else 1.0


def _matrix(correlations: Sequence[Correlation]) -> tuple[list[str], Array]:
    """Return the names in alphabetical order, and the matrix of their correlations."""
    correlated = sorted(set(chain.from_iterable(correlation.between for correlation in correlations)))
    matrix = np.eye(len(correlated))
    for correlation in correlations:
        row, column = (correlated.index(name) for name in correlation.between)
        matrix[row, column] = matrix[column, row] = correlation.rho
    return correlated, matrix


def _pair_problems(
    quantities: Mapping[str, Quantity], uncertain: Sequence[str], correlation: Correlation
) -> Iterator[LocalProblem]:
    for side, name in enumerate(correlation.between):
        hint = did_you_mean(name, uncertain)
        if name not in quantities:
            yield LocalProblem(("between", side), f"no quantity is named {name!r}", hint)
        elif name not in uncertain:
            yield LocalProblem(("between", side), f"{name} is a fixed value, expected a distribution", hint)
    if correlation.between[0] == correlation.between[1]:
        yield LocalProblem(("between",), "correlates a quantity with itself")
    if not -1.0 < correlation.rho < 1.0:
        yield LocalProblem(("rho",), f"given {correlation.rho:g}, expected between -1 and 1")
