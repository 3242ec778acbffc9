"""Known formats: those of this package, and those that installed packages add."""

from importlib import import_module
from importlib.metadata import entry_points

from missionplan.errors import Problem, shown
from missionplan.importers.importer import Importer
from missionplan.packages import PluginError, load_plugin

_GROUP = "missionplan.importers"
_OWN = ("slocum", "seaglider", "trajectory", "seaexplorer", "iver", "imc", "moos", "rosbag", "ardupilot", "track")
"""Modules of `readers`, in the order in which they are asked whether they recognise a file."""


def known_importers() -> tuple[dict[str, Importer], list[Problem]]:
    """Return the importers by name, and why any that an installed package adds is left out."""
    modules = [import_module(f"missionplan.importers.readers.{name}") for name in _OWN]
    found: dict[str, Importer] = {each.name: each for module in modules for each in module.IMPORTERS}
    left_out: list[Problem] = []
    for entry in entry_points(group=_GROUP):
        try:
            importer = load_plugin(entry)
            reason = "" if isinstance(importer, Importer) else "is no Importer"
        except PluginError as error:
            importer, reason = None, f"cannot be loaded: {error}"
        if isinstance(importer, Importer) and importer.name in found:
            reason = f"has the name of another, {shown(importer.name)}"
        if reason or not isinstance(importer, Importer):
            left_out.append(Problem(f"the importer {entry.name} ({entry.value}) is left out: it {reason}"))
        else:
            found = {importer.name: importer, **found}  # asked first: it knows its own files better
    return found, left_out
