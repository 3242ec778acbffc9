"""One-step-ahead prediction: how well the next leg's position error is predicted from the legs before it."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel

FIRST_PREDICTED = 10
"""Legs seen before the first prediction."""
MAX_PAST_LEGS = 30
"""Legs that a prediction uses: currents keep their phase for some periods only."""
REFITS = 8
"""Times, at most, that the hyperparameters are refitted along the record."""


@dataclass(frozen=True)
class OneStep:
    """Root mean square of the two-dimensional position error of the next leg [m]."""

    mean_so_far: float
    """With the unweighted mean of the past velocity errors."""
    last_leg: float
    """With the last leg's velocity error."""
    model: float
    """With the fitted set of causes, its hyperparameters refitted along the record, to past legs alone."""


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
    if data.n < 2 * FIRST_PREDICTED:
        return None
    predicted = np.arange(FIRST_PREDICTED, data.n)
    errors = []
    legs_per_refit = max(5, len(predicted) // REFITS)
    current = fit
    for k in predicted.tolist():
        if (k - FIRST_PREDICTED) % legs_per_refit == 0:
            current = model.refitted(current, np.arange(k))
        mean, _ = model.predicted(current, np.arange(max(0, k - MAX_PAST_LEGS), k), np.array([k]))
        errors.append(model.y[:, k] - mean[:, 0])
    velocity = data.velocity_error
    mean_so_far = np.cumsum(velocity, axis=1)[:, predicted - 1] / predicted
    return OneStep(
        _rms(velocity[:, predicted] - mean_so_far, data.under_way[predicted]),
        _rms(velocity[:, predicted] - velocity[:, predicted - 1], data.under_way[predicted]),
        _rms(np.stack(errors, axis=1), data.under_way[predicted]),
    )


def _rms(velocity: Array, duration: Array) -> float:
    return float(np.sqrt(np.mean(np.sum((velocity * duration) ** 2, axis=0))))
