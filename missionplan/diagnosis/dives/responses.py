"""Neutral responses beside fits of dives: smooth errors of the readings, unknown forces, and dives that differ.

Each is a smooth random function along an axis (`discrepancy_axes`) by its principal components, in the metric of the
noise and less what effects of the catalogue do to the readings there.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag, solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.dives.fitting import log_joint_with_noise
from missionplan.diagnosis.dives.noise import NOMINAL_NOISE, Noise, noise_grid
from missionplan.diagnosis.inference.adequacy.axes import Axis
from missionplan.diagnosis.inference.adequacy.residuals import InnerProducts
from missionplan.diagnosis.inference.marginal_likelihood import gaussian_log_density
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.set_evidence import SCALE_PRIOR, SCALES
from missionplan.diagnosis.inference.weighing import NeutralResponses

if TYPE_CHECKING:
    from missionplan.diagnosis.dives.model import DescentModel

LENGTH = 0.3
"""Correlation length, of the axis' extent."""
MOST_COLUMNS, LEAST_SHARE = 8, 1e-4
"""Principal components kept at most, and least share of the first one's variance that one has."""
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
    joined = np.concatenate(columns, axis=1)
    ends = np.cumsum([own.shape[1] for own in columns])
    places = [np.arange(end - own.shape[1], end) for own, end in zip(columns, ends, strict=True)]
    parts = [
        [place[[i]] for i in range(len(place))] if axis.are_alternatives else [place]
        for axis, place in zip(axes, places, strict=True)
    ]
    gains = [
        _log_gains(
            model.products(fit.state.linear, fit.state.prior_sd, joined, _likely_noises(fit)), parts, len(model.y)
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


def _columns(model: "DescentModel", fit: CauseFit, axes: Sequence[Axis]) -> list[Array]:
    """Readings' responses for standard normal coefficients, shape (N, q) each [m]."""
    linear, noise = fit.state.linear, noise_grid()[fit.state.best_noise]
    factor = np.linalg.cholesky(block_diag(*(block[0] for block in model.covariances(linear, (noise,)))))
    own = model.searched(fit.causes)
    named = solve_triangular(factor, (linear.columns * model.slab)[:, own], lower=True, check_finite=False)
    left, sizes, _ = np.linalg.svd(named, full_matrices=False)
    span = left[:, sizes > SAME * sizes.max(initial=0.0)]
    found = []
    for axis in axes:
        smooth = axis.smooth(LENGTH)
        functions = axis.response.shape[1] // len(smooth)
        values = axis.size * axis.response @ np.kron(np.eye(functions), smooth)
        if axis.are_alternatives:
            found.append(values)
            continue
        white = solve_triangular(factor, values, lower=True, check_finite=False)
        directions, sizes, _ = np.linalg.svd(white - span @ (span.T @ white), full_matrices=False)
        kept = np.flatnonzero(sizes**2 > LEAST_SHARE * sizes[0] ** 2)[: max(MOST_COLUMNS, functions)]
        found.append(np.asarray(factor @ (directions[:, kept] * sizes[kept])))
    return found


def _log_gains(products: Sequence[InnerProducts], parts: Sequence[Sequence[Array]], count: int) -> Array:
    """What each response adds to the log evidence of a fit, averaged over noises, sizes and its alternatives."""
    plain = [each.log_weight - 0.5 * (each.log_determinant + float(each.gram[-1, -1])) for each in products]
    base = float(logsumexp(plain)) - 0.5 * count * float(np.log(2.0 * np.pi))
    found = []
    for alternatives in parts:
        logs = [
            each.log_weight
            + np.log(share / len(alternatives))
            + gaussian_log_density(each.gram[np.ix_(own, own)], np.full(len(part), scale), each.log_determinant, count)
            for part in alternatives
            for own in [np.append(part, len(products[0].gram) - 1)]
            for each in products
            for scale, share in zip(SCALES, SCALE_PRIOR, strict=True)
        ]
        found.append(float(logsumexp(logs)) - base)
    return np.array(found)
