"""The command line: messages, exit statuses, nothing overwritten."""

import inspect
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from shutil import copytree
from typing import Any, cast

import pytest

import missionplan
from missionplan.cli import PANELS, app, main
from missionplan.effects import CATALOGUE
from missionplan.errors import RunError
from missionplan.studies.leg_length import optimise_legs
from missionplan.studies.leg_length.analytic_transit import PolicyFamily
from missionplan.studies.simulation import simulate as simulation

MISSIONS = Path(__file__).parents[2] / "missions"

SMALL = """
name: small <b>&
navigation: {velocity_error: {sigma: 0.035 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: ingress, from: [0 m, 0 m], to: [4 nmi, 0 m], speed: 1.25 m/s, d_max: 4 nmi, arrival_radius: 50 m}
sweep: {d_max: {from: 0.8, to: 1.0, points: 3, of: distance}, sigma: [0.035 m/s]}
monte_carlo: {trials: 500, seed: 1}
"""


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run the command line in this process and give its exit status."""
    monkeypatch.setattr(sys, "argv", ["missionplan", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return path


def test_validate_says_what_is_there(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "validate", *(str(MISSIONS / f"{name}.yaml") for name in ("chesapeake", "fig8"))) == 0
    said = capsys.readouterr().out
    assert "chesapeake.yaml: valid" in said
    assert "fig8.yaml: valid" in said


def test_validate_reports_every_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path
) -> None:
    mission.write_text(SMALL.replace("90 s", "90").replace("d_max: 4 nmi", "dmax: 4 nmi"))
    assert run(monkeypatch, "validate", str(mission), str(mission.with_name("smal.yaml"))) == 2
    errors = capsys.readouterr().err
    assert "small.yaml:3: navigation.surfacing_time: given the bare number 90" in errors
    assert "did you mean d_max?" in errors
    assert "did you mean small.yaml?" in errors
    assert "Traceback" not in errors


@pytest.mark.parametrize(
    "arguments",
    [
        ["sweep-dmx"],
        ["sweep-dmax"],
        ["sweep-dmax", "x.yaml", "--trials", "0"],
        ["sweep-dmax", "x" * 300],
        ["validate", "--no"],
    ],
)
def test_usage_errors_exit_with_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    assert run(monkeypatch, *arguments) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_report_folder_that_is_not_empty_is_refused_before_any_work(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path, tmp_path: Path
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "precious.txt").write_text("mine")
    assert run(monkeypatch, "sweep-dmax", str(mission), "--out", str(tmp_path / "out")) == 2
    assert "--force" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["precious.txt"]


def test_json_is_all_that_stands_on_standard_output(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path, tmp_path: Path
) -> None:
    assert run(monkeypatch, "sweep-dmax", str(mission), "--json", "--jobs", "1", "--out", str(tmp_path / "out")) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["command"] == "sweep-dmax"
    assert summary == json.loads((tmp_path / "out" / "summary.json").read_text())
    page = (tmp_path / "out" / "report.html").read_text()
    assert "small &lt;b&gt;&amp;" in page
    assert "small <b>" not in page
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "figures",
        "mission.yaml",
        "report.html",
        "summary.json",
        "sweep.csv",
    ]


def test_planned_legs_give_a_mission_that_validates(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path, tmp_path: Path
) -> None:
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))  # the best of these legs
    out = tmp_path / "out"
    assert (
        run(monkeypatch, "plan-legs", str(mission), "--trials", "50", "--json", "--jobs", "1", "--out", str(out)) == 0
    )
    summary = json.loads(capsys.readouterr().out)
    assert summary["adaptive"]["cost"] == pytest.approx(0.0178, abs=2e-4)
    assert "a fixed d_max of 6.75\u00a0km is best" in (out / "report.html").read_text()  # the table saves 0.24 %
    assert run(monkeypatch, "validate", str(out / "mission-with-d_max.yaml")) == 0


HEAVY = {
    "pandas",
    "matplotlib",
    "xarray",
    "netCDF4",
    "pyarrow",
    "joblib",
    "loky",
    "dask",
    "pint",
    "pyproj",
    "jinja2",
    "rich",
}
HEAVY |= {f"scipy.{part}" for part in ("interpolate", "linalg", "ndimage", "optimize", "sparse", "special", "stats")}


IMPORTS = """
import sys
from pathlib import Path
from missionplan.cli import main
def seen(status):
    print("\\nseen", status, *sys.modules, file=sys.stderr)
