import io
import json
import math
import sys

import numpy as np
import pyarrow.parquet
import pytest
from simulate_missions import EXACT, GONE, MISSIONS, chesapeake, chesapeake_data

from missionplan.errors import InputError, RunError
from missionplan.mission import load
from missionplan.montecarlo.streams import BLOCK
from missionplan.phases import mooring as moored
from missionplan.scenario.anchors import carried_anchors, wet_weight_of
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation import mooring_trials
from missionplan.studies.simulation import simulate as module
from missionplan.studies.simulation.simulate import simulate, simulate_block

pytestmark = pytest.mark.usefixtures("unplanned", "unheld")

WAY_IN = {"phases": chesapeake_data()["phases"][:1], "requirements": []}


@pytest.fixture(scope="module")
def outcome():
    return simulate(load(MISSIONS / "chesapeake.yaml"), trials=4200, sheet=False)


def means(outcome, phase):
    (found,) = [part for part in (*outcome.phases, outcome.total) if part.name == phase]
    return {name: statistic.mean for name, statistic in found.quantities.items()}


def test_without_current_or_error_the_durations_are_closed_form(tmp_path):
    mission = chesapeake(tmp_path, EXACT)
    found = simulate(mission, trials=50, sheet=False)
    ingress, moor, egress = (means(found, name) for name in ("ingress", "moor", "egress"))
    legs = math.ceil((1600.0 - 15.0) / 350.0)
    transit = 1600.0 / 1.5 + legs * 90.0
    for phase in (ingress, egress):
        assert phase["duration_s"] == pytest.approx(transit, rel=1e-9)
        assert phase["surfacings"] == legs
        assert phase["distance_m"] == pytest.approx(1600.0, rel=1e-9)
        assert phase["arrival_error_m"] == pytest.approx(0.0, abs=1e-9)
    assert moor["offset_m"] == pytest.approx(0.0, abs=1e-9)
    assert moor["target_offset_m"] == pytest.approx(0.0, abs=1e-9)
    steady = 10.0 + 20 * 60.0 + 10 * 60.0 + 90.0
    assert moor["duration_s"] == pytest.approx(steady + moor["descent_time_s"] + moor["ascent_time_s"], rel=1e-9)
    total = means(found, "total")
    assert total["duration_s"] == pytest.approx(2 * transit + moor["duration_s"], rel=1e-9)
    assert total["duration_s"] == found.phases[-1].end.mean
    assert found.total.events["success"].value == 1.0


def test_energy_is_hotel_propulsion_and_surfacings(tmp_path):
    mission = chesapeake(tmp_path, {**EXACT, "vehicle.energy.surfacing": "100 J"})
    found = simulate(mission, trials=20, sheet=False)
    scenario = Scenario.at_means(mission)
    carrying = carried_anchors(scenario, scenario.transit()).lengthened(scenario.vehicle_drag)
    for name, drag in (("ingress", carrying), ("egress", scenario.vehicle_drag)):
        phase, propulsion = means(found, name), float(drag(1.5)) * 1.5 / 0.45
        joules = 8.0 * phase["duration_s"] + propulsion * phase["distance_m"] / 1.5 + 100.0 * phase["surfacings"]
        assert phase["energy_wh"] == pytest.approx(joules / 3600.0, rel=1e-12)
    moor = means(found, "moor")
    assert moor["energy_wh"] == pytest.approx((8.0 * moor["duration_s"] + 100.0) / 3600.0, rel=1e-12)
    parts = [means(found, phase.name)["energy_wh"] for phase in found.phases]
    assert means(found, "total")["energy_wh"] == pytest.approx(sum(parts), rel=1e-12)


def test_the_missions_own_energy_section_comes_first(tmp_path):
    mission = chesapeake(tmp_path, {**EXACT, "energy": {"hotel": "20 W", "propulsive_efficiency": 0.9}})
    moor = means(simulate(mission, trials=5, sheet=False), "moor")
    assert moor["energy_wh"] == pytest.approx(20.0 * moor["duration_s"] / 3600.0)


