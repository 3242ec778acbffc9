"""Evidence of sets that have more causes than a fit, in the fit's own linearisation.

A set that adds a cause to another differs from it by a few columns, which the linearisation has. Where the cause has a
shape of its own the evidence is a mean over it, by Gauss–Hermite quadrature of three points (Abramowitz & Stegun 1972,
Table 25.10).
"""

import itertools
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.dives.likelihood import DescentLikelihood
from missionplan.diagnosis.dives.linearised import DIFFERENCE
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.inference.block_covariance import InnerProducts
from missionplan.diagnosis.inference.marginal_likelihood import SCALES, log_slab_factor
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.prior import Prior, log_normal_mass
from missionplan.results.learned.evidence import Causes

NODES, NODE_WEIGHTS = (-math.sqrt(3.0), 0.0, math.sqrt(3.0)), (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)
"""Points of a standard normal distribution, and their weights."""
USUAL = SCALES[1]
"""Scale of the slabs at which ranges are allowed for."""


def log_gains(model: DescentLikelihood, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Array]:
    """Return what further causes add to the log evidence of fits, shape (s,) for the supersets of each."""
    if not fits:
        return []
    by_fit = []
    for fit, sets, columns in zip(fits, supersets, _columns(model, fits), strict=True):
        gains = np.full(len(sets), np.nan)
        with suppress(np.linalg.LinAlgError):  # the linearisation has no numbers for them
            gains = _gains(model, fit, sets, columns)
        by_fit.append(np.where(np.isnan(gains), -np.inf, gains))
    return by_fit


@dataclass(frozen=True)
class _FurtherColumns:
    """What the readings of a fit respond to strengths of effects at several shapes each."""

    strengths: tuple[int, ...]
    """Coordinate of each column."""
    values: Array
    """Response to a strength of its slab, shape (N, m) [m]."""

    def places(self, strength: int) -> list[int]:
        """Columns of a strength at the points of its shape, or the one of an effect without."""
        first, *others = (place for place, coordinate in enumerate(self.strengths) if coordinate == strength)
        return [others[0], first, others[1]] if others else [first]


def _columns(model: DescentLikelihood, fits: Sequence[CauseFit]) -> list[_FurtherColumns]:
    """Columns of the linearisation, and those at other shapes of effects that a fit does not have."""
    others = [_other_shapes(model, fit) for fit in fits]
    widths = np.array([len(strengths) for strengths, _ in others])
    settings = np.concatenate([points for _, points in others], axis=1)
    delays = np.repeat(np.stack([fit.state.linear.release_delays for fit in fits]), widths, axis=0)
    readings = (
        model.forward.readings(model.coordinates, settings, delays) if widths.any() else np.zeros((len(model.y), 0))
    )
    blocks = np.split(readings, np.cumsum(widths)[:-1], axis=1)
    here = [i for i, coordinate in enumerate(model.coordinates) if coordinate.kind != "shape"]
    by_fit = []
    for fit, (strengths, _), block in zip(fits, others, blocks, strict=True):
        linear = fit.state.linear
        columns = linear.columns[:, here] * model.slab[here]
        more = (block - linear.readings[:, None]) / DIFFERENCE if strengths else np.zeros((len(columns), 0))
        by_fit.append(_FurtherColumns((*here, *strengths), np.concatenate([columns, more], axis=1)))
    return by_fit


def _other_shapes(model: DescentLikelihood, fit: CauseFit) -> tuple[list[int], Array]:
    """Strengths of effects that a fit does not have, and coordinates at which their shapes are others, (k, m)."""
    at, fit_effects = fit.state.linear.at, {*fit.causes, *(prior.effect for prior in model.given)}
    strengths, settings = [], [np.zeros((len(at), 0))]
    for name in model.candidates:
        coordinates = [(i, c) for i, c in enumerate(model.coordinates) if c.effect == name]
        shapes = [i for i, c in coordinates if c.kind == "shape"]
        if name in fit_effects or name in model.unnamed or not shapes:
            continue
        (strength,) = (i for i, c in coordinates if c.kind != "shape")
        for node in (NODES[0], NODES[-1]):
            moved = at.copy()
            moved[strength] += DIFFERENCE * model.slab[strength]
            moved[shapes[0]] += node * model.slab[shapes[0]]
            strengths.append(strength)
            settings.append(moved[:, None])
    return strengths, np.concatenate(settings, axis=1)


