"""The study of what a doubt is worth: its sums by hand, and cases that share nothing with the package."""

import ast
import json
from pathlib import Path

import numpy as np
import pytest

from .__main__ import main, table
from .ambiguous_dives import draw_dives
from .ambiguous_legs import draw_legs
from .choices import REQUIRED, LegChoice

HERE = Path(__file__).parent
CASE = {"kind": "legs", "truth": "speed-scale", "verdict": "ambiguous", "causes": ["mean-current"]}


@pytest.mark.parametrize("name", ["ambiguous_dives", "ambiguous_legs"])
def test_cases_are_made_without_the_package(name):
    tree = ast.parse((HERE / f"{name}.py").read_text(encoding="utf-8"))
    froms = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    imports = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    assert not [module for module in [*froms, *imports] if module.startswith("missionplan")]


@pytest.mark.parametrize("draw", [draw_dives, draw_legs])
def test_a_case_follows_from_its_seed(draw):
    first, again, other = draw(4), draw(4), draw(5)
    assert (first.rows, first.truth) == (again.rows, again.truth)
    assert first.rows != other.rows


def test_regret_of_legs_is_time_lost_against_the_best_choice():
    truth = LegChoice(1, np.array([1.5, 1.2, 1.8]))
    assert LegChoice(2, truth.loss).regret(truth) == pytest.approx(0.5)
    assert LegChoice(1, truth.loss).regret(truth) == 0.0
    assert LegChoice(0, np.array([1.0, 2.0, 3.0])).regret(LegChoice(1, np.array([np.inf, 1.2, 1.8]))) == 1.0


def test_results_are_continued_and_told_in_a_table(tmp_path, capsys):
    file = tmp_path / "regret.jsonl"
    ways = {"averaged": 0.01, "best": 0.02, "base": 0.03}
    rows = [
        {
            **CASE,
            "seed": k,
            "regret": {way: k * size for way, size in ways.items()},
            "outcome": {way: {"chosen": 1.0, "best": 1.0, "success": 0.981 - k * size} for way, size in ways.items()},
        }
        for k in range(5)
    ]
    file.write_text("".join(json.dumps(row) + "\n" for row in [*rows, {**CASE, "seed": 5}]))
    assert main(["--cases", "5", "--results", str(file)]) == 0  # enough: none is run
    assert capsys.readouterr().out.strip() == table([*rows, {**CASE, "seed": 5}])
    assert "| 5 legs | best | 4.0 % | 7.2 % | 4.0 % | – | – |" in table(rows)
    assert "| 5 dives | base | 6.0 % | 10.8 % | 6.0 % | 2 | 2 |" in table([{**row, "kind": "dives"} for row in rows])
    assert REQUIRED == 0.95
