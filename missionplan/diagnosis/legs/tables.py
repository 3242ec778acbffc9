"""Residuals of a navigation log leg by leg, and the size of the misfit in the planner's terms."""

import math

import numpy as np
import pandas as pd

from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel

LEGS_TOGETHER = 32
"""Legs over which position errors are added up for the misfit in words."""


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
