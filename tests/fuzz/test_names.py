"""Every shipped mission with hostile names through every command that draws: nothing breaks out, nothing is lost.

The few that are quick run always; the whole matrix is slow.
"""

import csv
import io
import json
import zipfile
from functools import partial
from pathlib import Path

import pytest
import yaml
from matplotlib.figure import Figure

import missionplan
from missionplan.cli.running import _print_result
from missionplan.errors import InputError
from missionplan.exporters import token
from missionplan.mission import Mission
from missionplan.report.html import named_apart
from missionplan.report.page import Drawn, Page, PageSection
from missionplan.report.page import Figure as PageFigure

from . import examples
from .hostile_names import MARK, NAMES, ODD, named
from .looking import look_at_file, look_at_folder, look_at_page

pytestmark = pytest.mark.usefixtures("drawn")

FORMS = ("csv", "json", "gpx", "geojson", "kml", "slocum", "moos", "neptus", "iver", "qgc")
ALL = (*NAMES, *ODD)
PHASES = {"chesapeake": 3, "starter": 3, "fig8": 1, "anchor-design": 1, "autosub-transition": 1}
WORST = (NAMES[13], NAMES[12], "in$^$", "site", "limit run", "../../etc/passwd", "%s %(x)d {0} {{7*7}}")


def mission(name: str, names) -> Mission:
    return Mission.from_data(named(examples.mission(name), names))


def batches(name: str):
    """All names, as many at a time as a mission takes."""
    size = PHASES[name] + 2
    return [ALL[start : start + size] for start in range(0, len(ALL), size)]


def look_at_result(result, folder: Path) -> None:
    """Check what a result shows: its folder, in a notebook, on axes made elsewhere, in a terminal."""
    result.save(folder)
    look_at_folder(folder, result.provenance.data)
    assert MARK not in "".join(json.loads((folder / "summary.json").read_text()))  # of the keys
    page = look_at_page(f"<script></script>{result._repr_html_()}")
    assert page.words
    figure = Figure()
    result.plot(ax=figure.add_subplot())
    figure.canvas.draw()


def _explore(planned: Mission):
    key = next(f"{phase.name}.arrival_radius" for phase in planned.transits)
    return missionplan.explore(planned, vary=f"{key}=15 m,20 m", trials=20)


STUDIES = {
    "simulate": partial(missionplan.simulate, trials=20),
    "sweep-dmax": partial(missionplan.sweep_dmax, trials=20),
    "plan-legs": partial(missionplan.plan_legs, trials=20),
    "size-anchor": partial(missionplan.size_anchor, trials=20),
    "sweep-transition": missionplan.sweep_transition,
    "explore": _explore,
    "compare": lambda planned: missionplan.compare_missions(planned, planned.with_(name=NAMES[14]), trials=20),
    "rare": partial(missionplan.find_rare_failure, trials=100),
}
CASES = [
    *[("simulate", name) for name in PHASES],
    *[("sweep-dmax", name) for name in ("fig8", "chesapeake")],
    ("plan-legs", "fig8"),
    *[("size-anchor", name) for name in ("anchor-design", "chesapeake")],
    ("sweep-transition", "autosub-transition"),
    ("explore", "chesapeake"),
    ("compare", "chesapeake"),
    ("rare", "chesapeake"),
]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Glyph", "ignore:constrained_layout not applied")
@pytest.mark.parametrize(("study", "name"), CASES)
def test_hostile_names_do_no_harm(study, name, tmp_path):
    for number, names in enumerate(batches(name)):
        look_at_result(STUDIES[study](mission(name, names)), tmp_path / str(number))


def test_the_worst_names_do_no_harm_in_a_report(tmp_path, capsys):
    planned = mission("anchor-design", WORST)
    outcome = missionplan.simulate(planned, trials=20)
    look_at_result(outcome, tmp_path / "report")
    _print_result(outcome)
    shown = capsys.readouterr().out
    assert WORST[2] in " ".join(shown.split())
    assert outcome.summary()["phases"][0]["name"] == WORST[2]