def command(*words):
    sys.argv = ["missionplan", *words]
    try: main()
    except SystemExit as end: seen(end.code)
missions, measured, damaged, out = sys.argv[1:]
chesapeake = missions + "/chesapeake.yaml"
command("--help")
command("validate", *(f"{missions}/{name}.yaml" for name in ("anchor-design", "autosub-transition", "fig8")), chesapeake)
import missionplan.studies.exploration.cells, missionplan.studies.simulation.block_sequence
seen("trials")
command("diagnose", chesapeake, damaged, "--out", out)
from missionplan import diagnose, load
import missionplan.diagnosis.diagnose
from missionplan.diagnosis.data_kind import bind_dataset
bind_dataset(Path(measured), load(chesapeake), 1)
seen("bound")
"""


@pytest.fixture(scope="module")
def imports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """Modules that have been imported after each of five steps in one process, from little to much, by their ends."""
    folder, measured = tmp_path_factory.mktemp("imports"), MISSIONS / "measured" / "avila-drag"
    damaged = copytree(measured, folder / "damaged")
    (damaged / "dataset.yaml").write_text((damaged / "dataset.yaml").read_text().replace("file:", "fil:"))
    command = [sys.executable, "-c", IMPORTS, *map(str, (MISSIONS, measured, damaged, folder / "out"))]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    steps = [line.split()[1:] for line in done.stderr.splitlines() if line.startswith("seen ")]
    ends = [end for end, *_ in steps]
    assert ends == ["0", "0", "trials", "2", "bound"]
    names = ("help", "validate", "trials", "refused", "bound")
    return {name: set(modules) for name, (_, *modules) in zip(names, steps, strict=True)}


def test_help_defers_heavy_imports(imports: dict[str, set[str]]) -> None:
    assert not imports["help"] & (HEAVY - {"rich"} | {"numpy", "pydantic", "scipy"})


def test_workers_import_what_trials_need(imports: dict[str, set[str]]) -> None:
    assert not imports["trials"] & {"pandas", "matplotlib", "xarray", "jinja2", "dask"}


def test_diagnose_imports_one_kind_of_data(imports: dict[str, set[str]]) -> None:
    imported = imports["bound"]
    assert "missionplan.diagnosis.tank.kind" in imported
    others = {
        "missionplan.diagnosis.legs.kind",
        "missionplan.diagnosis.dives.kind",
        "missionplan.diagnosis.summaries",
    }
    assert not imported & (
        others | {"matplotlib", "xarray", "dask", "joblib", "jinja2", "missionplan.studies.simulation.simulate"}
    )


def test_diagnose_refuses_a_data_set_before_it_imports_the_diagnosis(imports: dict[str, set[str]]) -> None:
    assert not imports["refused"] & {"missionplan.diagnosis.diagnose", "scipy.linalg", "matplotlib"}


@pytest.mark.parametrize("command", ["diagnose", "score"])
def test_what_is_wrong_with_the_mission_and_with_each_data_set_is_told_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, command: str
) -> None:
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    (damaged / "dataset.yaml").write_text("{kind: descent, file: dives.csv}")
    (damaged / "dives.csv").write_text("run,t_s,depth\n1,0,0\n")
    given = [str(tmp_path / name) for name in ("missing.yaml", "missing", "damaged")]
    assert run(monkeypatch, command, *given) == 2
    errors = capsys.readouterr().err
    for words in ("missing.yaml: no such file", "missing/dataset.yaml: no such file", "dives.csv", "depth_m"):
        assert words in errors


def test_validate_imports_only_what_a_mission_needs(imports: dict[str, set[str]]) -> None:
    imported = imports["validate"]
    assert {"numpy", "missionplan.studies.validate"} <= imported
    unwanted = HEAVY | {"missionplan.studies.simulation.simulate"}
    assert not imported & (unwanted - {"rich"})  # which typer 0.15 imports by itself


@pytest.fixture
def without_sheet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulate without the sheet for the boat, which takes longer than few trials do."""
    monkeypatch.setattr(simulation, "_overdue", lambda *_: None)


