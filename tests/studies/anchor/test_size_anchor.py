import copy
import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.montecarlo.streams import stream
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor import size_anchor, worst_case_anchor
from missionplan.studies.anchor.lightest_anchor import Demand, lightest_anchor
from missionplan.studies.anchor.sizing import AnchorSizer, AnchorTrials
from missionplan.studies.judgement import FRESH

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.fixture(scope="module")
def mission():
    return load(MISSIONS / "anchor-design.yaml")


@pytest.fixture(scope="module")
def quick(mission):
    """The example's anchor, for what no trial changes."""
    return size_anchor(mission, trials=10)


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


def test_carrying_the_buoyancy_makes_the_dive_as_fast_as_designed(tmp_path):
    carried = altered(tmp_path, ("line_length: 5 m", "line_length: 5 m\n      carry_net_buoyancy: true"))
    sizing = size_anchor(carried, trials=100)
    assert sizing.anchor.wet_weight == pytest.approx(11.6965 + 0.8896, abs=1e-3)
    assert sizing.anchor.terminal_velocity == pytest.approx(1.62)
    assert sizing.anchor.nominal.terminal_velocity == pytest.approx(1.62, rel=1e-6)


def test_design_current_defaults_to_mean_and_two_sd(tmp_path):
    mission = altered(tmp_path, ("      design_current: [1.3 m/s, 1.13 m/s]", "     "))
    assert size_anchor(mission, trials=10).required_velocity == pytest.approx((1.3 + 1.2) / 2 * 100 / 75)


def test_the_layers_own_directions_need_less(quick):
    aligned, vector = quick.required_velocity, quick.vector_velocity
    across = np.hypot(1.3 + 1.13 * np.cos(np.radians(30)), 1.13 * np.sin(np.radians(30)))
    assert vector == pytest.approx(aligned * across / (1.3 + 1.13))


@pytest.mark.slow
def test_a_probable_anchor_reaches_its_probability_and_a_lighter_one_does_not(mission):
    sizing = size_anchor(mission, trials=2000, probability=0.95)
    found = sizing.probable.anchor
    assert found.probabilities.good.value >= 0.95
    trials = AnchorTrials(mission, "moor", None, 2000, mission.monte_carlo.seed)
    assert trials.probabilities(found.wet_weight / 1.002).good.value < 0.95
    assert sizing.anchor.wet_weight < found.wet_weight


@pytest.fixture(scope="module")
def probabilities(mission):
    """Of the worst-case anchor, by two blocks of dives."""
    return size_anchor(mission, trials=4200).anchor.probabilities


def test_probabilities_against_a_normal_approximation(probabilities):
    """With offsets nearly normal, the probabilities follow from their mean and spread."""
    z = (75 * 0.3048 - probabilities.offset.mean) / probabilities.offset.sd
    from scipy.stats import norm

    assert probabilities.good.value == pytest.approx(norm.cdf(z), abs=0.01)


def test_probabilities_do_not_depend_on_the_number_of_jobs(mission, probabilities):
    threaded = size_anchor(mission, trials=4200, jobs=2, backend="threading")
    assert threaded.anchor.probabilities == probabilities


def test_progress_counts_the_blocks_of_dives_also_where_processes_run_them(mission):
    calls = []
    size_anchor(mission, trials=4097, jobs=2, progress=lambda done, total: calls.append((done, total)))
    assert calls[:3] == [(0, 2), (1, 2), (2, 2)]


@pytest.mark.slow
def test_a_short_line_needs_a_longer_one(tmp_path):
    mission = altered(tmp_path, ("line_length: 5 m", "line_length: 3.35 m"))
    sizing = size_anchor(mission, trials=200, probability=0.99)
    probable = sizing.probable
    assert probable.anchor is None
    assert "a dive clear of the seafloor" in probable.reason
    assert probable.line_length > 3.35
    trials = AnchorTrials(mission, "moor", None, 200, mission.monte_carlo.seed)
    assert trials.probabilities(probable.line_anchor_weight, probable.line_length).good.value >= 0.99


@pytest.mark.slow
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


@pytest.mark.slow
def test_where_the_parts_cannot_make_the_lightest_anchor_the_lightest_that_they_make_is_built():
    sizing = size_anchor(load(MISSIONS / "chesapeake.yaml"), trials=500)
    found = sizing.probable
    assert found.lighter < found.anchor.wet_weight
    assert not found.anchor.problems
    assert all(item.met for item in found.anchor.probabilities.requirements)
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


