"""Known formats: those of this package, and those that installed packages add."""

from importlib import import_module
from importlib.metadata import entry_points

from missionplan.errors import RunError
from missionplan.importers.importer import Importer

_GROUP = "missionplan.importers"
_OWN = ("slocum", "seaglider", "trajectory", "seaexplorer", "iver", "imc", "moos", "rosbag", "ardupilot", "track")
"""Modules of `readers`, in the order in which they are asked whether they recognise a file."""


def known_importers() -> dict[str, Importer]:
    """Return the importers by name.

    Raises
    ------
    RunError
        When an installed package's entry is no importer, or has the name of another.
    """
    modules = [import_module(f"missionplan.importers.readers.{name}") for name in _OWN]
    found: dict[str, Importer] = {each.name: each for module in modules for each in module.IMPORTERS}
    for entry in entry_points(group=_GROUP):
        try:
            importer = entry.load()
        except Exception as error:
            raise RunError(f"importer {entry.name} ({entry.value}) cannot be loaded: {error}") from error
        if not isinstance(importer, Importer) or importer.name in found:
            reason = "has the name of another" if isinstance(importer, Importer) else "is no Importer"
            raise RunError(f"importer {entry.name} ({entry.value}) {reason}")
        found = {importer.name: importer, **found}  # asked first: it knows its own files better
    return found
