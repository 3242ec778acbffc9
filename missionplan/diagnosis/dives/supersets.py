"""Evidence of sets that have more causes than a fit, in the fit's own linearisation.

A set that adds a cause to another differs from it by a few columns, which the linearisation has. Where the cause has a
shape of its own the evidence is a mean over it, by Gauss–Hermite quadrature of three points (Abramowitz & Stegun 1972,
Table 25.10).
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.dives.likelihood import DescentLikelihood, inner_products
from missionplan.diagnosis.dives.linearised import DIFFERENCE
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.prior import log_normal_mass
from missionplan.diagnosis.inference.set_evidence import SCALE_PRIOR, SCALES, GramMatrix, SetPriors
from missionplan.results.learned.evidence import Causes

NODES, NODE_WEIGHTS = (-math.sqrt(3.0), 0.0, math.sqrt(3.0)), (1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0)
"""Points of a standard normal distribution, and their weights."""
USUAL = 1
"""Scale of the slabs at which ranges are allowed for."""


@dataclass(frozen=True)
class _Variant:
    """A set with its further causes at one shape each: number of the set, log weight, their strengths and columns."""

    number: int
    log_weight: float
    strengths: tuple[int, ...]
    places: tuple[int, ...]


def log_gains(model: DescentLikelihood, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Array]:
    """Return what further causes add to the log evidence of fits, shape (s,) for the supersets of each.

    Parameters
    ----------
    model : DescentLikelihood
    fits : sequence of CauseFit
    supersets : sequence of sequence of set
        Of each fit.
    """
    if not fits:
        return []
    shapes = [_FurtherShapes.of(model, fit) for fit in fits]
    columns = _columns(model, fits, shapes)
    return [
        _gains_where_known(model, fit, sets, own, further)
        for fit, sets, own, further in zip(fits, supersets, shapes, columns, strict=True)
    ]


@dataclass(frozen=True)
class _FurtherShapes:
    """Effects that a fit does not have at other shapes than the linearisation's."""

    strengths: list[int]
    """Coordinate of each one's strength."""
    settings: Array
    """Coordinates at which the phase is run, shape (k, m)."""

    @classmethod
    def of(cls, model: DescentLikelihood, fit: CauseFit) -> "_FurtherShapes":
        at, known = fit.state.linear.at, {*fit.causes, *(each.effect for each in model.given)}
        strengths, settings = [], []
        for name in model.candidates:
            own = [(i, c) for i, c in enumerate(model.coordinates) if c.effect == name]
            shapes = [i for i, c in own if c.kind == "shape"]
            if name in known or name in model.unnamed or not shapes:
                continue
            (strength,) = (i for i, c in own if c.kind != "shape")
            for node in (NODES[0], NODES[-1]):
                moved = at.copy()
                moved[strength] += DIFFERENCE * model.slab[strength]
                moved[shapes[0]] += node * model.slab[shapes[0]]
                strengths.append(strength)
                settings.append(moved)
        return cls(strengths, np.stack(settings, axis=1) if settings else np.zeros((len(at), 0)))

    def places(self, strength: int, first: int) -> list[int]:
        """Columns of a strength at the points of its shape, those at other shapes from the number given on."""
        others = [first + place for place, own in enumerate(self.strengths) if own == strength]
        return [others[0], strength, others[1]] if others else [strength]


def _columns(model: DescentLikelihood, fits: Sequence[CauseFit], shapes: Sequence[_FurtherShapes]) -> list[Array]:
    """Sensitivities to the strengths at other shapes, shape (N, m) for each fit, by one call of the phase."""
    widths = np.array([own.settings.shape[1] for own in shapes])
    if not widths.sum():
        return [np.zeros((len(model.y), 0)) for _ in fits]
    delays = np.repeat(np.stack([fit.state.linear.release_delays for fit in fits]), widths, axis=0)
    readings = model.forward.readings(model.coordinates, np.concatenate([s.settings for s in shapes], axis=1), delays)
    blocks = np.split(readings, np.cumsum(widths)[:-1], axis=1)
    return [
        (block - fit.state.linear.readings[:, None]) / (DIFFERENCE * model.slab[own.strengths])
        for fit, own, block in zip(fits, shapes, blocks, strict=True)
    ]


def _gains_where_known(
    model: DescentLikelihood, fit: CauseFit, sets: Sequence[Causes], shapes: _FurtherShapes, further: Array
) -> Array:
    """Gains of the supersets of one fit; none where the linearisation has no numbers for them."""
    try:
        gains = _gains(model, fit, sets, shapes, further)
    except np.linalg.LinAlgError:
        return np.full(len(sets), -np.inf)
    return np.where(np.isnan(gains), -np.inf, gains)


