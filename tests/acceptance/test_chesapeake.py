"""Briggs et al., section VI.B: the full-system test in the Chesapeake Bay, performed twice.

1600 m in with at most 350 m between fixes, arrival within the CEP, moored at 40 ft for 20 minutes, 1600 m out. The
paper gives no numbers beyond these; current, errors and the CEP's radius of 15 m are the example's.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from missionplan.mission import load
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor import size_anchor
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.simulation.trial_block import run_block

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"


@pytest.fixture(scope="module")
def mission():
    return load(MISSION)


@pytest.fixture(scope="module")
def outcome(mission):
    return simulate(mission, trials=4096, sheet=False)


def test_both_tests_arrived_as_nearly_all_trials_do(outcome):
    ingress = outcome.phases[0]
    assert ingress.events["arrived"].low ** 2 > 0.99  # twice
    assert ingress.quantities["arrival_error_m"].p95 < 15.0


def test_legs_between_fixes_are_at_most_350_m(mission):
    scenario = Scenario.at_means(mission).sampled(seed=1, block=0, size=500)
    track = run_block(scenario, 1, 0, 500, tracked=500).phases[0].track
    dived, surfaced = track[0:-1:2], track[1::2]
    over_ground = np.hypot(*np.moveaxis(surfaced - dived, 1, 0))
    # the first leg is 350 m through the water; the mean current carries it on for the 233 s that it takes
    carried = 0.4 * 0.514444 * 350.0 / 1.5
    expected = math.hypot(350.0 + carried * math.sin(math.radians(60.0)), carried * math.cos(math.radians(60.0)))
    assert np.median(over_ground[0]) == pytest.approx(expected, abs=3.0)
    assert np.nanmax(over_ground) < 350.0 + 350.0 / 1.5 * 0.5
    legs = np.count_nonzero(np.isfinite(surfaced[:, 0]), axis=0)
    assert legs.min() >= math.floor(1600.0 / 420.0)
    assert np.median(legs) == 5


def test_it_moors_at_40_ft_for_20_minutes_and_more(mission):
    columns = simulate_block(mission, seed=1, block=0, trials=1000).columns()
    held = columns["moor.duration_s"] - sum(
        columns[f"moor.{part}_s"] for part in ("release_time", "descent_time", "ascent_time")
    )
    assert held - columns["moor.galvanic_release"] == pytest.approx(1200.0 + 90.0)
    assert np.all(columns["moor.lowest_altitude_m"] > 0.3)
    assert Scenario.at_means(mission).mooring.depth == pytest.approx(12.192)


def test_the_mission_meets_its_requirements(outcome):
    assert outcome.requirements_met
    assert outcome.total.events["success"].low > 0.99
    assert outcome.phases[2].events["arrived"].low > 0.99


def test_the_anchor_stays_within_the_radius_as_often_as_the_sizing_found():
    """Eq. 1 leaves out release, pay-out and acceleration, but takes the worst currents as aligned."""
    design = load(MISSION.with_name("anchor-design.yaml"))
    promised = size_anchor(design, trials=4096).anchor.probabilities
    found = simulate(design, trials=4096, seed=7, sheet=False).phases[0]
    within, offset = found.events["within_radius"], found.quantities["offset_m"]
    assert 0.8 < within.value < 0.97  # not the certainty that a worst case suggests
    assert abs(within.value - promised.within.value) < 4.0 * math.sqrt(2.0 * 0.07 * 0.93 / 4096)
    assert offset.mean == pytest.approx(promised.offset.mean, abs=6.0 * offset.standard_error)
    # three standard errors of the difference of two normal 95 % quantiles, each 2.11 sd / sqrt(4096)
    assert offset.p95 == pytest.approx(promised.offset.p95, abs=3.0 * math.sqrt(2.0) * 2.11 * offset.sd / 64.0)
