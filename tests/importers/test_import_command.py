"""The command `import`, from raw files to a verdict, and what it says when something is wrong."""

import contextlib
import io
import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from made_tracks import made

from missionplan.cli import main
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.diagnose import diagnose
from missionplan.errors import InputError
from missionplan.importers import import_logs, importer
from missionplan.importers.descents import separations_by_sinking
from missionplan.importers.geodesy import model_declination, with_declination
from missionplan.importers.importer import Importer
from missionplan.importers.track import Series, Track
from missionplan.mission import load
from missionplan.report.imported.leg_basis import COLUMNS, basis_rows, explained_rows
from missionplan.report.page import draw, drawing_by

MADE = Path(__file__).parent / "made.gli"
NAMES = "time=t[epoch] lat=lat lon=lon dr_lat=a dr_lon=b depth=depth heading_true=heading"


def run(*arguments, cwd):
    """Run the command line in this process, in a folder: exit status and what it writes."""
    out, err = io.StringIO(), io.StringIO()
    words = ["missionplan", *map(str, arguments)]
    streams = contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)
    with (
        contextlib.chdir(cwd),
        streams[0],
        streams[1],
        mock.patch.object(sys, "argv", words),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    return SimpleNamespace(returncode=int(ended.value.code or 0), stdout=out.getvalue(), stderr=err.getvalue())


@pytest.fixture(scope="module")
def raw_folder(tmp_path_factory):
    """A folder as it comes from a vehicle: two tables, a photo and a note."""
    folder = tmp_path_factory.mktemp("raw")
    log = made(legs=24, duration=1800.0, pause=300.0, step=60.0, current=(0.08, 0.03))
    track = log.track
    rng = np.random.default_rng(4)
    own = pd.DataFrame({"t": track.reckoned.t, "a": track.reckoned.latitude, "b": track.reckoned.longitude})
    leg = np.searchsorted(log.starts, own["t"])
    elapsed = own["t"] - np.append(log.starts, np.inf)[np.maximum(leg - 1, 0)]
    noise = rng.normal(0.0, 0.01, (2, 26))[:, leg] * np.clip(elapsed.to_numpy(), 0.0, 1800.0)
    own["a"] += noise[0] / 111_200.0
    own["b"] += noise[1] / 74_600.0
    fixed = pd.DataFrame({"t": track.fixes.t, "lat": track.fixes.latitude, "lon": track.fixes.longitude})
    rows = fixed.merge(own, on="t", how="outer").sort_values("t")
    rows["depth"], rows["heading"] = (each.at(rows["t"].to_numpy()) for each in (track.depth, track.heading))
    half = len(rows) // 2
    rows[:half].to_csv(folder / "one.csv", index=False, float_format="%.9f")
    rows[half:].to_csv(folder / "two.csv", index=False, float_format="%.9f")
    (folder / "photo.jpg").write_bytes(b"\xff\xd8\xff")
    return folder


@pytest.fixture(scope="module")
def imported(raw_folder, tmp_path_factory):
    """The folder into which both files were imported as `data`, and the summary."""
    files, folder = [raw_folder / "one.csv", raw_folder / "two.csv"], tmp_path_factory.mktemp("imported")
    told = run("import", *files, "--out", "data", "--map", *NAMES.split(), "--json", cwd=folder)
    assert told.returncode == 0, told.stderr
    return folder, json.loads(told.stdout)


def test_the_legs_of_raw_files_show_the_current_that_they_were_sailed_in(imported):
    folder, _ = imported
    legs = read_transit(folder / "data", load(folder / "data" / "mission.yaml"))
    np.testing.assert_allclose(
        ((legs.end - legs.dead_reckoned) / legs.under_way).mean(axis=1), [0.08, 0.03], atol=0.015
    )


@pytest.mark.slow
def test_from_raw_files_to_a_verdict(raw_folder, tmp_path):
    files = [raw_folder / "one.csv", raw_folder / "two.csv"]
    assert run("import", *files, "--out", "data", "--map", *NAMES.split(), cwd=tmp_path).returncode == 0
    diagnosed = diagnose(tmp_path / "data" / "mission.yaml", tmp_path / "data", plan=False)
    found = json.loads(diagnosed.files()["diagnosis.json"])
    assert "mean-current" in found["causes"]
    values = {each["name"]: each["value"] for each in found["ranking"][0]["parameters"]}
    assert values["east"] == pytest.approx(0.08, abs=0.015)
    assert values["north"] == pytest.approx(0.03, abs=0.015)


def test_the_folder_holds_what_is_promised(imported):
    folder, summary = imported
    names = {path.name for path in (folder / "data").iterdir()}
    assert {"dataset.yaml", "legs.csv", "all-dives.csv", "import.json", "report.html", "mission.yaml"} <= names
    assert summary["counted"] == summary["legs"] == 24
    assert [each["name"] for each in summary["sources"]] == ["one.csv", "two.csv"]
    assert all(len(each["sha256"]) == 64 for each in summary["sources"])
    assert json.loads((folder / "data" / "import.json").read_text())["counted"] == 24
    page = (folder / "data" / "report.html").read_text()
    for words in ("What these data can show", "Every dive|All 24 dives count", "missionplan diagnose mission.yaml ."):
        assert re.search(words, page)
    mission = load(folder / "data" / "mission.yaml")
    assert mission.site.origin is not None
    checked = run("validate", "data", cwd=folder)
    assert checked.returncode == 0, checked.stderr


def test_nothing_is_overwritten(raw_folder, tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "mine.txt").write_text("mine")
    refused = run("import", MADE, "--out", "data", cwd=tmp_path)
    assert refused.returncode == 2
    assert "is not empty" in refused.stderr
    assert "Traceback" not in refused.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--shortest", "10"], "expected a unit too"),
        (["--dive-depth", "-3 m"], "expected more than 0"),
        (["--shift-origin", "north"], "expected a latitude and a longitude"),
        (["--shift-origin", "89,0"], "expected a latitude to 85 deg"),
        (["--kind", "trasit"], "did you mean transit"),
        (["--dive-depth", "900 m"], "no dive between"),
        (["--mark", "noon", "--kind", "descent"], "expected a time such as"),
    ],
)
def test_options_that_cannot_be_are_said(arguments, words, tmp_path):
    refused = run("import", MADE, "--out", "data", *arguments, cwd=tmp_path)
    assert refused.returncode == 2
    assert words in refused.stderr
    assert "Traceback" not in refused.stderr
    assert not (tmp_path / "data").exists()


