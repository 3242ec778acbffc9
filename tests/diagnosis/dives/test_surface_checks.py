"""Dives in which the vehicle stays at the surface are refused in words."""

import numpy as np
import pandas as pd
import pytest

from missionplan import diagnose
from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.dives.model import check_leaves_surface
from missionplan.errors import InputError

RUNS = {f"dive-{k}": {"anchor_wet_weight": f"{8 + 4 * k} N", "line_length": "5 m", "depth": "24 m"} for k in (1, 2, 3)}
KIND = {"kind": "descent", "name": "dives", "noise": {"depth": "0.05 m"}, "runs": RUNS}


def floating(until):
    """Three dives at the surface, with waves."""
    t = np.arange(0.0, until, 0.1)
    waves = 0.1 * np.sin(2.0 * t) + np.random.default_rng(1).normal(0.0, 0.02, t.size)
    return pd.concat([pd.DataFrame({"run": name, "t_s": t, "depth_m": waves}) for name in RUNS])


def test_a_vehicle_that_never_leaves_the_surface(folder, descent_mission):
    with pytest.raises(
        InputError, match=r"dive-1: the vehicle never leaves the surface: .* line of 5 m is taut"
    ) as found:
        diagnose(descent_mission, folder(KIND, floating(20.0)), plan=False)
    assert [problem.line for problem in found.value.problems] == [2, 202, 402]


def test_a_log_that_ends_before_the_line_is_taut(folder, descent_mission):
    with pytest.raises(InputError, match=r"dive-2: the log ends 1.4 s after the separation, before the line is taut"):
        diagnose(descent_mission, folder(KIND, floating(1.5)), plan=False)


def test_the_missions_own_effects_delay_the_taut_line(folder, descent_mission, mission):
    late = mission({**descent_mission.raw, "effects": [{"line-payout": {"delay_per_length": "3 s/m"}}]})
    data = folder(KIND, floating(16.0))
    with pytest.raises(InputError, match="never leaves the surface"):
        check_leaves_surface(read_descent(data, descent_mission), descent_mission)
    with pytest.raises(InputError, match="before the line is taut"):
        check_leaves_surface(read_descent(data, late), late)


def test_a_dive_is_none_of_these(folder, descent_mission):
    t = np.arange(0.0, 12.0, 0.1)
    depth = 1.3 * np.maximum(t - 4.0, 0.0)
    table = pd.concat([pd.DataFrame({"run": name, "t_s": t, "depth_m": depth}) for name in RUNS])
    check_leaves_surface(read_descent(folder(KIND, table), descent_mission), descent_mission)
