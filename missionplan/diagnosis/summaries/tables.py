"""Residuals of summaries number by number, and the size of the misfit in the planner's terms."""

import numpy as np
import pandas as pd

from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.summaries.model import SummaryModel

WORDS = {"terminal_velocity_m_s": ("terminal velocity", "m/s"), "descent_time_s": ("descent time", "s")}
"""Quantities in words, and their units."""


def summary_residuals(model: SummaryModel, base: CauseFit, best: CauseFit) -> pd.DataFrame:
    """Return one row a number: measured, both models', and residuals in standard deviations.

    Where a test has a simulated number too, ``measured`` is less that, and a model's is less the base model's.
    """
    places = np.stack([base.state.linear.at, best.state.linear.at], axis=1)
    found = model.forward.readings(model.coordinates, places)
    tests = model.forward.tests
    return pd.DataFrame(
        {
            "run": np.repeat([test.name for test in tests], [len(test.quantities) for test in tests]),
            "quantity": [quantity for test in tests for quantity in test.quantities],
            "less_simulated": [relative for test in tests for relative in test.relative],
            "measured": model.y,
            "sd": model.units,
            "base": found[:, 0],
            "extended": found[:, 1],
            "residual_base_sd": (model.y - found[:, 0]) / model.units,
            "residual_extended_sd": (model.y - found[:, 1]) / model.units,
        }
    )


def summary_misfit(table: pd.DataFrame) -> str:
    """Describe the number that is farthest from the base model's, in standard deviations."""
    worst = table.iloc[int(np.argmax(np.abs(table["residual_base_sd"].to_numpy())))]
    words, unit = WORDS[worst["quantity"]]
    off = worst["measured"] - worst["base"]
    return (
        f"Of {len(table)} numbers of {table['run'].nunique()} tests the farthest from the simulation is the {words} of "
        f"{worst['run']}, {abs(off):.2f} {unit} {'above' if off > 0.0 else 'below'} it, "
        f"{abs(worst['residual_base_sd']):.1f} standard deviations."
    )
