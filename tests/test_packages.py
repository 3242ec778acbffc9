"""Code of other packages does no harm, and is named where it fails; what is missing is said how to install."""

import importlib.metadata
import sys
from dataclasses import replace

import pytest

from missionplan import identity, import_log
from missionplan.cli.running import progress_bar
from missionplan.effects import CATALOGUE, entry_problems, with_plugins
from missionplan.errors import InputError, RunError
from missionplan.importers import importer

HOOK = "def hook(speed):\n    return 1 / speed\n"


def _plugin(monkeypatch, tmp_path, text, group="missionplan.effects") -> importlib.metadata.EntryPoint:
    """Install a plug-in of one module, for the test."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    name = f"plugin_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(text)
    entry = importlib.metadata.EntryPoint("barnacles", f"{name}:INFO", group)
    for module in (identity, importer):
        monkeypatch.setattr(module, "entry_points", lambda group: [entry] if group == entry.group else [])
    return entry


@pytest.mark.parametrize(
    "text", ["import sys\nsys.exit(7)\n", "raise SystemExit\n", "import no_such_module\n", "1 +\n", ""]
)
def test_a_plugin_that_fails_or_ends_the_program_is_left_out_with_the_reason(monkeypatch, tmp_path, text):
    found = with_plugins(list(CATALOGUE.values()), [_plugin(monkeypatch, tmp_path, text)])
    assert list(found.entries) == list(CATALOGUE)
    assert "Error" in found.failed["barnacles"] or "SystemExit" in found.failed["barnacles"]


def test_what_a_plugin_prints_is_no_part_of_the_answer(monkeypatch, tmp_path, capsys):
    entry = _plugin(monkeypatch, tmp_path, "print('hello')\nINFO = 3\ndef hook():\n    print('again')\n")
    assert identity.load_plugin(entry) == 3
    with progress_bar("simulate", shown=False):
        sys.modules[entry.module].hook()
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "hello\nagain\n"


def test_an_error_in_a_hook_names_its_plugin(monkeypatch, tmp_path):
    entry = _plugin(monkeypatch, tmp_path, f"INFO = 3\n{HOOK}")
    identity.load_plugin(entry)
    hook = sys.modules[entry.module].hook
    with (
        pytest.raises(RunError, match=r"the plug-in barnacles failed: ZeroDivisionError"),
        progress_bar("a", shown=False),
    ):
        hook(0)
    with pytest.raises(ZeroDivisionError), progress_bar("a", shown=False):
        1 / 0  # noqa: B018 - a bug of our own keeps its traceback
    with pytest.raises(InputError), progress_bar("a", shown=False):
        raise InputError("a mistake of the user's")


@pytest.mark.parametrize("name", ["<script>", "Drag Bias", "", "a.b", "one_of", "é"])
def test_an_effect_has_a_name_that_can_stand_in_a_key_path(name):
    (problem,) = entry_problems(replace(CATALOGUE["mean-current"], id=name))
    assert "expected words of small letters" in problem


def test_a_broken_importer_stops_no_other(monkeypatch, tmp_path):
    _plugin(monkeypatch, tmp_path, "raise SystemExit(7)\n", "missionplan.importers")
    found, (problem,) = importer.known_importers()
    assert "track" in found
    assert str(problem).startswith("the importer barnacles (plugin_")
    log = tmp_path / "log.csv"
    log.write_text("time,lat,lon\n1,2,3\n")
    with pytest.raises(InputError, match="importer barnacles"):
        import_log(log, format="barnacles")


def test_a_line_longer_than_any_cell_is_no_traceback(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(f"time,lat,lon,{'x' * 140_000}\n1,2,3,4\n")
    with pytest.raises(InputError, match="no column") as wrong:
        import_log(log, names=["time=time", "lat=lat", "lon=lon"])
    assert len(str(wrong.value)) < 500


def test_the_command_that_installs_an_extra_names_its_libraries():
    assert identity.how_to_install("parquet") == "pip install 'pyarrow>=14'"
    assert identity.how_to_install("netcdf").startswith("pip install 'xarray")
    listed = importlib.metadata.metadata("missionplan").get_all("Provides-Extra")
    assert all(identity.how_to_install(extra).count("'") >= 2 for extra in listed)
