"""Residuals of dive logs reading by reading, and the size of the misfit in the planner's terms."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.inference.model import CauseFit


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


def descent_shares(model: DescentModel, base: CauseFit, fits: Sequence[CauseFit]) -> list[float]:
    """Share of the squared residuals that goes with each set, by one call of the phase."""
    places = np.stack([fit.state.linear.at for fit in (base, *fits)], axis=1)
    left = (model.y[:, None] - model.forward.readings(model.coordinates, places)) / model.units[:, None]
    before, *after = (float(value) for value in np.sum(left**2, axis=0))
    return [float(np.clip(1.0 - value / max(before, 1e-30), 0.0, 1.0)) for value in after]


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
