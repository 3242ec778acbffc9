"""The runner of the blocks of README and docs: what it finds, and that no block is without a mark."""

import importlib.util
import re
import shutil
import sys
from pathlib import Path

import pytest
import yaml

from missionplan.cli import main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")]


@pytest.fixture(scope="module")
def runner():
    spec = importlib.util.spec_from_file_location("doc_blocks", ROOT / ".ci" / "doc_blocks.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["doc_blocks"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def problems(runner, tmp_path):
    """What is found in a page."""
    home = tmp_path / "here"
    home.mkdir()
    return lambda text: runner.problems_of(text, runner.Reader(home))


def page(mark: str, text: str, language: str = "") -> str:
    return f"Words.\n\n{mark}\n```{language}\n{text}\n```\n"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_block_is_marked(runner, path):
    text = path.read_text(encoding="utf-8")
    blocks = list(runner.blocks(text))
    assert [block.line for block in blocks if not block.kind] == []
    fences = re.findall(r"^\s*(?:```|~~~)", text, re.MULTILINE)
    assert len(fences) == 2 * sum(block.kind != "set up" for block in blocks), "a fence that the runner does not see"


@pytest.mark.parametrize("mark", ["", "<!-- run -->", "<!-- not run -->", "<!-- not run: -->", "<!-- in -->"])
def test_a_block_without_a_mark_is_found(problems, mark):
    (problem,) = problems(page(mark, "true"))
    assert "a block without a mark" in problem


def test_a_block_with_a_reason_is_left_alone(problems):
    assert problems(page("<!-- not run: needs a network -->", "false")) == []


def test_a_changed_number_is_found(problems):
    assert problems(page("<!-- runs -->", "$ echo 96.8 ± 0.3 %\n96.8 ± 0.3 %")) == []
    (problem,) = problems(page("<!-- runs -->", "$ echo 95.4 ± 0.4 %\n96.8 ± 0.3 %"))
    assert "is said to print: 96.8 ± 0.3 %" in problem
    assert "95.4 ± 0.4 %" in problem


def test_what_is_shown_comes_in_its_order_and_after_its_command(problems):
    shown = "$ printf 'one\\ntwo\\nthree\\n'\n{}\n$ echo four"
    assert problems(page("<!-- runs -->", shown.format("one\ntwo"))) == []
    assert problems(page("<!-- runs -->", shown.format("one two\n... three"))) == []
    assert problems(page("<!-- runs -->", shown.format("one\n…\nthree"))) == []
    for wrong in ("two\none", "one\nthree", "four"):
        assert len(problems(page("<!-- runs -->", shown.format(wrong)))) == 1


def test_a_number_is_not_found_within_another(problems):
    assert len(problems(page("<!-- runs -->", "$ echo 12.5 m\n2.5 m"))) == 1
    assert len(problems(page("<!-- runs -->", "$ echo 2.58 m\n2.5"))) == 1


def test_exit_statuses_are_compared_for_every_command(problems):
    assert len(problems(page("<!-- runs -->", "false\ntrue"))) == 1
    assert problems(page("<!-- runs: exit 0 3 -->", "(exit 3)\ntrue")) == []
    assert len(problems(page("<!-- runs: exit 3 -->", "true"))) == 1


def test_folder_and_variables_go_from_block_to_block(problems):
    set_up = "<!-- set up:\nmkdir a\nexport WHERE=sea\n-->\n"
    assert (
        problems(set_up + page("<!-- runs -->", "cd a") + page("<!-- runs -->", "$ basename $PWD-$WHERE\na-sea")) == []
    )
    assert len(problems("<!-- set up:\nfalse\ntrue\n-->\n")) == 1


def test_an_option_is_added_where_the_mark_says_so(problems):
    assert problems(page("<!-- runs with --trials 9 -->", "$ echo 5  # remark\n5 --trials 9")) == []


def test_python_runs(problems):
    assert problems(page("<!-- runs -->", "print(1)", "python")) == []
    assert "ZeroDivisionError" in problems(page("<!-- runs -->", "1 / 0", "python"))[0]


def test_files_are_written_and_their_parts_compared(problems):
    written = page("<!-- file a/b.txt -->", "x: 1\ny: 2")
    assert problems(written + page("<!-- from a/b.txt -->", "y: ...")) == []
    assert len(problems(written + page("<!-- from a/b.txt -->", "y: 3"))) == 1
    assert len(problems(page("<!-- from nowhere.txt -->", "y: 3"))) == 1


def test_a_fragment_is_validated_in_its_mission(runner, tmp_path, monkeypatch, capsys):
    home = tmp_path / "here"
    shutil.copytree(ROOT / "missionplan" / "starter", home)
    reader, in_bash = runner.Reader(home), runner.Reader.run

    def run(self, command):
        """In this process, where it is a command of the package."""
        if not command.startswith("missionplan "):
            return in_bash(self, command)
        monkeypatch.setattr(sys, "argv", command.split())
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code or 0), "".join(capsys.readouterr())

    monkeypatch.setattr(runner.Reader, "run", run)
    assert runner.problems_of(page("<!-- in mission.yaml: phases -->", "- moor: {radius: 12 m}", "yaml"), reader) == []
    made = yaml.safe_load((home / "with-mission.yaml").read_text(encoding="utf-8"))
    assert [next(iter(each)) for each in made["phases"]] == ["transit", "moor", "transit"]
    assert (made["phases"][1]["moor"]["radius"], made["phases"][1]["moor"]["line_length"]) == ("12 m", "5 m")
    (problem,) = runner.problems_of(page("<!-- in mission.yaml -->", "vehicle: {hul: 1 m}", "yaml"), reader)
    assert "unknown key" in problem


def test_the_tree_of_the_architecture_names_every_folder():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    tree = page[page.index("missionplan/\n") : page.index("Imports point one way")]
    named = set(re.findall(r"\b([a-z_]+)/", tree)) - {"missionplan"}
    folders = {each.parent.name for each in (ROOT / "missionplan").glob("*/**/__init__.py")} | {"starter"}
    assert named - folders == set(), "not in the package"
    assert folders - named == set(), "not in the tree"


@pytest.mark.parametrize("script", sorted((ROOT / "docs" / "figures").glob("*.py")), ids=lambda path: path.stem)
def test_a_script_that_draws_the_pages_figures_finds_what_it_imports(script):
    spec = importlib.util.spec_from_file_location(script.stem, script)
    spec.loader.exec_module(importlib.util.module_from_spec(spec))
