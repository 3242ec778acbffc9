"""Trials that meet a limit of the world fail with its reason, and what did not happen is missing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from simulate_missions import chesapeake

from missionplan.phases.hooks import TrialState
from missionplan.phases.place import Cause, Place
from missionplan.phases.zones import Fence, Zone
from missionplan.report.simulation.page import answer
from missionplan.studies.simulation import mooring_trials, phase_trials
from missionplan.studies.simulation.phase_trials import _leg_inputs, _profile
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")


def lost(found):
    return {step.step: step.lost.value for step in found.attrition if step.lost.value}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"phases.1.moor.line_length": {"choices": ["5 m", "11.5 m"]}},
            "moor: line and vehicle longer than the water is deep",
        ),
        ({"phases.0.transit.depth": {"choices": ["2 m", "13 m"]}}, "ingress: aground"),
        (
            {
                "phases.1.moor.anchor_wet_weight": {"choices": ["11.8 N", "0.5 N"]},
                "vehicle.anchor.flooded_mass": "2.5 kg",
            },
            "moor: anchor too light to sink the vehicle",
        ),
    ],
)
def test_half_of_the_trials_meet_a_limit(tmp_path, changes, reason):
    found = simulate(chesapeake(tmp_path, changes), trials=400, sheet=False)
    assert lost(found)[reason] == pytest.approx(0.5, abs=0.1)
    good = round(400 * (1.0 - sum(lost(found).values())))
    assert found.phases[1].quantities["descent_time_s"].count == good
    assert found.phases[1].quantities["terminal_velocity_m_s"].count == good
    assert "works" not in answer(found) or "% of the time" in answer(found)


def test_a_current_faster_than_the_vehicle_is_a_reason_and_its_share_is_said(tmp_path):
    layers = [
        {"down_to": "20 ft", "speed": {"choices": ["0.2 m/s", "1.8 m/s"]}, "toward": "0 deg"},
        {"down_to": "40 ft", "speed": "0.1 m/s", "toward": "0 deg"},
    ]
    found = simulate(chesapeake(tmp_path, {"site.current": layers}), trials=400, sheet=False)
    share = found.limits["current_faster"].value
    assert share == pytest.approx(0.5, abs=0.1)
    assert lost(found)["ingress: current faster than the vehicle"] == pytest.approx(share)
    assert "of the trials the current is faster than the vehicle" in answer(found)


def test_a_transit_is_deep_from_each_dive_to_where_the_leg_ends_and_no_longer():
    """Two trials of depths of their own: legs from 0 to 200 and 230 to 500 s, and one leg alone; 30 s afloat after each."""
    nan = np.nan
    time = np.array([[0.0, 10.0], [200.0, 90.0], [230.0, 120.0], [500.0, nan], [530.0, nan]])
    when, depth = _profile(SimpleNamespace(depth=np.array([5.0, 7.0]), surfacing_time=30.0), time)
    for moment, one, other in ((100.0, 5.0, nan), (50.0, 5.0, 7.0), (199.0, 5.0, nan), (215.0, 0.0, nan), (499.0, 5.0, nan),
                               (520.0, 0.0, nan), (105.0, 5.0, 0.0)):  # fmt: skip
        found = [np.interp(moment, when[:, k], depth[:, k], right=nan) for k in (0, 1)]
        assert found[0] == one
        if not np.isnan(other):
            assert np.interp(moment, when[:6, 1], depth[:6, 1]) == other
    assert (when[[0, -1], 0].tolist(), depth[[0, -1], 0].tolist()) == ([0.0, 530.0], [0.0, 0.0])
    assert np.isnan(depth[6:, 1]).all()


def test_a_moorings_depths_track_and_wear_by_hand():
    """10 s to the separation, 20 down, 870 held 6 m above 30 m, 15 up and 90 afloat; another is never up, a third began none."""
    nan, flags = np.nan, np.array
    before = SimpleNamespace(clock=flags([100.0, 200.0, 0.0]), alive=flags([True, True, False]), trials=3)
    after = SimpleNamespace(alive=flags([True, False, False]), position=np.full((2, 3), 9.0))
    descent = SimpleNamespace(release_time=flags([10.0, 12.0, 0.0]), descent_time=flags([20.0, 25.0, 0.0]),
                              touched_down=flags([True, True, False]))  # fmt: skip
    record = SimpleNamespace(descent=descent, duration=flags([1005.0, nan, nan]), ascent_time=flags([15.0, nan, nan]),
                             hold=SimpleNamespace(nose_altitude=6.0), surfaced=flags([True, False, False]),
                             anchor=np.full((2, 3), 3.0), surfaced_at=np.full((2, 3), 4.0))  # fmt: skip
    plan = SimpleNamespace(surfacing_time=90.0, moored_time=600.0, dive=SimpleNamespace(site_depth=30.0))
    moored = flags([True, True, False])
    when, depth = mooring_trials._profile(plan, before, moored, after, record)
    assert when[:, 0] == pytest.approx([100.0, 110.0, 130.0, 1000.0, 1015.0, 1105.0])
    assert depth[:, 0] == pytest.approx([0.0, 0.0, 24.0, 24.0, 0.0, 0.0])
    assert when[:, 1] == pytest.approx([200.0, 212.0, 237.0, nan, nan, nan], nan_ok=True)
    track, track_time = mooring_trials._track(plan, before, after, record, 2)
    assert track_time[:, 0] == pytest.approx([130.0, 1015.0, 1105.0])
    assert track[:, 0, 0].tolist() == [3.0, 4.0, 9.0]
    assert np.isnan(track[:, :, 1]).all()
    worn = mooring_trials._exposure(plan, before.alive, record)
    assert [each.tolist() for each in (worn.time, worn.surfacings, worn.wake_ups)] == [
        [1005.0, 637.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
    ]
    assert (worn.dives.tolist(), worn.releases.tolist(), worn.distance) == ([1.0, 1.0, 0.0], [1.0, 1.0, 0.0], 0.0)
    asked = []
    current = SimpleNamespace(covers=lambda span: asked.append(span) or np.ones(3, dtype=bool))
    before.position = np.zeros((2, 3))
    assert mooring_trials._is_covered(plan, current, before, after, record).all()
    down, up = asked
    assert [(each.start[0], each.end[0], each.depth) for each in asked] == [
        (100.0, 130.0, 30.0),
        (1000.0, 1105.0, 30.0),
    ]
    assert [place[0, 0] for place in (*down.places, *up.places)] == [0.0, 3.0, 3.0, 4.0, 9.0]


def test_an_anchor_lands_where_the_current_at_the_surface_and_then_half_way_down_carry_it(monkeypatch):
    """Released after 10 s, 20 m at 2 m/s: 10 s of 0.5 m/s eastward, and 10 s of the flow then at 10 m, 0.3 m/s north."""
    monkeypatch.setattr(mooring_trials, "_depth", lambda *_: np.array([20.0]))
    monkeypatch.setattr(mooring_trials, "dive_of", lambda *_: None)
    monkeypatch.setattr(mooring_trials, "sinking_speed", lambda *_: 2.0)
    flows = {(100.0, 0.0): [0.5, 0.0], (110.0, 10.0): [0.0, 0.3]}

    def at(clock, depth, position):
        return np.array(flows[float(clock[0]), float(np.ravel(depth)[0])])[:, None]

    current = SimpleNamespace(velocity=at, mean_velocity=lambda clock, lasting, depth, position, _: at(clock, depth, 0))
    state = TrialState(np.array([[7.0], [9.0]]), np.zeros((2, 1)), np.array([100.0]), np.zeros(1), np.ones(1, bool))
    scenario, phase = SimpleNamespace(current=current, place=Place(), means=None), SimpleNamespace(release_time=10.0)
    found = mooring_trials._foreseen(scenario, phase, state)
    assert found[:, 0] == pytest.approx([7.0 + 5.0, 9.0 + 3.0])


@pytest.mark.parametrize(("until", "cause"), [(905.0, Cause.KEEP_OUT), (895.0, Cause.NONE)])
def test_a_vehicle_drifts_into_zones_while_it_is_at_the_surface_after_the_ascent(until, cause):
    """It surfaces in the zone at 900 s, and its fix is at 1000 s."""
    box = pytest.importorskip("shapely").box
    place = Place(None, Fence((Zone(box(-5.0, -5.0, 5.0, 5.0), "range", is_land=False, until=until, since=850.0),)))
    state = TrialState(np.full((2, 1), 500.0), np.zeros((2, 1)), np.zeros(1), np.zeros(1), np.ones(1, bool))
    after = replace(state, position=np.array([[100.0], [0.0]]), clock=np.array([1000.0]))
    plan = SimpleNamespace(surfacing_time=100.0, dive=SimpleNamespace(site_depth=np.array([20.0])))
    descent = SimpleNamespace(touched_down=np.ones(1, bool), release_time=np.zeros(1))
    record = SimpleNamespace(
        descent=descent, anchor=state.position, surfaced=np.ones(1, bool), surfaced_at=np.zeros((2, 1))
    )
    assert mooring_trials.met_at_mooring(place, plan, state, after, record).cause.tolist() == [cause]


def test_errors_of_legs_are_along_the_course_and_to_port(monkeypatch):
    """Going north, 3 m/s east is to starboard; over two legs a mean, and of fixes the last leg's."""
    monkeypatch.setattr(phase_trials, "random_part", lambda size, normals: size * normals)
    velocity = SimpleNamespace(leg=lambda number: np.array([[3.0, 3.0], [4.0, 4.0]]) * (1.0 - number))
    fixes = SimpleNamespace(leg=lambda number: np.array([[1.0, 1.0], [2.0, 2.0]]) * (1.0 + number))
    plan = SimpleNamespace(velocity_error=10.0, fix_error=5.0)
    state = TrialState(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros(2), np.zeros(2), np.ones(2, bool))
    normals, record = (
        SimpleNamespace(velocity=velocity, fix_on_diving=fixes),
        SimpleNamespace(surfacings=np.array([1, 2])),
    )
    found = _leg_inputs(plan, normals, state, record, np.array([[0.0], [100.0]]))
    assert {name: values.tolist() for name, values in found.items()} == {
        "velocity_error.along": [40.0, 20.0],
        "velocity_error.across": [-30.0, -15.0],
        "fix_error.along": [10.0, 20.0],
        "fix_error.across": [-5.0, -10.0],
    }
