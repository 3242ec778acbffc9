"""Effects that do to these legs what a claimed cause does, and would do something else on the way back."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import Alias

UNTOLD = 3.0
"""Expected nats below which these legs do not tell two effects apart."""
LATER = 6.0 * 3600.0
"""Time after the record at which the way back is taken [s]: half a tide."""


def aliases(model: TransitModel, fit: CauseFit) -> tuple[Alias, ...]:
    """Return the aliases of each claimed cause in the mean.

    Another effect is as large as makes it likest to the cause on these legs (weighted least squares). Where what is
    left is worth less than `UNTOLD` nats under the fit's noise, half its squared size over the errors' covariance
    (Kass & Raftery 1995), it is an alias. It matters from the distance at which the two place the vehicle apart by two
    standard deviations of the errors of as many legs, on the same legs sailed the other way, later.

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set.
    """
    model = model.with_term(fit.state.term)
    noise = np.sqrt(np.stack([np.diag(each) for each in model.noise(fit.state.values)]))
    here, back = model.columns_at(fit), _on_the_way_back(model).columns_at(fit)
    found = []
    for claimed in fit.causes:
        own = model.by_effect.get(claimed)
        if own is None:
            continue
        size = fit.state.mean[own]
        for other, places in model.by_effect.items():
            if other in fit.causes:
                continue
            alike, left = _likest(here[:, :, own] @ size, here[:, :, places], noise)
            apart = back[:, :, own] @ size - back[:, :, places] @ alike
            if left < UNTOLD and (distance := _matters_from(model, apart, noise)) < np.inf:
                found.append(Alias(claimed, other, distance, CATALOGUE[other].distinguished_by))
    return tuple(sorted(found, key=lambda alias: alias.matters_from))


def _likest(signal: Array, columns: Array, noise: Array) -> tuple[Array, float]:
    """Coefficients with which columns are likest to a signal, and the nats that tell them from it."""
    weighted = (columns / noise[:, :, None]).reshape(-1, columns.shape[2])
    wanted = (signal / noise).ravel()
    alike = np.linalg.lstsq(weighted, wanted, rcond=1e-9)[0]
    return np.asarray(alike), 0.5 * float(np.sum((wanted - weighted @ alike) ** 2))


def _on_the_way_back(model: TransitModel) -> TransitModel:
    """The model of the same legs sailed the other way."""
    data = model.data
    later = LATER + float(np.ptp(data.t_start))
    turned = data.start - (data.dead_reckoned - data.start)
    moved = replace(data, t_start=data.t_start + later, dead_reckoned=turned, end=turned)
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
