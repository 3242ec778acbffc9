"""Wrong arguments of the public functions are said in words, in Python's terms, before anything runs."""

from pathlib import Path

import pytest

import missionplan
from missionplan.errors import InputError

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"trials": 2.5}, "trials: given 2.5, expected a whole number"),
        ({"trials": "10"}, "trials: given '10'"),
        ({"trials": 0}, "trials: given 0, expected a whole number, at least 1"),
        ({"trials": True}, "trials: given True"),
        ({"seed": -1}, "seed: given -1, expected a whole number, at least 0"),
        ({"jobs": 0}, "jobs: given 0"),
        ({"precision": 5}, "precision: given 5, expected text"),
        ({"checkpoint": 5}, "checkpoint: given 5, expected a path"),
        ({"trials": 0, "seed": -1}, "(?s)trials.*seed"),
    ],
)
def test_a_simulation_refuses(arguments, words):
    mission = missionplan.load(MISSIONS / "chesapeake.yaml")
    with pytest.raises(InputError, match=words):
        missionplan.simulate(mission, **arguments)


@pytest.mark.parametrize("study", ["simulate", "sweep_dmax", "plan_legs", "size_anchor", "sweep_transition"])
def test_a_study_refuses_what_is_no_mission(study):
    with pytest.raises(InputError, match=r"mission: given 3, expected a Mission"):
        getattr(missionplan, study)(3)


def test_other_choices_are_refused():
    mission = missionplan.load(MISSIONS / "fig8.yaml")
    with pytest.raises(InputError, match="method: given 'x', expected one of None, both, analytic, monte-carlo"):
        missionplan.sweep_dmax(mission, method="x")
    with pytest.raises(InputError, match="aim: given 'x', expected one of mean"):
        missionplan.plan_legs(mission, aim="x")


@pytest.mark.parametrize("path", [None, 5, b"x", "a\0b"])
def test_paths_are_text(path):
    mission = missionplan.load(MISSIONS / "fig8.yaml")
    for call in (missionplan.load, missionplan.identify, lambda given: missionplan.diagnose(mission, given)):
        with pytest.raises(InputError, match=r"expected a path|control character"):
            call(path)


def test_a_checkpoint_may_be_text_and_hints_are_pythons(tmp_path):
    mission = missionplan.load(MISSIONS / "chesapeake.yaml")
    result = missionplan.simulate(mission, trials=10, checkpoint=str(tmp_path / "blocks"))
    with pytest.raises(InputError, match="resume=True continues"):
        missionplan.simulate(mission, trials=10, checkpoint=str(tmp_path / "blocks"))
    with pytest.raises(InputError, match="force=True writes over it"):
        result.save(tmp_path)
