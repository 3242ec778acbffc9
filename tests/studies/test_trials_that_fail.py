"""A report comes from whatever trials did: one, some, all but one or all of them fail, at each phase."""

import copy
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.studies.simulation.simulate import simulate_block

pytestmark = pytest.mark.usefixtures("drawn")

MISSIONS = Path(__file__).parents[2] / "missions"
TRIALS = 60
COUNTS = (1, TRIALS // 3, TRIALS - 1, TRIALS)
REFUSED = ("moor-line", TRIALS)
"""A line that is too long in every trial is so at its mean: refused when the mission is read."""


def _transit(name, bad):
    """A vehicle that the current carries away in some trials."""
    return lambda data, share: _phase(data, name).update(speed=_choices("1.5 m/s", bad, share))


def _flooded(data, share):
    data["vehicle"]["anchor"]["premature_flooding"] = share


def _line(data, share):
    """A line too long for the water; of choices the mean must not be."""
    _phase(data, "moor")["line_length"] = _choices("5 m", "11.1 m", share)


def _radius(data, share):
    _phase(data, "moor")["radius"] = _choices("75 ft", "1 mm", share)


def _battery(data, share):
    data["energy"] = {"capacity": _choices("60 W*h", "15 W*h", share)}


WAYS = {
    "ingress": _transit("ingress", "0.05 m/s"),
    "moor-flooded": _flooded,
    "moor-line": _line,
    "moor-radius": _radius,
    "battery": _battery,
    "egress": _transit("egress", "0.05 m/s"),
}


def _phase(data, name):
    return next(
        section for entry in data["phases"] for kind, section in entry.items() if section.get("name", kind) == name
    )


def _choices(good, bad, share):
    """A value of 1000, as many bad ones as the share says."""
    worse = round(1000 * share)
    return {"choices": [bad] * worse + [good] * (1000 - worse)}


def mission_that_fails(way, count):
    """The mission with that many failing trials of TRIALS: the share of bad draws is found by bisection about theirs."""
    low, high = 0.0, 1.0
    for tried in range(12):
        share = 0.5 * (low + high) if tried and count < TRIALS else count / TRIALS
        data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
        data["monte_carlo"] = {"trials": TRIALS, "seed": 1}
        WAYS[way](data, share)
        mission = Mission.from_data(data)
        failed = np.count_nonzero(~simulate_block(mission, seed=1, block=0, trials=TRIALS).success)
        if failed == count:
            return mission
        low, high = (share, high) if failed < count else (low, share)
    return mission


def saved(result, folder):
    """Every part of a result is made: files, page, figures, terminal."""
    result.save(folder)
    result.to_frame()
    str(result)
    result._repr_html_()
    text = (folder / "summary.json").read_text(encoding="utf-8")
    assert "NaN" not in text
    return result


@pytest.mark.parametrize(
    ("way", "count"),
    [
        ("moor-line", 1),
        pytest.param("egress", TRIALS - 1, marks=pytest.mark.slow),
        pytest.param("moor-line", TRIALS - 1, marks=pytest.mark.slow),
        pytest.param("egress", 1, marks=pytest.mark.slow),
    ],
)
def test_simulate_reports_whatever_the_trials_did(way, count, tmp_path):
    mission = mission_that_fails(way, count)
    found = saved(missionplan.simulate(mission, trials=TRIALS, seed=1), tmp_path / "report")
    assert round(TRIALS * (1.0 - found.total.events["success"].value)) == count


CASES = [(way, count) for way in WAYS for count in COUNTS if (way, count) != REFUSED]
STUDIES = {
    "simulate": lambda mission, _: missionplan.simulate(mission, trials=TRIALS, seed=1, keep_trials=True),
    "explore": lambda mission, _: missionplan.explore(mission, "moor.anchor_wet_weight=9 N,11.8 N", trials=TRIALS),
    "explore-map": lambda mission, _: missionplan.explore(
        mission, ["moor.anchor_wet_weight=9 N,11.8 N", "ingress.d_max=300 m,500 m"], trials=TRIALS
    ),
    "optimise": lambda mission, _: missionplan.optimise(
        mission, choose=["moor.anchor_wet_weight=9 N,11.8 N"], trials=TRIALS, seed=1
    ),
    "sweep-dmax": lambda mission, _: missionplan.sweep_dmax(mission, trials=TRIALS, seed=1),
    "plan-legs": lambda mission, _: missionplan.plan_legs(mission, trials=TRIALS, seed=1),
    "size-anchor": lambda mission, _: missionplan.size_anchor(mission, trials=TRIALS, seed=1),
    "rare": lambda mission, _: missionplan.find_rare_failure(mission, trials=TRIALS, seed=1),
    "compare": lambda mission, folder: missionplan.compare_missions(
        mission.save(folder / "a.yaml"), mission.with_(hold="30 min").save(folder / "b.yaml"), trials=TRIALS
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("study", STUDIES)
@pytest.mark.parametrize(("way", "count"), CASES)
def test_every_study_reports_or_refuses_whatever_the_trials_did(way, count, study, tmp_path):
    mission = mission_that_fails(way, count)
    try:
        found = STUDIES[study](mission, tmp_path)
    except missionplan.MissionplanError as error:
        assert str(error)  # a mission that no study of this kind can answer is refused in words
    else:
        saved(found, tmp_path / "report")


@pytest.mark.slow
@pytest.mark.parametrize(("way", "count"), CASES)
def test_the_plan_of_a_mission_that_fails_is_written(way, count, tmp_path):
    mission = mission_that_fails(way, count)
    for name in ("geojson", "kml", "json"):
        missionplan.export(mission, name, out=tmp_path / name)