def test_effects_of_the_mission_make_the_anchor_heavier(tmp_path, quick):
    """Six tenths more drag, and a lift of up to 2 N that the anchor has to overcome besides: as fast as designed."""
    lifted = "effects:\n  - drag-bias: {fraction: 0.6}\n  - lift-by-depth: {lift: 2 N}\nmonte_carlo:"
    heavy = size_anchor(altered(tmp_path, ("monte_carlo:", lifted)), trials=10)
    drag = heavy.anchor.summary()["drag_n"]["total"]
    assert drag == pytest.approx(1.6 * quick.anchor.wet_weight)
    assert 0.5 < heavy.anchor.wet_weight - drag < 2.0
    assert heavy.anchor.terminal_velocity == pytest.approx(1.62)


def test_effects_on_readings_leave_the_plan_alone(tmp_path, quick):
    late = altered(tmp_path, ("monte_carlo:", "effects:\n  - clock-offset: {time: 5 s}\nmonte_carlo:"))
    assert size_anchor(late, trials=10).anchor.nominal.time == quick.anchor.nominal.time


def test_everything_missing_is_reported_at_once():
    with pytest.raises(InputError) as caught:
        size_anchor(load(MISSIONS / "fig8.yaml"))
    assert {problem.key for problem in caught.value.problems} >= {"phases", "vehicle", "site.depth"}


def test_a_probability_must_be_one(mission):
    with pytest.raises(InputError, match="between 0 and 1"):
        size_anchor(mission, probability=1.5)


class Shares:
    """Probabilities of a made-up mooring."""

    def __init__(self, within, struck):
        self.within, self.struck = (SimpleNamespace(value=value) for value in (within, struck))
        self.good = SimpleNamespace(value=within - struck)


WITHIN = Demand("within the radius", 0.9, lambda found: found.within.value)
CLEAR = Demand("clear of the bottom", 0.9, lambda found: 1.0 - found.struck.value, needs_height=True)
GOOD = Demand("a dive that succeeds", 0.9, lambda found: found.good.value, is_hill=True)


def test_search_finds_the_lightest_weight_in_a_narrow_window():
    """Within from 10 N, striking from 10.05 N: half a percent of all weights will do."""

    def probabilities(weight, line):
        return Shares(float(weight >= 10.0), float(weight >= (10.05 if line is None else 2.01 * line)))

    found = lightest_anchor(probabilities, (WITHIN, CLEAR), 11.0, 5.0)
    assert found.weight == pytest.approx(10.0, rel=2e-3)
    assert found.reason == ""


def test_search_goes_on_where_a_few_strikes_ask_for_more_weight():
    """Within the radius rises with the weight, a twentieth strikes always: 0.9 of all dives are good from 12.345 N."""
    found = lightest_anchor(lambda w, line: Shares(min(0.95 * w / 12.345, 1.0), 0.05), (GOOD,), 11.0, 5.0)
    assert found.weight == pytest.approx(12.345, rel=2e-3)


def test_search_says_what_no_weight_does():
    found = lightest_anchor(lambda w, line: Shares(float(w >= 10.0), 0.5), (WITHIN, CLEAR), 11.0, 5.0)
    assert (found.weight, found.line_length) == (None, None)
    assert found.reason.startswith("clear of the bottom in 50.0 % of dives, whatever the anchor weighs")
    assert "no line up to 20 times as long" in found.reason


def test_search_says_which_demand_stands_against_which_with_the_numbers_of_the_best_compromise():
    """Within rises, clear falls with the weight: 18 N and more against 12 N and less, and 15 N miss both by as much."""

    def probabilities(weight, line):
        return Shares(min(weight / 20.0, 1.0), min(max((weight - 10.0) / 20.0, 0.0), 1.0))

    found = lightest_anchor(probabilities, (WITHIN, CLEAR), 11.0, 5.0)
    assert found.weight is None
    assert found.compromise == pytest.approx(15.0, rel=0.02)
    low, high = re.search(
        r"asks for ([\d.]+) N or more, clear of the bottom for ([\d.]+) N or less", found.reason
    ).groups()
    assert float(low) == pytest.approx(18.0, rel=0.21)
    assert float(high) == pytest.approx(12.0, rel=0.21)
    assert "within the radius in 7" in found.reason