def test_symmetric_errors_leave_offsets_centred(tmp_path):
    mission = chesapeake(tmp_path, {"site.current": GONE})
    block = simulate_block(mission, seed=4, block=0)
    for phase in block.phases:
        error = phase.miss.mean(axis=1) / (phase.miss.std(axis=1) / math.sqrt(BLOCK))
        # an arrival is judged on fixes: with no current the misses of a moor are as symmetric across the course
        assert abs(error[1]) < 4.0
    anchor = block.phases[1]
    drift = anchor.anchor.mean(axis=1) - np.array([1600.0, 0.0])
    assert abs(drift[1]) < 4.0 * anchor.anchor[1].std() / math.sqrt(BLOCK)


def test_doubling_the_trials_halves_the_variance_of_the_mean(tmp_path):
    mission = chesapeake(tmp_path, WAY_IN)
    # 256 means of 64 trials, 128 means of 128: all independent
    values = np.stack([simulate_block(mission, seed=1, block=b).total["duration_s"] for b in range(8)]).reshape(2, -1)
    small, large = values[0].reshape(-1, 64).mean(axis=1), values[1].reshape(-1, 128).mean(axis=1)
    assert 1.4 < small.var() / large.var() < 2.8
    few, many = (
        simulate(mission, trials=n, sheet=False).total.quantities["duration_s"].standard_error for n in (2048, 4096)
    )
    assert (few / many) ** 2 == pytest.approx(2.0, rel=0.1)


def test_phases_follow_each_other(outcome):
    ingress, moor, egress = outcome.phases
    assert ingress.start.mean == 0.0
    assert moor.start.mean == pytest.approx(ingress.end.mean, rel=1e-12)
    assert egress.start.mean == pytest.approx(moor.end.mean, rel=1e-12)
    assert egress.end.mean == pytest.approx(outcome.total.quantities["duration_s"].mean, rel=1e-12)


def test_each_phase_starts_where_the_last_one_left_each_trial(tmp_path):
    tracks = simulate(chesapeake(tmp_path), trials=100, sheet=False).tracks
    last = np.array([np.flatnonzero(tracks.phase == index).max() for index in range(3)])
    egress = tracks.position[last[1] + 1]
    assert np.array_equal(egress, tracks.position[last[1]])  # from wherever it surfaced
    assert tracks.position.shape[1:] == (2, 100)
    assert tracks.targets["ingress"] == ((1600.0, 0.0), 15.0)
    assert tracks.origin == pytest.approx((math.radians(37.25), math.radians(-76.38)))


def test_summary_has_the_contracts_names(outcome):
    summary = json.loads(json.dumps(outcome.summary()))
    ingress, moor, egress = summary["phases"]
    assert (ingress["name"], ingress["kind"], moor["kind"]) == ("ingress", "transit", "moor")
    transit = {"duration_s", "surfacings", "distance_m", "arrival_error_m", "energy_wh"}
    assert set(ingress["quantities"]) == set(egress["quantities"]) == transit
    assert set(ingress["events"]) == {"arrived"}
    assert set(moor["quantities"]) == {
        *("release_time_s", "payout_time_s", "descent_time_s", "terminal_velocity_m_s", "offset_m"),
        *("target_offset_m", "lowest_altitude_m", "ascent_time_s", "duration_s", "energy_wh"),
        *("nose_altitude_m", "excursion_m", "line_tension_n", "holding_margin", "touchdown_speed_m_s"),
        "snatch_tension_n",
    }
    assert set(moor["events"]) == {"within_radius", "struck_seafloor", "anchor_holds", "grounded", "line_parts"}
    assert set(summary["total"]["quantities"]) == {"duration_s", "energy_wh"}
    assert set(summary["total"]["events"]) == {"success"}
    assert set(ingress["quantities"]["duration_s"]) == {"mean", "sd", "p05", "p50", "p95", "standard_error"}
    offset = summary["requirements"][1]
    assert (offset["quantity"], offset["required"]) == ("moor.offset", 0.9)
    assert offset["at_most"] == pytest.approx(22.86)
    assert summary["trials"] == 4200


