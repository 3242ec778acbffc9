"""Effects that do to these legs what a claimed cause does, and would do something else on the way back."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import CATALOGUE, named_effects
from missionplan.phases.hooks import TransitEffect, velocity_error
from missionplan.results.learned.evidence import Alias

UNTOLD = 3.0
"""Expected nats below which these legs do not tell two effects apart."""
LATER = 6.0 * 3600.0
"""Time after the record at which the way back is taken [s]: half a tide."""
STEP = 1e-3
"""Strength at which columns of effects with terms are taken, in its usual sizes."""


def aliases(model: TransitModel, fit: CauseFit) -> tuple[Alias, ...]:
    """Return the aliases of each claimed cause in the mean.

    Another effect is as large as makes it likest to the cause on these legs (weighted least squares). Where what is
    left is worth less than `UNTOLD` nats under the fit's noise, half its squared size over the errors' covariance
    (Kass & Raftery 1995), it is an alias. It matters from the distance at which the two place the vehicle apart by two
    standard deviations of the errors of as many legs, on the same courses sailed the other way, later, at the mission's
    speed and depth.

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set.
    """
    model = model.with_term(fit.state.term)
    ahead = _on_the_way_back(model)
    noise = np.sqrt(np.stack([np.diag(each) for each in model.noise(fit.state.values)]))
    here, back = model.columns_at(fit), ahead.columns_at(fit)
    others = [(name, here[:, :, own], back[:, :, own]) for name, own in model.by_effect.items()]
    others += _of_terms(model, ahead, model.water(fit.causes, fit.state.mean))
    found = []
    for claimed in fit.causes:
        own = model.by_effect.get(claimed)
        if own is None:
            continue
        size = fit.state.mean[own]
        for other, columns, later in others:
            if other in fit.causes:
                continue
            alike, left = _likest(here[:, :, own] @ size, columns, noise)
            apart = back[:, :, own] @ size - later @ alike
            if left < UNTOLD and (distance := _matters_from(ahead, apart, noise)) < np.inf:
                found.append(Alias(claimed, other, distance, CATALOGUE[other].distinguished_by))
    return tuple(sorted(found, key=lambda alias: alias.matters_from))


def _of_terms(here: TransitModel, back: TransitModel, water: Array) -> Iterator[tuple[str, Array, Array]]:
    """Named effects that act by their terms, with their columns here and on the way back; none that need a moment."""
    for info in named_effects("transit"):
        for term in info.terms:
            if term.searched or info.id in here.by_effect:
                continue
            made = [(STEP * info.parameters[name].scale, name) for name in term.strengths]
            effects = [(step, cast(TransitEffect, info.make({name: step}))) for step, name in made]
            columns = [
                np.stack(
                    [model.axes.T @ velocity_error((effect,), model.leg, water) / step for step, effect in effects],
                    axis=2,
                )
                for model in (here, back)
            ]
            if all(np.isfinite(each).all() and each.any() for each in columns):
                yield info.id, columns[0], columns[1]


def _likest(signal: Array, columns: Array, noise: Array) -> tuple[Array, float]:
    """Coefficients with which columns are likest to a signal, and the nats that tell them from it."""
    weighted = (columns / noise[:, :, None]).reshape(-1, columns.shape[2])
    wanted = (signal / noise).ravel()
    alike = np.linalg.lstsq(weighted, wanted, rcond=1e-9)[0]
    return np.asarray(alike), 0.5 * float(np.sum((wanted - weighted @ alike) ** 2))


def _on_the_way_back(model: TransitModel) -> TransitModel:
    """The model of the same courses sailed the other way, at the mission's speed and depth."""
    data, depth, path = model.data, model.data.depth, model.data.dead_reckoned - model.data.start
    if model.planned is not None:
        path = model.leg.along * model.planned[0] * data.under_way
        depth = None if depth is None else np.full(data.n, model.planned[1])
    later = LATER + float(np.ptp(data.t_start))
    turned = data.start - path
    moved = replace(data, t_start=data.t_start + later, dead_reckoned=turned, end=turned, depth=depth)
    return replace(model, data=moved, only=model.with_term(None).coordinates)


def _matters_from(model: TransitModel, apart: Array, noise: Array) -> float:
    """Distance from which velocity errors apart displace the vehicle by two standard deviations of n legs' errors [m].

    The displacement grows as n, the errors as √n.
    """
    under_way = model.data.under_way
    each = float(np.sqrt(np.mean(np.sum((apart * under_way) ** 2, axis=0))))
    spread = float(np.sqrt(np.mean(np.sum((noise * under_way) ** 2, axis=0))))
    length = float(np.mean(model.leg.speed * under_way))
    return length * max((2.0 * spread / each) ** 2, 1.0) if each > 1e-3 * spread else np.inf
