"""The load of the snatch as mission files give it."""

import copy
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.studies.simulation.simulate import simulate_block

MISSIONS = Path(__file__).parents[2] / "missions"


def chesapeake(requirements=None, **moor):
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    del data["phases"][1]["moor"]["line_material"]
    data["phases"][1]["moor"].update(moor)
    data["requirements"] = requirements or []
    return Mission.from_data(data)


def mooring(mission, trials=40):
    found = simulate_block(mission, seed=1, block=0, trials=trials)
    return found, found.phases[1]


def test_without_stiffness_nothing_is_said_of_the_load():
    _, found = mooring(chesapeake())
    assert "snatch_tension_n" not in found.quantities
    assert "line_parts" not in found.events


def test_a_stiff_line_bears_half_a_kilonewton():
    """The estimate of the prototype at 10 kN/m; a tenth of the stiffness, about a third of the tension."""
    stiff, soft = (
        mooring(chesapeake(line_stiffness=k))[1].quantities["snatch_tension_n"] for k in ("10 kN/m", "1 kN/m")
    )
    assert stiff == pytest.approx(np.full(40, 446.0), abs=1.0)
    assert np.all((soft > stiff / np.sqrt(10.0)) & (soft < 1.1 * stiff / np.sqrt(10.0)))


def test_a_line_that_is_too_weak_parts_and_the_trial_fails():
    strength = {"mean": "430 N", "sd": "20 N"}
    trials, found = mooring(chesapeake(line_stiffness="10 kN/m", line_strength=strength), 200)
    parts = found.events["line_parts"]
    assert 20 < np.count_nonzero(parts) < 180
    assert np.array_equal(found.failures["line parted"], parts)
    assert not np.any(trials.success & parts)
    assert np.isnan(found.quantities["offset_m"][parts]).all()
    assert np.isfinite(found.quantities["snatch_tension_n"]).all()
    assert np.isfinite(found.quantities["offset_m"][~parts]).all()


def test_a_strong_line_changes_nothing_but_its_stretch():
    plain, strong = (
        mooring(chesapeake(**keys)) for keys in ({}, {"line_stiffness": "10 kN/m", "line_strength": "5 kN"})
    )
    assert not np.any(strong[1].events["line_parts"])
    for name, values in plain[1].quantities.items():
        assert strong[1].quantities[name] == pytest.approx(values, abs=2e-3, nan_ok=True), name


@pytest.mark.parametrize(
    ("requirement", "moor", "words"),
    [
        ({"quantity": "moor.snatch_tension", "at_most": "1 kN", "probability": 0.9}, {}, "needs line_stiffness"),
        ({"quantity": "moor.line_parts", "probability": 0.1}, {"line_stiffness": "10 kN/m"}, "needs line_strength"),
        (None, {"line_strength": "1 kN"}, "says nothing without line_stiffness"),
        (None, {"line_stiffness": "10 N"}, "line_stiffness"),
        (None, {"line_stiffness": "10 GN/m"}, "impossible"),
    ],
)
def test_what_cannot_be_asked_is_refused(requirement, moor, words):
    with pytest.raises(InputError, match=words):
        chesapeake([requirement] if requirement else None, **moor)


def test_a_requirement_may_name_the_load():
    asked = {"quantity": "moor.snatch_tension", "at_most": "1 kN", "probability": 0.9}
    mission = chesapeake(
        [asked, {"quantity": "moor.line_parts", "probability": 0.0}], line_stiffness="10 kN/m", line_strength="1 kN"
    )
    assert mission.requirements[0].at_most == 1000.0