def test_statistics_are_those_of_the_trials(outcome):
    mission = load(MISSIONS / "chesapeake.yaml")
    blocks = [simulate_block(mission, seed=1, block=block, trials=n) for block, n in ((0, BLOCK), (1, 4200 - BLOCK))]
    for phase, name in (("ingress", "duration_s"), ("moor", "offset_m"), ("egress", "energy_wh")):
        values = np.concatenate([block.columns()[f"{phase}.{name}"] for block in blocks])
        (found,) = [part.quantities[name] for part in outcome.phases if part.name == phase]
        assert found.mean == pytest.approx(values.mean(), rel=1e-12)
        assert found.sd == pytest.approx(values.std(ddof=1), rel=1e-9)
        assert found.p95 == pytest.approx(np.quantile(values, 0.95), rel=2e-3)
    (counts,) = [phase.histograms["offset_m"].counts for phase in outcome.phases if phase.name == "moor"]
    assert counts.sum() == 4200


def test_whole_numbers_stay_whole(outcome):
    surfacings = outcome.phases[0].quantities["surfacings"]
    assert (surfacings.p05, surfacings.p50, surfacings.p95) == (5, 5, 6)
    edges = outcome.phases[0].histograms["surfacings"].edges
    assert np.allclose(edges % 1.0, 0.5)


def test_the_offset_counts_from_the_fix_and_its_error(tmp_path):
    exact = simulate_block(chesapeake(tmp_path, EXACT), seed=1, block=0, trials=500)
    erring = simulate_block(
        chesapeake(tmp_path, {**EXACT, "navigation.fix_error": "3 m"}), seed=1, block=0, trials=1000
    )
    assert np.allclose(exact.columns()["moor.offset_m"], 0.0, atol=1e-9)
    # in still water the anchor falls where the vehicle is: what is left is one fix's error, Rayleigh distributed
    assert erring.columns()["moor.offset_m"].mean() == pytest.approx(3.0 * math.sqrt(math.pi / 2.0), rel=0.05)


def test_a_trial_that_does_not_arrive_is_counted_where_it_failed(tmp_path):
    found = simulate(chesapeake(tmp_path, {"navigation.max_legs": 5}), trials=500, sheet=False)
    ingress, moor, _ = found.phases
    arrived = ingress.events["arrived"].value
    assert 0.5 < arrived < 1.0
    assert ingress.quantities["duration_s"].missing == round(500 * (1 - arrived))
    assert moor.quantities["offset_m"].count == round(500 * arrived)
    steps = {step.step: step.lost.value for step in found.attrition}
    assert steps["ingress: not arrived"] == pytest.approx(1.0 - arrived)
    assert found.attrition[-1].surviving == found.total.events["success"]
    assert found.total.events["success"].value + sum(steps.values()) == pytest.approx(1.0)
    assert found.requirements[0].probability.value == arrived
    assert found.requirements[1].probability.value <= arrived  # what was never reached is not met


def test_a_moor_outside_its_radius_goes_on(tmp_path):
    found = simulate(chesapeake(tmp_path, {"phases.1.moor.radius": "4 m"}), trials=500, sheet=False)
    _, moor, egress = found.phases
    within = moor.events["within_radius"].value
    assert 0.2 < within < 0.8
    assert egress.events["arrived"].value == 1.0
    assert found.total.quantities["duration_s"].count == 500
    assert found.total.events["success"].value == within
    assert {step.step: step.lost.value for step in found.attrition}["moor: anchor outside the radius"] == pytest.approx(
        1.0 - within
    )


