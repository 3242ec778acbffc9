"""Rare failures of missions whose probability is known otherwise."""

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.integrate import trapezoid
from scipy.special import ive
from typing_extensions import override

import missionplan
from missionplan.arrays import Array
from missionplan.cli import main
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.rare_events import Key, NormalPopulation
from missionplan.montecarlo.rare_events.strata import StrataView, strata
from missionplan.montecarlo.streams import BLOCK, LegNormals, stream
from missionplan.report.quantities import reading_in
from missionplan.report.wording import phase_in_words
from missionplan.scenario.scenario import Scenario
from missionplan.studies.rare_failure import Cause, failure_modes, find_rare_failure
from missionplan.studies.rare_failure.driven_trials import (
    DrivenMission,
    RareEvent,
    discrete_values,
    units_of_inputs,
    variation_asked,
)
from missionplan.studies.rare_failure.page import _value, event_in_words
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.simulation.trial_block import run_block
from tests.fuzz import examples

STARTER = Path(missionplan.__file__).parent / "starter" / "mission.yaml"
TRANSIT = """
name: Legs to the goal
navigation:
  velocity_error: {{sigma: {sigma} m/s}}
  surfacing_time: 60 s
  max_legs: {legs}
phases:
  - transit: {{from: [0 m, 0 m], to: [800 m, 0 m], speed: 1.5 m/s, d_max: {d_max} m, arrival_radius: {radius} m}}
monte_carlo: {{trials: 1000, seed: 1}}
"""


def transit(folder: Path, *, sigma: float, legs: int, d_max: float, radius: float) -> Mission:
    path = folder / "transit.yaml"
    path.write_text(TRANSIT.format(sigma=sigma, legs=legs, d_max=d_max, radius=radius), encoding="utf-8")
    return missionplan.load(path)


def missed_after_four_legs(sigma: float, trials: int, seed: int) -> int:
    """Count the trials of Eqs. 18–20 that are not within 15 m of a goal 800 m away after four legs of 300 m."""
    generator, missed = np.random.default_rng(seed), 0
    for done in range(0, trials, 200_000):
        place = np.zeros((2, min(200_000, trials - done)))
        place[0] = -800.0
        for _ in range(4):
            left = np.hypot(*place)
            place = place[:, left >= 15.0]
            left = left[left >= 15.0]
            length = np.minimum(left, 300.0)
            place = place * (1.0 - length / left) + generator.standard_normal(place.shape) * (sigma * length / 1.5)
        missed += int(np.count_nonzero(np.hypot(*place) >= 15.0))
    return missed


def rice(distance: Array, mean: Array | float, sd: Array | float) -> Array:
    """Density of the distance of a place with normal errors `sd` on each axis about one at a distance `mean`."""
    return distance / sd**2 * np.exp(-0.5 * ((distance - mean) / sd) ** 2) * ive(0, distance * mean / sd**2)


def missed_by_quadrature(sigma: float) -> float:
    """Return the probability of the same miss: each distance from the goal follows Rice's distribution."""
    scale = sigma / 1.5  # of the error, per metre of the leg
    first = np.linspace(500.0 - 1800.0 * sigma, 500.0 + 1800.0 * sigma, 301)
    second, third = np.linspace(15.0, 500.0, 600), np.linspace(15.0, 400.0, 600)  # finer: 3 in a million less
    density = rice(first, 500.0, 300.0 * scale)
    density = trapezoid(density * rice(second[:, None], first - 300.0, 300.0 * scale), first)
    legs = np.minimum(second, 300.0)
    density = trapezoid(density * rice(third[:, None], second - legs, legs * scale), second)
    last = np.exp(-0.5 * (15.0 / (third * scale)) ** 2)  # it ends at the goal but for its error
    return float(trapezoid(density * np.where(third < 300.0, last, 1.0), third))


def test_one_leg_in_a_million_misses_as_often_as_rayleigh_says(tmp_path: Path) -> None:
    sigma, radius = 0.03, 84.1
    truth = math.exp(-0.5 * (radius / (sigma * 800.0 / 1.5)) ** 2)
    assert 0.9e-6 < truth < 1.1e-6
    found = find_rare_failure(transit(tmp_path, sigma=sigma, legs=1, d_max=1000.0, radius=radius), trials=200_000)
    assert found.provenance.trials <= 200_000
    assert found.variation <= 0.10
    assert found.probability.value == pytest.approx(truth, rel=3.0 * found.variation)
    assert [mode.step for mode in found.modes] == ["transit: not arrived"]
    assert found.plain_trials > 5e7


