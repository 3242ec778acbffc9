"""`optimise` and `explore` on a small mission, against a plain loop of simulations of every choice."""

import itertools
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.studies.optimisation.evaluations import Demand, Evaluation, is_feasible, violations
from missionplan.studies.simulation.simulate import simulate_block

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[3] / "missions"
TRIALS, SEED = 1024, 3
SPEEDS = ["0.8 m/s", "1.1 m/s", "1.4 m/s", "1.7 m/s"]
LENGTHS = ["250 m", "650 m", "1700 m"]
ALL = list(itertools.product(SPEEDS, LENGTHS))
CHOOSE = ["out.speed=0.8:1.7:0.3 m/s", f"out.d_max={','.join(LENGTHS)}"]


def mission(minutes, speed="1 m/s", d_max="300 m", arrive=0.6):
    """To a goal 1600 m away in so many minutes, by at most four legs, which short ones do not suffice for."""
    whole = missionplan.load(MISSIONS / "chesapeake.yaml").raw
    way = {"name": "out", "from": ["0 m", "0 m"], "to": ["1600 m", "0 m"], "depth": "2 m", "arrival_radius": "25 m"}
    return Mission.from_data(
        {
            "vehicle": whole["vehicle"],
            "site": whole["site"],
            "navigation": {**whole["navigation"], "max_legs": 4},
            "phases": [{"transit": {**way, "speed": speed, "d_max": d_max}}],
            "requirements": [
                {"quantity": "out.arrived", "probability": arrive},
                {"quantity": "total.duration", "at_most": f"{minutes} min", "probability": 0.95},
            ],
            "monte_carlo": {"trials": TRIALS, "seed": SEED},
        }
    )


@pytest.fixture(scope="module")
def alone():
    """Every choice simulated by itself."""
    return {choice: missionplan.simulate(mission(30.0, *choice), sheet=False).total for choice in ALL}


def cost(alone, choice, aim):
    return alone[choice].quantities[f"{aim}_{'wh' if aim == 'energy' else 's'}"].mean


@pytest.fixture(scope="module")
def tight(alone):
    """Minutes that the choice of least energy that arrives by 27 min keeps only if they were 1 % more."""
    slowest = ("1.1 m/s", "650 m")
    in_time = [choice for choice in ALL if alone[choice].quantities["duration_s"].p95 <= 27.0 * 60.0]
    assert min(in_time, key=lambda choice: cost(alone, choice, "energy")) == slowest
    return 0.995 * alone[slowest].quantities["duration_s"].p95 / 60.0


@lru_cache
def trials_of(choice):
    return simulate_block(mission(30.0, *choice), seed=SEED, block=0, trials=TRIALS).columns()


def meets_all(choice, minutes, arrive=0.6):
    """Whether the trials of a plain simulation meet both requirements."""
    trials = trials_of(choice)
    in_time = trials["total.duration_s"] <= 60.0 * minutes  # nan, of what never ended, is not
    return np.mean(trials["out.arrived"]) >= arrive and np.mean(in_time) >= 0.95


def meeting(choices, minutes):
    return [choice for choice in choices if meets_all(choice, minutes)]


