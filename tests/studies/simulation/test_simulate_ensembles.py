"""Ensembles of currents: each trial sails in one member, and the result says which spoils the mission."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from simulate_missions import chesapeake
from test_simulate_currents import STEADY, csv

from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.mission import with_values
from missionplan.phases.currents import layers
from missionplan.phases.ensemble import Ensemble
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.report.render import terminal_view
from missionplan.report.simulation.page import answer
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import members_of, recorded_current
from missionplan.studies.anchor import size_anchor
from missionplan.studies.exploration.explore import explore
from missionplan.studies.leg_length import paired_trials
from missionplan.studies.leg_length.plan_legs import plan_legs
from missionplan.studies.leg_length.plan_page import page as plan_page
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.optimisation.optimise import optimise
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.validate import validated_mission

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unheld")

SPEEDS = (0.0, 0.1, 1.2)
WEIGHTS = (5.0, 3.0, 2.0)


def series(speed):
    east = np.full((2, 1), speed)
    return SeriesCurrent(np.array([0.0, 1e5]), np.array([0.0]), east, 0.0 * east)


def ensemble_mission(folder, speeds=SPEEDS, weights=WEIGHTS, changes=None):
    for number, speed in enumerate(speeds):
        csv(folder, lambda t, depth, speed=speed: (0.0, -speed))
        (folder / "current.csv").rename(folder / f"run-{number}.csv")
    files = [f"run-{number}.csv" for number in range(len(speeds))]
    current = {"file": files, "outside": "hold"}
    if weights is not None:
        current["weights"] = list(weights)
    return chesapeake(folder, STEADY | {"site.current": current} | (changes or {}))


def test_each_trial_has_one_member_by_its_weight():
    whole = Ensemble.of([series(speed) for speed in SPEEDS], "abc", WEIGHTS)
    drawn = whole.drawn(np.random.default_rng(1).normal(size=20_000))
    place = np.zeros((2, 20_000))
    speeds = drawn.velocity(np.arange(20_000.0), 0.0, place)[0]
    for speed, weight in zip(SPEEDS, WEIGHTS, strict=True):
        assert np.mean(np.isclose(speeds, speed)) == pytest.approx(weight / 10.0, abs=0.012)
    kept = np.array([7, 3, 11])
    assert drawn.take(kept).velocity(50.0, 0.0, place[:, kept])[0] == pytest.approx(speeds[kept])
    assert whole.velocity(50.0, 0.0, place[:, :1])[0] == pytest.approx(0.3 * 0.1 + 0.2 * 1.2)
    mean = drawn.mean_velocity(np.arange(20_000.0), 60.0, 0.0, place, place)
    assert mean[0] == pytest.approx(speeds)
    assert layers([1.0], [0.0], [0.0]).is_record is False


def test_an_ensemble_of_one_and_the_same_is_that_current(tmp_path):
    same = ensemble_mission(tmp_path, (0.1, 0.1), None)
    alone = chesapeake(tmp_path, STEADY | csv(tmp_path, lambda t, depth: (0.0, -0.1)), name="alone.yaml")
    found = [simulate_block(each, seed=1, block=0, trials=100).columns() for each in (alone, same)]
    for name, values in found[0].items():
        assert found[1][name] == pytest.approx(values, rel=1e-9, nan_ok=True), name


def test_the_member_that_spoils_the_mission_is_named(tmp_path):
    # the mean of the members would carry the others astray, and those that are would take all legs allowed
    alone = {"navigation.drift_compensation": "last-leg", "navigation.max_legs": 20}
    found = simulate(ensemble_mission(tmp_path, changes=alone), trials=600, sheet=False)
    successes = {each.causes[0]: each.success.value for each in found.members}
    assert successes["run-0.csv"] == successes["run-1.csv"] == 1.0
    assert successes["run-2.csv"] == 0.0
    assert sum(each.trials for each in found.members) == 600
    said = answer(found).replace("\N{NO-BREAK SPACE}", " ")
    assert "It depends on the forecast: it succeeds 0 % of the time in run-2.csv and 100 % in run-" in said
    (entry,) = [each for each in found.summary()["members"] if each["member"] == "run-2.csv"]
    assert entry["probability"] == pytest.approx(0.2)
    assert entry["success"]["value"] == 0.0
    importance = {each.source: each.first_order for each in found.sensitivities if each.output == "total.success"}
    assert importance["site.current.member"] > 0.9


def test_the_forecast_is_the_weighted_mean(tmp_path):
    mission = ensemble_mission(tmp_path, (0.0, 0.2), (1.0, 3.0))
    means = Scenario.at_means(mission, recorded_current(mission))
    assert means.current.velocity(0.0, 2.0, np.zeros((2, 1)))[:, 0] == pytest.approx([0.0, -0.15])
    drawn = means.sampled(seed=1, block=0, size=500)
    assert set(np.round(drawn.current.velocity(0.0, 2.0, np.zeros((2, 500)))[1], 9)) == {0.0, -0.2}


def test_a_dimension_of_members_is_an_ensemble(tmp_path):
    netcdf = pytest.importorskip("netCDF4")
    with netcdf.Dataset(tmp_path / "ens.nc", "w") as file:
        axes = {"member": [1, 2, 3], "time": [0.0, 12.0], "lat": [37.15, 37.35], "lon": [-76.5, -76.3]}
        for name, values in axes.items():
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        file["time"].units = "hours since 2026-05-01 11:00:00"
        for name in ("u", "v"):
            file.createVariable(name, "f4", tuple(axes)).units = "m s-1"
            file[name][:] = 0.0
        file["u"][:] = np.array([0.0, 0.05, 0.1])[:, None, None, None]
    changes = {"start": "2026-05-01T12:00:00Z", "site.current": {"file": "ens.nc", "weights": [1, 1, 2]}}
    found = recorded_current(chesapeake(tmp_path, STEADY | changes))
    assert isinstance(found, Ensemble)
    assert found.names == ("member 1", "member 2", "member 3")
    assert found.velocity(0.0, 0.0, np.zeros((2, 1)))[0] == pytest.approx((0.05 + 2 * 0.1) / 4.0)
    changes["site.current"]["weights"] = [1, 1]
    with pytest.raises(InputError, match="2 weights for 3 members"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


@pytest.mark.parametrize(
    ("current", "message"),
    [
        ({"weights": [1, 2]}, "2 weights for 3 members"),
        ({"weights": [0, 0, 0]}, "at least one weight above zero"),
        ({"weights": [1, -1, 1]}, "site.current.weights"),
        ({"file": ["run-0.csv"]}, "an ensemble has two members or more"),
        ({"file": ["run-0.csv", "run-9.csv"]}, "there is no such file"),
    ],
)
def test_impossible_ensembles_are_refused(tmp_path, current, message):
    ensemble_mission(tmp_path, weights=None)
    data = yaml.safe_load((tmp_path / "mission.yaml").read_text())
    with pytest.raises(InputError, match=message):
        chesapeake(tmp_path, STEADY | {"site.current": data["site"]["current"] | current})


def test_legs_are_judged_over_all_members_by_their_weights(tmp_path):
    """The cost of each length of legs is the members' weighted mean."""
    speeds = (0.0, 0.1, 0.3)
    lengths = {
        "sweep": {"d_max": ["400 m", "900 m"], "sigma": ["0.05 m/s"]},
        "navigation.drift_compensation": "last-leg",
        "requirements": [],
    }
    together = ensemble_mission(tmp_path, speeds, changes=lengths)
    swept = sweep_dmax(together, trials=1500).summary()["sweep"][0]["curve"]
    alone = []
    for number in range(len(speeds)):
        current = {"file": f"run-{number}.csv", "outside": "hold"}
        mission = chesapeake(tmp_path, STEADY | lengths | {"site.current": current}, name=f"only-{number}.yaml")
        alone.append(sweep_dmax(mission, trials=1500).summary()["sweep"][0]["curve"])
    for index, point in enumerate(swept):
        costs = [curve[index]["cost"] for curve in alone]
        assert max(costs) - min(costs) > 10.0 * point["standard_error"]
        mean = np.average(costs, weights=WEIGHTS)
        assert point["cost"] == pytest.approx(mean, abs=5.0 * point["standard_error"])


