"""Designs of trials against the missions that make them; what they cost and lose, against plain simulations."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import missionplan
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.next_trial import designs as losing
from missionplan.diagnosis.next_trial.designs import COSTING_TRIALS, Alternatives, cost_of
from missionplan.diagnosis.next_trial.dive_trials import DiveTrials, _counted, _deepened
from missionplan.diagnosis.next_trial.leg_trials import SHAPES, SHARES, LegTrials
from missionplan.mission import Mission
from missionplan.results.decision import FAILURE_LOSS

MISSIONS = Path(__file__).parents[2] / "missions"
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def metres(text):
    return float(text.split()[0])


@pytest.fixture
def offered(folder, mission, legs):
    """Trials of a mission whose first transit goes to the south-west, after legs at 15 m."""

    def make(d_max="1 km", speed="1.2 m/s", depth="15 m"):
        transit = {
            "name": "out",
            "from": ["100 m", "200 m"],
            "to": ["-2900 m", "-3800 m"],
            "speed": speed,
            "depth": depth,
            "d_max": d_max,
            "arrival_radius": "60 m",
        }
        second = {key: value for key, value in transit.items() if key != "from"} | {
            "name": "back",
            "to": ["0 m", "0 m"],
        }
        navigation = {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s", "fix_error": "3 m"}
        made = mission({"name": "made", "navigation": navigation, "phases": [{"transit": transit}, {"transit": second}],
                        "requirements": [{"quantity": "out.arrived", "probability": 0.5}]})  # fmt: skip
        data = read_transit(folder(KIND, legs().assign(depth_m=15.0, surface_s=40.0)), made)
        return LegTrials(SimpleNamespace(mission=made, data=data))

    return make


def test_a_trial_is_planned_as_its_mission_sails_it(offered):
    trials = offered()
    data, begin, speed = trials.bound.data, np.array([100.0, 200.0]), 1.2
    for number, name in enumerate(trials.designs):
        sailed, planned = trials.trial(number), trials._planned(trials._legs[number])
        phases = [phase["transit"] for phase in sailed["phases"]]
        ends = np.array([[metres(each) for each in phase["to"]] for phase in phases]).T
        assert planned.dead_reckoned == pytest.approx(ends, abs=0.06), name
        assert planned.start == pytest.approx(np.column_stack([begin, ends[:, :-1]]), abs=0.06)
        assert np.array([metres(each) for each in phases[0]["from"]]) == pytest.approx(begin)
        assert not any("from" in phase for phase in phases[1:])
        lengths = np.hypot(*(planned.dead_reckoned - planned.start))
        for phase, length, lasting, depth in zip(phases, lengths, planned.under_way, planned.depth, strict=True):
            own = metres(phase["speed"])
            assert own in (speed, pytest.approx(0.7 * speed))
            assert lasting == pytest.approx(length / own)
            assert metres(phase["depth"]) in (15.0, 10.5)
            assert depth == pytest.approx(metres(phase["depth"]))
            assert metres(phase["d_max"]) == pytest.approx(1.2 * length, abs=0.06)
            assert metres(phase["arrival_radius"]) == pytest.approx(0.5 * length, abs=0.06)
        later = planned.t_start[1:] - planned.t_start[:-1]
        assert later == pytest.approx(planned.under_way[:-1] + 40.0 + 90.0), "one leg after the other"
        assert planned.t_start[0] == pytest.approx(data.t_start[-1] + data.under_way[-1] + 86_400.0)
        assert (planned.surface == 40.0).all()
        assert sailed["name"] == f"Trial: {name}"
        assert "requirements" not in sailed
        if not name.startswith("one long leg"):
            assert planned.dead_reckoned[:, -1] == pytest.approx(begin, abs=1e-6), "each ends where it begins"
        course = math.atan2(-3000.0, -4000.0)  # of the mission's own way
        first = planned.dead_reckoned[:, 0] - begin
        assert math.remainder(math.atan2(*first) - course, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
        halves = [name.endswith(f"half of it at {words}") for words in ("0.84 m/s", "10 m depth")]
        slower, higher = (np.array([metres(phase[key]) for phase in phases]) for key in ("speed", "depth"))
        for half, values in zip(halves, (slower, higher), strict=True):
            count = len(values) // 2 if half else len(values)
            assert (values[:count] == values[0]).all()
            assert not half or (values[count:] == pytest.approx(0.7 * values[0]))


@pytest.mark.parametrize(
    ("d_max", "lengths"),
    [
        ("1 km", [360.0, 500.0, 1000.0, 2000.0]),  # ten minutes are no shorter than half of d_max
        ("3 km", [360.0, 720.0, 1500.0, 3000.0, 6000.0]),
        ("9 km", [360.0, 720.0, 2500.0, 5000.0, 10_000.0]),  # no more than there is to go
        ({"table": [["0 m", "300 m"], ["9 km", "2 km"]]}, [360.0, 625.0, 1250.0, 2500.0]),
    ],
)
def test_lengths_of_legs_are_about_d_max_and_shorter_ones_by_their_time(offered, d_max, lengths):
    trials = offered(d_max)
    assert trials._lengths == pytest.approx(lengths)
    for shape, headings in SHAPES.items():
        found = sorted({len(legs.courses) for legs in trials._legs if legs.name.startswith(shape)})
        most = found[-1] // len(headings)
        assert found == [len(headings), most * len(headings)]
        assert most >= 2
        assert most * len(headings) >= 8 > (most - 1) * len(headings) or most == 2
    (long,) = (legs for legs in trials._legs if legs.name.startswith("one long leg"))
    assert (long.length, len(long.courses)) == (pytest.approx(4.0 * lengths[-2]), 1)


def test_half_of_a_trial_is_no_shallower_where_that_is_no_other_depth(offered):
    assert [key for key, _ in offered(depth="15 m")._others] == ["speed", "depth"]
    assert [key for key, _ in offered(depth="6.6 m")._others] == ["speed"]
    assert [key for key, _ in offered(depth="6.8 m")._others] == ["speed", "depth"]


def test_what_may_be_chosen_is_a_length_of_all_transits(offered):
    trials = offered()
    found = trials.alternatives()
    assert (found.key, found.values.tolist()) == ("d_max_m", pytest.approx((5000.0 * SHARES).tolist()))
    changed = found.change(trials.bound.mission, 777.0)
    assert [transit.d_max for transit in changed.transits] == [777.0, 777.0]
    assert [transit.d_max for transit in trials.bound.mission.transits] == [1000.0, 1000.0]


SHORT = {
    "name": "short",
    "navigation": {"velocity_error": {"sigma": "0.05 m/s"}, "surfacing_time": {"low": "20 s", "high": "200 s"}, "fix_error": "3 m", "max_legs": 4},
    "phases": [{"transit": {"name": "out", "from": ["0 m", "0 m"], "to": ["900 m", "0 m"], "speed": "1 m/s", "d_max": "400 m", "arrival_radius": "30 m"}}],
}  # fmt: skip


@pytest.mark.parametrize("vehicle", [False, True])
def test_a_trial_costs_what_a_simulation_of_it_takes_on_the_same_draws(vehicle):
    data = missionplan.load(MISSIONS / "chesapeake.yaml").raw if vehicle else SHORT
    cost = cost_of(data, 5)
    alone = missionplan.simulate(Mission.from_data(data), trials=COSTING_TRIALS, seed=5, sheet=False).total.quantities
    assert cost.minutes == pytest.approx(alone["duration_s"].mean / 60.0, rel=1e-12)
    if vehicle:
        assert cost.energy_wh == pytest.approx(alone["energy_wh"].mean, rel=1e-12)
    else:
        assert cost.energy_wh is None
    far = [{"transit": {**SHORT["phases"][0]["transit"], "arrival_radius": "1 mm"}}]
    assert cost_of({**SHORT, "phases": far}, 5) is None  # it never ends


def test_each_alternative_is_simulated_on_the_same_draws():
    mission = Mission.from_data(SHORT)
    change = lambda own, value: own.with_({"out.d_max": f"{value} m"})  # noqa: E731
    each = SimpleNamespace(coordinates=(), mission=mission)
    found = losing._trials(
        each, np.empty((300, 0)), Alternatives("d_max_m", np.array([300.0, 450.0]), change), 9, np.random.default_rng(1)
    )
    for number, value in enumerate((300.0, 450.0)):
        alone = missionplan.simulate(change(mission, value), trials=300, seed=9, sheet=False).total
        duration, success = found[1][:, number], found[2][:, number]
        assert np.nanmean(duration) == pytest.approx(alone.quantities["duration_s"].mean, rel=1e-12)
        assert success.mean() == alone.events["success"].value


@pytest.mark.parametrize("has_energy", [True, False])
def test_a_failure_costs_ten_missions_besides(monkeypatch, has_energy):
    """Two sets of causes with two draws each, of two alternatives; what a failed mission took is not known."""
    nan = math.nan
    energy = [np.array([[20.0, 30.0], [nan, 32.0]]), np.array([[24.0, nan], [22.0, 31.0]])]
    minutes = [3.0 * each for each in energy]
    success = [np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 0.0]])]
    runs = iter([(e if has_energy else nan * e, 60.0 * m, s) for e, m, s in zip(energy, minutes, success, strict=True)])
    monkeypatch.setattr(losing, "_trials", lambda *args: next(runs))
    weight = np.array([0.1, 0.2, 0.3, 0.4])
    draws = SimpleNamespace(parameters=[np.zeros((2, 0))] * 2, weight=weight)
    found = losing.losses(
        [None, None], draws, Alternatives("d_max_m", np.array([1.0, 2.0]), None), 1, np.random.default_rng(1)
    )
    cost = np.concatenate(energy if has_energy else minutes)
    worked = np.concatenate(success)
    usual = cost[(worked > 0.0) & np.isfinite(cost)].mean()
    assert (found.unit, found.failure) == ("W h" if has_energy else "min", pytest.approx(FAILURE_LOSS * usual))
    expected = np.where(np.isfinite(cost), cost, usual) + 10.0 * usual * (1.0 - worked)
    assert found.problem.losses == pytest.approx(expected)
    assert found.success == pytest.approx(weight @ worked)


def test_dives_cost_one_dive_so_many_times_and_the_depth_of_the_lowest_layer_goes_along(measured, descent_mission):
    trials = DiveTrials(SimpleNamespace(mission=descent_mission, model=measured()))
    two = next(number for number, name in enumerate(trials.designs) if name.startswith("two dives"))
    four = list(trials.designs).index(trials.designs[two].replace("two", "four"))
    plan = trials._plans[two]
    one = cost_of(trials._mission(replace(plan, dives=plan.dives[:1])), 3)
    assert [trials.cost(number, 3).minutes for number in (two, four)] == [2.0 * one.minutes, 4.0 * one.minutes]
    for number, name in enumerate(trials.designs):
        dives, made = trials._plans[number].dives, trials.trial(number)
        assert len(dives) == {"two": 2, "four": 4}[name.split()[0]]
        for phase, dive in zip((phase["moor"] for phase in made["phases"]), dives, strict=True):
            written = metres(phase["anchor_wet_weight"]), metres(phase["line_length"])
            assert written == pytest.approx((dive.wet_weight, dive.line_length), rel=1e-3)
            assert phase["hold"] == "0 s"
        assert metres(made["site"]["depth"]) == pytest.approx(dives[0].site_depth, rel=1e-3)
    layers = [{"down_to": "10 m", "speed": "1 m/s"}, {"down_to": "24 m", "speed": "0 m/s"}]
    found = _deepened({"depth": "24 m", "current": layers, "water": 1}, 48.0)
    assert found == {"depth": "48 m", "current": [layers[0], {"down_to": "48 m", "speed": "0 m/s"}], "water": 1}
    assert _deepened({"current": {"file": "a.nc"}}, 48.0) == {"depth": "48 m", "current": {"file": "a.nc"}}
    assert [_counted(n) for n in (2, 4, 7)] == ["two dives", "four dives", "7 dives"]