@pytest.mark.parametrize(
    ("aim", "minutes"),
    [
        ("energy", "tight"),
        ("duration", 27.0),
        *(pytest.param("energy", minutes, marks=pytest.mark.slow) for minutes in (27.0, 23.8)),
        *(pytest.param("duration", minutes, marks=pytest.mark.slow) for minutes in (23.8, "tight")),
    ],
)
def test_the_choice_is_the_least_of_all_that_meet_the_requirements(alone, tight, aim, minutes):
    minutes = tight if minutes == "tight" else minutes
    found = missionplan.optimise(mission(minutes), choose=CHOOSE, aim=aim)
    good = meeting(ALL, minutes)
    best = min(good, key=lambda choice: cost(alone, choice, aim))
    assert (found.feasible, tuple(found.chosen.values())) == (True, best)
    assert max(each.trials for each in found.tried) == TRIALS  # as many as the loop has
    for each in found.tried:
        choice = tuple(each.values.values())
        assert each.trials < TRIALS or each.feasible == (choice in good)
        if each.trials == TRIALS:
            assert (each.energy, each.duration) == pytest.approx(
                [cost(alone, choice, of) for of in ("energy", "duration")]
            )
            assert each.success == alone[choice].events["success"]
    wider = {"total.duration": 1.01 * minutes, "out.arrived": minutes}
    for relaxed in found.relaxations:
        then = min(meeting(ALL, wider[relaxed.quantity]), key=lambda choice: cost(alone, choice, aim))
        assert tuple(relaxed.values.values()) == then
        assert relaxed.saved == pytest.approx(cost(alone, best, aim) - cost(alone, then, aim), abs=1e-9)
    saved = {each.quantity: each.saved for each in found.relaxations}
    assert (saved["total.duration"] > 1.0) is (aim == "energy" and minutes == tight)


def test_the_obstacle_is_what_the_nearest_choice_of_all_lacks(alone):
    found = missionplan.optimise(mission(15.0), choose=CHOOSE)
    arriving = [choice for choice in ALL if alone[choice].quantities["duration_s"].count >= 0.6 * TRIALS]
    nearest = min(arriving, key=lambda choice: alone[choice].quantities["duration_s"].p95)
    assert (found.feasible, tuple(found.chosen.values())) == (False, nearest)
    (obstacle,) = found.obstacles
    assert (obstacle.quantity, obstacle.limit, obstacle.required, obstacle.alone) == (
        "total.duration",
        900.0,
        0.95,
        True,
    )
    assert obstacle.reached.value == 0.0
    durations = alone[nearest].quantities["duration_s"]
    assert durations.p95 < obstacle.would_do < durations.p95 + 0.6 * durations.sd
    assert meeting([nearest], obstacle.would_do / 60.0) == [nearest]


@pytest.mark.parametrize("aim", ["success", "energy", "duration"])
@pytest.mark.parametrize("minutes", [27.0, 15.0])
def test_cells_the_best_and_the_front_are_those_of_a_plain_loop(alone, aim, minutes):
    found = missionplan.explore(mission(minutes), CHOOSE, aim=aim)
    good = meeting(ALL, minutes) if minutes > 20.0 else []
    for cell, choice in zip(found.cells, ALL, strict=True):
        total = alone[choice]
        assert cell.success == total.events["success"]
        assert cell.meets_all == (choice in good)
        for quantity in ("energy_wh", "duration_s"):
            one, other = cell.quantities[f"total.{quantity}"], total.quantities[quantity]
            assert [one.mean, one.sd, one.p05, one.p50, one.p95] == pytest.approx(
                [other.mean, other.sd, other.p05, other.p50, other.p95], rel=0.02, nan_ok=True
            )
    costs = {
        choice: (
            -alone[choice].events["success"].value,
            *(_finite(cost(alone, choice, of)) for of in ("energy", "duration")),
        )
        for choice in ALL
    }
    array = np.array([costs[choice] for choice in ALL])
    for cell, own in zip(found.cells, array, strict=True):
        beaten = np.any(np.all(array <= own, axis=1) & np.any(array < own, axis=1))
        assert cell.on_front == (np.isfinite(own[1]) and not beaten)
    most = (
        aim == "success" or not good
    )  # where none meets all, the one that succeeds most often, then with least energy
    order = {
        c: (costs[c][0], costs[c][1]) if most else (costs[c][1 if aim == "energy" else 2], costs[c][0]) for c in ALL
    }
    best = min(good or ALL, key=order.__getitem__)
    assert ALL[found.best] == best
    for cell, choice in zip(found.cells, ALL, strict=True):
        compared = choice in good if good else True
        assert np.isfinite(cell.worse) == compared
        if compared:
            gap = costs[choice][0] - costs[best][0] if most else order[choice][0] - order[best][0]
            assert cell.worse == pytest.approx(gap, abs=1e-9)
            assert cell.as_good == (cell.worse <= 4.0 * cell.worse_error if choice != best else True)


