"""Residuals of tank data row by row, and the size of the misfit."""

import numpy as np
import pandas as pd

from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.tank.model import TankModel


def tank_residuals(model: TankModel, best: CauseFit) -> pd.DataFrame:
    """Return one row a datum: where it lies, what was measured, both models' values, and what is left of each [SI]."""
    places = {f"at_{name}": values for name, values in model.forward.axes.items()}
    measured = model.forward.y
    before = model.plain_residuals()
    after = best.state.residuals if best.causes else before
    return pd.DataFrame(
        {
            "group": model.forward.groups,
            **places,
            model.forward.quantity: measured,
            "base": measured - before,
            "extended": measured - after,
            "residual_base": before,
            "residual_extended": after,
        }
    )


def tank_misfit(model: TankModel, table: pd.DataFrame) -> str:
    """Describe the base model's errors beside the sensor's noise."""
    rms = float(np.sqrt(np.mean(table["residual_base"] ** 2)))
    size = float(np.sqrt(np.mean(model.forward.y**2)))
    stated = f", {rms / float(np.median(model.forward.sd)):.1f} times the stated noise" if model.forward.stated else ""
    name, unit = UNITS[model.forward.quantity]
    return f"The base model misses {name} by {rms:.3g} {unit} rms, {100.0 * rms / size:.1f} % of it{stated}."


UNITS = {"force_n": ("the drag", "N"), "displacement_m": ("the displacement", "m"), "thrust_n": ("the thrust", "N")}


def tank_share(table: pd.DataFrame, fit: CauseFit) -> float:
    """Return the share of the base model's squared residuals that goes with a set."""
    before, after = float(np.sum(table["residual_base"] ** 2)), float(np.sum(fit.state.residuals**2))
    return float(np.clip(1.0 - after / max(before, 1e-30), 0.0, 1.0))