@pytest.mark.parametrize("form", FORMS)
def test_hostile_names_do_no_harm_in_plans(form, tmp_path):
    for number, names in enumerate(batches("chesapeake")[:: {"kml": 1, "json": 1, "slocum": 8}.get(form, 4)]):
        out = tmp_path / str(number) / ("plan" if form in ("slocum", "iver", "qgc") else f"plan.{form}")
        out.parent.mkdir()
        planned = mission("chesapeake", names)
        if form == "slocum":  # at a glider's speed and depth, where it is not carried past its goal again and again
            slower = {"speed": "0.35 m/s", "depth": "6 m"}
            changes = {f"{each.name}.{key}": value for each in planned.transits for key, value in slower.items()}
            planned = planned.with_({**changes, "site.current": []})
        missionplan.export(planned, form, out=out, seed=1)
        for path in (path for path in out.parent.rglob("*") if path.is_file()):
            _look_at_plan(path, names)


def _look_at_plan(path: Path, names) -> None:
    content = path.read_bytes()
    if zipfile.is_zipfile(io.BytesIO(content)):
        with zipfile.ZipFile(io.BytesIO(content)) as parts:
            for name in parts.namelist():
                look_at_file("part.xml" if name.endswith(".nmis") else name, parts.read(name))
        return
    look_at_file(path.name, content)
    if path.suffix == ".json":
        told = [phase["name"] for phase in json.loads(content)["phases"]]
        assert told == [each.label for each in mission("chesapeake", names).phases]
    if path.suffix in (".ma", ".bhv", ".mis"):
        assert content.isascii()


def test_a_mission_with_hostile_names_is_the_same_when_it_is_written_and_read(tmp_path):
    for number, names in enumerate(batches("chesapeake")):
        planned = mission("chesapeake", names)
        path = planned.save(tmp_path / f"{number}.yaml")
        assert yaml.safe_load(path.read_text(encoding="utf-8")) == dict(planned.raw)
        assert missionplan.load(path).raw == planned.raw


@pytest.mark.parametrize("name", ["a\x1b[31m", "a\x00", "txt\u202egnp.exe", "a\x85"])
def test_a_name_that_moves_the_terminal_or_turns_the_text_is_refused(name):
    with pytest.raises(InputError, match="control characters"):
        mission("fig8", (name, "vehicle", "a"))


def test_figures_of_one_name_are_told_apart():
    figure = PageFigure("a-b", Drawn("<svg/>"), "", "")
    sections = [PageSection("", [figure, "words"]), PageSection("", [figure])]
    page = Page("", "", [], lambda: sections, lambda: ((), ()), lambda: figure)
    apart = named_apart(page)
    assert [block.name for section in apart.sections for block in section.blocks if block != "words"] == [
        "a-b-2",
        "a-b-3",
    ]


@pytest.mark.parametrize("name", ALL)
def test_a_token_is_a_short_word(name):
    assert len(token(3, name)) <= 44
    assert token(3, name).isidentifier() or token(3, name)[0] == "3"
    assert set(token(3, name)) <= set("0123456789_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")


def _dataset(folder: Path, kind: str, names) -> Path:
    """Write a small data set, itself and its runs by these names."""
    keys = dict(examples.DATASETS[kind][1]) | {"name": names[0]}
    rows = list(csv.reader(io.StringIO(examples.table(kind))))
    runs = dict(zip(dict.fromkeys(row[0] for row in rows[1:]), names[1:], strict=False)) if rows[0][0] == "run" else {}
    text = io.StringIO()
    csv.writer(text).writerows([[runs.get(row[0], row[0]), *row[1:]] for row in rows])
    if "runs" in keys:
        keys["runs"] = {runs[run]: told for run, told in keys["runs"].items()}
    examples.write_dataset(folder, kind, keys, text.getvalue().encode())
    return folder


HOSTILE = (WORST[:3], ("=1+1", "a: b # c", "</script>"), ("../../x", "%s", 'a,"b'))


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        pytest.param(kind, names, marks=pytest.mark.slow if names != HOSTILE[at] else ())
        for at, kind in enumerate(("drag", "thruster", "descent"))
        for names in HOSTILE
    ],
)
def test_hostile_names_of_data_and_runs_do_no_harm(kind, names, tmp_path):
    data = _dataset(tmp_path / "data", kind, names)
    result = missionplan.score(mission("chesapeake", WORST), data) if kind == "descent" else missionplan.identify(data)
    result.save(tmp_path / "report")
    look_at_folder(tmp_path / "report", result.provenance.data)
    assert names[0] in json.dumps(result.summary(), ensure_ascii=False).replace('\\"', '"')
