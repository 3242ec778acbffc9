"""The report of a plan of legs: what a mission file takes over, and what is left out where nothing adapts."""

from dataclasses import replace

import numpy as np
import pytest

from missionplan.mission import load
from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.report.leg_length.plan import page
from missionplan.report.page import Figure, Listing, Table
from missionplan.results.leg_cases import CandidatePlan
from missionplan.studies.leg_length.plan_legs import plan_legs

MISSION = """
name: Legs
navigation: {velocity_error: {sigma: 0.05 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: in, from: [0 m, 0 m], to: [3 km, 1 km], speed: 1 m/s, d_max: 1 km, arrival_radius: 50 m}
monte_carlo: {trials: 400, seed: 5}
"""


@pytest.fixture(scope="module")
def adaptive(tmp_path_factory):
    path = tmp_path_factory.mktemp("legs") / "legs.yaml"
    path.write_text(MISSION, encoding="utf-8")
    return plan_legs(load(path))


@pytest.fixture(scope="module")
def fixed(adaptive):
    return replace(adaptive, left=np.array([50.0]), leg=np.array([693.25]), speed=0.845, mission_speed=1.0)


def blocks(plan, kind):
    return [block for section in page(plan).sections for block in section.blocks if isinstance(block, kind)]


def test_a_table_is_given_a_knot_a_line(adaptive):
    (listing,) = blocks(adaptive, Listing)
    assert listing.text.splitlines()[:2] == ["d_max:", "  table:"]
    assert len(listing.text.splitlines()) == 2 + adaptive.left.size


def test_a_fixed_d_max_is_given_as_a_length_with_the_speed_chosen(fixed):
    (listing,) = blocks(fixed, Listing)
    assert listing.text.splitlines() == ["speed: 0.845 m/s", "d_max: 693.2 m"]
    transit = fixed.mission_with_legs()["phases"][0]["transit"]
    assert (transit["speed"], transit["d_max"]) == ("0.845 m/s", "693.2 m")


def test_two_plans_are_set_beside_each_other_only_where_there_are_two(adaptive, fixed):
    assert [figure.name for figure in blocks(adaptive, Figure)] == ["tracks", "robustness"]
    assert [figure.name for figure in blocks(fixed, Figure)] == ["tracks"]
    assert {len(table.columns) for table in blocks(fixed, Table)} == {2, 5}
    assert all("able" not in head for table in blocks(fixed, Table) for head in table.columns)


def test_an_aim_of_energy_is_judged_by_energy(adaptive):
    case = replace(adaptive.cases[0], energy_saving=7200.0, energy_saving_error=360.0)
    energy = Statistic(36e3, 3600.0, 30e3, 36e3, 42e3, 36.0, 400)
    rival = CandidatePlan("rival", 1.0, Statistic.of_constant(3600.0, 400), energy, wilson(400, 400), 36e3, 36.0)
    plan = replace(adaptive, aim="energy", cases=(case,), candidates=(rival,) * 4)
    assert plan.recommended
    (table,) = (table for table in blocks(plan, Table) if table.columns[0] == "Errors")
    assert table.columns[-1] == "Energy saved (W\u202fh)"
    assert table.rows[0][-1] == "2.00\u00a0±\u00a00.10"
    assert not replace(plan, cases=(replace(case, energy_saving=500.0),)).recommended
