"""`export`: files where they are asked for, nothing overwritten, one clear message where something is missing."""

import re
import sys
from functools import cache
from pathlib import Path
from typing import get_args

import pytest
import yaml

import missionplan
from missionplan.cli import main
from missionplan.cli.exchange import PlanFormat
from missionplan.errors import InputError
from missionplan.exporters import FORMATS, format_named

MISSIONS = Path(__file__).parents[2] / "missions"
CHESAPEAKE = str(MISSIONS / "chesapeake.yaml")
LOCAL = """
navigation: {velocity_error: {sigma: 0.035 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: out, from: [0 m, 0 m], to: [4 nmi, 0 m], speed: 1.25 m/s, d_max: 1 nmi, arrival_radius: 50 m}
"""


def for_format(name: str, folder: Path) -> str:
    """Mission that the vehicle of a format can sail: a glider's is slower and deeper, in slack water."""
    if name != "slocum":
        return CHESAPEAKE
    gliding = {f"{phase}.{key}": value for phase in ("ingress", "egress") for key, value in GLIDER.items()}
    data = missionplan.load(CHESAPEAKE).with_({**gliding, "site.current": []})
    path = folder / "chesapeake.yaml"
    path.write_text(yaml.safe_dump(dict(data.raw)))
    return str(path)


