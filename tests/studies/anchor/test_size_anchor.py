import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor.dive_trials import AnchorTrials
from missionplan.studies.anchor.lightest_anchor import lightest_anchor
from missionplan.studies.anchor.size_anchor import size_anchor, worst_case_anchor
from missionplan.studies.anchor.sizing import AnchorSizer

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.fixture(scope="module")
def mission():
    return load(MISSIONS / "anchor-design.yaml")


def altered(tmp_path, *changes, vehicle=()):
    """A copy of the example with pieces of text replaced."""
    texts = {"anchor-design.yaml": changes, "vehicles/vt475-self-mooring.yaml": vehicle}
    (tmp_path / "vehicles").mkdir(exist_ok=True)
    for name, pairs in texts.items():
        text = (MISSIONS / name).read_text()
        for old, new in pairs:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / name).write_text(text)
    return load(tmp_path / "anchor-design.yaml")


GIVEN_WATER = ("{temperature: 15 degC, salinity: 35}", "{density: 1026.02 kg/m^3, viscosity: 1.1892e-6 m^2/s}")


def test_check_values_of_the_example(tmp_path):
    uncoupled = ("line_length: 5 m", "line_length: 5 m\n      lateral: uncoupled")
    summary = size_anchor(altered(tmp_path, GIVEN_WATER, uncoupled), trials=100).summary()
    anchor = summary["anchor"]
    expected = {
        "terminal_velocity_m_s": (1.6200, 5e-5),
        "wet_weight_n": (11.697, 5e-4),
        "cylinder_length_m": (0.12248, 5e-6),
        "trim_mass_kg": (0.3915, 5e-5),
        "trim_position_m": (0.1072, 5e-5),
        "dry_mass_kg": (1.6007, 5e-5),
        "displaced_mass_kg": (1.6007, 5e-5),
        "centre_of_gravity_m": (0.0883, 5e-5),
        "centre_of_buoyancy_m": (0.0883, 5e-5),
    }
    for key, (value, within) in expected.items():
        assert anchor[key] == pytest.approx(value, abs=within), key
    drag = {"body": 6.614, "sail": 0.281, "vehicle": 8.619, "anchor": 3.078, "total": 11.697}
    assert anchor["drag_n"] == pytest.approx(drag, abs=5e-4)
    assert anchor["feasible"] is True
    assert anchor["problems"] == []
    descent = summary["descent"]
    assert descent["time_s"] == pytest.approx(19.2, abs=0.1)
    assert descent["offset_m"] == pytest.approx(19.6, abs=0.1)
    assert descent["lowest_altitude_m"] == pytest.approx(1.67, abs=0.01)


def test_tied_bodies_drift_further_than_each_with_its_layer(tmp_path):
    """The vehicle follows the anchor a line's length later, and holds it back in the upper layer's direction."""
    descent = size_anchor(altered(tmp_path, GIVEN_WATER), trials=100).summary()["descent"]
    assert descent["time_s"] == pytest.approx(19.24, abs=0.01)
    assert descent["offset_m"] == pytest.approx(20.24, abs=0.01)


def test_summary_and_tables_can_be_written(mission):
    sizing = size_anchor(mission, trials=200, probability=0.9)
    json.dumps(sizing.summary())
    files = sizing.files()
    assert files["anchor.csv"].splitlines()[0] == "quantity,worst_case,probable"
    frame = sizing.descent_frame()
    assert list(frame.columns[:2]) == ["t_s", "vehicle_depth_m"]
    assert set(frame["stage"]) == {"release", "free fall", "pull-down", "coasting", "rise to the line's length"}


def test_carrying_the_buoyancy_makes_the_dive_as_fast_as_designed(tmp_path):
    carried = altered(tmp_path, ("line_length: 5 m", "line_length: 5 m\n      carry_net_buoyancy: true"))
    sizing = size_anchor(carried, trials=100)
    assert sizing.anchor.wet_weight == pytest.approx(11.6965 + 0.8896, abs=1e-3)
    assert sizing.anchor.terminal_velocity == pytest.approx(1.62)
    assert sizing.anchor.descent_summary()["terminal_velocity_m_s"] == pytest.approx(1.62, rel=1e-6)