def test_a_missing_library_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "imcpy", None)
    (tmp_path / "Data.lsf").write_bytes(b"")
    with pytest.raises(InputError, match="pip install 'imcpy>="):
        import_logs([tmp_path])


def test_an_installed_package_adds_an_importer(monkeypatch, tmp_path):
    track = made(legs=9).track
    own = Importer("own", "a made-up format", lambda path, head: path.suffix == ".own", lambda *_: track)

    class Entry:
        name, value = "own", "package:IMPORTER"

        def load(self):
            return own

    monkeypatch.setattr(importer, "entry_points", lambda group: [Entry()] if group == "missionplan.importers" else [])
    (tmp_path / "log.own").write_bytes(b"x")

    def reading(files, options, log):
        with log.reading(files[0]):
            return track
        return track

    own = replace(own, read=reading)
    assert import_logs([tmp_path]).counted == 9
    own = "no importer"
    with pytest.raises(InputError, match="no log of a known format"):
        import_logs([tmp_path])


def test_a_wrong_declination_is_seen_as_what_it_is():
    pytest.importorskip("pygeomag")
    t, track = 1_655_280_000.0, made(legs=3).track
    model = model_declination(48.0, -123.0, t)
    assert model == pytest.approx(15.8, abs=0.3)  # NOAA's calculator, WMM-2020, June 2022: 15.8 deg east
    wrong = Series(track.fixes.t[:1], np.array([-model]))
    told = with_declination(replace(track, heading_from="magnetic", declination=wrong)).notices
    assert any("which looks like an error of the compass" in notice for notice in told)


def dive_record(separations=(50.0, 400.0), depth=20.0, speed=0.5, step=0.5):
    """A depth record with dives at constant speed from each separation, and waves of 10 cm at the surface."""
    t = np.arange(0.0, 700.0, step)
    z = np.zeros_like(t)
    for start in separations:
        since = t - start
        sinking = np.clip(speed * since, 0.0, depth)
        z = np.where((since >= 0.0) & (since < 200.0), sinking, z)
    return Series(1_700_000_000.0 + t, z + np.where(z == 0.0, 0.1 * np.sin(2.0 * t), 0.0))


def test_separations_are_found_by_the_first_steady_sinking():
    record = dive_record()
    found = np.array(separations_by_sinking(record)) - 1_700_000_000.0
    np.testing.assert_allclose(found, [50.0, 400.0], atol=1.0)
    assert separations_by_sinking(dive_record(separations=())) == []


@pytest.mark.parametrize("by", ["sinking", "mark", "column"])
def test_a_depth_record_becomes_dives(by, tmp_path):
    record = dive_record()
    rows = pd.DataFrame({"t": record.t, "depth": record.values})
    rows["released"] = ((rows["t"] - record.t[0]) % 350.0 >= 50.0).astype(int)
    rows.to_csv(tmp_path / "dives.csv", index=False)
    names = ["time=t[epoch] depth=depth", *(["mark=released"] if by == "column" else [])]
    marks = ["2023-11-14T22:14:10Z", "1700000400"] if by == "mark" else []
    result = import_logs([tmp_path / "dives.csv"], kind="descent", names=names, marks=marks)
    assert result.counted == 2
    table = result.table
    if by != "sinking":
        first = table[table["run"] == "dive-1"]
        np.testing.assert_allclose(
            first["depth_m"][first["t_s"] > 0.5], 0.5 * first["t_s"][first["t_s"] > 0.5].clip(upper=40.0)
        )
    folder = result.save(tmp_path / "data")
    checked = run("validate", folder, cwd=tmp_path)
    assert checked.returncode == 0, checked.stderr
    assert "ready" in checked.stdout or "diagnose" in checked.stdout


