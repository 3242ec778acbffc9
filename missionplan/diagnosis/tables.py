"""Residuals row by row, and the size of the misfit in the planner's terms."""

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.model import TransitModel

LEGS_TOGETHER = 32


def transit_residuals(model: TransitModel, base: CauseFit, best: CauseFit) -> pd.DataFrame:
    """One row a leg: velocity errors, what the mission expects, and the errors left with both models.

    `residual_base` is data less mission; `residual_extended` the error of predicting the leg from those before it.
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


def descent_residuals(model: DescentModel, base: CauseFit, best: CauseFit) -> pd.DataFrame:
    """One row a reading: depth, both models' depths, and what is left of each.

    An innovation is the error of predicting a reading from those before it, over its standard deviation.
    """
    places = np.stack([base.state.linear.at, best.state.linear.at], axis=1)
    depths = model.forward.readings(model.coordinates, places)
    logs = model.forward.logs
    return pd.DataFrame(
        {
            "run": np.concatenate([np.full(len(log.t), log.name) for log in logs]),
            "t_s": np.concatenate([log.t for log in logs]),
            "depth_m": model.y,
            "base_m": depths[:, 0],
            "extended_m": depths[:, 1],
            "residual_base_m": model.y - depths[:, 0],
            "residual_extended_m": model.y - depths[:, 1],
            "innovation_base": model.innovations(base),
            "innovation_extended": model.innovations(best),
        }
    )


def transit_share(model: TransitModel, fit: CauseFit) -> float:
    """Share of the squared velocity errors that a set predicts a leg ahead."""
    before = float(np.sum(model.y**2))
    return float(np.clip(1.0 - np.sum(model.one_step_errors(fit) ** 2) / max(before, 1e-30), 0.0, 1.0))


def descent_shares(model: DescentModel, base: CauseFit, fits: Sequence[CauseFit]) -> list[float]:
    """Share of the squared residuals that goes with each set, by one call of the phase."""
    places = np.stack([fit.state.linear.at for fit in (base, *fits)], axis=1)
    left = (model.y[:, None] - model.forward.readings(model.coordinates, places)) / model.units[:, None]
    before, *after = (float(value) for value in np.sum(left**2, axis=0))
    return [float(np.clip(1.0 - value / max(before, 1e-30), 0.0, 1.0)) for value in after]


def transit_misfit(model: TransitModel) -> str:
    """How errors add up over many legs against what independent errors would give."""
    count = min(LEGS_TOGETHER, model.data.n)
    moved = (model.axes @ model.y) * model.data.under_way
    sums = np.stack([moved[:, k : k + count].sum(axis=1) for k in range(model.data.n - count + 1)])
    measured = math.sqrt(float(np.mean(np.sum(sums**2, axis=1))))
    variance = np.trace(model.covariance) * model.data.under_way**2 + 4.0 * max(model.fix_error, 0.0) ** 2
    expected = math.sqrt(count * float(np.mean(variance)))
    ratio = measured / expected
    words = f"{ratio:.1f} times" if not 0.95 < ratio < 1.05 else "about"
    rms = math.sqrt(float(np.mean(np.sum(model.y**2, axis=0))))
    return (
        f"Over {count} legs the errors add up to {words} what the mission expects "
        f"({measured / 1000.0:.2f} km against {expected / 1000.0:.2f} km); a leg errs by {100.0 * rms:.1f} cm/s rms."
    )


def descent_misfit(table: pd.DataFrame) -> str:
    """How late or early the vehicle is at the depth where the logs end, on the whole and at worst."""
    late = []
    for name, run in table.groupby("run", sort=False):
        last = run.tail(max(3, len(run) // 10))
        speed = float(np.polyfit(run["t_s"].tail(len(run) // 2), run["base_m"].tail(len(run) // 2), 1)[0])
        late.append(
            (float((-last["residual_base_m"]).mean()) / max(speed, 0.05), float(last["depth_m"].mean()), str(name))
        )
    mean_late, mean_depth = np.mean([entry[0] for entry in late]), np.mean([entry[1] for entry in late])
    worst = max(late, key=lambda entry: abs(entry[0]))
    word = "late" if mean_late > 0 else "early"
    worst_word = "late" if worst[0] > 0 else "early"
    return (
        f"The vehicle arrives {abs(mean_late):.1f} s {word} at {mean_depth:.0f} m on the mean of the dives; "
        f"the farthest off is {worst[2]}, {abs(worst[0]):.1f} s {worst_word} at {worst[1]:.0f} m."
    )