def test_design_current_defaults_to_mean_and_two_sd(tmp_path):
    mission = altered(tmp_path, ("      design_current: [1.3 m/s, 1.13 m/s]", "     "))
    assert size_anchor(mission, trials=10).required_velocity == pytest.approx((1.3 + 1.2) / 2 * 100 / 75)


def test_the_layers_own_directions_need_less(mission):
    sizing = size_anchor(mission, trials=10)
    aligned, vector = sizing.required_velocity, sizing.vector_velocity
    across = np.hypot(1.3 + 1.13 * np.cos(np.radians(30)), 1.13 * np.sin(np.radians(30)))
    assert vector == pytest.approx(aligned * across / (1.3 + 1.13))


def test_a_probable_anchor_reaches_its_probability_and_a_lighter_one_does_not(mission):
    sizing = size_anchor(mission, trials=2000, probability=0.95)
    found = sizing.probable.anchor
    assert found.probabilities.good.value >= 0.95
    trials = AnchorTrials(mission, "moor", None, 2000, mission.monte_carlo.seed)
    assert trials.probabilities(found.wet_weight / 1.002).good.value < 0.95
    assert sizing.anchor.wet_weight < found.wet_weight


def test_probabilities_against_a_normal_approximation(mission):
    """With offsets nearly normal, the probabilities follow from their mean and spread."""
    probabilities = size_anchor(mission, trials=5000).anchor.probabilities
    z = (75 * 0.3048 - probabilities.offset.mean) / probabilities.offset.sd
    from scipy.stats import norm

    assert probabilities.good.value == pytest.approx(norm.cdf(z), abs=0.01)


def test_probabilities_do_not_depend_on_the_number_of_jobs(mission):
    one = size_anchor(mission, trials=5000).anchor.probabilities
    assert size_anchor(mission, trials=5000, jobs=2, backend="threading").anchor.probabilities == one


def test_progress_counts_the_blocks_of_dives_also_where_processes_run_them(mission):
    calls = []
    size_anchor(mission, trials=5000, jobs=2, progress=lambda done, total: calls.append((done, total)))
    assert calls[:3] == [(0, 2), (1, 2), (2, 2)]


def test_a_short_line_needs_a_longer_one(tmp_path):
    mission = altered(tmp_path, ("line_length: 5 m", "line_length: 3.35 m"))
    sizing = size_anchor(mission, trials=200, probability=0.99)
    probable = sizing.probable
    assert probable.anchor is None
    assert "strike" in probable.reason
    assert probable.line_length > 3.35
    trials = AnchorTrials(mission, "moor", None, 200, mission.monte_carlo.seed)
    assert trials.probabilities(probable.line_anchor_weight, probable.line_length).good.value >= 0.99


def test_a_release_that_drifts_too_far_is_beyond_any_anchor(tmp_path):
    mission = altered(tmp_path, ("{mean: 2 s, sd: 0.5 s, low: 0 s}", "40 s"))
    probable = size_anchor(mission, trials=200, probability=0.9).probable
    assert probable.anchor is None
    assert probable.line_length is None
    assert "drift before the line is taut" in probable.reason


def test_an_impossible_anchor_is_reported_with_reasons_and_remedies(tmp_path):
    mission = altered(tmp_path, vehicle=[("mass: 0.7 kg", "mass: 0.9 kg")])
    summary = size_anchor(mission, trials=10).summary()
    assert summary["anchor"]["feasible"] is False
    assert "behind the tube" in summary["anchor"]["problems"][0]
    assert any("front" in problem for problem in summary["anchor"]["problems"][1:])


def test_where_the_parts_cannot_make_the_lightest_anchor_the_lightest_that_they_make_is_built():
    sizing = size_anchor(load(MISSIONS / "chesapeake.yaml"), trials=500)
    found = sizing.probable
    assert found.lighter < found.anchor.wet_weight
    assert not found.anchor.problems
    assert found.anchor.probabilities.good.value >= found.required == 0.9
    assert sizing.succeeds
    below = AnchorSizer(*sizer_parts(500)).sized(found.anchor.wet_weight / 1.02)
    assert below.problems