def test_a_vehicle_that_strikes_the_seafloor_is_counted(tmp_path):
    mission = chesapeake(tmp_path, {"phases.1.moor.line_length": {"low": "2.5 m", "high": "5 m"}})
    found = simulate(mission, trials=300, sheet=False)
    struck = found.phases[1].events["struck_seafloor"].value
    altitude = simulate_block(mission, seed=1, block=0, trials=300).columns()["moor.lowest_altitude_m"]
    assert 0.1 < struck < 0.9
    assert struck == np.mean(altitude <= 0.0)
    assert found.total.events["success"].value == pytest.approx(1.0 - struck)
    assert found.total.quantities["duration_s"].count == 300  # it is buoyant and comes up all the same


def test_a_battery_that_runs_out_ends_the_mission_there(tmp_path):
    found = simulate(chesapeake(tmp_path, {"vehicle.energy.capacity": "26.5 W*h"}), trials=500, sheet=False)
    lost = {step.step: step.lost.value for step in found.attrition}
    assert 0.1 < lost["egress: out of energy"] < 0.9
    assert found.phases[2].events["arrived"].value == pytest.approx(1.0 - lost["egress: out of energy"])
    assert found.total.quantities["energy_wh"].p95 <= 26.5
    early = simulate(chesapeake(tmp_path, {"vehicle.energy.capacity": "5 W*h"}), trials=50, sheet=False)
    assert early.attrition[1].step == "ingress: out of energy"
    assert early.attrition[1].lost.value == 1.0
    assert early.total.events["success"].value == 0.0
    assert early.summary()["total"]["quantities"]["duration_s"]["mean"] is None


def test_an_anchor_that_cannot_pull_the_vehicle_down(tmp_path):
    changes = {"phases.1.moor.anchor_wet_weight": "0.5 N", "vehicle.anchor.flooded_mass": "2.5 kg"}
    with pytest.raises(InputError, match=r"0\.5 N cannot sink a vehicle of 0\.8896 N"):
        chesapeake(tmp_path, changes)


def test_requirements_may_be_undecided(tmp_path):
    requirements = [
        {"quantity": "moor.offset", "at_most": "4.35 m", "probability": 0.5},
        {"quantity": "total.duration", "at_least": "1 h", "probability": 0.9},
        {"quantity": "total.success", "probability": 0.999},
        {"quantity": "total.energy", "at_most": "20 W*h", "probability": 0.1},
    ]
    found = simulate(chesapeake(tmp_path, {"requirements": requirements}), trials=1000, sheet=False)
    assert [requirement.undecided for requirement in found.requirements] == [True, False, True, False]
    assert [requirement.met for requirement in found.requirements][1:] == [True, True, False]
    assert not found.requirements_met


def test_correlations_tie_draws(tmp_path):
    pair = ["site.current[0].speed", "site.current[1].speed"]
    mission = chesapeake(tmp_path, {"correlations": [{"between": pair, "rho": 0.9}], **WAY_IN})
    block = simulate_block(mission, seed=1, block=0)
    assert np.corrcoef(*(block.draws[name] for name in pair))[0, 1] == pytest.approx(0.9, abs=0.02)


def test_sensitivities_name_what_matters(outcome):
    first = {}
    for found in outcome.sensitivities:
        first.setdefault(found.output, found)
    assert first["egress.duration_s"].source == "site.current[0].speed"
    assert first["moor.offset_m"].source.startswith("ingress.fix_error")
    assert {"moor.release_time", "ingress.velocity_error.along"} <= {found.source for found in outcome.sensitivities}
    early = {found.source for found in outcome.sensitivities if found.output.startswith("ingress.")}
    assert not any(source.startswith(("moor.", "egress.")) for source in early)  # what is yet to come changes nothing


@pytest.fixture(scope="module")
def plain_columns(tmp_path_factory):
    """Columns of the mission without effects."""
    return simulate_block(chesapeake(tmp_path_factory.mktemp("plain")), seed=1, block=0, trials=200).columns()