def test_dives_need_a_depth(tmp_path):
    (tmp_path / "a.csv").write_text("t,lat,lon\n1700000000,1,2\n1700000100,1,2\n")
    with pytest.raises(InputError, match="hold no depth"):
        import_logs([tmp_path / "a.csv"], kind="descent", names=["time=t[epoch] lat=lat lon=lon"])


def test_an_empty_track_is_said(tmp_path):
    (tmp_path / "a.csv").write_text("t,lat,lon\n1700000000,0,0\n")
    with pytest.raises(InputError, match="0 fixes that count"):
        import_logs([tmp_path / "a.csv"], names=["time=t[epoch] lat=lat lon=lon"])
    assert isinstance(Track("a", "b", made(legs=1).track.fixes).depth, Series)


def test_a_track_due_north_is_drawn(tmp_path):
    """All of it at one longitude: the map has no width of its own."""
    rows = ["t,lat,lon,depth"]
    for n in range(2000):
        dive, step = divmod(n, 200)
        north = 1800 * dive + 10 * min(step, 180) + (0 if step < 180 else 40) + 40 * dive
        rows.append(
            f"{1.8e9 + 10 * n},{37.2 + north / 111000:.6f},-76.1,{60 * np.sin(np.pi * min(step, 180) / 180):.1f}"
        )
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    names = "time=t[epoch] lat=lat lon=lon depth=depth"
    with drawing_by(draw):
        done = run("import", "log.csv", "--out", "data", "--map", *names.split(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "data" / "figures" / "track.svg").is_file()


def test_one_table_says_what_each_leg_rests_on(raw_folder):
    files = [raw_folder / "one.csv", raw_folder / "two.csv"]
    result = import_logs(files, names=[NAMES], explain=[3])
    dives = result.dives
    assert (dives["fix_before_by"] == "place").all()  # the table states nothing of its fixes
    assert (dives["dr_by"] == "logged").all()
    assert dives["covered"].between(0.9, 1.0).all()
    assert (dives["gap_s"] <= result.basis.longest_gap).all()
    assert result.basis.heading == "true north"
    rows = basis_rows(dives, result.basis)
    assert len(rows) == 24
    assert all(len(row) == len(COLUMNS) for row in rows)
    told = dict(explained_rows(result, result.pictures[0]))
    assert told["counts?"] == "yes"
    assert told["fix before"].startswith(dives["t_start"].iloc[2])
    with pytest.raises(InputError, match="given 25, expected the number of a leg, 1 to 24"):
        import_logs(files, names=[NAMES], explain=[25])


def test_explaining_a_leg_draws_it_and_tells_it(raw_folder, tmp_path):
    files = [raw_folder / "one.csv", raw_folder / "two.csv"]
    with drawing_by(draw):
        told = run("import", *files, "--out", "data", "--explain", 3, "--map", NAMES, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    assert "longest gap under water" in told.stdout
    assert "24 of 24 dives between fixes count as legs" in re.sub(r"\s+", " ", told.stdout)
    assert (tmp_path / "data" / "figures" / "leg-3.svg").is_file()
    assert "Leg 3: what it rests on" in (tmp_path / "data" / "report.html").read_text()


@pytest.mark.slow
def test_why_goes_from_logs_to_a_verdict_in_one_command(raw_folder, tmp_path):
    done = run(
        "why",
        raw_folder / "one.csv",
        raw_folder / "two.csv",
        "--map",
        *NAMES.split(),
        "--jobs",
        1,
        "--out",
        tmp_path / "why",
        "--json",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["command"] == "diagnose"
    assert "mean-current" in {cause for causes in summary["credible_set"] for cause in causes}
    for name in ("report.html", "mission.yaml", "dataset/legs.csv", "dataset/mission.yaml", "dataset/report.html"):
        assert (tmp_path / "why" / name).is_file(), name
    assert load(tmp_path / "why" / "mission.yaml").effects


def test_what_is_wrong_with_logs_is_json_for_scripts(tmp_path):
    done = run("why", tmp_path / "nothing", "--json", cwd=tmp_path)
    assert done.returncode == 2
    (error,) = json.loads(done.stdout)["errors"]
    assert "nothing" in error["file"] + error["message"]