def test_an_anchor_in_a_record_of_the_current_is_sized_for_a_speed_that_the_mission_names(tmp_path):
    mission = ensemble_mission(tmp_path)
    with pytest.raises(InputError, match=r"moor\.design_current: missing; sizing the anchor needs one speed"):
        size_anchor(mission)
    ready = {entry.command: entry.needs for entry in validated_mission(tmp_path / "mission.yaml", mission).table}
    assert ready["size-anchor"] == ("moor.design_current",)


@pytest.mark.slow
def test_with_that_speed_it_is_sized(tmp_path):
    # one member carries the vehicle away, and with it for all legs that are allowed
    few_legs = {"phases.1.moor.design_current": "0.5 m/s", "navigation.max_legs": 20, "requirements": []}
    named = ensemble_mission(tmp_path, changes=few_legs)
    assert size_anchor(named, trials=40).summary()["anchor"]["wet_weight_n"] > 0.0


@pytest.fixture
def spoiled(tmp_path):
    """A mission of which one of three members carries the vehicle away."""
    changes = {
        "navigation.drift_compensation": "last-leg",
        "navigation.max_legs": 8,  # those that are carried away would take all legs allowed
        "sweep": {"d_max": ["400 m", "900 m"]},
    }
    mission = ensemble_mission(tmp_path, changes=changes)
    return Mission.from_data(with_values(mission.raw, {"moor.design_current": "0.3 m/s"}), file=mission.file)


