"""Draws of a mission's named quantities for one block of trials, with correlations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem
from missionplan.montecarlo.distributions import Distribution, Quantity
from missionplan.montecarlo.streams import BLOCK, stream

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Correlation:
    """Correlation of two named quantities, between the standard normals from which both are drawn."""

    between: tuple[str, str]
    rho: float


def draw(
    quantities: Mapping[str, Quantity],
    correlations: Sequence[Correlation],
    seed: int,
    block: int,
    size: int = BLOCK,
) -> dict[str, float | Array]:
    """Draw each quantity once a trial.

    Parameters
    ----------
    quantities : mapping of str to float or Distribution
        By key path; a number stays a number.
    correlations : sequence of Correlation
        Pairs not named are independent.
    seed, block : int
        See `stream`.
    size : int
        Trials in use, at most BLOCK: the first of a block that is always drawn whole.

    Returns
    -------
    dict of str to float or array, shape (size,)

    Raises
    ------
    InputError
        When the correlations are impossible (see `correlation_factor`).
    """
    tied, factor = correlation_factor(quantities, correlations)
    mixed: dict[str, Array] = {}
    if tied:
        independent = np.stack([stream(seed, name, block).standard_normal(BLOCK) for name in tied])
        # einsum, not BLAS: the bits must not depend on the number of BLAS threads
        mixed = dict(zip(tied, np.einsum("ij,jt->it", factor, independent), strict=True))
    drawn: dict[str, float | Array] = {}
    for name, quantity in quantities.items():
        if isinstance(quantity, Distribution):
            normals = mixed[name] if name in mixed else stream(seed, name, block).standard_normal(BLOCK)
            drawn[name] = quantity.from_normal(normals[:size])
        else:
            drawn[name] = quantity
    return drawn


def correlation_factor(
    quantities: Mapping[str, Quantity], correlations: Sequence[Correlation]
) -> tuple[list[str], Array]:
    """Find the quantities that are tied, and the Cholesky factor of their correlations.

    Returns
    -------
    names, factor : list of str, array of shape (k, k)
        Names in alphabetical order, so that the order in the file does not matter, and the lower factor.

    Raises
    ------
    InputError
        When a quantity is unknown or not uncertain, a pair is given twice or ties a quantity to itself, a
        coefficient is not between -1 and 1, or no joint distribution has these correlations.
    """
    problems = [problem for number, pair in enumerate(correlations) for problem in _problems(quantities, number, pair)]
    pairs = [frozenset(correlation.between) for correlation in correlations]
    for number, pair in enumerate(pairs):
        if pair in pairs[:number]:
            problems.append(Problem("this pair is given twice", key=f"correlations[{number}].between"))
    if problems:
        raise InputError(problems)
    tied = sorted(set(chain.from_iterable(correlation.between for correlation in correlations)))
    matrix = np.eye(len(tied))
    for correlation in correlations:
        row, column = (tied.index(name) for name in correlation.between)
        matrix[row, column] = matrix[column, row] = correlation.rho
    try:
        return tied, np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        smallest = float(np.linalg.eigvalsh(matrix)[0])
        message = (
            f"no quantities can have these correlations together: the matrix's smallest eigenvalue is {smallest:.3g}"
        )
        raise InputError([Problem(message, key="correlations", hint="make them smaller")]) from error


def _problems(quantities: Mapping[str, Quantity], number: int, correlation: Correlation) -> list[Problem]:
    key = f"correlations[{number}]"
    problems = []
    for name in correlation.between:
        if name not in quantities:
            problems.append(Problem(f"no quantity is named {name!r}", key=f"{key}.between"))
        elif not isinstance(quantities[name], Distribution):
            problems.append(Problem(f"{name} is a fixed value, expected a distribution", key=f"{key}.between"))
    if correlation.between[0] == correlation.between[1]:
        problems.append(Problem("ties a quantity to itself", key=f"{key}.between"))
    if not -1.0 < correlation.rho < 1.0:
        problems.append(Problem(f"given {correlation.rho:g}, expected between -1 and 1", key=f"{key}.rho"))
    return problems
