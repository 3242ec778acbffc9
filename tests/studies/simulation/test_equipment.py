"""Equipment that fails, against the laws' closed forms and published survival."""

import json
import math

import numpy as np
import pytest
import yaml
from test_over_ground import MISSION, failing

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.montecarlo.reliability import Exposure, age_at_chance, age_weibull, rate_of_counts
from missionplan.phases.hooks import TrialState
from missionplan.results.failures import Failure
from missionplan.studies.simulation.overdue import _first_failures
from missionplan.studies.simulation.phase_trials import PhaseTrials
from missionplan.studies.simulation.simulate import simulate_block
from missionplan.studies.simulation.trial_block import Part
from missionplan.studies.simulation.trial_block import failing as with_failures

Z = np.random.default_rng(1).standard_normal(200_000)
OTHER = np.random.default_rng(2).standard_normal(200_000)


@pytest.fixture
def with_hazards(tmp_path):
    def make(*hazards, **moor):
        data = json.loads(json.dumps(MISSION))
        del data["site"]["bathymetry"]
        data["site"]["depth"] = "40 m"
        data["vehicle"]["reliability"] = list(hazards)
        data["phases"][1]["moor"] |= moor
        (tmp_path / "m.yaml").write_text(yaml.safe_dump(data))
        return load(tmp_path / "m.yaml")

    return make


def test_a_weibull_law_has_its_survival_and_a_chance_its_geometric_law():
    age = age_weibull(0.7, 100.0, Z)
    for t in (10.0, 100.0, 300.0):
        assert np.mean(age > t) == pytest.approx(math.exp(-((t / 100.0) ** 0.7)), abs=0.004)
    count = np.ceil(age_at_chance(0.2, Z))
    for k in (1, 2, 5):
        assert np.mean(count > k) == pytest.approx(0.8**k, abs=0.004)
    assert count.min() == 1.0


def test_counts_give_a_gamma_rate_and_pareto_survival():
    rate = rate_of_counts(3.0, 1200.0, Z)
    assert rate.mean() == pytest.approx(3.5 / 1200.0, rel=0.01)
    assert rate.var() == pytest.approx(3.5 / 1200.0**2, rel=0.02)
    assert np.mean(np.exp(-rate * 200.0)) == pytest.approx((1.0 + 200.0 / 1200.0) ** -3.5, abs=0.002)  # Lomax


# survival, days, and how many deployments stand behind it: Brito, Smeed & Griffiths 2014; Rudnick, Davis & Sherman 2016
PUBLISHED = [(0.50, 90.0, 205), (0.59, 30.0, 205), (0.83, 100.0, 200)]


@pytest.mark.parametrize(
    ("survival", "days", "deployments"),
    [PUBLISHED[0], *(pytest.param(*each, marks=pytest.mark.slow) for each in PUBLISHED[1:])],
)
def test_published_survival_comes_out_within_its_interval(with_hazards, survival, days, deployments):
    rate = -math.log(survival) / days
    mission = with_hazards({"per": "hour", "rate": f"{rate} 1/d", "source": "as published"}, hold=f"{days} d")
    block = simulate_block(mission, seed=4, block=0, trials=4000)
    kept = 1.0 - sum(count for step, count in failing(block).items() if "equipment" in step) / 4000.0
    half = 1.96 * math.sqrt(survival * (1.0 - survival) / deployments)
    assert survival - half < kept < survival + half
    assert kept == pytest.approx(survival, abs=0.025)


@pytest.mark.parametrize(
    ("hazard", "phase", "share"),
    [
        ({"per": "release", "rate": 0.3}, "moor", 0.3),
        ({"per": "wake-up", "rate": 0.3}, "moor", 0.3),
        ({"per": "dive", "shape": 20.0, "scale": 1.0}, "out", 1.0),
        ({"per": "surfacing", "rate": 1.0}, "out", 1.0),
        ({"per": "km", "rate": "0.3 1/km"}, "out", 1.0 - math.exp(-0.3)),
        ({"per": "release", "failures": 40, "exposure": 100}, "moor", 1.0 - (1.0 + 1.0 / 100.0) ** -40.5),
    ],
)
def test_each_hazard_strikes_where_it_is_met(with_hazards, hazard, phase, share):
    block = simulate_block(with_hazards(hazard), seed=2, block=0, trials=2000)
    arrived = block.phases[0].events["arrived"].mean() if phase == "moor" else 1.0
    found = failing(block)[f"{phase}: equipment"] / 2000.0
    assert found == pytest.approx(share * arrived, abs=0.04)
    assert not block.success[block.phases[phase == "moor"].failures[Failure.EQUIPMENT]].any()