def _gains(model: DescentLikelihood, fit: CauseFit, sets: Sequence[Causes], columns: _FurtherColumns) -> Array:
    """Gains of the supersets of one fit, at its likeliest noise."""
    mission_effects = {prior.effect for prior in model.given}
    changed = [tuple(name for name in causes if name in mission_effects and name not in fit.causes) for causes in sets]
    products = {causes: _products(model, fit, causes, columns.values) for causes in {(), *changed}}
    plain = products[()].log_density
    prior = replace(model.prior(model.candidates), sd=model.slab)
    masses, gains, alike = prior.log_masses, np.empty(len(sets)), dict[tuple[Causes, tuple[int, ...]], list[int]]()
    strengths = [_strengths(model, set(causes) - set(fit.causes)) for causes in sets]
    known_places = {strength: columns.places(strength) for strength in set(columns.strengths)}
    places = [[known_places[strength] for strength in indices] for indices in strengths]
    for index, choices in enumerate(places):
        alike.setdefault((changed[index], tuple(map(len, choices))), []).append(index)
    for (causes, points), chosen in alike.items():
        which = np.array([strengths[index] for index in chosen])
        at = np.array([list(itertools.product(*places[index])) for index in chosen])
        increments = _further_gains(at, points, products[causes].gram, prior.of(which.ravel()))
        gains[chosen] = increments - masses[which].sum(axis=1) + products[causes].log_density
    return gains - plain


def _strengths(model: DescentLikelihood, effects: set[str]) -> list[int]:
    """Coordinates of the strengths of effects."""
    return [i for i, c in enumerate(model.coordinates) if c.effect in effects and c.kind != "shape"]


def _products(model: DescentLikelihood, fit: CauseFit, changed: Causes, columns: Array) -> InnerProducts:
    """Inner products of columns and data beside a fit, without what the mission knew of effects that have changed."""
    linear, prior_sd = fit.state.linear, fit.state.prior_sd
    if changed:
        centre = model.prior((*fit.causes, *changed)).centre
        indices = model.free(changed)
        prior_sd = prior_sd.copy()
        prior_sd[[i for i in indices if model.coordinates[i].kind != "shape"]] = 0.0
        linear = replace(linear, y=linear.y - linear.columns[:, indices] @ (centre - linear.centre)[indices])
    (products,) = model.products(linear, prior_sd, columns, (noise_grid()[fit.state.best_noise],))
    return products


def _further_gains(places: NDArray[np.int_], points: Sequence[int], gram: Array, slabs: Prior) -> Array:
    """What q further strengths add to the log density in each of s sets, a mean over shapes and slabs cut to ranges.

    `places`, (s, p, q): of the columns of the strengths, at the points of their shapes, `points` of each. `gram`: inner
    products of all columns and, last, the data. `slabs`: of the strengths of all sets, one after the other.
    """
    sets, _, size = places.shape
    shares = itertools.product(*(NODE_WEIGHTS if count > 1 else (1.0,) for count in points))
    inner, right = gram[places[..., :, None], places[..., None, :]], gram[places, -1]
    spread = np.linalg.inv(inner + np.eye(size) / USUAL**2)
    centre, slab, low, high = (values.reshape(sets, 1, size) for values in (slabs.centre, slabs.sd, *slabs.bounds))
    mean = centre + slab * (spread @ right[..., None])[..., 0]
    sd = slab * np.sqrt(np.diagonal(spread, axis1=-2, axis2=-1))
    inside = np.sum(log_normal_mass((low - mean) / sd, (high - mean) / sd), axis=-1)
    logs = log_slab_factor(inner, right) + np.log([math.prod(weights) for weights in shares]) + inside
    return np.asarray(np.logaddexp.reduce(logs, axis=1))