@pytest.mark.usefixtures("without_sheet")
def test_simulate_is_resumed_refused_and_forced(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path, tmp_path: Path
) -> None:
    out = str(tmp_path / "out")
    common = ("simulate", str(mission), "--jobs", "1", "--json", "--no-assumptions", "--out", out)
    assert run(monkeypatch, *common, "--trials", "300") == 0
    first = json.loads(capsys.readouterr().out)
    assert run(monkeypatch, *common, "--trials", "300") == 2
    assert "--force" in capsys.readouterr().err
    assert run(monkeypatch, *common, "--trials", "300", "--resume") == 0
    assert json.loads(capsys.readouterr().out)["phases"] == first["phases"]
    assert run(monkeypatch, *common, "--trials", "300", "--seed", "2", "--resume") == 2
    assert "seed" in capsys.readouterr().err
    assert run(monkeypatch, *common, "--trials", "300", "--seed", "2", "--force") == 0
    assert json.loads(capsys.readouterr().out)["seed"] == 2


@pytest.mark.usefixtures("without_sheet")
def test_damaged_blocks_are_computed_again_with_a_warning(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
    mission: Path,
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    asked = ("--jobs", "1", "--json", "--no-assumptions", "--trials", "4100")
    common = ("simulate", str(mission), *asked, "--out", str(out))
    assert run(monkeypatch, *common) == 0
    first = json.loads(capsys.readouterr().out)
    blocks = sorted((out / "blocks").glob("block-*.npz"))
    whole = [path.read_bytes() for path in blocks]
    blocks[0].write_bytes(whole[0][:500] + bytes([whole[0][500] ^ 4]) + whole[0][501:])
    blocks[1].write_bytes(whole[0])
    (out / "blocks" / "run.json").write_text("{")
    assert run(monkeypatch, *common, "--resume") == 0
    again = json.loads(capsys.readouterr().out)
    assert {**again, "elapsed_s": 0, "created_utc": ""} == {**first, "elapsed_s": 0, "created_utc": ""}
    assert [path.read_bytes() for path in blocks] == whole
    assert "run.json is damaged" in caplog.text
    assert f"computed again: {blocks[0].name}, {blocks[1].name} (in" in caplog.text


@pytest.mark.parametrize("options", [[], ["--resume"], ["--force"]])
def test_blocks_being_a_file_is_said_before_the_run(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    mission: Path,
    tmp_path: Path,
    options: list[str],
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "blocks").write_text("precious")
    assert run(monkeypatch, "simulate", str(mission), "--out", str(out), *options) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert (out / "blocks").read_text() == "precious"


@pytest.mark.parametrize(("error", "status"), [(RunError("a worker process died"), 1), (KeyboardInterrupt(), 130)])
@pytest.mark.parametrize("blocks", [0, 1])
def test_a_run_that_is_cut_short_tells_how_to_go_on(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    mission: Path,
    error: BaseException,
    status: int,
    blocks: int,
) -> None:
    def cut_short(_: object, task: Callable[[object], object], items: Sequence[object]) -> Iterator[object]:
        yield from map(task, items[:blocks])
        raise error

    monkeypatch.setattr("missionplan.montecarlo.blocks.Workers.run", cut_short)
    out = mission.with_name("report")
    assert run(monkeypatch, "simulate", str(mission), "--trials", "5000", "--out", str(out)) == status
    assert (f"--resume --out {out}" in capsys.readouterr().err.replace("\n", "")) == bool(blocks)


def test_what_another_package_makes_of_an_interrupt_is_no_error() -> None:
    """Signals arrive amid anything: while pydantic builds a schema, which then fails with an error of its own."""
    failing = "try: signal.raise_signal(signal.SIGTERM)\n    except KeyboardInterrupt: raise RuntimeError('schema')"
    code = f"import signal, missionplan.cli as cli\ndef app(**_):\n    {failing}\ncli.app = app\ncli.main()"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr.split()) == (130, ["Interrupted."])


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("sent", "blocks"),
    [
        (signal.SIGINT, 1),
        pytest.param(signal.SIGINT, 20, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, 20, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 20, marks=pytest.mark.slow),
    ],
    ids=["Ctrl-C while workers start", "Ctrl-C", "SIGTERM", "SIGHUP"],
)
def test_an_interrupt_ends_a_run_in_few_words(mission: Path, tmp_path: Path, sent: signal.Signals, blocks: int) -> None:
    out = tmp_path / "report"
    words = ["simulate", mission, "--trials", "40000000", "--jobs", "2", "--out", out]
    run = subprocess.Popen(
        [sys.executable, "-m", "missionplan", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
        text=True,
        preexec_fn=lambda: signal.signal(sent, signal.SIG_DFL),  # a background shell or nohup ignores some
    )
    while run.poll() is None and len(list(out.rglob("block-*.npz"))) < blocks:
        time.sleep(0.02)
    os.killpg(run.pid, sent)
    said, _ = run.communicate(timeout=120)  # until the last process that could write has ended
    assert run.returncode == 130
    assert (
        said.replace("\n", " ").split()
        == f"Finished blocks are kept; go on with: --resume --out {out} Interrupted.".split()
    )


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_workers_end_when_the_command_is_killed(mission: Path, tmp_path: Path) -> None:
    out = tmp_path / "report"
    words = ["simulate", mission, "--trials", "40000000", "--jobs", "2", "--out", out, "--quiet"]
    run = subprocess.Popen([sys.executable, "-m", "missionplan", *words], stdout=subprocess.PIPE, text=True)
    while run.poll() is None and len(list(out.rglob("block-*.npz"))) < 6:
        time.sleep(0.02)
    run.kill()
    said, _ = run.communicate(timeout=60)  # until the last process that holds the pipe has ended
    assert said == ""


@pytest.mark.parametrize(
    "command", [["simulate"], ["simulate", "--resume"], ["sweep-dmax"], ["plan-legs"]], ids=" ".join
)
def test_a_report_never_replaces_its_mission(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, command: list[str]
) -> None:
    mission = tmp_path / "mission.yaml"
    mission.write_text(SMALL)
    assert run(monkeypatch, *command, str(mission), "--out", str(tmp_path), "--force", "--jobs", "1") == 2
    said = capsys.readouterr().err
    assert f"{mission}: is read by this command" in said
    assert "Traceback" not in said
    assert mission.read_text() == SMALL
    assert list(tmp_path.iterdir()) == [mission]


@pytest.mark.parametrize("command", ["diagnose", "identify", "vehicle", "current", "link", "compare"])
def test_a_report_never_replaces_other_files_that_were_read(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, command: str
) -> None:
    other = tmp_path / "read"
    other.mkdir()
    mission = tmp_path / "mission.yaml"
    mission.write_text(SMALL)
    words = [str(mission)]
    if command in ("diagnose", "identify"):
        (other / "dataset.yaml").write_text("{kind: transit, file: residuals.csv}")
        (other / "residuals.csv").write_text("precious")
        words = [*([str(mission)] if command == "diagnose" else []), str(other)]
    elif command == "vehicle":
        (other / "mission.yaml").write_text((MISSIONS.parent / "missionplan" / "starter" / "vehicle.yaml").read_text())
        mission.write_text(SMALL + "vehicle: read/mission.yaml\n")
    elif command == "current":
        (other / "mission.yaml").write_text("t_s,depth_m,east_m_s,north_m_s\n0,0,0,0\n")
        mission.write_text(SMALL + "site: {current: {file: read/mission.yaml}}\n")
    elif command == "link":
        mission.rename(other / "mission.yaml")
        mission.symlink_to(other / "mission.yaml")
    else:
        (other / "summary.json").write_text("precious")
        words = [str(tmp_path), str(other)]
    before = {path: path.read_text() for path in other.iterdir()}
    study = command if command in ("diagnose", "identify", "compare") else "sweep-dmax"
    assert run(monkeypatch, study, *words, "--out", str(other), "--force") == 2
    assert "is read by this command" in capsys.readouterr().err
    assert {path: path.read_text() for path in other.iterdir()} == before


def test_a_requirement_that_is_not_met_exits_with_3(
    monkeypatch: pytest.MonkeyPatch, mission: Path, tmp_path: Path
) -> None:
    mission.write_text(SMALL + "requirements: [{quantity: ingress.duration, at_most: 60 min, probability: 0.9}]\n")
    arguments = ("simulate", str(mission), "--jobs", "1", "--quiet", "--trials", "300", "--out", str(tmp_path / "out"))
    assert run(monkeypatch, *arguments) == 3
    assert (tmp_path / "out" / "report.html").exists()


def test_validate_lists_what_each_file_of_a_folder_is_ready_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "validate", str(MISSIONS)) == 0
    out = capsys.readouterr().out
    assert "simulate          ready" in out
    assert "sweep-transition  needs a transition" in out
    assert "valid data set of kind summary" in out
    for path in MISSIONS.glob("*.yaml"):
        assert f"{path.name}: valid" in out


