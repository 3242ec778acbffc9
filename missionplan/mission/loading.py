"""`load`: a mission file to a `Mission`, or every problem of the file at once."""

from pathlib import Path

from missionplan.mission.mission import Mission
from missionplan.mission.reading.documents import load_document
from missionplan.store.paths import as_path


def load(path: str | Path, *, allow_outside: bool = False) -> Mission:
    """Load and validate a mission file.

    Parameters
    ----------
    path : str or Path
        The mission file.
    allow_outside : bool
        Whether included files may lie outside the mission file's folder.

    Raises
    ------
    InputError
        With every problem of the file: file, line, key path, what was given, what was expected.
    """
    path = as_path(path, "path")
    return Mission.from_document(load_document(path), path.parent, allow_outside=allow_outside, file=str(path))
