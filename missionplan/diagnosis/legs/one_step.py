"""One step ahead: how well the next leg's position error is predicted from the legs before it."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel

FIRST = 10
"""Legs seen before the first prediction."""
MEMORY = 30
"""Legs before the one asked for that a prediction uses: currents keep their phase for some periods only."""
REFITS = 8


@dataclass(frozen=True)
class OneStep:
    """Root mean square of the two-dimensional position error of the next leg [m].

    Attributes
    ----------
    mean_so_far : float
        With the unweighted mean of the past velocity errors.
    last_leg : float
        With the last leg's velocity error.
    model : float
        With the fitted set, its hyperparameters refitted on the way to the past alone.
    """

    mean_so_far: float
    last_leg: float
    model: float


def one_step(model: TransitModel, fit: CauseFit) -> OneStep | None:
    """Predict every leg from the eleventh on; None for a record that is too short.

    Parameters
    ----------
    model : TransitModel
        With its data.
    fit : CauseFit
        The set of causes.
    """
    data = model.data
    if data.n < 2 * FIRST:
        return None
    asked = np.arange(FIRST, data.n)
    errors = []
    every = max(5, len(asked) // REFITS)
    current = fit
    for k in asked.tolist():
        if (k - FIRST) % every == 0:
            current = model.fit(fit.causes, (current,), np.arange(k), integrate=False)
            predictor = model.predictor(current)
        mean, _ = predictor(np.arange(max(0, k - MEMORY), k), np.array([k]))
        errors.append(model.y[:, k] - mean[:, 0])
    velocity = data.velocity_error
    mean_so_far = np.cumsum(velocity, axis=1)[:, asked - 1] / asked
    return OneStep(
        _rms(velocity[:, asked] - mean_so_far, data.under_way[asked]),
        _rms(velocity[:, asked] - velocity[:, asked - 1], data.under_way[asked]),
        _rms(np.stack(errors, axis=1), data.under_way[asked]),
    )


def _rms(velocity: Array, duration: Array) -> float:
    return float(np.sqrt(np.mean(np.sum((velocity * duration) ** 2, axis=0))))