def test_validate_reports_a_data_set_with_a_mission(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "dataset.yaml").write_text("kind: summary\nfile: t.csv\nruns: {a: {dpeth: 60 ft}, c: {depth: 9 m}}\n")
    rows = ("a,descent_time_s,-3,1", "a,descent_time_s,9,-1", "b,descent_tme_s,9,1")
    (tmp_path / "t.csv").write_text("\n".join(("run,quantity,value,sd", *rows)))
    assert run(monkeypatch, "validate", str(MISSIONS / "chesapeake.yaml"), str(tmp_path)) == 2
    errors = capsys.readouterr().err
    for said in ("did you mean depth?", "did you mean descent_time_s?", "t.csv:2: value", "t.csv:3: sd", "already"):
        assert said in errors


def test_validate_opens_the_file_of_the_current(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], mission: Path
) -> None:
    mission.write_text(SMALL + "site: {depth: 20 m, current: {file: c.csv}}\n")
    series = mission.with_name("c.csv")
    series.write_text("t_s,depth,east_m_s,north_m_s\n0,0,0,0\n")
    assert run(monkeypatch, "validate", str(mission)) == 2
    assert "c.csv:1: depth_m: the column is missing" in capsys.readouterr().err
    series.write_text("t_s,depth_m,east_m_s,north_m_s\n0,0,0,0\n1800,0,0,0\n")
    assert run(monkeypatch, "validate", str(mission)) == 2
    assert "the record lasts from 0 s to 1800 s" in capsys.readouterr().err


