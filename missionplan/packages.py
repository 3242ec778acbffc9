"""Other packages: plug-ins, loaded with care and named where they fail, and libraries that only some features need."""

import sys
import traceback
from contextlib import redirect_stdout
from functools import cache
from importlib.metadata import EntryPoint, entry_points, requires, version
from importlib.util import find_spec

PLUGINS = ("missionplan.effects", "missionplan.importers")
"""Entry points by which other packages add code."""


version_of = cache(version)
"""Version of a package that is installed: its metadata are read once."""


class PluginError(Exception):
    """A plug-in cannot be loaded; its words say why."""


def load_plugin(entry: EntryPoint) -> object:
    """Load what an entry point names; what its module prints goes to standard error.

    Raises
    ------
    PluginError
        Whatever somebody else's code raises, also when it would end the program.
    """
    try:
        with redirect_stdout(sys.stderr):
            return entry.load()
    except (Exception, SystemExit) as error:
        raise PluginError(f"{type(error).__name__}: {error}") from error


def blamed_plugin(error: BaseException) -> str | None:
    """Name the plug-in in whose code an error arose, here or in another process; None where it arose in none."""
    frames = [line for line in "".join(traceback.format_exception(error)).splitlines() if 'File "' in line]
    for entry in (entry for group in PLUGINS for entry in entry_points(group=group)):
        if any(place in frame for place in _places(entry.module.partition(".")[0]) for frame in frames):
            return entry.name
    return None


def _places(package: str) -> list[str]:
    """Return where the code of a package lies: its folders, or its file."""
    spec = find_spec(package)
    if spec is None:
        return []
    return [f'"{folder}/' for folder in spec.submodule_search_locations or ()] or [f'"{spec.origin}"']


def how_to_install(extra: str) -> str:
    """Write the command that installs the libraries of an extra, wherever this package itself came from."""
    needed = [each.split(";") for each in requires("missionplan") or ()]
    libraries = [name.strip() for name, *marker in needed if f'extra == "{extra}"' in "".join(marker).replace("'", '"')]
    return " ".join(["pip install", *(f"'{library}'" for library in libraries)])
