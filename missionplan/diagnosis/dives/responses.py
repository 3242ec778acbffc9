"""Neutral responses beside fits of dives: smooth errors of the readings, unknown forces, and dives that differ.

Each is a smooth random function along an axis (`discrepancy_axes`) by its principal components, in the metric of the
noise and less what effects of the catalogue do to the readings there.
"""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.dives.fitting import log_joint_with_noise
from missionplan.diagnosis.dives.noise import NOMINAL_NOISE, Noise, noise_grid
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import InnerProducts
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.set_evidence import log_slab_factor
from missionplan.diagnosis.inference.weighing import NeutralResponses

if TYPE_CHECKING:
    from missionplan.diagnosis.dives.model import DescentModel

LENGTHS = (0.3, 0.1)
"""Correlation lengths, of the axis' extent: slow changes, and what happens within a second or in a layer."""
MOST_COLUMNS, MOST_OF_RUNS, LEAST_SHARE = 8, 32, 1e-4
"""Principal components kept at most, of what all runs share and of what each has of its own, and least share of the
first one's variance that one has."""
MOST_TOGETHER = 8
"""Runs that differ from the others, of which it is not known which they are, at most."""
LEAST_LIKELY = 0.01
"""Probability from which a noise is considered."""
SAME = 1e-6
"""Size of a combination of the catalogue's effects, over the greatest, below which it is none."""


def responses_beside(model: "DescentModel", fits: Sequence[CauseFit]) -> NeutralResponses:
    """Return neutral responses by the axes of the first fit, and what they add to the log evidence of each."""
    axes = model.response_axes(fits[0].state.linear)
    if not axes:
        return NeutralResponses((), np.zeros((len(fits), 0)))
    columns = _columns(model, fits[0], axes)
    joined = np.concatenate([own for axis in columns for own in axis], axis=1)
    places = iter(np.split(np.arange(joined.shape[1]), np.cumsum([own.shape[1] for axis in columns for own in axis])))
    parts = [[next(places) for _ in axis] for axis in columns]
    in_some = [axis.in_some_runs for axis in axes]
    gains = [
        _log_gains(
            list(model.products(fit.state.linear, fit.state.prior_sd, joined, _likely_noises(fit))), parts, in_some
        )
        for fit in fits
    ]
    return NeutralResponses([(axis.name, axis.description) for axis in axes], np.array(gains))


def _likely_noises(fit: CauseFit) -> tuple[Noise, ...]:
    """Noises that are likely under a fit, and those with the usual scatter, which may be so beside a response."""
    logs = log_joint_with_noise(fit.state.likelihood.marginals(fit.state.prior_sd))
    likely = logs - logsumexp(logs) > np.log(LEAST_LIKELY)
    return tuple(
        noise
        for noise, kept in zip(noise_grid(), likely, strict=True)
        if kept or (noise.scatter == NOMINAL_NOISE.scatter and noise.diffusion == NOMINAL_NOISE.diffusion)
    )


def _columns(model: "DescentModel", fit: CauseFit, axes: Sequence[Axis]) -> list[list[Array]]:
    """Readings' responses for standard normal coefficients, shape (N, q) each [m]: of each axis, its alternatives.

    These are the lengths over which it is smooth, or the runs in which it acts.
    """
    linear, noise = fit.state.linear, noise_grid()[fit.state.best_noise]
    factors = [np.linalg.cholesky(block[0]) for block in model.covariances(linear, (noise,))]

    def whitened(values: Array) -> Array:
        solved = [
            solve_triangular(own, values[rows], lower=True) for own, rows in zip(factors, model.parts, strict=True)
        ]
        return np.concatenate(solved)

    def coloured(values: Array) -> Array:
        return np.concatenate([own @ values[rows] for own, rows in zip(factors, model.parts, strict=True)])

    named = whitened((linear.columns * model.slab)[:, model.searched(fit.causes)])
    left, sizes, _ = np.linalg.svd(named, full_matrices=False)
    span = left[:, sizes > SAME * sizes.max(initial=0.0)]
    found = []
    for axis in axes:
        functions = axis.response.shape[1] // len(axis.places)
        if len(axis.places) == 1:
            found.append(np.split(axis.size * axis.response, functions if axis.in_some_runs else 1, axis=1))
            continue
        response = axis.size * whitened(axis.response)
        response -= span @ (span.T @ response)
        smooth = (np.kron(np.eye(functions), axis.smooth(length)) for length in LENGTHS)
        found.append([coloured(_principal(response @ each, functions)) for each in smooth])
    return found


def _principal(white: Array, functions: int) -> Array:
    """Principal components of columns, shape (N, c), that are of so many functions: (N, q)."""
    directions, sizes, _ = np.linalg.svd(white, full_matrices=False)
    most = MOST_COLUMNS if functions == 1 else max(MOST_OF_RUNS, functions)
    kept = np.flatnonzero(sizes**2 > LEAST_SHARE * sizes[0] ** 2)[:most]
    return np.asarray(directions[:, kept] * sizes[kept])


def _log_gains(
    products: Sequence[InnerProducts], parts: Sequence[Sequence[NDArray[np.intp]]], in_some: Sequence[bool]
) -> Array:
    """What each response adds to the log evidence of a fit, averaged over noises, sizes and its alternatives."""
    grams = np.stack([each.gram for each in products])
    plain = np.array([each.log_density for each in products])
    plain -= logsumexp(plain)

    def gain(part: NDArray[np.intp]) -> float:
        inner, right = grams[:, part[:, None], part], grams[:, part, -1]
        return float(logsumexp(plain + log_slab_factor(inner, right)))

    return np.array(
        [
            _in_some_runs(gain, alternatives) if are_runs else _mean([gain(part) for part in alternatives])
            for alternatives, are_runs in zip(parts, in_some, strict=True)
        ]
    )


def _mean(logs: Sequence[float]) -> float:
    return float(logsumexp(logs)) - math.log(len(logs))


def _in_some_runs(gain: Callable[[NDArray[np.intp]], float], runs: Sequence[NDArray[np.intp]]) -> float:
    """Gain of a response in one run or several: in each alone, and in the likeliest together.

    All numbers of runs are as likely, and all choices of so many.
    """
    alone = [gain(part) for part in runs]
    order, total = np.argsort(alone)[::-1], len(runs)
    sizes = range(2, min(total, MOST_TOGETHER) + 1)
    together = [
        gain(np.concatenate([runs[i] for i in order[:size]])) - math.log(math.comb(total, size)) for size in sizes
    ]
    return float(logsumexp([_mean(alone), *together])) - math.log(total)