def test_legs_that_depend_on_each_other_miss_as_often_as_in_a_plain_loop_and_by_quadrature(tmp_path: Path) -> None:
    truth = missed_by_quadrature(0.14)
    assert missed_after_four_legs(0.14, 1_000_000, seed=1) == pytest.approx(
        1e6 * truth, abs=3.0 * math.sqrt(1e6 * truth)
    )
    found = find_rare_failure(transit(tmp_path, sigma=0.14, legs=4, d_max=300.0, radius=15.0), trials=120_000)
    assert found.probability.value == pytest.approx(truth, rel=3.0 * found.variation)


@pytest.mark.slow
def test_a_miss_in_two_million_is_found_as_quadrature_has_it(tmp_path: Path) -> None:
    truth = missed_by_quadrature(0.097)
    assert 5.1e-7 < truth < 5.3e-7
    found = find_rare_failure(transit(tmp_path, sigma=0.097, legs=4, d_max=300.0, radius=15.0), trials=200_000, seed=2)
    assert found.variation <= 0.12
    assert found.probability.value == pytest.approx(truth, rel=3.0 * found.variation)


@pytest.mark.slow
def test_one_in_a_million_agrees_with_a_hundred_million_plain_trials(tmp_path: Path) -> None:
    missed = missed_after_four_legs(0.097, 100_000_000, seed=7)
    mission = transit(tmp_path, sigma=0.097, legs=4, d_max=300.0, radius=15.0)
    runs = [find_rare_failure(mission, seed=seed, trials=200_000, precision="0.5%") for seed in range(1, 9)]
    assert np.mean([each.variation for each in runs]) <= 0.10
    mean = float(np.mean([each.probability.value for each in runs]))
    assert mean * 1e8 / missed == pytest.approx(1.0, abs=0.2 + 1.0 / math.sqrt(missed))


@pytest.mark.slow
def test_a_failure_that_is_not_rare_is_the_plain_simulation_s() -> None:
    data = yaml.safe_load(STARTER.read_text(encoding="utf-8"))
    data["vehicle"] = yaml.safe_load((STARTER.parent / "vehicle.yaml").read_text(encoding="utf-8"))
    data["navigation"]["max_legs"] = 8  # else trials are driven towards transits of 400 legs too
    mission = Mission.from_data(data)
    plain = simulate(mission, trials=4096, sheet=False).phases[1].events["within_radius"]
    found = find_rare_failure(mission, event="not moor.within_radius", trials=20_000)
    assert 1.0 - plain.high < found.probability.value < 1.0 - plain.low
    assert found.modes[0].step == "moor: anchor outside the radius"


def test_neither_processes_nor_threads_change_the_result(tmp_path: Path) -> None:
    mission = transit(tmp_path, sigma=0.14, legs=4, d_max=300.0, radius=15.0)
    one = find_rare_failure(mission, trials=60_000)
    two = find_rare_failure(mission, trials=60_000, jobs=2, backend="threading")
    assert one.summary()["rare"] == two.summary()["rare"]
    assert one.sample.equals(two.sample)
    assert find_rare_failure(mission, trials=60_000, seed=2).probability != one.probability


class _OfStreams(NormalPopulation):
    """The normals of the first block of a run."""

    @override
    def _draw(self, key: Key, rows: int) -> Array:
        name, leg = key
        if name.endswith(" by leg"):
            return LegNormals(1, name.removesuffix(" by leg"), 0).leg(leg)
        return stream(1, name, 0).standard_normal((rows, BLOCK))


def test_a_mission_driven_by_a_run_s_own_normals_repeats_the_run() -> None:
    means = Scenario.at_means(missionplan.load(STARTER))
    driven = DrivenMission(means, RareEvent("not total.success", "total.success", negated=True))
    _, trials = driven.run(StrataView(_OfStreams(BLOCK, np.random.default_rng(0))), inputs=True)
    plain = run_block(means.sampled(seed=1, block=0), 1, 0, BLOCK)
    for name, values in plain.columns().items():
        assert np.array_equal(values, trials.columns()[name], equal_nan=values.dtype.kind == "f"), name