GLIDER = {"speed": "0.35 m/s", "depth": "6 m"}


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["missionplan", "export", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


def test_the_command_knows_every_format() -> None:
    assert set(get_args(PlanFormat)) == set(FORMATS)
    for name in FORMATS:
        form = format_named(name)
        assert form.TITLE
        assert isinstance(form.NEEDS_ORIGIN, bool)


@pytest.mark.parametrize("name", sorted(set(FORMATS) - {"gpkg"}))
def test_files_are_written_here_and_named(name, monkeypatch, tmp_path, capsys) -> None:
    (tmp_path / "given").mkdir()
    (tmp_path / "here").mkdir()
    mission = for_format(name, tmp_path / "given")
    monkeypatch.chdir(tmp_path / "here")
    assert run(monkeypatch, mission, "--to", name) == 0
    said = capsys.readouterr()
    written = [path.relative_to(tmp_path / "here") for path in (tmp_path / "here").rglob("*") if path.is_file()]
    assert sorted(said.out.splitlines()) == sorted(str(path) for path in written)
    assert "Note: uncertain quantities are at their means" in said.err
    for words in format_named(name).lost(plan_of(mission)):
        assert words.split(" (")[0][:30] in said.err


@cache
def plan_of(mission: str):
    from missionplan.studies.export import mission_plan

    return mission_plan(missionplan.load(mission))


def test_out_names_a_file_or_a_folder(monkeypatch, tmp_path) -> None:
    assert run(monkeypatch, CHESAPEAKE, "--to", "gpx", "--out", str(tmp_path / "route.gpx"), "-q") == 0
    assert run(monkeypatch, CHESAPEAKE, "--to", "csv", "--out", str(tmp_path), "-q") == 0
    assert run(monkeypatch, CHESAPEAKE, "--to", "iver", "--out", str(tmp_path / "boat"), "-q") == 0
    assert (tmp_path / "route.gpx").read_text().startswith("<?xml")
    assert (tmp_path / "chesapeake.csv").exists()
    assert list((tmp_path / "boat").glob("*.mis"))


def test_nothing_is_overwritten_unless_forced(monkeypatch, tmp_path, capsys) -> None:
    kept = tmp_path / "chesapeake.csv"
    kept.write_text("mine")
    assert run(monkeypatch, CHESAPEAKE, "--to", "csv", "--out", str(tmp_path)) == 2
    assert kept.read_text() == "mine"
    assert "chesapeake.csv: is there already (--force writes over it)" in capsys.readouterr().err
    assert run(monkeypatch, CHESAPEAKE, "--to", "csv", "--out", str(tmp_path), "--force", "-q") == 0
    assert kept.read_text() != "mine"


def test_a_mission_is_never_replaced_by_its_plan(monkeypatch, tmp_path, capsys) -> None:
    mission = tmp_path / "local.yaml"
    mission.write_text(LOCAL)
    assert run(monkeypatch, str(mission), "--to", "csv", "--out", str(mission), "--force") == 2
    assert mission.read_text() == LOCAL
    assert "is read by this command and is not replaced" in capsys.readouterr().err


def test_places_on_earth_need_an_origin(monkeypatch, tmp_path, capsys) -> None:
    mission = tmp_path / "local.yaml"
    mission.write_text(LOCAL)
    for name in set(FORMATS) - {"csv", "json", "svg", "moos"}:
        assert run(monkeypatch, str(mission), "--to", name, "--out", str(tmp_path / "x")) == 2
        assert re.search(
            r"local.yaml: site.origin: missing; positions on Earth, which the format \w+ has, need it",
            capsys.readouterr().err,
        )
    assert run(monkeypatch, str(mission), "--to", "csv", "--out", str(tmp_path / "x.csv"), "-q") == 0
    assert not (tmp_path / "x").exists()


def test_what_a_vehicle_cannot_do_is_refused(monkeypatch, tmp_path, capsys) -> None:
    assert run(monkeypatch, CHESAPEAKE, "--to", "slocum", "--out", str(tmp_path / "x")) == 2
    said = capsys.readouterr().err
    assert "ingress: a Slocum glider cannot make 1.5 m/s without a thruster" in said
    assert "egress: a Slocum glider cannot run at 2 m" in said
    assert not (tmp_path / "x").exists()


def test_a_mission_without_a_transit_has_no_course(monkeypatch, tmp_path, capsys) -> None:
    assert run(monkeypatch, str(MISSIONS / "anchor-design.yaml"), "--to", "csv", "--out", str(tmp_path / "x.csv")) == 2
    assert "no transit" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("export --to mooos", "--to: given 'mooos', expected one of csv, json"),
        (
            "simulate --backend dusk",
            "--backend: given 'dusk', expected one of loky, threading, dask (did you mean dask?)",
        ),
        ("simulate --units nauticl", "--units: given 'nauticl'"),
        ("simulate --as-exported quc", "--as-exported: given 'quc'"),
        ("sweep-dmax --method monte_carlo", "(did you mean monte-carlo?)"),
        ("plan-legs --aim men", "(did you mean mean?)"),
        ("explore --vary start=1:2:3 --aim energi", "(did you mean energy?)"),
        ("optimise --aim duratoin", "(did you mean duration?)"),
    ],
)
def test_a_misspelt_choice_of_an_option_points_to_the_nearest(words, said, monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", ["missionplan", *words.split(), CHESAPEAKE])
    with pytest.raises(SystemExit) as ended:
        main()
    errors = " ".join(capsys.readouterr().err.split())
    assert ended.value.code == 2
    assert said in errors
    assert "did you mean" in errors
    assert "Value error" not in errors


def test_an_unknown_format_is_an_input_error() -> None:
    with pytest.raises(InputError, match="csv"):
        missionplan.export(missionplan.load(CHESAPEAKE), "dos")


def test_names_of_any_writing_are_written(tmp_path) -> None:
    data = yaml.safe_load(LOCAL)
    data["name"] = "Fahrt ü–± <&> \n } # // =1"
    data["phases"][0]["transit"]["name"] = "Ærø } // =cmd"
    data["site"] = {"origin": {"latitude": "55 deg", "longitude": "10.4 deg"}}
    mission = missionplan.Mission.from_data(data)
    for name in sorted(set(FORMATS) - {"gpkg"}):
        mission = mission.with_({f"{mission.transits[0].name}.{k}": v for k, v in GLIDER.items()})
        written = missionplan.export(mission, name, out=tmp_path / name)
        assert all(path.stat().st_size for path in written.files)