def sizer_parts(trials):
    mission = load(MISSIONS / "chesapeake.yaml")
    means = Scenario.at_means(mission)
    return means.moor(), means, AnchorTrials(mission, "moor", None, trials, 1)


def test_dives_in_water_that_line_and_vehicle_do_not_fit_fail(tmp_path):
    """Depths from a metre less to two metres more than line and vehicle are long: in a third they do not fit."""
    length = 5.0 + load(MISSIONS / "anchor-design.yaml").vehicle.hull.length
    depth = f"depth: {{low: {length - 1.0} m, high: {length + 2.0} m}}"
    mission = altered(tmp_path, ("depth: 100 ft", depth), ("down_to: 50 ft", "down_to: 3 m"))
    probabilities = AnchorTrials(mission, "moor", None, 2000, 1).probabilities(12.0)
    assert probabilities.offset.count / 2000 == pytest.approx(2.0 / 3.0, abs=0.03)
    assert probabilities.good.value <= 0.7


def test_without_construction_the_weight_is_still_found(tmp_path):
    construction = (MISSIONS / "vehicles/vt475-self-mooring.yaml").read_text()
    block = construction[construction.index("  construction:") : construction.index("energy:")]
    mission = altered(tmp_path, vehicle=[(block, "  flooded_mass: 2.79 kg\n")])
    summary = size_anchor(mission, trials=10).summary()
    assert summary["anchor"]["wet_weight_n"] == pytest.approx(11.6965, abs=1e-3)
    assert summary["anchor"]["feasible"] is None
    assert summary["descent"]["time_s"] == pytest.approx(19.24, abs=0.01)


def test_effects_of_the_mission_make_the_anchor_heavier(tmp_path, mission):
    biased = altered(tmp_path, ("monte_carlo:", "effects:\n  - drag-bias: {fraction: 0.6}\nmonte_carlo:"))
    plain, heavy = size_anchor(mission, trials=10), size_anchor(biased, trials=10)
    assert heavy.anchor.wet_weight == pytest.approx(1.6 * plain.anchor.wet_weight)
    assert heavy.anchor.terminal_velocity == pytest.approx(1.62)
    assert heavy.anchor.summary()["drag_n"]["total"] == pytest.approx(heavy.anchor.wet_weight)


def test_effects_on_readings_leave_the_plan_alone(tmp_path, mission):
    late = altered(tmp_path, ("monte_carlo:", "effects:\n  - clock-offset: {time: 5 s}\nmonte_carlo:"))
    assert size_anchor(late, trials=10).anchor.descent_time == size_anchor(mission, trials=10).anchor.descent_time


def test_everything_missing_is_reported_at_once():
    with pytest.raises(InputError) as caught:
        size_anchor(load(MISSIONS / "fig8.yaml"))
    assert {problem.key for problem in caught.value.problems} >= {"phases", "vehicle", "site.depth"}


def test_a_probability_must_be_one(mission):
    with pytest.raises(InputError, match="between 0 and 1"):
        size_anchor(mission, probability=1.5)


def test_search_finds_the_lightest_weight_within_the_radius():
    """A made-up mooring: within from 10 N, striking from 12 N."""

    class Probabilities:
        def __init__(self, weight, line):
            edge = 12.0 if line is None else 12.0 * line / 5.0

            def share(value):
                return type("Share", (), {"value": value})()

            self.within = self.enough = share(float(weight >= 10.0))
            self.struck = share(float(weight >= edge))
            self.good = share(float(10.0 <= weight < edge))

    assert lightest_anchor(Probabilities, 0.9, 11.0, 5.0).weight == pytest.approx(10.0, rel=2e-3)


class Shares:
    """Probabilities of a made-up mooring: within the radius, struck, and neither."""

    def __init__(self, within, struck):
        self.within, self.struck, self.good = (
            SimpleNamespace(value=value) for value in (within, struck, within - struck)
        )
        self.enough = self.within


