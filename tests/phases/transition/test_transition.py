"""The transition phase: interchange, invariances, convergence, and trials side by side."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import missionplan
from missionplan.phases import transition_plan as plan
from missionplan.phases import transition_simulation as tr
from missionplan.scenario.phases import manoeuvre, transition_vehicle
from missionplan.scenario.scenario import Scenario

MISSION = Path(__file__).parents[3] / "missions" / "autosub-transition.yaml"


@pytest.fixture(scope="module")
def vehicle():
    means = Scenario.at_means(missionplan.load(MISSION))
    return transition_vehicle(means, means.drawn.transitions[0])


@pytest.fixture(scope="module")
def slow_down():
    means = Scenario.at_means(missionplan.load(MISSION))
    return replace(manoeuvre(means.drawn.transitions[0]), deceleration=0.02, after=110.0)


@given(speed=st.floats(0, 3), mid=st.floats(0.3, 2), steepness=st.floats(0.01, 1))
def test_interchange_is_a_share(speed, mid, steepness):
    share = plan.interchange(speed, mid, steepness)
    assert 0.0 <= share <= 1.0
    assert plan.interchange(mid, mid, steepness) == 0.5
    assert plan.interchange(speed + 0.1, mid, steepness) <= share


def test_steep_interchange_is_a_step():
    np.testing.assert_allclose(plan.interchange(np.array([0.7, 0.8]), 0.75, 0.01), [1.0, 0.0], atol=1e-4)


@given(demand=st.floats(-1, 1))
def test_allocation_shares_out_everything(demand):
    share = plan.allocation(demand, 1.0, 0.17)
    assert share + plan.allocation(-demand, 1.0, 0.17) == pytest.approx(1.0)


def test_survey_flight_is_steady_until_it_slows(vehicle, slow_down):
    """Level trim and integrators fit each other: nothing moves before the deceleration but a little speed."""
    record = tr.simulate_transition(vehicle, replace(slow_down, before=60.0, after=0.0), time_step=0.5, sample=1.0)
    before = record.history.time < 0.0
    assert np.abs(record.history.depth[before]).max() < 0.05
    assert np.ptp(record.history.speed[before]) < 0.01


def test_it_ends_at_hover_with_the_thrust_that_holds_it(vehicle, slow_down):
    record = tr.simulate_transition(vehicle, replace(slow_down, after=200.0), time_step=0.5, sample=1.0)
    history = record.history
    assert abs(history.speed[-1, 0]) < 0.01
    assert abs(history.depth[-1, 0]) < 0.02
    assert vehicle.thrusters[0].thrust_constant * history.revolutions[-1, 0] ** 2 == pytest.approx(105.9, rel=0.01)


def test_halving_the_step_changes_little(vehicle, slow_down):
    coarse, fine = (tr.simulate_transition(vehicle, slow_down, time_step=h) for h in (0.5, 0.25))
    assert coarse.depth_excursion == pytest.approx(fine.depth_excursion, rel=0.02)
    assert coarse.energy_to_hover == pytest.approx(fine.energy_to_hover, rel=0.02)


def test_trials_do_not_know_of_each_other(vehicle, slow_down):
    varied = replace(slow_down, mid_speed=np.array([0.6, 0.75, 1.0]))
    together = tr.simulate_transition(vehicle, varied, time_step=1.0)
    alone = tr.simulate_transition(vehicle, replace(slow_down, mid_speed=0.75), time_step=1.0)
    np.testing.assert_allclose(together.depth_excursion[1], alone.depth_excursion[0], rtol=1e-9)
    np.testing.assert_allclose(together.energy_to_hover[1], alone.energy_to_hover[0], rtol=1e-9)


def test_heavier_ballast_errors_cost_energy(vehicle, slow_down):
    body = replace(vehicle.body, excess_buoyancy=np.array([53.0, 105.9, 212.0]))
    record = tr.simulate_transition(replace(vehicle, body=body), slow_down, time_step=1.0)
    assert np.all(np.diff(record.end_energy) > 0.0)


def test_energy_until_the_end_is_the_end_energy(vehicle, slow_down):
    record = tr.simulate_transition(vehicle, slow_down, time_step=0.5, sample=0.5)
    assert plan.energy_until(record.history, record.end_time) == pytest.approx(record.end_energy)
    assert np.isnan(plan.energy_until(record.history, np.nan)).all()


def test_no_history_after_the_start_by_default(vehicle, slow_down):
    assert tr.simulate_transition(vehicle, replace(slow_down, after=101.0), time_step=1.0).history.time.size == 1


def test_a_vehicle_hovers_once_it_has_stopped_and_stays_at_its_depth():
    """Three at 5 s: one 3 cm off, one still to stop, one in hover; pitch counts from that at survey speed."""
    pitch, depth = np.array([0.3, -0.2, 0.1]), np.array([0.03, 0.01, 0.01])
    run = SimpleNamespace(
        **{"time": 5.0, "stopped": np.array([4.0, 6.0, 4.0]), "start_pitch": 0.1, "energy": np.array([7.0, 8.0, 9.0])},
        **{"hover_time": np.ones(3), "energy_to_hover": np.full(3, 2.0), "pitch_sums": np.ones((3, 3))},
        **{"depth_excursion": np.full(3, 0.02), "pitch_excursion": np.full(3, 0.25)},
        state=np.stack((*np.zeros((3, 3)), pitch, -depth)),
    )
    tr._Run._observe(run, steady=True)
    assert (run.hover_time.tolist(), run.energy_to_hover.tolist()) == ([5.0, 5.0, 1.0], [7.0, 8.0, 2.0])
    assert run.depth_excursion == pytest.approx([0.03, 0.02, 0.02])
    assert run.pitch_excursion == pytest.approx([0.25, 0.3, 0.25])
    assert run.pitch_sums == pytest.approx(1.0 + np.array([np.ones(3), pitch, pitch**2]))


def test_a_record_tells_of_hover_only_where_it_was_reached_and_the_share_beyond_the_models_range():
    run = SimpleNamespace(
        **{"time": 5.0, "hover_time": np.array([3.0, 5.0]), "energy_to_hover": np.array([6.0, 9.0])},
        **{"energy": np.array([10.0, 0.0]), "energy_beyond": np.array([2.0, 0.0])},
        **{"depth_excursion": np.zeros(2), "pitch_excursion": np.zeros(2)},
        pitch_sums=np.array([[2.0, 4.0], [0.4, 0.0], [0.1, 0.36]]),  # of 0.1 and 0.3; of 0.3 and its opposite, twice
        controllers=SimpleNamespace(saturation_speed=np.full(2, np.nan)),
    )
    found = tr._Run.record(run, None)
    np.testing.assert_array_equal(found.hover_time, [3.0, np.nan])
    np.testing.assert_array_equal(found.energy_to_hover, [6.0, np.nan])
    assert found.out_of_range.tolist() == [0.2, 0.0]
    assert found.hover_pitch == pytest.approx([0.1, 0.3])
