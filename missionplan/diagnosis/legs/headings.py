"""Causes that the headings flown cannot tell from a current: on one heading a slow vehicle meets a contrary current."""

import numpy as np

from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import CATALOGUE
from missionplan.phases.hooks import MarkovProcess
from missionplan.results.learned.evidence import Causes

UNLIKE = 0.04
"""Share of a cause's squared velocity errors, beyond those of a steady current, below which they look the same: legs on
headings uniform within ±20°."""


def inseparable(model: TransitModel, causes: Causes) -> tuple[Causes, ...]:
    """Return the sets that these headings cannot separate from a set, however the evidence falls.

    A cause in the mean whose velocity errors are nearly the same on every leg exchanges with a steady current, which
    a random process that persists can be as well.

    Parameters
    ----------
    model : TransitModel
    causes : tuple of str
        The set claimed.
    """
    alike = _like_a_current(model)
    if not alike:
        return ()
    currents = [name for name in model.candidates if CATALOGUE[name].is_steady_current]
    found: list[Causes] = []
    for index, name in enumerate(causes):
        others = alike if name in currents or _persists(name) else currents if name in alike else []
        found += [(*causes[:index], other, *causes[index + 1 :]) for other in others if other not in causes]
    order = {name: place for place, name in enumerate(model.candidates)}
    return tuple(dict.fromkeys(tuple(sorted(each, key=order.__getitem__)) for each in found))


def _like_a_current(model: TransitModel) -> list[str]:
    """Causes of a single strength whose columns are nearly those of a steady current."""
    columns = model.columns_as_expected
    found = []
    for name, own in model.by_effect.items():
        if len(own) == 1 and not CATALOGUE[name].is_steady_current:
            column = columns[:, :, own[0]]
            left = column - column.mean(axis=1, keepdims=True)
            if np.sum(left**2) < UNLIKE * np.sum(column**2):
                found.append(name)
    return [name for name in found if name in model.candidates]


def _persists(name: str) -> bool:
    info = CATALOGUE[name]
    return info.part == "covariance" and isinstance(info.make({}), MarkovProcess)
