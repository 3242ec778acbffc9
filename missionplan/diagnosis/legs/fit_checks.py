"""What a fit to a navigation log leaves leg by leg, how it predicts the next leg, and whether its causes hold still."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.diagnosis.inference.discrepancy import differing_causes
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel, leg_by_leg
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import Causes

LEGS_TOGETHER = 32
"""Legs over which position errors are added up for the misfit in words."""
FIRST_PREDICTED = 10
"""Legs seen before the first prediction."""
MAX_PAST_LEGS = 30
"""Legs that a prediction uses: currents keep their phase for some periods only."""
REFITS = 8
"""Times, at most, that the hyperparameters are refitted along the record."""
LEGS_OF_HALF = 10
"""Legs that either half needs."""


def transit_residuals(model: TransitModel, best: CauseFit) -> pd.DataFrame:
    """Return one row a leg: velocity errors, what the mission expects, and the errors left with both models.

    `residual_base` is data less the mission's expectation, `residual_extended` the error of predicting the leg from
    those before it.
    """
    data = model.data
    heading = np.degrees(np.arctan2(*model.leg.along)) % 360.0
    error = data.velocity_error
    ahead = model.axes @ (model.one_step_errors(best) if best.causes else model.y)
    plain = model.axes @ model.y
    return pd.DataFrame(
        {
            "leg": data.labels,
            "t_start_s": data.t_start,
            "duration_s": data.under_way,
            "surface_s": data.surface,
            "x_start_m": data.start[0],
            "y_start_m": data.start[1],
            "heading_deg": heading,
            "error_east_m_s": error[0],
            "error_north_m_s": error[1],
            "expected_east_m_s": model.base[0],
            "expected_north_m_s": model.base[1],
            "residual_base_east_m_s": plain[0],
            "residual_base_north_m_s": plain[1],
            "residual_extended_east_m_s": ahead[0],
            "residual_extended_north_m_s": ahead[1],
        }
    )


def transit_share(model: TransitModel, fit: CauseFit) -> float:
    """Return the share of the squared velocity errors that a set predicts one leg ahead."""
    before = float(np.sum(model.y**2))
    return float(np.clip(1.0 - np.sum(model.one_step_errors(fit) ** 2) / max(before, 1e-30), 0.0, 1.0))


def transit_misfit(model: TransitModel) -> str:
    """Describe how errors add up over many legs, beside independent errors of the mission's size."""
    count = min(LEGS_TOGETHER, model.data.n)
    moved = (model.axes @ model.y) * model.data.under_way
    sums = np.stack([moved[:, k : k + count].sum(axis=1) for k in range(model.data.n - count + 1)])
    measured = math.sqrt(float(np.mean(np.sum(sums**2, axis=1))))
    variance = np.trace(model.covariance) * model.data.under_way**2 + 4.0 * max(model.fix_error, 0.0) ** 2
    expected = math.sqrt(count * float(np.mean(variance)))
    ratio = measured / expected
    words = f"{ratio:.1f} times" if not 0.95 < ratio < 1.05 else "about"
    row = " in a row" if count < model.data.n else ""
    rms = math.sqrt(float(np.mean(np.sum(model.y**2, axis=0))))
    return (
        f"Over {count} legs{row} the errors add up to {words} what the mission expects "
        f"({measured / 1000.0:.2f} km against {expected / 1000.0:.2f} km); a leg errs by {100.0 * rms:.1f} cm/s rms."
    )


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


def not_constant(model: TransitModel, fit: CauseFit) -> Causes:
    """Return the physical causes whose strengths differ between the halves of a log.

    The halves are the first and the second, and even and odd blocks of five legs; a modulated oscillation is compared
    with its modulation in the model.

    Parameters
    ----------
    model : TransitModel
    fit : CauseFit
        The claimed set, fitted to the whole log.
    """
    count, acting = model.data.n, model.with_term(fit.state.term)
    physical = [name for name in fit.causes if CATALOGUE[name].tier == "physical" and name in acting.by_effect]
    if count < 2 * LEGS_OF_HALF:
        return ()
    columns = acting.columns_at(fit)
    own = {name: leg_by_leg(columns[:, :, acting.by_effect[name]]) for name in physical}
    legs = np.arange(count)
    halves = [np.repeat(half, 2).astype(float) for half in (legs >= count // 2, legs // 5 % 2 == 1)]
    return differing_causes(
        partial(acting.residuals_along, fit), own, [np.stack([1.0 - half, half], axis=1) for half in halves]
    )