@pytest.mark.parametrize(
    ("event", "expected"),
    [
        ("total.success", "not total.success"),
        ("not moor.struck_seafloor", "expected moor.struck_seafloor"),
        ("moor.ofset > 3 m", "offset"),
        ("moor.offset", "give the limit"),
        ("moor.offset > 3", "unit"),
        ("total.success > 3", "has no limit"),
        ("morr.offset > 3 m", "moor"),
        ("", "such as"),
    ],
)
def test_an_event_that_is_no_failure_is_refused(event: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        RareEvent.parse(event, missionplan.load(STARTER))
    assert expected in str(caught.value)


@pytest.mark.parametrize("name", ["moor 1.5 m, first", "moor"])
def test_an_event_of_a_phase_of_any_name_is_that_of_its_column(name: str) -> None:
    mission = missionplan.load(STARTER)
    place = [phase.kind for phase in mission.phases].index("moor")
    mission = mission.with_({f"phases[{place}].moor.name": name, "requirements": []})
    key = name if name == "moor" else f"phases[{place}]"
    event = RareEvent.parse(f"{name}.offset>30 m", mission)
    assert (event.text, event.key, event.limit) == (f"{key}.offset > 30 m", f"{key}.offset_m", 30.0)
    assert event_in_words(event.text) == f"offset of the anchor ({phase_in_words(key)}) above 30 m"
    assert RareEvent.parse(f"{name}.struck_seafloor", mission).key == f"{key}.struck_seafloor"


def test_a_quantity_beyond_its_limit_is_found(tmp_path: Path) -> None:
    mission = transit(tmp_path, sigma=0.1, legs=400, d_max=300.0, radius=15.0)
    found = find_rare_failure(mission, event="transit.duration > 15 min", trials=60_000)
    assert found.sample["transit.duration_s"].min() > 900.0
    assert 0.0 < found.probability.value < 0.02


def test_a_failure_to_which_nothing_leads_is_not_made_up(tmp_path: Path) -> None:
    found = find_rare_failure(transit(tmp_path, sigma=0.001, legs=400, d_max=300.0, radius=15.0))
    assert not found.reached
    assert found.probability.value == 0.0
    assert found.probability.high > 1e-4
    assert "No failure" in missionplan.rendering.render(found).html


def test_an_explanation_of_known_probability_is_found_though_no_plain_trial_meets_it() -> None:
    """Under it the legs make two fifths of their way: such transits last for more than 20 minutes, no others do."""
    data = yaml.safe_load(TRANSIT.format(sigma=0.001, legs=400, d_max=300.0, radius=15.0))
    data["effects"] = [
        {"one-of": [{"probability": 1e-5, "effects": [{"speed-scale": {"fraction": -0.6}}]}]},
    ]
    mission = Mission.from_data(data)
    parts = strata(discrete_values(mission, Scenario.at_means(mission)))
    assert [part.probability for part in parts] == pytest.approx([1.0 - 1e-5, 1e-5], rel=1e-9)
    found = find_rare_failure(mission, event="transit.duration > 20 min", trials=20_000)
    assert found.probability.value == pytest.approx(1e-5, rel=0.01)


def test_an_anchor_that_floods_too_early_once_in_a_million_is_a_stratum_of_its_own() -> None:
    data = yaml.safe_load(STARTER.read_text(encoding="utf-8"))
    data["vehicle"] = yaml.safe_load((STARTER.parent / "vehicle.yaml").read_text(encoding="utf-8"))
    data["vehicle"]["anchor"] |= {"premature_flooding": 1e-6}
    mission = Mission.from_data(data)
    parts = strata(discrete_values(mission, Scenario.at_means(mission)))
    assert [part.probability for part in parts] == pytest.approx([1.0 - 1e-6, 1e-6], rel=1e-6)
    means = Scenario.at_means(mission)
    driven = DrivenMission(means, RareEvent.parse("not moor.within_radius", mission), ())
    flooded, usual = (
        driven(StrataView(NormalPopulation(64, np.random.default_rng(1)), [part])).failed for part in parts[::-1]
    )
    assert flooded.all()
    assert not usual.all()


def test_the_command_writes_the_report_and_refuses_what_does_not_apply(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def status(*words: str) -> object:
        command = ["missionplan", "simulate", "transit.yaml", "--jobs", "1", "--trials", "60000", "--rare", *words]
        monkeypatch.setattr(sys, "argv", command)
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code

    monkeypatch.chdir(tmp_path)
    transit(tmp_path, sigma=0.14, legs=4, d_max=300.0, radius=15.0)
    assert status("--json", "--out", "out") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["rare"]["event"] == "not total.success"
    assert {"report.html", "summary.json", "rare.csv", "failures.csv"} <= {p.name for p in (tmp_path / "out").iterdir()}
    again = "missionplan simulate transit.yaml --rare &#39;not total.success&#39; --seed 1 --trials 60000"
    assert again in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert status("--resume") == 2
    assert "--resume" in capsys.readouterr().err


def test_what_is_unlike_usual_is_said_in_its_declared_unit_and_the_readers():
    data = examples.mission("rich")
    data["effects"].append(
        {
            "tidal-current": {
                "m2_east": {"mean": "0.1 m/s", "sd": "0.01 m/s"},
                "m2_east_phase": {"mean": "60 deg", "sd": "6 deg"},
            }
        }
    )
    data["vehicle"]["anchor"]["flooded_mass"] = {"mean": "2.6 kg", "sd": "0.1 kg"}
    mission = Mission.from_data(data)
    trials = run_block(Scenario.at_means(mission), 1, 0, 20)
    inputs = trials.inputs()
    units = units_of_inputs(mission, inputs)
    assert units["vehicle.anchor.flooded_mass"] == "kg"
    assert units["effects.compass-bias.angle"] == units["effects.tidal-current.m2_east_phase"] == "rad"
    assert units["ingress.velocity_error.across"] == units["effects.mean-current.north"] == "m/s"
    assert units["ingress.fix_error.along"] == units["site.depth"] == "m"
    assert {name for name, unit in units.items() if not unit} == {
        name for name in inputs if name.endswith((".fraction", ".hypothesis", "one-of"))
    }
    for name, drawn in mission.quantities().items():
        if units.get(name) and not name.startswith(("effects", "site.")):
            mean = float(mean_of(drawn))
            assert mission.with_({name: f"{mean!r} {units[name]}"}).quantities()[name] == mean
    turned, swift = Cause("", 0.3, 0.0, 0.05, "rad"), Cause("", 0.25, 0.1, 0.02, "m/s")
    with reading_in("nautical"):
        assert [_value(turned, 0.3), _value(swift, 0.25)] == ["17.19°", "0.4860\xa0kn"]


def test_what_is_unlike_usual_is_weighed_and_drawn_in_half_of_the_failures_or_more() -> None:
    """Of failures with weights 1 and 3, and a third in a hundred of them: usual is 0 with a standard deviation of 1."""
    nan, usual = np.nan, {name: np.array([-1.0, 1.0]) for name in "abcd"} | {"e": np.array([2.0, 2.0])}
    drawn = {"a": [0.0, 4.0, 0.0], "b": [nan, 9.0, 0.0], "c": [9.0, nan, 0.0], "d": [0.4] * 3, "e": [9.0] * 3}
    inputs = {name: np.array(values) for name, values in drawn.items()}
    (found,) = failure_modes(
        np.array([1.0, 3.0, 0.04]), np.array(["out", "out", "moor"]), inputs, usual, dict.fromkeys("abcde", "m")
    )
    assert (found.step, found.share) == ("out", pytest.approx(4.0 / 4.04))
    assert [(each.source, each.mean, each.shift, each.unit) for each in found.causes] == [
        ("b", 9.0, 9.0, "m"),
        ("a", 3.0, 3.0, "m"),
    ]


@pytest.mark.parametrize(
    ("precision", "value"), [(None, 0.1), ("5%", 0.05), (" 0.05 ", 0.05), ("30 %", 0.3), ("100%", None), ("0", None)]
)
def test_the_precision_asked_for_is_a_share_or_a_percentage(precision: str | None, value: float | None) -> None:
    if value is not None:
        assert variation_asked(precision) == pytest.approx(value)
    else:
        with pytest.raises(InputError, match="expected a coefficient of variation"):
            variation_asked(precision)