def test_a_longer_line_is_looked_for_where_height_is_missing():
    def probabilities(weight, line):
        return Shares(float(weight >= 10.0), float(weight >= 9.0 * (line or 5.0) / 5.0))

    found = lightest_anchor(probabilities, (WITHIN, CLEAR), 11.0, 5.0)
    assert found.weight is None
    assert found.line_length == pytest.approx(5.0 * 10.0 / 9.0, rel=0.05)


def demanding(tmp_path, *requirements, factor="0.4", **moor):
    """The example, and what it requires of its dive."""
    mission = altered(
        tmp_path, vehicle=[("  drag_coefficient: 0.2", f"  holding_factor: {factor}\n  drag_coefficient: 0.2")]
    )
    data = copy.deepcopy(dict(mission.raw))
    data["phases"][0]["moor"] |= moor
    return Mission.from_data({**data, "requirements": list(requirements)})


HOLDS = {"quantity": "moor.anchor_holds", "probability": 0.95}
HIGH = {"quantity": "moor.lowest_altitude", "at_least": "1.1 m", "probability": 0.9}
INSIDE = {"quantity": "moor.within_radius", "probability": 0.9}
SOFT = {"quantity": "moor.touchdown_speed", "at_most": "1.75 m/s", "probability": 0.8}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("requirements", "factor"),
    [
        ((HOLDS, HIGH, SOFT), "1.5"),
        ((INSIDE, HIGH), "0.4"),
        ((INSIDE,), "0.4"),
        ((INSIDE, HOLDS), "1.5"),
        ((HOLDS,), "0.9"),
    ],
)
def test_the_lightest_anchor_meets_all_requirements_on_its_dive_as_brute_force_has_it(tmp_path, requirements, factor):
    mission = demanding(tmp_path, *requirements, factor=factor)
    check_by_brute_force(mission, size_anchor(mission, trials=60).probable)


def check_by_brute_force(mission, found):
    dives = AnchorTrials(mission, "moor", None, 60, mission.monte_carlo.seed)
    grid = np.geomspace(3.0, 40.0, 15)
    good = (w for w in grid if all(item.met for item in dives.probabilities(float(w)).requirements))
    if (least := next(good, None)) is None:
        assert found.anchor is None
        return
    lightest = found.anchor.wet_weight if found.lighter is None else found.lighter  # of any parts
    assert least / 1.21 <= lightest <= least * 1.06
    assert all(item.met for item in found.anchor.probabilities.requirements)


@pytest.mark.slow
def test_requirements_that_exclude_each_other_are_told_and_fail(tmp_path):
    sizing = size_anchor(demanding(tmp_path, HOLDS, {**HIGH, "at_least": "1.6 m"}), trials=60)
    assert sizing.probable.anchor is None
    assert "moor.anchor_holds" in sizing.probable.reason
    assert "moor.lowest_altitude at least 1.6 m" in sizing.probable.reason
    assert not sizing.succeeds


DEMANDS = (INSIDE, {**HIGH, "at_least": "1.45 m"})


@pytest.fixture(scope="module")
def demanded(tmp_path_factory):
    """What is required of the dive can be met, what is required of the mission cannot."""
    late = {"quantity": "total.duration", "at_most": "10 s", "probability": 0.9}
    folder = tmp_path_factory.mktemp("demanded")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(lightest_anchor.__globals__, "_RESOLUTION", 1.05)
        return size_anchor(demanding(folder, *DEMANDS, late), trials=60)


def test_the_margin_says_what_a_heavier_anchor_misses(demanded):
    sizing = demanded
    lighter, heavier = sizing.probable.margins
    weight = sizing.probable.anchor.wet_weight
    assert (lighter.weight, heavier.weight) == pytest.approx((0.9 * weight, 1.1 * weight))
    assert lighter.misses
    assert any("lowest altitude" in words for words in heavier.misses)


def test_the_lightest_anchor_of_two_demands_is_that_of_brute_force(demanded, tmp_path):
    check_by_brute_force(demanding(tmp_path, *DEMANDS), demanded.probable)


def test_the_headline_is_that_of_the_whole_mission_on_fresh_draws(demanded):
    sizing = demanded
    assert sizing.probable.anchor is not None
    assert sizing.judged.provenance.seed == sizing.provenance.seed + FRESH
    assert sizing.judged.requirements[0].met
    assert not sizing.judged.requirements[2].met
    assert not sizing.succeeds
    assert sizing.summary()["judged"]["requirements_met"] is False


def test_the_worst_case_by_itself_is_the_anchor_sized(mission, quick):
    assert worst_case_anchor(mission) == quick.anchor.wet_weight