def test_without_reliability_nothing_changes_and_with_none_that_strikes_neither(with_hazards):
    without = simulate_block(with_hazards(), seed=2, block=0, trials=300)
    never = simulate_block(with_hazards({"per": "hour", "rate": "0 1/h"}), seed=2, block=0, trials=300)
    assert (without.success == never.success).all()
    for name, values in without.total.items():
        assert np.array_equal(values, never.total[name], equal_nan=True)


def test_what_a_failure_leaves_is_kept_apart_for_the_search(with_hazards):
    hazards = ({"per": "wake-up", "rate": 0.2}, {"per": "surfacing", "rate": 0.1, "leaves": "sunk"})
    block = simulate_block(with_hazards(*hazards), seed=2, block=0, trials=1000)
    missing = np.isnan(block.total["duration_s"])
    reasons = {(phase, reason) for (phase, reason), _ in _first_failures(block, missing)}
    assert {("moor", "equipment, moored"), ("out", "equipment, sunk")} <= reasons


def test_of_two_hazards_in_a_phase_that_leaves_what_it_leaves_which_strikes_first():
    def part(per, leaves, *ages):
        return Part(per, leaves, np.array(ages))

    parts = (
        part(
            "dive", "sunk", 2.1, 2.1, 3.5, 9.0, 2.0
        ),  # of four in the phase, after two: the 3rd at 1/4, the 4th at 2/4
        part("hour", "adrift", 150.0, 120.0, 160.0, 201.0, 100.0),  # of 100 s in the phase, after 100 s
    )
    begun, none = TrialState.at(np.zeros(2), 5), np.full(5, np.nan)
    met = Exposure(time=100.0, dives=4.0)
    found = PhaseTrials(
        "out", "transit", {"legs": np.arange(5.0)}, {"arrived": np.ones(5, dtype=bool)}, {}, none, np.ones(5), {},
        np.zeros((2, 5)), none, none, none, none, 0.0, {}, exposure=met,
    )  # fmt: skip
    after, found, exposure = with_failures(parts, Exposure(time=100.0, dives=2.0), begun, begun, found)
    assert np.flatnonzero(found.left["sunk"]).tolist() == [0, 2]
    assert np.flatnonzero(found.left["adrift"]).tolist() == [1]
    assert after.alive.tolist() == found.events["arrived"].tolist() == [False, False, False, True, True]
    assert (
        np.isnan(found.quantities["legs"]).tolist() == np.isnan(found.end).tolist() == [True, True, True, False, False]
    )
    assert (exposure.time, exposure.dives) == (200.0, 6.0)
    assert np.exp(found.margins[Failure.EQUIPMENT]) == pytest.approx([2.1 / 6, 2.1 / 6, 3.5 / 6, 201 / 200, 2 / 6])


@pytest.mark.parametrize(
    ("hazard", "words"),
    [
        ({"per": "hour", "rate": 1e-4}, "1/s|unit"),
        ({"per": "hour"}, "one of rate"),
        ({"per": "hour", "rate": "1e-4 1/h", "failures": 3, "exposure": 100}, "one of rate"),
        ({"per": "dive", "failures": 3}, "exposure"),
        ({"per": "week", "rate": 0.1}, "per"),
        ({"per": "dive", "rate": 1.5}, "at most 1"),
        ({"per": "hour", "rate": "1e-4 1/h", "leaves": "gone"}, "leaves"),
    ],
)
def test_a_hazard_that_cannot_be_meant_is_refused(with_hazards, hazard, words):
    with pytest.raises(InputError, match=words):
        with_hazards(hazard)
