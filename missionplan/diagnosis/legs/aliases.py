"""Effects that do to these legs what a claimed cause does, and would do something else on the way back."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.designs import LATER, TRIAL_LEGS, short_trials
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import CATALOGUE, named_effects
from missionplan.phases.hooks import TransitEffect, velocity_error
from missionplan.results.learned.evidence import Alias

UNTOLD, TOLD = 3.0, 5.0
"""Expected nats below which these legs do not tell two effects apart, and from which legs do."""
STEP = 1e-3
"""Strength at which columns of effects with terms are taken, in its usual sizes."""


def aliases(model: TransitModel, fit: CauseFit) -> tuple[Alias, ...]:
    """Return the aliases of each claimed cause in the mean.

    Another effect is as large as makes it likest to the cause on these legs (weighted least squares). Where what is
    left is worth less than `UNTOLD` nats under the fit's noise, half its squared size over the errors' covariance
    (Kass & Raftery 1995), it is an alias. It matters from the distance at which the two place the vehicle apart by two
    standard deviations of the errors of as many legs, on the same courses sailed the other way, later, at the mission's
    speed and depth. The trial that would part them is the shortest of a few legs more, all round the compass, that
    leaves `TOLD` nats between them.

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set.
    """
    model = model.with_term(fit.state.term)
    here, back = _Legs.of(model, fit), _Legs.of(_on_the_way_back(model), fit)
    trials: list[tuple[str, _Legs]] = []
    found = []
    for claimed in fit.causes:
        own = model.by_effect.get(claimed)
        if own is None:
            continue
        size = fit.state.mean[own]
        for other, columns in here.columns.items():
            if other in fit.causes or other not in back.columns:
                continue
            alike, left = _likest(here.columns[claimed] @ size, columns, here.noise)
            apart = back.columns[claimed] @ size - back.columns[other] @ alike
            distance = _matters_from(back.model, apart, here.noise)
            if left < UNTOLD and distance < np.inf:
                trials = trials or [(words, _Legs.of(model.of_longer(d), fit)) for words, d in short_trials(model.data)]
                told = _cheapest(trials, claimed, other, size) or CATALOGUE[other].distinguished_by
                found.append(Alias(claimed, other, distance, told))
    return tuple(sorted(found, key=lambda alias: alias.matters_from))


@dataclass(frozen=True)
class _Legs:
    """Legs with the columns of all effects, as a fit has them, and the standard deviation of their errors, (2, n)."""

    model: TransitModel
    columns: dict[str, Array]
    noise: Array

    @classmethod
    def of(cls, model: TransitModel, fit: CauseFit) -> "_Legs":
        noise = np.sqrt(np.stack([np.diag(each) for each in model.noise(fit.state.values)]))
        every = model.columns_at(fit)
        own = {name: every[:, :, places] for name, places in model.by_effect.items()}
        return cls(model, own | dict(_of_terms(model, model.water(fit.causes, fit.state.mean))), noise)


def _cheapest(trials: Sequence[tuple[str, _Legs]], claimed: str, other: str, size: Array) -> str:
    """The trial of least time under way after which the legs tell a claimed effect from another, in words, or none."""
    told = []
    for words, legs in trials:
        total = legs.model.data.n
        for count in range(1, TRIAL_LEGS + 1):
            until = total - TRIAL_LEGS + count
            signal = legs.columns[claimed][:, :until] @ size
            if _likest(signal, legs.columns[other][:, :until], legs.noise[:, :until])[1] >= TOLD:
                time = float(legs.model.data.t_start[until - 1] + legs.model.data.under_way[until - 1])
                told.append((time, f"{count} more {'leg' if count == 1 else 'legs'} all round the compass, {words}"))
                break
    return min(told)[1] if told else ""


def _of_terms(model: TransitModel, water: Array) -> Iterator[tuple[str, Array]]:
    """Named effects that act by their terms, with their columns; none that need a moment."""
    for info in named_effects("transit"):
        for term in info.terms:
            if term.searched or info.id in model.by_effect:
                continue
            columns = []
            for name in term.strengths:
                step = STEP * info.parameters[name].scale
                effect = cast(TransitEffect, info.make({name: step}))
                columns.append(model.axes.T @ velocity_error((effect,), model.leg, water) / step)
            together = np.stack(columns, axis=2)
            if np.isfinite(together).all() and together.any():
                yield info.id, together


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