@pytest.mark.parametrize(
    ("effect", "column", "changes"),
    [
        ({"mean-current": {"east": "-0.2 m/s"}}, "ingress.duration_s", True),
        ({"speed-scale": {"fraction": -0.1}}, "ingress.duration_s", True),
        ({"surface-drift": {"east": "0.3 m/s"}}, "moor.offset_m", True),
        ({"fix-error": {"sd": "5 m"}}, "moor.offset_m", True),
        ({"heavy-tails": {"dof": 3}}, "egress.duration_s", True),
        ({"random-walk": {"rate": "0.001 m/s^1.5"}}, "egress.duration_s", True),
        ({"persistent-error": {"sigma": "0.1 m/s", "time": "1 h"}}, "egress.duration_s", True),
        ({"inertial-current": {"amplitude": "0.2 m/s"}}, "egress.duration_s", True),
        ({"drag-bias": {"fraction": 0.5}}, "moor.descent_time_s", True),
        ({"slow-flooding": {"fraction": 0.3, "time": "10 s"}}, "moor.descent_time_s", True),
        ({"trapped-gas": {"lift": "2 N"}}, "moor.ascent_time_s", True),
        ({"line-payout": {"delay_per_length": "0.5 s/m"}}, "moor.descent_time_s", True),
        ({"vertical-current": {"speed": "0.05 m/s"}}, "moor.ascent_time_s", True),
        ({"sensor-lag": {"time": "2 s"}}, "moor.descent_time_s", False),
    ],
)
def test_effects_act(plain_columns, tmp_path, effect, column, changes):
    plain = plain_columns[column]
    block = simulate_block(chesapeake(tmp_path, {"effects": [effect]}), seed=1, block=0, trials=200)
    assert np.isfinite(block.columns()[column]).mean() > 0.5
    assert np.array_equal(plain, block.columns()[column]) != changes


def test_effects_may_be_uncertain(tmp_path):
    effects = [{"drag-bias": {"fraction": {"mean": 0.3, "sd": 0.1}}}]
    block = simulate_block(chesapeake(tmp_path, {"effects": effects}), seed=1, block=0, trials=500)
    bias, time = block.draws["effects.drag-bias.fraction"], block.columns()["moor.descent_time_s"]
    assert np.corrcoef(bias, time)[0, 1] > 0.9


def test_an_effect_on_a_reading_is_reported_not_to_change_the_plan(tmp_path):
    found = simulate(chesapeake(tmp_path, {"effects": [{"depth-scale": {"fraction": 0.1}}]}), trials=10, sheet=False)
    assert any("depth-scale" in notice for notice in found.provenance.notices)


def test_missions_without_vehicle_or_mooring(tmp_path):
    fig8 = simulate(load(MISSIONS / "fig8.yaml"), trials=200, sheet=False)
    assert fig8.phases[0].events["arrived"].value == 1.0
    assert any("no vehicle" in notice for notice in fig8.provenance.notices)
    assert fig8.summary()["total"]["quantities"]["energy_wh"]["mean"] is None
    design = simulate(load(MISSIONS / "anchor-design.yaml"), trials=200, sheet=False)
    assert design.phases[0].quantities["duration_s"].count == 200


def test_positions_may_be_geographic(tmp_path):
    here = {"latitude": "37.25 deg", "longitude": "-76.38 deg"}
    there = {"latitude": "37.25 deg", "longitude": "-76.3619655 deg"}
    changes = {"phases.0.transit.from": here, "phases.0.transit.to": there, "phases.2.transit.to": here}
    geographic = simulate(chesapeake(tmp_path, changes | EXACT), trials=10, sheet=False)
    planar = simulate(chesapeake(tmp_path, EXACT), trials=10, sheet=False)
    assert means(geographic, "ingress")["distance_m"] == pytest.approx(means(planar, "ingress")["distance_m"], abs=0.1)


