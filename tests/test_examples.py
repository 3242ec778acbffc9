"""The notebooks and programs of `examples` run as they stand, and the README's Python twice in a row."""

import ast
import inspect
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import missionplan

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


def _program(notebook: Path) -> str:
    """Code of a notebook as a program that shows the last expression of each cell, as a notebook does."""
    lines = ["def show(value):", "    print(value._repr_html_()[:0] if hasattr(value, '_repr_html_') else value)"]
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        tree = ast.parse("".join(cell["source"]))
        if isinstance(tree.body[-1], ast.Expr):
            tree.body[-1] = ast.parse(f"show({ast.unparse(tree.body[-1])})").body[0]
        lines.append(ast.unparse(tree))
    return "\n".join(lines)


def _run(program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    return subprocess.run([sys.executable, "-c", program], cwd=folder, env=environment, capture_output=True, text=True)


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path) -> None:
    done = _run(_program(notebook), tmp_path)
    assert done.returncode == 0, done.stderr
    if notebook.stem == "diagnose":
        assert "compass-bias" in done.stdout


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_calls_what_there_is(notebook: Path) -> None:
    """Functions of the package take what it gives them, by number and name."""
    calls = [each for each in ast.walk(ast.parse(_program(notebook))) if isinstance(each, ast.Call)]
    names = [ast.unparse(each.func).removeprefix("missionplan.") for each in calls]
    called = [(name, each) for name, each in zip(names, calls, strict=True) if name in missionplan.__all__]
    assert {"init", "load"} <= {name for name, _ in called}
    for name, call in called:
        keywords = {str(each.arg): None for each in call.keywords}
        inspect.signature(getattr(missionplan, name)).bind(*call.args, **keywords)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_small(notebook: Path) -> None:
    assert notebook.stat().st_size < 50_000


def few_lengths(folder: Path) -> str:
    """Write `missions/fig8.yaml` with a sweep of few lengths of legs."""
    fig8 = folder / "missions" / "fig8.yaml"
    fig8.parent.mkdir()
    text = (ROOT / "missions" / "fig8.yaml").read_text(encoding="utf-8")
    assert "points: 99" in text
    fig8.write_text(text.replace("points: 99", "points: 5"), encoding="utf-8")
    return str(fig8)


def test_the_python_of_the_readme_runs_twice_in_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (program,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    few_lengths(tmp_path)
    few = program.replace("trials=2000", "trials=50")
    assert few != program
    monkeypatch.chdir(tmp_path)
    exec(f"{few}\n{few}", {})
    assert (tmp_path / "reports" / "fig8" / "report.html").exists()


def test_a_program_of_somebody_elses_works(tmp_path: Path) -> None:
    consumer = runpy.run_path(str(ROOT / "examples" / "python" / "consumer.py"))
    assert consumer["best_leg"](few_lengths(tmp_path))
    assert "no such file" in str(consumer["problems"]("missions/nowhere.yaml"))