def test_the_worst_case_by_itself_reports_what_is_missing():
    with pytest.raises(InputError, match="no mooring"):
        worst_case_anchor(load(MISSIONS / "fig8.yaml"))


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_anchor_that_cannot_hold_is_told(tmp_path):
    slippery = altered(
        tmp_path, vehicle=[("  drag_coefficient: 0.2", "  holding_factor: 0.02\n  drag_coefficient: 0.2")]
    )
    probable = size_anchor(slippery, trials=100, probability=0.6).probable
    assert probable.anchor is None
    assert "an anchor that holds in 0.0 % of dives" in probable.reason


def test_the_vehicle_lies_as_its_centres_say(tmp_path, quick):
    states = quick.trim
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
    bare = ("line_material: polyester   # or nylon, aramid, polyethylene, steel-wire", "line_wet_weight: 0.01 N/m")
    plain = size_anchor(altered(tmp_path, bare), trials=10).summary()["descent"]
    assert not {"snatch_tension_n", "nose_down_time_s", "depth_lost_m"} & set(plain)
    found = size_anchor(altered(tmp_path, stiff, vehicle=[centres]), trials=60)
    summary = found.summary()
    assert summary["descent"]["snatch_tension_n"] == pytest.approx(440.0, abs=2.0)
    assert 1.0 < summary["descent"]["nose_down_time_s"] < 2.0
    assert any("line parts in the nominal dive" in note for note in summary["notes"])
    assert summary["odds"]["within_radius"]["value"] == 0.0


def test_with_two_moorings_the_answer_says_which_one_it_is_for(tmp_path, quick):
    mission = altered(tmp_path, vehicle=[("\nanchor:", "\nanchors: 2\nanchor:")])
    raw = copy.deepcopy(mission.raw)
    first = next(phase for phase in raw["phases"] if "moor" in phase)
    raw["phases"].append({"moor": {**first["moor"], "name": "second", "radius": "20 m"}})
    both = Mission.from_data(raw, file=mission.file)
    answers = {name: size_anchor(both, trials=10, phase=name).summary()["decision"]["do"] for name in (None, "second")}
    assert answers[None].endswith("It is sized for moor alone, not for second.")
    assert answers["second"].endswith("It is sized for second alone, not for moor.")
    assert "sized for" not in quick.summary()["decision"]["do"]


def test_a_spare_anchor_is_as_heavy_as_the_one_that_carries_it_down(tmp_path):
    def at(weight):
        return altered(
            tmp_path,
            ("anchor_wet_weight: sized", f"anchor_wet_weight: {weight}"),
            vehicle=[("\nanchor:", "\nanchors: 2\nanchor:")],
        )

    found = worst_case_anchor(at("sized"))
    assert found > 1.002 * worst_case_anchor(load(MISSIONS / "anchor-design.yaml"))
    assert worst_case_anchor(at(f"{found!r} N")) == pytest.approx(found, rel=1e-9)


def test_what_an_anchor_misses_is_told_in_hundredths_of_its_dives(mission):
    """Of 1000 dives 876 are within the radius, where 950 were asked for, and all are clear of the seafloor."""
    sizer = SimpleNamespace(trials=SimpleNamespace(probabilities=lambda weight: Shares(0.876, 0.0)))
    demands = (replace(WITHIN, required=0.95), CLEAR)
    found = list(AnchorSizer._deviations(sizer, 10.0, demands))
    assert [each.weight for each in found] == pytest.approx([9.0, 11.0])
    assert {each.misses for each in found} == {("within the radius: 87.6 % of 95 %",)}


def test_fixes_of_dives_err_by_their_own_stream(tmp_path):
    """In still water all else is alike: the anchor lies off the fix by the error, drawn from the mooring's fix."""
    mission = altered(
        tmp_path, ("site:", "navigation: {velocity_error: {sigma: 0 m/s}, surfacing_time: 60 s, fix_error: 7 m}\nsite:")
    )
    still = mission.with_(**{"site.current": None, "moor.design_current": None})
    trials = AnchorTrials(still, still.moors[0].name, None, 64, 5)
    normals = stream(5, f"{still.moors[0].name}.fix", 0).standard_normal((2, 64))
    offset = trials.probabilities(60.0).offset
    assert (offset.mean, offset.sd) == pytest.approx(
        (np.hypot(*7.0 * normals).mean(), np.hypot(*7.0 * normals).std(ddof=1)), rel=1e-6
    )
