"""Reports of `explore` and of `optimise` side by side, and missions whose tasks are not alike."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.mission import with_values
from missionplan.report.render import terminal_view
from missionplan.results import to_yaml
from missionplan.studies.comparison.alternatives_page import answer, page
from missionplan.studies.comparison.choices_page import task_in_words
from missionplan.studies.comparison.differing_values import MissionKey, differing_values, parts_of_task
from missionplan.studies.comparison.result import Alternatives

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[3] / "missions"
CHESAPEAKE = missionplan.load(MISSIONS / "chesapeake.yaml")
BASE = {**CHESAPEAKE.raw, "phases": CHESAPEAKE.raw["phases"][:2]}
SPEEDS = "ingress.speed=1:2:0.5 m/s"


def changed(folder, name, **values):
    path = folder / f"{name}.yaml"
    keys = {key.replace("__", "."): value for key, value in values.items()}
    path.write_text(to_yaml(with_values(BASE, keys)))
    return path


@pytest.fixture(scope="module")
def explored(tmp_path_factory):
    return missionplan.explore(changed(tmp_path_factory.mktemp("near"), "near"), SPEEDS, trials=60)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, explored):
    """Two explorations over speed, one over the length of the line, and two optimisations of the way in, one hopeless."""
    folder = tmp_path_factory.mktemp("choices")
    near, far = changed(folder, "near"), changed(folder, "far", moor__radius="4 m")
    explored.save(folder / "explored-near")
    missionplan.explore(missionplan.load(far), SPEEDS, trials=60).save(folder / "explored-far")
    missionplan.explore(missionplan.load(near), "moor.line_length=4:5:1 m", trials=20).save(folder / "lines")
    needed = [BASE["requirements"][0], BASE["requirements"][-1]]
    for name, energy in (("near", "45 W*h"), ("hopeless", "2 W*h")):
        needed[1] = {**needed[1], "at_most": energy}
        way_in = Mission.from_data({**BASE, "phases": BASE["phases"][:1], "requirements": needed}, file=CHESAPEAKE.file)
        found = missionplan.optimise(way_in, choose=[SPEEDS], trials=100)
        found.save(folder / f"optimised-{name}")
    missionplan.simulate(missionplan.load(near), trials=40).save(folder / "simulated")
    return folder


def test_two_explorations_are_compared_at_their_best_cells(folder, explored):
    found = missionplan.compare(folder / "explored-far", folder / "explored-near")
    assert isinstance(found, Alternatives)
    best = explored
    near = found.alternatives[1]
    assert near.chosen.values == best.values_of(best.best_cell)
    assert near.success == best.best_cell.success
    assert near.quantities["energy_wh"][0] == pytest.approx(best.best_cell.quantities["total.energy_wh"].mean)
    assert near.chosen.windows == tuple(
        (best.axes[0].exact(window.first), best.axes[0].exact(window.last)) for window in best.windows
    )
    assert found.best_one.name == "explored-near"
    assert "The missions differ in radius (moor) (4 m, 75 ft)." in answer(found)
    assert answer(found).startswith("The best speed (ingress) is ")


def test_the_cells_that_both_have_tried_stand_side_by_side(folder):
    found = missionplan.compare(folder / "explored-far", folder / "explored-near")
    assert page(found).figure.name == "cells"
    (cells,) = (section for section in page(found).sections if section.heading.startswith("P(success) of the 3"))
    assert [row[0] for row in cells.blocks[0].rows] == ["1 m/s", "1.5 m/s", "2 m/s"]
    assert "all requirements met" in terminal_view(found).columns
    found.save(folder / "compared")
    assert "Side by side" in (folder / "compared" / "report.html").read_text()


def test_explorations_of_unlike_keys_are_refused(folder):
    with pytest.raises(InputError, match=r"explored-near varies ingress\.speed, .*lines varies moor\.line_length"):
        missionplan.compare(folder / "explored-near", folder / "lines")


def test_two_optimisations_are_compared_by_what_they_aim_at(folder):
    near = folder / "optimised-near"
    found = missionplan.compare(near, near)
    assert found.aim == "energy"
    assert found.compared == "optimise"
    assert "cannot be told apart by their energy" in answer(found)
    assert found.summary()["alternatives"][0]["chosen"] == dict(found.best_one.chosen.values)


def test_an_optimisation_without_a_choice_is_last_and_says_so(folder):
    found = missionplan.compare(folder / "optimised-hopeless", folder / "optimised-near")
    assert found.best_one.name == "optimised-near"
    assert "no choice tried for optimised-hopeless meets all requirements" in answer(found)
    assert "they differ in what is required" in answer(found)
    page(found)
    none = missionplan.compare(folder / "optimised-hopeless", folder / "optimised-hopeless")
    assert np.isnan(none.best_one.success.value)
    assert "Of none of them a choice was found" in answer(none)
    page(none)


@pytest.mark.parametrize(
    "others",
    [("near.yaml",), ("simulated",), ("optimised-near",), ("near.yaml", "simulated"), ("explored-far", "lines")],
)
def test_unlike_kinds_are_refused_in_one_message(folder, others):
    with pytest.raises(InputError) as caught:
        missionplan.compare(folder / "explored-near", *(folder / name for name in others), trials=10)
    assert len(caught.value.problems) == 1
    assert "expected" in str(caught.value)


def test_missions_with_unlike_tasks_are_no_alternatives(folder):
    path = changed(folder, "further", ingress__to=["1700 m", "0 m"])
    found = missionplan.compare(folder / "near.yaml", path, trials=40)
    assert answer(found).startswith("The missions have unlike tasks: they differ in where ingress leads")
    assert "is better than" not in answer(found)
    assert found.summary()["task_differs"] == ["to"]


def test_two_reports_of_unlike_tasks_say_so_first(folder):
    path = changed(folder, "longer", moor__hold="40 min")
    missionplan.simulate(missionplan.load(path), trials=40).save(folder / "held-longer")
    found = missionplan.compare(folder / "simulated", folder / "held-longer")
    assert terminal_view(found).sentence.startswith("The missions have unlike tasks")


def test_requirements_of_one_quantity_are_told_apart(folder):
    twice = (folder / "near.yaml").read_text().replace("at_most: 75 ft", "at_most: 60 ft")
    (folder / "stricter.yaml").write_text(twice)
    found = missionplan.compare(folder / "near.yaml", folder / "stricter.yaml", trials=40)
    (table,) = (
        section.blocks[0] for section in page(found).sections if section.heading.startswith("What each reaches")
    )
    rows = {row[0]: row[2:] for row in table.rows}
    assert rows["offset of the anchor (moor) at most 75 ft"][1] == "–"
    assert rows["offset of the anchor (moor) at most 60 ft"][0] == "–"


def test_parts_of_the_task_and_ways_to_do_it():
    task = {
        "phases": [{"transit": {"name": "out", "to": ["1 km", "0 m"], "speed": "1 m/s"}}, {"moor": {"hold": "1 h"}}],
        "site": {"origin": {"latitude": "1 deg"}, "depth": "20 m", "current": {"file": "a.csv"}},
        "requirements": [{"quantity": "out.duration", "at_most": "1 h"}],
        "optimise": {"choose": [{"from": "1 m"}]},
        "sweep": {"d_max": {"to": "1 km"}},
    }
    other = yaml.safe_load(yaml.safe_dump(task).replace("1 ", "2 ").replace("20 m", "30 m").replace("a.csv", "b.csv"))
    parts = {each.path: each.mission_key.part() for each in differing_values((task, other))}
    assert parts == {
        "out.to[0]": "to",
        "out.speed": None,
        "moor.hold": "hold",
        "site.origin.latitude": "place",
        "site.depth": "depth",
        "site.current.file": None,
        "requirements[0].at_most": "requirements",
        "optimise.choose[0].from": None,
        "sweep.d_max.to": None,
    }


def test_the_task_in_words():
    keys_found = [
        MissionKey(("to", 0), "out"),
        MissionKey(("to", 1), "back"),
        MissionKey(("hold",), "out"),
        MissionKey(("site", "depth")),
    ]
    differs = parts_of_task(keys_found, phases_differ=False)
    assert task_in_words(differs) == "in the depth of the water, in where out and back lead and in how long out holds"