def test_search_goes_on_where_a_few_strikes_ask_for_more_weight():
    """Within the radius rises with the weight, a twentieth strikes always: 0.9 of all dives are good from 12.345 N."""

    def probabilities(weight, line):
        return Shares(min(0.95 * weight / 12.345, 1.0), 0.05)

    found = lightest_anchor(probabilities, 0.9, 11.0, 5.0)
    assert found.weight == pytest.approx(12.345, rel=2e-3)


def test_search_gives_up_where_half_of_all_dives_strike():
    found = lightest_anchor(lambda weight, line: Shares(float(weight >= 10.0), 0.5), 0.9, 11.0, 5.0)
    assert (found.weight, found.best, found.line_length) == (None, 0.5, None)
    assert "seafloor" in found.reason


def test_the_worst_case_by_itself_is_the_anchor_sized(mission):
    assert worst_case_anchor(mission) == size_anchor(mission, trials=10).anchor.wet_weight


def test_the_worst_case_by_itself_reports_what_is_missing():
    with pytest.raises(InputError, match="no mooring"):
        worst_case_anchor(load(MISSIONS / "fig8.yaml"))


def test_an_anchor_must_hold_where_its_holding_factor_is_given(tmp_path, mission):
    spoken = altered(tmp_path, vehicle=[("  drag_coefficient: 0.2", "  holding_factor: 0.5\n  drag_coefficient: 0.2")])
    silent, counted = (size_anchor(each, trials=300, probability=0.6) for each in (mission, spoken))
    assert silent.anchor.probabilities.holds is None
    dives = counted.anchor.probabilities
    assert dives.within.value == silent.anchor.probabilities.within.value
    assert dives.good.value <= min(dives.within.value, dives.holds.value)
    assert dives.holds.value < 0.9
    assert counted.probable.anchor.wet_weight > silent.probable.anchor.wet_weight
    assert counted.probable.anchor.probabilities.good.value >= 0.6
    assert "anchor_holds" in counted.summary()["odds"]


def test_an_anchor_that_cannot_hold_is_told(tmp_path):
    slippery = altered(
        tmp_path, vehicle=[("  drag_coefficient: 0.2", "  holding_factor: 0.02\n  drag_coefficient: 0.2")]
    )
    probable = size_anchor(slippery, trials=100, probability=0.6).probable
    assert probable.anchor is None
    assert "and holds in" in probable.reason


def test_the_vehicle_lies_as_its_centres_say(tmp_path, mission):
    states = size_anchor(mission, trials=10).trim
    assert [state.verdict for state in states][1] == "nose-heavy"
    assert states[1].net_force == pytest.approx(0.89 - 11.7, abs=0.01)
    centres = "centre_of_gravity: {from_nose: 561 mm, below_axis: 5 mm}\ncentre_of_buoyancy: {from_nose: 560 mm}\nmass:"
    sealed, _, released = size_anchor(altered(tmp_path, vehicle=[("mass: 10.2", f"{centres} 10.2")]), trials=10).trim
    assert sealed.pitch == released.pitch == pytest.approx(-math.atan2(1.0, 5.0))
    assert released.verdict == "tail-heavy"


def test_the_report_holds_the_snatch_where_the_files_let_it_be_known(tmp_path):
    stiff = ("line_length: 5 m", "line_length: 5 m\n      line_stiffness: 10 kN/m\n      line_strength: 300 N")
    centres = (
        "mass: 10.2 kg ",
        "centre_of_gravity: {from_nose: 0.56 m}\ncentre_of_buoyancy: {from_nose: 0.56 m}\nmass: 10.2 kg ",
    )
    plain = size_anchor(altered(tmp_path), trials=100).summary()["descent"]
    assert not {"snatch_tension_n", "nose_down_time_s", "depth_lost_m"} & set(plain)
    found = size_anchor(altered(tmp_path, stiff, vehicle=[centres]), trials=100)
    summary = found.summary()
    assert summary["descent"]["snatch_tension_n"] == pytest.approx(440.0, abs=2.0)
    assert 1.0 < summary["descent"]["nose_down_time_s"] < 2.0
    assert any("line parts in the nominal dive" in note for note in summary["notes"])
    assert summary["odds"]["within_radius"]["value"] == 0.0
