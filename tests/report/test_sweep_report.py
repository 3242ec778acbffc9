"""What the report of a sweep recommends where not every trial arrives."""

import pytest

from missionplan.mission import load
from missionplan.montecarlo.statistics import wilson
from missionplan.report.render import terminal_view
from missionplan.results.base import Provenance
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.leg_length.sweep_page import page
from missionplan.studies.leg_length.sweep_result import Sweep, SweepCurve, SweepPoint

pytestmark = pytest.mark.usefixtures("unassumed")

AGAINST_THE_CURRENT = """
name: Against the current
site:
  depth: 20 m
  current: [{{down_to: 20 m, speed: {{mean: 0.3 m/s, sd: 0.06 m/s}}, toward: 270 deg}}]
navigation: {{velocity_error: {{sigma: 0.02 m/s}}, surfacing_time: 60 s, max_legs: 40}}
phases:
  - transit: {{name: out, from: [0 m, 0 m], to: [2 km, 0 m], speed: 0.35 m/s, d_max: 1 km, arrival_radius: 60 m}}
sweep: {{d_max: [500 m, 1 km, 2 km]}}
monte_carlo: {{trials: 400, seed: 2}}
{more}
"""


def point(d_max, cost, arrived, trials=500):
    return SweepPoint(
        d_max=d_max,
        d_max_over_distance=d_max / 1000.0,
        cost=cost,
        standard_error=0.001,
        sd=0.02,
        surfacings=2.0,
        arrived=wilson(arrived, trials),
        cost_analytic=None,
        excess_error=0.001,
        as_good=False,
    )


def sweep(*points, required=0.99, best=0):
    curve = SweepCurve(0.05, points, best, points[-1], None, required, 1000.0)
    provenance = Provenance("sweep-dmax", "Bay", "bay.yaml", 1, 500, elapsed_s=0.1)
    return Sweep(provenance, "out", "monte-carlo", 1000.0, 1.0, 60.0, 20.0, (curve,))


def test_the_cheapest_d_max_that_arrives_often_enough_is_recommended():
    found = sweep(point(400.0, 0.10, 496), point(700.0, 0.20, 500), point(1000.0, 0.30, 500), required=0.995)
    entry = found.summary()["sweep"][0]
    assert entry["best"]["d_max_m"] == 400.0
    assert (entry["recommended"]["d_max_m"], entry["recommended"]["reaches_required_arrival"]) == (700.0, True)
    assert page(found).answer.startswith("Choose d_max = 700\u00a0m")
    assert terminal_view(found).verdict == page(found).verdict == ""


def test_means_of_those_that_arrive_say_of_how_many():
    answer = page(sweep(point(400.0, 0.10, 497), point(1000.0, 0.30, 500))).answer
    assert "of the 99.4\u00a0% that arrive" in answer


def test_without_a_d_max_that_arrives_often_enough_the_likeliest_is_named():
    found = sweep(point(400.0, 0.10, 370), point(700.0, 0.50, 380), point(1000.0, 0.70, 200))
    entry = found.summary()["sweep"][0]["recommended"]
    assert (entry["d_max_m"], entry["reaches_required_arrival"]) == (700.0, False)
    answer = page(found).answer
    assert "no d_max of this sweep arrives as often as 99\u00a0%" in answer
    assert "of the 76\u00a0% that arrive is 25.0\u00a0min" in answer
    assert "Choose" not in answer
    assert terminal_view(found).verdict == page(found).verdict == "bad"


@pytest.mark.parametrize(
    ("more", "required"), [("", 0.99), ("requirements: [{quantity: out.arrived, probability: 0.2}]", 0.2)]
)
def test_the_missions_requirement_on_arrival_is_the_one_that_counts(tmp_path, more, required):
    path = tmp_path / "against.yaml"
    path.write_text(AGAINST_THE_CURRENT.format(more=more), encoding="utf-8")
    curve = sweep_dmax(load(path)).curves[0]
    assert curve.required_arrival == required
    assert max(point.arrived.value for point in curve.points) < 0.99
    assert curve.reaches(curve.recommended) is (required == 0.2)