def test_every_number_may_be_uncertain(tmp_path):
    spread = {
        "phases.0.transit.speed": {"mean": "1.5 m/s", "sd": "0.05 m/s"},
        "phases.0.transit.d_max": {"low": "300 m", "high": "400 m"},
        "phases.0.transit.depth": {"low": "1 m", "high": "8 m"},
        "phases.0.transit.arrival_radius": {"low": "14 m", "high": "16 m"},
        "phases.0.transit.to": [{"mean": "1600 m", "sd": "5 m"}, "0 m"],
        "phases.0.transit.from": ["0 m", {"mean": "0 m", "sd": "10 m"}],
        "site.depth": {"low": "11 m", "high": "14 m"},
        "site.current.0.down_to": {"low": "5 m", "high": "7 m"},
        "site.current.0.toward": {"mean": "60 deg", "sd": "10 deg"},
        "site.water": {"temperature": {"mean": "20 degC", "sd": "2 degC"}, "salinity": {"low": 10, "high": 20}},
        "navigation.surfacing_time": {"median": "90 s", "factor": 1.1},
        "navigation.fix_error": {"low": "2 m", "high": "4 m"},
        "navigation.velocity_error": {
            "mean": [{"mean": "0 m/s", "sd": "0.02 m/s"}, "0 m/s"],
            "sigma": {"low": "0.02 m/s", "high": "0.05 m/s"},
        },
        "vehicle.hull.form_factor": {"mean": 2.643, "sd": 0.2},
        "vehicle.hull.length": {"mean": "44 in", "sd": "0.1 in"},
        "vehicle.mass": {"mean": "10.2 kg", "sd": "0.1 kg"},
        "vehicle.net_buoyancy": {"mean": "0.89 N", "sd": "0.05 N"},
        "vehicle.anchor.drag_coefficient": {"median": 0.2, "factor": 1.2},
        "vehicle.anchor.construction.front.mass": {"mean": "0.7 kg", "sd": "0.01 kg"},
        "vehicle.energy.hotel": {"mean": "8 W", "sd": "1 W"},
        "vehicle.energy.capacity": {"mean": "60 W*h", "sd": "2 W*h"},
        "phases.1.moor.anchor_wet_weight": {"mean": "11.8 N", "sd": "0.2 N"},
        "phases.1.moor.line_length": {"mean": "5 m", "sd": "0.1 m"},
        "phases.1.moor.radius": {"mean": "75 ft", "sd": "1 ft"},
        "phases.1.moor.hold": {"choices": ["20 min", "30 min"]},
    }
    found = simulate(chesapeake(tmp_path, spread), trials=500, sheet=False)
    assert found.total.events["success"].value > 0.95
    moor = found.phases[1].quantities
    assert moor["descent_time_s"].sd > 0.1
    assert any("front.mass" in notice for notice in found.provenance.notices)


def test_a_sized_anchor_has_the_worst_case_weight(tmp_path):
    mission = chesapeake(tmp_path, {"phases.1.moor.anchor_wet_weight": "sized"})
    scenario = Scenario.at_means(mission)
    speed = (0.6 * 6.096 + 0.4 * 6.096) * 0.514444 / 22.86
    dive = dive_of(scenario, scenario.moor())
    assert dive.wet_weight == pytest.approx(float(dive.vehicle_drag(speed)) + float(dive.anchor_drag(speed)), rel=1e-5)
    carried = chesapeake(
        tmp_path, {"phases.1.moor.anchor_wet_weight": "sized", "phases.1.moor.carry_net_buoyancy": True}
    )
    heavier = wet_weight_of(Scenario.at_means(carried), carried.moors[0])
    assert heavier == pytest.approx(dive.wet_weight + 0.2 * 4.4482216, rel=1e-6)