def _finite(value):
    return value if np.isfinite(value) else np.inf


# verdicts on one choice


LATE = Demand("total.duration", "total.duration_s", "at_most", 100.0, 0.75)
DEEP = Demand("moor.lowest_altitude", "moor.lowest_altitude_m", "at_least", 2.0, 0.5)
THERE = Demand("out.arrived", "out.arrived", None, float("nan"), 0.75)
TRIED = Evaluation(
    (0,),
    {
        "total.duration_s": np.array([90.0, 100.0, 130.0, np.nan]),
        "moor.lowest_altitude_m": np.array([1.0, 2.0, 3.0, 0.5]),
        "out.arrived": np.array([True, True, True, False]),
    },
)


def test_a_choice_that_cannot_be_run_is_none_whatever_its_numbers_say():
    """A trial that was run before the reason was found does not make it feasible."""
    assert is_feasible((THERE, DEEP), TRIED)
    broken = replace(TRIED, reason="the anchor cannot be built")
    for demands in ((THERE, DEEP), ()):
        assert not is_feasible(demands, broken)
        assert not is_feasible(demands, broken, doubt=5.0)
    assert violations((THERE, DEEP), broken) == [100.0, 100.0]
    assert [demand.slack(broken) for demand in (THERE, LATE)] == [-1.0, -1.0]
    assert all(demand.margin(broken) < demand.margin(TRIED) for demand in (THERE, DEEP, LATE))
    assert np.isnan(LATE.would_do(broken))


def test_slack_and_violation_count_trials():
    assert [demand.slack(TRIED) for demand in (LATE, DEEP, THERE)] == [0.5 - 0.75, 0.0, 0.0]
    assert [demand.probability(TRIED).value for demand in (LATE, DEEP, THERE)] == [0.5, 0.5, 0.75]
    assert violations((LATE, DEEP, THERE), TRIED) == pytest.approx([0.25 + 30.0 / 100.0, 0.0, 0.0])
    stricter = replace(DEEP, required=0.75)
    assert stricter.violation(TRIED) == pytest.approx(0.25 + (2.0 - 1.0) / 2.0)
    assert replace(DEEP, limit=1.5).violation(TRIED) == 0.0  # no less than that where there is room
    assert replace(LATE, limit=50.0, required=1.0).violation(TRIED) == 1.0 + 1.0  # none does, and the worst never ends
    assert replace(stricter, limit=1.001).violation(TRIED) == pytest.approx(0.25 + 0.001 / 1.001)
    assert not is_feasible((LATE,), TRIED)
    assert is_feasible((LATE,), TRIED, doubt=2.0)  # 0.25 short, with a standard error of 0.217
    assert not is_feasible((LATE,), TRIED, doubt=1.0)


def test_a_relaxed_demand_is_one_percent_wider():
    assert LATE.relaxed().limit == pytest.approx(101.0)
    assert DEEP.relaxed().limit == pytest.approx(1.98)
    assert replace(DEEP, limit=-2.0).relaxed().limit == pytest.approx(-2.02)
    assert THERE.relaxed().required == pytest.approx(0.74)
    assert replace(THERE, required=0.005).relaxed().required == 0.0


def test_a_margin_is_positive_inside_and_grows_inwards():
    limits = [80.0, 95.0, 120.0, 131.0, 200.0]
    margins = [replace(LATE, limit=limit).margin(TRIED) for limit in limits]
    assert margins == sorted(margins)
    assert [margin > 0.0 for margin in margins] == [False, False, False, True, True]
    margins = [replace(DEEP, limit=limit).margin(TRIED) for limit in (3.5, 2.5, 1.9, 0.7)]
    assert margins == sorted(margins)
    assert [margin > 0.0 for margin in margins] == [False, False, True, True]