def words(found):
    return terminal_view(found).sentence.replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.usefixtures("unsought")
def test_plans_of_legs_say_which_member_spoils_them(spoiled, monkeypatch):
    monkeypatch.setattr(paired_trials, "HALVING_RUNGS", ((16, 1),))  # which legs are planned does not matter here
    plan = plan_legs(spoiled, trials=80)
    arrived = {each.name: each.good.value for each in plan.arrivals}
    assert arrived == {"run-0.csv": 1.0, "run-1.csv": 1.0, "run-2.csv": 0.0}
    assert [each.probability for each in plan.arrivals] == pytest.approx([0.5, 0.3, 0.2])
    assert "It depends on the forecast: it arrives 0 % of the time in run-2.csv" in words(plan)
    assert plan.summary()["members"][2]["good"]["value"] == 0.0
    assert "Which member of the current's ensemble spoils the plan" in [
        part.heading for part in plan_page(plan).sections
    ]


def test_sweeps_say_which_member_spoils_them(spoiled):
    swept = sweep_dmax(spoiled, trials=400)
    assert {each.name: each.good.value for each in swept.members}["run-2.csv"] == 0.0
    assert "it arrives 0 % of the time in run-2.csv" in words(swept)
    over_all = swept.middle.recommended.arrived.value
    assert over_all == pytest.approx(sum(each.probability * each.good.value for each in swept.members), abs=0.07)


def test_anchors_say_which_member_spoils_them(tmp_path):
    fast = ensemble_mission(
        tmp_path, (0.0, 0.1, 2.5), (50.0, 45.0, 5.0)
    )  # 25 m in the 10 s from the fix to the anchor's release
    without = {"moor.design_current": "1 m/s", "requirements": []}  # a search of the lightest would take long
    mission = Mission.from_data(with_values(fast.raw, without), file=fast.file)
    sized = size_anchor(mission, trials=40)
    assert [each.good.value for each in sized.members] == [1.0, 1.0, 0.0]
    assert "it succeeds 0 % of the time in run-2.csv" in words(sized)
    assert sized.summary()["members"][2]["probability"] == pytest.approx(0.05)


@pytest.mark.slow
def test_explorations_and_optimisations_say_which_member_spoils_the_best(spoiled):
    found = explore(spoiled, "ingress.speed=1:1.5:0.5 m/s", trials=80)
    best = simulate(
        Mission.from_data(with_values(spoiled.raw, {"ingress.speed": "1 m/s"}), file=spoiled.file),
        trials=80,
        sheet=False,
    )
    assert found.values_of(found.best_cell) == {"ingress.speed": "1 m/s"}
    assert [each.good for each in found.members] == [each.success for each in best.members]
    assert "It depends on the forecast: it succeeds 0 % of the time in run-2.csv" in words(found)
    lenient = with_values(spoiled.raw, {"requirements": [{"quantity": "ingress.arrived", "probability": 0.5}]})
    chosen = optimise(Mission.from_data(lenient, file=spoiled.file), choose=["ingress.speed=1:1.5:0.5 m/s"], trials=80)
    assert {each.name: each.good.value for each in chosen.members}["run-2.csv"] == 0.0
    assert "in run-2.csv" in words(chosen)


def test_a_mission_without_an_ensemble_names_no_member(tmp_path):
    alone = chesapeake(tmp_path, STEADY | {"requirements": []})
    assert simulate(alone, trials=20, sheet=False).members == ()


def test_a_given_member_leaves_what_is_expected():
    whole = Ensemble.of([series(speed) for speed in SPEEDS], "abc", WEIGHTS)
    last = replace(whole, given=2)
    assert members_of(whole)[2] == ("c", pytest.approx(0.2))
    place = np.zeros((2, 3))
    assert last.velocity(50.0, 0.0, place[:, :1])[0] == pytest.approx(whole.velocity(50.0, 0.0, place[:, :1])[0])
    assert last.drawn(np.zeros(3)).velocity(50.0, 0.0, place)[0] == pytest.approx(1.2)
