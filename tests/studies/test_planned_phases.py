"""What the plan of a vehicle expects of its transits, from the tracks of some trials."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.mission import Mission
from missionplan.montecarlo.distributions import Normal
from missionplan.phases.transit.plan import Execution
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies import planned_phases
from missionplan.studies.export import mission_plan
from missionplan.studies.planned_phases import TransitDurations, _last_drift, _sailed_by_its_vehicle, transit_durations
from missionplan.studies.simulation.simulate import simulate_block
from tests.exporters.made_plans import PLANS

START, NOTHING = [0.0, 0.0], [np.nan, np.nan]


def track(*trials):
    """Points of trials: start, where each leg surfaces and dives again, then nothing."""
    most = max(map(len, trials))
    return np.array([[*each, *[NOTHING] * (most - len(each))] for each in trials]).transpose(2, 1, 0)


def test_the_last_drift_at_the_surface_is_that_after_each_trials_last_leg():
    one_leg = [START, [100.0, 0.0], [101.0, 2.0]]
    two_legs = [START, [90.0, 0.0], [95.0, 9.0], [180.0, 9.0], [183.0, 13.0]]
    assert _last_drift(track(one_leg)) == pytest.approx([1.0, 2.0])
    assert _last_drift(track(two_legs)) == pytest.approx([3.0, 4.0])
    assert _last_drift(track(one_leg, two_legs)) == pytest.approx([2.0, 3.0])


def test_without_a_leg_there_is_no_drift():
    assert _last_drift(None).tolist() == [0.0, 0.0]
    assert _last_drift(track([START])).tolist() == [0.0, 0.0]
    there, far = [START], [START, [100.0, 0.0], [101.0, 2.0]]
    assert _last_drift(track(there, far)) == pytest.approx([1.0, 2.0]), "only trials that have made a leg count"


PATH = {"from": ["0 m", "0 m"], "to": ["1 km", "0 m"], "speed": "1 m/s", "d_max": "300 m", "arrival_radius": "100 m"}


def test_a_transit_is_sailed_in_the_current_of_its_own_time_and_is_not_given_up(tmp_path):
    """0.25 m/s to the east from 10 000 s on, 90 s at the surface; with a time-out of a second none would arrive."""
    (tmp_path / "current.csv").write_text(
        "t_s,depth_m,east_m_s,north_m_s\n0,0,0,0\n9999,0,0,0\n10000,0,0.25,0\n50000,0,0.25,0\n"
    )
    navigation = {"velocity_error": {"sigma": "0.001 m/s"}, "surfacing_time": "90 s"}
    site = {"current": {"file": str(tmp_path / "current.csv"), "outside": "hold"}}
    mission = Mission.from_data({"site": site, "navigation": navigation, "phases": [{"transit": PATH}]})
    means = Scenario.at_means(mission, recorded_current(mission))
    hasty = Execution(
        ends="fix", aim=np.array([1000.0, 0.0]), interval=300.0, fix_wait=600.0, aborts=True, time_out=1.0
    )
    for begins, drift in ((0.0, 0.0), (20_000.0, 22.5)):
        for execution in (None, hasty):
            found = transit_durations(means, means.transit(), np.zeros(2), begins, 1, execution)
            assert found.arrived == 1.0
            assert found.surface_drift == pytest.approx([drift, 0.0], abs=1e-6)


def test_what_follows_a_transit_of_one_leg_begins_after_its_surfacing_in_the_current_of_that_time(tmp_path):
    """300 m out at 1 m/s and 90 s up; 0.25 m/s from then on shorten the way on, as in trials."""
    (tmp_path / "current.csv").write_text(
        "t_s,depth_m,east_m_s,north_m_s\n0,0,0,0\n390,0,0,0\n391,0,0.25,0\n50000,0,0.25,0\n"
    )
    ways = ({"name": "out", "to": ["0 m", "300 m"]}, {"name": "on", "to": ["1 km", "300 m"]})
    path = {key: value for key, value in PATH.items() if key != "from"}
    first, second = ({"transit": {**path, **way}} for way in ways)
    first["transit"]["from"] = ["0 m", "0 m"]
    data = {
        "site": {"current": {"file": str(tmp_path / "current.csv"), "outside": "hold"}},
        "navigation": {"velocity_error": {"sigma": "0.001 m/s"}, "surfacing_time": "90 s"},
        "phases": [first, second],
    }
    mission = Mission.from_data(data)
    out, on = mission_plan(mission).transits
    assert (out.waypoints[-1].elapsed, on.start.elapsed, on.legs[0].elapsed) == pytest.approx((300.0, 390.0, 690.0))
    trials = simulate_block(mission, seed=mission.monte_carlo.seed, block=0, trials=200)
    for planned, sailed in zip((out, on), trials.phases, strict=True):
        assert planned.duration_p99 == pytest.approx(np.quantile(sailed.quantities["duration_s"], 0.99), abs=2.0)
    assert on.duration_p99 < 1000.0 + 3 * 90.0 - 100.0  # still water takes it all


@pytest.mark.parametrize(("ends", "extra"), [("fix", 0), ("count", 2)])
def test_each_leg_has_the_duration_of_its_number_and_as_many_follow_as_most_arrive_with(ends, extra):
    """Shares that arrive with none, one, two, three and four legs more; durations of three legs."""
    shares = (0.5, 0.7, 0.9, 0.8, 0.6)
    ingress = replace(PLANS["west"].transits[0], extra_legs=0)

    def sail(legs):
        return TransitDurations(np.array([1.0, 2.0, 3.0]) + 10.0 * legs, 60.0 + legs, shares[legs], np.zeros(2))

    def executes(transit):
        return SimpleNamespace(ends=ends, legs=transit.extra_legs)

    found = _sailed_by_its_vehicle(ingress, executes, lambda execution: sail(execution.legs))
    assert (found.extra_legs, found.duration_p99) == (extra, 60.0 + extra)
    assert [point.duration_p99 for point in found.waypoints[1:]] == [10.0 * extra + k for k in (1.0, 2.0, 3.0)]
    assert np.isnan(found.start.duration_p99)


def test_the_interval_in_place_of_a_table_is_the_quickest_of_those_that_arrive_often_enough(monkeypatch):
    """Of three the first is quick and arrives too seldom; what the second costs is of trials that both arrive in."""
    yes, no = True, False
    arrived = [[yes, yes, yes, no], [yes, no, no, no], [no, yes, yes, yes], [yes, yes, yes, yes]]
    durations = [
        [100.0, 110.0, 120.0, 9.0],
        [1.0, 1.0, 1.0, 1.0],
        [9.0, 130.0, 150.0, 140.0],
        [150.0, 150.0, 160.0, 150.0],
    ]
    runs = [SimpleNamespace(arrived=np.array(a), duration=np.array(d)) for a, d in zip(arrived, durations, strict=True)]
    swept = SimpleNamespace(d_max=np.array([100.0, 200.0, 300.0]), required_arrival=0.75)
    monkeypatch.setattr(planned_phases.SweepScenario, "of", lambda mission, means: swept)
    monkeypatch.setattr(planned_phases, "run_plans", lambda scenario, plans, *_: runs)
    same = SimpleNamespace(sweep=SimpleNamespace(model_copy=lambda update: update), model_copy=lambda update: update)
    found = planned_phases.single_interval(SimpleNamespace(mission=same), SimpleNamespace(name="out"), None, 1)
    assert found == (200.0, pytest.approx((20.0 + 30.0) / 2.0), pytest.approx(5.0 / np.sqrt(2.0)))


def test_a_planned_mooring_has_the_times_of_its_parts_and_what_most_take():
    """Released after 10 s, held 600 and 1200 s, 300 s until the release; then 80 s at the surface."""
    drawn = {"name": "hold", "label": "Hold", "radius": 20.0, "line_length": 5.0, "anchor_wet_weight": 11.8}
    phase = SimpleNamespace(**drawn, release_time=10.0, times_moored=(600.0, 1200.0, 300.0))
    written = SimpleNamespace(name="hold", release_time=Normal(10.0, 3.0))
    navigation = SimpleNamespace(surfacing_time=Normal(80.0, 10.0))
    mission = SimpleNamespace(moors=(SimpleNamespace(name="other"), written), navigation=True)
    site = SimpleNamespace(depth=12.0)
    means = SimpleNamespace(
        mission=mission, navigation=navigation, drawn=SimpleNamespace(site=site), surfacing_time=80.0
    )
    planner = SimpleNamespace(means=means, _place=np.array([3.0, 4.0]), _elapsed=50.0, _on_earth=lambda _: (1.0, 2.0))
    found = planned_phases.PhaseBuilder._mooring(planner, phase)
    assert (found.elapsed, found.hold, found.galvanic_release, planner._elapsed) == (50.0, 1800.0, 300.0, 2240.0)
    assert (found.east, found.north, found.latitude, found.longitude, found.water_depth) == (3.0, 4.0, 1.0, 2.0, 12.0)
    assert found.release_time_p99 == pytest.approx(10.0 + 3.0 * 2.3263, abs=1e-3)
    assert found.surface_time_p99 == pytest.approx(80.0 + 10.0 * 2.3263, abs=1e-3)
