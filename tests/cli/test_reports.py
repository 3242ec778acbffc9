"""`missionplan reports`: what was computed so far."""

import os
import subprocess
import sys
from pathlib import Path
from shutil import copytree

import pytest

import missionplan
from missionplan.errors import InputError

pytestmark = pytest.mark.usefixtures("unassumed")

MISSIONS = Path(__file__).parents[2] / "missions"


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "BROWSER": "echo opened %s"}
    command = [sys.executable, "-m", "missionplan", "reports", *arguments]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    result = missionplan.sweep_dmax(MISSIONS / "fig8.yaml", method="analytic")
    for number in (1, 2):
        result.save(folder / f"sweep-dmax-{number}")
    return folder


@pytest.fixture
def made(tmp_path: Path, two: Path) -> Path:
    copytree(two, tmp_path / "reports" / "fig8")
    return tmp_path


def test_reports_are_listed_with_their_answers(made: Path) -> None:
    found = missionplan.reports(made / "reports")
    assert [entry.command for entry in found] == ["sweep-dmax"] * 2
    assert found[0].answer.startswith("Choose d_max =")
    assert found[0].mission.startswith("Navigation cost")
    listed = run(cwd=made)
    assert listed.returncode == 0, listed.stderr
    assert listed.stdout.count("Choose d_max") == 2
    assert max(map(len, listed.stdout.splitlines())) <= 80
    assert str(found[0].folder.relative_to(made)) in listed.stdout


def test_a_report_is_opened_by_its_number(made: Path) -> None:
    opened = run("2", "--root", "reports", cwd=made)
    page = missionplan.reports(made / "reports")[1].page
    assert opened.returncode == 0, opened.stderr
    assert f"opened {page.as_uri()}" in opened.stdout
    refused = run("3", cwd=made)
    assert refused.returncode == 2
    assert "given 3, expected 1 to 2" in refused.stderr


def test_a_folder_that_is_not_there_is_refused_and_a_damaged_report_said(made: Path) -> None:
    assert run("--root", "nowhere", cwd=made).returncode == 2
    with pytest.raises(InputError, match="no such folder of reports"):
        missionplan.reports(made / "nowhere")
    (made / "reports" / "fig8" / "sweep-dmax-1" / "summary.json").write_text("{")
    answers = {entry.answer[:14] for entry in missionplan.reports(made / "reports")}
    assert answers == {"cannot be read", "Choose d_max ="}
