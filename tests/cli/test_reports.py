"""`missionplan reports`: what was computed so far."""

import os
import subprocess
import sys
from pathlib import Path
from shutil import copytree

import pytest

import missionplan
from missionplan.cli import main
from missionplan.errors import InputError

pytestmark = pytest.mark.usefixtures("unassumed")

MISSIONS = Path(__file__).parents[2] / "missions"


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "BROWSER": "echo opened %s"}
    command = [sys.executable, "-m", "missionplan", "reports", *arguments]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


def status_of(monkeypatch: pytest.MonkeyPatch, *arguments: str, cwd: Path) -> int:
    """Run the command in this process."""
    monkeypatch.chdir(cwd)
    monkeypatch.setattr(sys, "argv", ["missionplan", "reports", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    few = missionplan.load(MISSIONS / "fig8.yaml").with_({"sweep.d_max.points": 5})
    result = missionplan.sweep_dmax(few, method="analytic")
    for number in (1, 2):
        result.save(folder / f"sweep-dmax-{number}")
    return folder


@pytest.fixture
def made(tmp_path: Path, two: Path) -> Path:
    copytree(two, tmp_path / "reports" / "fig8")
    return tmp_path


def test_reports_are_listed_with_their_answers(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = missionplan.reports(made / "reports")
    assert [entry.command for entry in found] == ["sweep-dmax"] * 2
    assert found[0].answer.startswith("Choose d_max =")
    assert found[0].mission.startswith("Navigation cost")
    assert status_of(monkeypatch, cwd=made) == 0
    listed = capsys.readouterr().out
    assert listed.count("Choose d_max") == 2
    assert max(map(len, listed.splitlines())) <= 80
    assert str(found[0].folder.relative_to(made)) in listed


def test_a_report_is_opened_by_its_number(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened = run("2", "--root", "reports", cwd=made)
    page = missionplan.reports(made / "reports")[1].page
    assert opened.returncode == 0, opened.stderr
    assert f"opened {page.as_uri()}" in opened.stdout
    assert status_of(monkeypatch, "3", cwd=made) == 2
    assert "given 3, expected 1 to 2" in capsys.readouterr().err


def test_a_folder_that_is_not_there_is_refused_and_a_damaged_report_said(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert status_of(monkeypatch, "--root", "nowhere", cwd=made) == 2
    with pytest.raises(InputError, match="no such folder of reports"):
        missionplan.reports(made / "nowhere")
    (made / "reports" / "fig8" / "sweep-dmax-1" / "summary.json").write_text("{")
    answers = {entry.answer[:14] for entry in missionplan.reports(made / "reports")}
    assert answers == {"cannot be read", "Choose d_max ="}
