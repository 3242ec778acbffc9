"""Missions that carry effects, diagnosed on summaries of dives."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from missionplan import diagnose
from missionplan.datasets.summaries import read_summary
from missionplan.diagnosis.summaries import SummaryKind, summary_model
from missionplan.mission import Mission
from missionplan.phases.hooks import DescentEffect

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


def test_the_farthest_number_is_told_with_its_side_and_its_deviations():
    rows = {"run": ["a", "a", "b"], "quantity": ["terminal_velocity_m_s", "descent_time_s", "descent_time_s"],
            "measured": [1.0, 9.0, 8.5], "base": [1.02, 8.8, 9.0], "residual_base_sd": [-1.0, 2.0, -5.0]}  # fmt: skip
    assert SummaryKind.misfit(None, pd.DataFrame(rows)) == (
        "Of 3 numbers of 2 tests the farthest from the simulation is the descent time of b, 0.50 s below it, 5.0 standard "
        "deviations."
    )


def test_numbers_lie_in_their_table_beside_both_models_in_deviations():
    tests = [SimpleNamespace(name="a", quantities=("terminal_velocity_m_s", "descent_time_s"), relative=(False, True)),
             SimpleNamespace(name="b", quantities=("descent_time_s",), relative=(False,))]  # fmt: skip
    values = {0.0: [1.0, 9.0, 8.0], 7.0: [1.1, 9.5, 7.0]}
    forward = SimpleNamespace(tests=tests, readings=lambda _, at: np.stack([values[each] for each in at[0]], axis=1))
    model = SimpleNamespace(
        forward=forward, coordinates=(), y=np.array([1.2, 9.3, 8.2]), units=np.array([0.1, 0.5, 0.2])
    )
    base, best = (SimpleNamespace(state=SimpleNamespace(linear=SimpleNamespace(at=np.array([at])))) for at in values)
    found = SummaryKind.residual_table(SimpleNamespace(model=model), base, best)
    assert found["run"].tolist() == ["a", "a", "b"]
    assert found["less_simulated"].tolist() == [False, True, False]
    assert found["residual_base_sd"].tolist() == pytest.approx([2.0, 0.6, 1.0])
    assert found["residual_extended_sd"].tolist() == pytest.approx([1.0, -0.4, 6.0])


class Downward(DescentEffect):
    """Water that goes down at 0.2 m/s."""

    def water_velocity(self):
        return 0.2


def test_below_a_hundred_metres_dives_go_on_at_their_speed_over_ground(folder, descent_mission):
    """Of two alike 150 m apart, in still water and in water that goes down."""
    runs = {
        f"dive-{k}": {"anchor_wet_weight": "13 N", "depth": f"{depth} m"}
        for k, depth in enumerate((100, 250, 100, 250))
    }
    data = read_summary(folder({"kind": "summary", "name": "table", "runs": runs}, table((1.0, 90.0))), descent_mission)
    forward = summary_model(data, descent_mission).forward
    for effects, sinking in (((), 0.0), ((Downward(),), 0.2)):
        numbers = replace(forward, given=effects).readings((), np.zeros((0, 1)))[:, 0]
        velocity, shallow, _, deep = numbers[:4]
        assert deep - shallow == pytest.approx(150.0 / (velocity + sinking), rel=1e-6)