def test_what_is_missing_is_reported_before_any_trial(tmp_path):
    with pytest.raises(InputError, match=r"site\.water.*a mooring needs it"):
        simulate(chesapeake(tmp_path, {"site.water": GONE}), sheet=False)
    with pytest.raises(InputError, match="at least one phase"):
        simulate(chesapeake(tmp_path, {"phases": [], "requirements": []}), sheet=False)
    inertial = {"effects": [{"inertial-current": {"amplitude": "0.1 m/s"}}], "site.origin": GONE}
    with pytest.raises(InputError, match=r"site\.origin"):
        simulate(chesapeake(tmp_path, inertial), sheet=False)
    unsized = {"site.current": GONE, "phases.1.moor.anchor_wet_weight": "sized"}
    with pytest.raises(InputError, match="design_current"):
        simulate(chesapeake(tmp_path, unsized), sheet=False)


def test_a_drift_as_fast_as_the_vehicle_is_reported(tmp_path):
    changes = {**EXACT, "navigation.velocity_error": {"mean": ["-1.6 m/s", "0 m/s"], "sigma": "0.01 m/s"}}
    found = simulate(chesapeake(tmp_path, {**changes, "navigation.max_legs": 20}), trials=10, sheet=False)
    assert found.phases[0].events["arrived"].value == 0.0
    assert any("reaches the vehicle's speed" in notice for notice in found.provenance.notices)


def test_keeping_trials_gives_one_row_each(tmp_path):
    mission = chesapeake(tmp_path, {"navigation.max_legs": 5})
    found = simulate(mission, trials=4200, keep_trials=True, sheet=False)
    frame = pyarrow.parquet.read_table(io.BytesIO(found.trials_table)).to_pandas()
    assert list(frame["trial"]) == list(range(4200))
    assert frame["total.success"].mean() == found.total.events["success"].value
    assert frame["ingress.duration_s"].isna().sum() == found.phases[0].quantities["duration_s"].missing
    assert frame["ingress.duration_s"].mean() == pytest.approx(found.phases[0].quantities["duration_s"].mean)
    assert {"moor.release_time", "site.current[0].speed", "moor.offset_m"} <= set(frame)
    assert "trials.parquet" in found.files()


def test_keeping_trials_without_pyarrow_says_what_to_install_before_any_trial(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match="pip install 'pyarrow>="):
        simulate(chesapeake(tmp_path), trials=10, keep_trials=True, sheet=False)


def test_a_block_that_fails_is_reported_and_the_others_kept(tmp_path, monkeypatch):
    original = mooring_trials.moor

    def failing(plan, state, normals, *rest, **options):
        if failing.calls == 1:
            normals = np.full_like(normals, np.inf)
        failing.calls += 1
        return original(plan, state, normals, *rest, **options)

    failing.calls = 0
    mission = chesapeake(tmp_path, {"phases": chesapeake_data()["phases"][1:2], "requirements": []})
    whole = simulate(mission, trials=BLOCK + 54, sheet=False)
    monkeypatch.setattr(mooring_trials, "moor", failing)
    found = simulate(mission, trials=BLOCK + 54, sheet=False)
    (words,) = found.failed_blocks
    assert "block 1 (trials 4096 to 4149, seed 1)" in words
    assert found.provenance.trials == BLOCK
    assert found.summary()["failed_blocks"] == [words]
    assert any("simulate_block" in notice for notice in found.provenance.notices)
    assert found.total.quantities["duration_s"].mean != whole.total.quantities["duration_s"].mean


def test_a_block_that_fails_can_be_run_alone(tmp_path, monkeypatch):
    def failing(*_, **__):
        raise ZeroDivisionError("on purpose")

    mission = chesapeake(tmp_path)
    monkeypatch.setattr(mooring_trials, "moor", failing)
    with pytest.raises(RunError, match="every block of trials failed"):
        simulate(mission, trials=10, sheet=False)
    with pytest.raises(ZeroDivisionError, match="on purpose"):
        simulate_block(mission, seed=1, block=7)
    monkeypatch.setattr(mooring_trials, "moor", moored.moor)
    assert simulate_block(mission, seed=1, block=7).success.size == BLOCK
    assert module.MAX_TRIALS > BLOCK
