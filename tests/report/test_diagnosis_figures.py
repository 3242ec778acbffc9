"""What the captions of a diagnosis's main figure say is what it draws."""

from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest

from missionplan.report.diagnosis.kinds import REPORTS

pytestmark = pytest.mark.usefixtures("drawn")

LEGS = {
    **{"t_start_s": [0.0, 900.0], "duration_s": [840.0, 840.0]},
    **{
        f"{what}_{side}_m_s": [0.01, 0.02]
        for what in ("error", "expected", "residual_extended")
        for side in ("east", "north")
    },
}
DIVE = {"run": ["a", "a"], "t_s": [0.0, 1.0], "depth_m": [0.0, 1.0], "base_m": [0.0, 1.1], "extended_m": [0.0, 1.0]}
TANK = {"at_speed": [0.5, 1.0], "force_n": [2.0, 8.0], "base": [2.1, 8.2], "extended": [2.0, 8.0]}
SUMMARY = {
    **{"run": ["a", "b"], "quantity": "terminal_velocity_m_s", "less_simulated": False},
    **{"measured": [1.0, 1.1], "sd": 0.05, "base": [1.0, 1.0], "extended": [1.05, 1.05]},
}


@pytest.mark.parametrize("causes", [(), ("drag-bias",)])
@pytest.mark.parametrize(
    ("kind", "table"), [("transit", LEGS), ("descent", DIVE), ("drag", TANK), ("summary", SUMMARY)]
)
def test_the_main_figure_tells_of_an_extended_model_only_where_it_draws_one(
    kind: str, table: dict[str, Any], causes: tuple[str, ...]
) -> None:
    found: Any = SimpleNamespace(kind=kind, causes=causes, residuals=pd.DataFrame(table))
    figure = REPORTS[kind].data_figure(found)
    assert ("extended" in figure.alt) == bool(causes)
    assert ("extended" in figure.caption or "with the causes" in figure.caption) == bool(causes)
