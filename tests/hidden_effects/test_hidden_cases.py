"""Cases with hidden effects: independence of the package, determinism, files, and the plan of a study."""

import ast
import csv
import json
import sys
from pathlib import Path

import pytest
import yaml

from .cases import KINDS, SCENARIO_CYCLE, SCENARIOS, cases, draw_case, plan
from .dives.catalogue import CATALOGUE as DIVE_CATALOGUE
from .dives.outside import OUTSIDE as DIVE_OUTSIDE
from .dives.outside import STUDIED as STUDIED_DIVES
from .dives.strength import MINIMUM_STRENGTH
from .legs.catalogue import CATALOGUE as LEG_CATALOGUE
from .legs.outside import OUTSIDE as LEG_OUTSIDE
from .legs.outside import STUDIED as STUDIED_LEGS

HERE = Path(__file__).parent
ALLOWED = {"numpy", "scipy", "yaml", "pytest"}


def test_imports_nothing_from_the_package_under_test():
    for path in HERE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            roots = {name.split(".")[0] for name in names}
            assert roots <= ALLOWED | set(sys.stdlib_module_names), f"{path.name} imports {roots}"


def test_studied_effects_are_some_of_those_outside():
    assert set(LEG_OUTSIDE) > STUDIED_LEGS
    assert set(DIVE_OUTSIDE) > STUDIED_DIVES
    assert not set(LEG_OUTSIDE) & set(DIVE_OUTSIDE)  # one set of names serves both kinds
    assert not set(LEG_OUTSIDE) & set(LEG_CATALOGUE)
    assert not set(DIVE_OUTSIDE) & set(DIVE_CATALOGUE)


@pytest.mark.parametrize(
    ("kind", "scenario"),
    [("descent", "control"), ("transit", "single"), pytest.param("transit", "pair", marks=pytest.mark.slow)],
)
def test_same_seed_same_case(kind, scenario):
    first, second = draw_case(11, kind, scenario), draw_case(11, kind, scenario)
    assert (first.header, first.rows, first.dataset, first.mission) == (
        second.header,
        second.rows,
        second.dataset,
        second.mission,
    )
    assert draw_case(12, kind, scenario).rows != first.rows


def test_plan_has_every_scenario_of_both_kinds():
    arguments = plan(40, 5)
    assert [seed for seed, _, _ in arguments] == list(range(5, 45))
    for kind in KINDS:
        drawn = [scenario for _, each, scenario in arguments if each == kind]
        assert sorted(drawn) == sorted(SCENARIO_CYCLE)
        assert set(drawn) == set(SCENARIOS)
    with pytest.raises(ValueError, match="no cases"):
        draw_case(1, "descent", "calm")


@pytest.mark.parametrize("kind", KINDS)
def test_files_hold_the_case_and_not_the_truth(kind, tmp_path):
    case = next(cases(1, 7, kind))
    mission, data = case.write(tmp_path / "seen", tmp_path / "truth")
    truth = json.loads((tmp_path / "truth" / f"{case.name}.json").read_text())
    assert truth["truth"] == list(case.truth)
    dataset = yaml.safe_load((data / "dataset.yaml").read_text())
    assert dataset == case.dataset
    with (data / dataset["file"]).open(newline="") as file:
        header, *rows = csv.reader(file)
    assert (header, rows) == (case.header, case.rows)
    assert yaml.safe_load(mission.read_text()) == case.mission
    if kind == "descent":
        assert {row[0] for row in rows} == set(dataset["runs"])
        vehicle = case.mission["vehicle"]
        assert isinstance(vehicle, dict) or (mission.parent / vehicle).exists()
    seen = " ".join(path.read_text() for path in (tmp_path / "seen").rglob("*") if path.is_file())
    names = [*DIVE_CATALOGUE, *LEG_CATALOGUE, *DIVE_OUTSIDE, *LEG_OUTSIDE]
    assert not [name for name in names if "-" in name and name in seen]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "effect"), [("descent", e) for e in DIVE_OUTSIDE] + [("transit", e) for e in LEG_OUTSIDE]
)
def test_outside_effects_are_outside(kind, effect):
    """The nearest single effect of the catalogue leaves a clear misfit (checked where the case is drawn)."""
    assert draw_case(102, kind, "outside", effect).strength >= MINIMUM_STRENGTH


def test_exact_ties_are_stated():
    case = draw_case(1, "descent", "tie")
    assert len({run["line_length"] for run in case.dataset["runs"].values()}) == 1
    assert case.accepts(["line-payout"])
    assert case.accepts(["clock-offset"])
    assert not case.accepts([])
    heading = draw_case(1, "transit", "tie")
    assert heading.accepts(["mean-current"])