def test_a_probability_in_per_cent_is_asked_back(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ("size-anchor", str(MISSIONS / "anchor-design.yaml"), "--probability", "95")
    assert run(monkeypatch, *arguments, "--out", str(tmp_path / "out")) == 2
    assert "was 0.95 meant?" in capsys.readouterr().err


@pytest.mark.slow
def test_an_anchor_that_misses_the_missions_requirement_exits_with_3(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """However heavy the anchor, some dives drift out of the radius before the line is taut."""
    for name in ("anchor-design.yaml", "vehicles/vt475-self-mooring.yaml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text((MISSIONS / name).read_text())
    with (tmp_path / "anchor-design.yaml").open("a") as file:
        file.write("\nrequirements: [{quantity: moor.within_radius, probability: 0.99999}]\n")
    changed = (tmp_path / "anchor-design.yaml").read_text().replace("radius: 75 ft", "radius: 30 ft")
    (tmp_path / "anchor-design.yaml").write_text(changed)
    arguments = ("size-anchor", str(tmp_path / "anchor-design.yaml"), "--jobs", "1", "--trials", "100")
    assert run(monkeypatch, *arguments, "--out", str(tmp_path / "out")) == 3
    assert "No anchor does all that the mission requires" in " ".join(capsys.readouterr().out.split())
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["judged"]["requirements_met"], summary["succeeds"]) == (False, False)


@pytest.mark.parametrize("command", [["init"], ["init", "--data", "drag"], ["import", "--out", "data"]])
def test_a_name_that_is_too_long_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path, command: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(monkeypatch, *command, "a" * 300) in (1, 2)
    assert "a" * 300 in capsys.readouterr().err


def test_every_command_stands_in_one_group_of_the_help() -> None:
    named = [name for names in PANELS.values() for name in names]
    assert sorted(named) == sorted(str(command.name) for command in app.registered_commands)
    for panel, names in PANELS.items():
        assert panel.rpartition(" ")[2] in names, "each group says where to begin"


def test_bad_input_is_json_for_scripts(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("name: x\nphaes: []\n", encoding="utf-8")
    for command in ("validate", "simulate"):
        assert run(monkeypatch, command, str(bad), "--json") == 2
        (first, *_) = json.loads(capsys.readouterr().out)["errors"]
        assert (first["line"], first["key"], first["expected"]) == (2, "phaes", "did you mean phases?")
    assert run(monkeypatch, "simulate", str(bad), "--json", "--trials", "none") == 2
    assert "--trials" in json.loads(capsys.readouterr().out)["errors"][0]["message"]


def test_commands_about_files_answer_as_json_by_the_names_of_python(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    def answer(*words: str) -> dict[str, Any]:
        assert run(monkeypatch, *words, "--json") == 0
        return cast(dict[str, Any], json.loads(capsys.readouterr().out, parse_constant=pytest.fail))

    trial = str(tmp_path / "trial")
    made = answer("init", trial)["files"]
    assert sorted(made) == sorted(str(path) for path in (tmp_path / "trial").rglob("*") if path.is_file())
    exported = answer("export", f"{trial}/mission.yaml", "--to", "moos", "--out", str(tmp_path / "plan.bhv"))
    assert exported["files"] == [str(tmp_path / "plan.bhv")]
    assert exported["notes"]
    assert exported["lost"]
    (effect,) = answer("effects", "compass-bias")["effects"]
    assert (effect["id"], effect["parameters"]["angle"]["unit"]) == ("compass-bias", "rad")
    assert [entry["id"] for entry in answer("effects")["effects"]] == list(CATALOGUE)
    assert answer("schema", "mission") == missionplan.schema("mission")
    assert run(monkeypatch, "effects", "compas-bias", "--json") == 2
    assert json.loads(capsys.readouterr().out)["errors"][0]["expected"] == "did you mean compass-bias?"
    assert run(monkeypatch, "export", f"{trial}/mission.yaml", "--to", "mos", "--out", "plan", "--json") == 2
    assert json.loads(capsys.readouterr().out)["errors"][0]["message"].endswith("(did you mean moos?)")


def test_reports_are_listed_as_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    missionplan.sweep_transition(MISSIONS / "autosub-transition.yaml").save(tmp_path / "sweep")
    capsys.readouterr()
    for words in (("reports",), ("reports", "1")):
        assert run(monkeypatch, *words, "--root", str(tmp_path), "--json") == 0
        (entry,) = json.loads(capsys.readouterr().out)["reports"]
        (listed,) = missionplan.reports(tmp_path)
        assert (entry["folder"], entry["command"]) == (str(listed.folder), "sweep-transition")
        assert datetime.fromisoformat(entry["created"]) == listed.created


def test_every_command_takes_json() -> None:
    for command in app.registered_commands:
        assert "as_json" in inspect.signature(command.callback).parameters, command.name


def test_validate_as_json_says_what_files_are_good_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "validate", str(MISSIONS / "fig8.yaml"), "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["errors"] == []
    ready = {row["command"]: row["ready"] for row in found["files"][0]["commands"]}
    assert ready["simulate"]
    assert not ready["size-anchor"]