def _gains(
    model: DescentLikelihood, fit: CauseFit, sets: Sequence[Causes], shapes: _FurtherShapes, further: Array
) -> Array:
    """Gains of the supersets of one fit, at its likeliest noise."""
    linear, noise = fit.state.linear, noise_grid()[fit.state.best_noise]
    joined = np.concatenate([linear.columns, linear.curvature[:, None], further, linear.y[:, None]], axis=1)
    parts = [
        inner_products(covariance, joined[rows])
        for rows, covariance in zip(model.parts, model.covariances(linear, (noise,)), strict=True)
    ]
    products, determinant = (sum(part[i][0] for part in parts) for i in (0, 1))
    gram = GramMatrix.of(np.asarray(products), float(determinant), len(model.y))
    k = len(model.coordinates)
    root = np.zeros((len(products) - 1,) * 2)
    known = fit.state.prior_sd
    root[:k, :k] = np.diag(known) if known.ndim == 1 else known
    root[k, k] = noise.scatter
    before = SetPriors(np.zeros((1, len(root))), root[None]).log_density(gram)
    variants = list(_variants(model, fit, sets, shapes))
    scaled = [_priors(model, fit, sets, variants, root, scale) for scale in SCALES]
    logs = np.stack([own.log_densities([gram])[0] + math.log(p) for own, p in zip(scaled, SCALE_PRIOR, strict=True)])
    each = logsumexp(logs, axis=0) + np.array([variant.log_weight for variant in variants])
    each += _inside(model, fit, sets, variants, scaled[USUAL].posterior([gram]))
    numbers = np.array([variant.number for variant in variants])
    return np.array([logsumexp(each[numbers == number]) for number in range(len(sets))]) - before


def _added(model: DescentLikelihood, fit: CauseFit, causes: Causes) -> tuple[int, ...]:
    """Strengths of the causes that a set adds."""
    more = set(causes) - set(fit.causes)
    return tuple(i for i, c in enumerate(model.coordinates) if c.effect in more and c.kind != "shape")


def _variants(
    model: DescentLikelihood, fit: CauseFit, sets: Sequence[Causes], shapes: _FurtherShapes
) -> Iterator[_Variant]:
    first = len(model.coordinates) + 1
    for number, causes in enumerate(sets):
        strengths = _added(model, fit, causes)
        choices = [shapes.places(strength, first) for strength in strengths]
        weights = [NODE_WEIGHTS if len(places) > 1 else (1.0,) for places in choices]
        for places, shares in zip(itertools.product(*choices), itertools.product(*weights), strict=True):
            yield _Variant(number, math.log(math.prod(shares)), strengths, places)


def _priors(
    model: DescentLikelihood,
    fit: CauseFit,
    sets: Sequence[Causes],
    variants: Sequence[_Variant],
    root: Array,
    scale: float,
) -> SetPriors:
    """Priors with the further causes' slabs at a scale; those of the fit are at their likeliest."""
    factors = np.repeat(root[None], len(variants), axis=0)
    means = np.zeros((len(variants), len(root)))
    k = len(model.coordinates)
    centres = {causes: model.prior(causes).centre - fit.state.linear.centre for causes in set(sets)}
    for row, variant in enumerate(variants):
        means[row, :k] = centres[sets[variant.number]]
        for strength, place in zip(variant.strengths, variant.places, strict=True):
            factors[row, place] = factors[row, :, place] = 0.0
            factors[row, place, place] = scale * model.slab[strength]
    return SetPriors(means, factors)


def _inside(
    model: DescentLikelihood,
    fit: CauseFit,
    sets: Sequence[Causes],
    variants: Sequence[_Variant],
    posterior: tuple[Array, Array],
) -> Array:
    """Log share of each posterior in which the further causes' strengths are possible, over the prior's, shape (v,)."""
    (means,), (roots,) = posterior
    sd = np.linalg.norm(roots, axis=-1)
    priors = {causes: model.prior(causes) for causes in set(sets)}
    found = np.zeros(len(variants))
    for row, variant in enumerate(variants):
        prior = priors[sets[variant.number]]
        for strength, place in zip(variant.strengths, variant.places, strict=True):
            at = fit.state.linear.centre[strength] + means[row, place]
            low, high = ((end[strength] - at) / sd[row, place] for end in prior.bounds)
            found[row] += float(log_normal_mass(low, high) - prior.log_masses[strength])
    return found
