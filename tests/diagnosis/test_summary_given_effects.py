"""Missions that carry effects, diagnosed on summaries of dives."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from missionplan import diagnose
from missionplan.datasets.summaries import read_summary
from missionplan.diagnosis.summaries import summary_model
from missionplan.mission import Mission

WEIGHTS = (9.0, 13.0, 18.0, 25.0)
RUNS = {f"dive-{k}": {"anchor_wet_weight": f"{weight} N"} for k, weight in enumerate(WEIGHTS)}


def table(values=(1.0, 9.0), simulated=()):
    """Rows of two quantities a dive, and of the simulated ones where they are given."""
    found = []
    for k in range(len(WEIGHTS)):
        for quantity, value, sd in zip(("terminal_velocity_m_s", "descent_time_s"), values, (0.02, 0.1), strict=True):
            found.append((f"dive-{k}", quantity, np.atleast_1d(value)[k % np.size(value)], sd))
        for quantity, value in zip(("terminal_velocity_m_s", "descent_time_s"), simulated, strict=False):
            found.append((f"dive-{k}", f"simulated_{quantity}", value[k], np.nan))
    return pd.DataFrame(found, columns=["run", "quantity", "value", "sd"])


@pytest.fixture
def measured_summary(folder, descent_mission):
    """Numbers of dives with two fifths more drag, less the simulation's own or not."""

    def write(less_simulated):
        keys = {"kind": "summary", "name": "table", "runs": RUNS}
        model = summary_model(read_summary(folder(keys, table()), descent_mission), descent_mission)
        at = np.stack([model.centre, model.centre], axis=1)
        at[model.index("drag-bias"), 1] = 0.4
        plain, slow = model.forward.readings(model.coordinates, at).T.reshape(2, -1, 2)
        return folder(keys, table(slow.T, plain.T if less_simulated else ()))

    return write


@pytest.mark.parametrize("less_simulated", [pytest.param(False, marks=pytest.mark.slow), True])
@pytest.mark.usefixtures("among_few")
def test_a_summary_diagnosed_again_is_adequate_and_nothing_grows(descent_mission, measured_summary, less_simulated):
    data = measured_summary(less_simulated)
    found = diagnose(descent_mission, data, plan=False)
    assert "drag-bias" in found.causes
    second = diagnose(Mission.from_data(found.extended), data, plan=False)
    assert second.verdict == "adequate"
    assert {estimate.effect for estimate in second.known} == set(found.causes)
    for before, after in zip(found.best.parameters, second.confirmed, strict=True):
        assert after.value == pytest.approx(before.value, abs=before.sd)


def test_the_missions_own_effects_are_expected(descent_mission, mission, measured_summary):
    own = {"drag-bias": {"fraction": {"mean": 0.4, "sd": 0.03}}}
    carrying = mission({**descent_mission.raw, "effects": [own]})
    model = summary_model(read_summary(measured_summary(less_simulated=True), carrying), carrying)
    (fit,) = model.fit_all([((), ())])
    np.testing.assert_allclose(fit.state.linear.y, 0.0, atol=1e-3)
    (without,) = replace(model, given=()).fit_all([((), ())])
    assert fit.log_evidence > without.log_evidence + 5.0
