"""Mission files: YAML in, validated missions in SI out.

Read first `sections` and `mission`, then `schema` (each section), `documents` (YAML with line marks), `includes`,
`validation_errors` and `checks` (between sections). `views` are missions with all that one kind of phase needs; `units`
and `schema.place` convert.
"""

from pathlib import Path, PurePath

from missionplan.errors import InputError, Problem, shown
from missionplan.mission.documents import load_document
from missionplan.mission.mission import Mission
from missionplan.store.folder import as_path

__all__ = ["Mission", "MissionOrPath", "as_mission", "load"]


MissionOrPath = Mission | str | Path
"""A mission, or the path of its file."""


def load(path: str | Path, *, allow_outside: bool = False) -> Mission:
    """Load and validate a mission file.

    Parameters
    ----------
    allow_outside : bool
        Whether included files may lie outside the mission file's folder.

    Raises
    ------
    InputError
        With every problem of the file: file, line, key path, what was given, what was expected.
    """
    path = as_path(path, "path")
    return Mission.from_document(load_document(path), path.parent, allow_outside=allow_outside, file=str(path))


def as_mission(mission: object) -> Mission:
    """Return a mission as it is, and load one that is given by the path of its file.

    Raises
    ------
    InputError
        When it is neither, or the file has problems.
    """
    if isinstance(mission, Mission):
        return mission
    if isinstance(mission, str | PurePath):
        return load(str(mission))
    message = f"given {shown(mission)}, expected a Mission, or the path of a mission file"
    raise InputError([Problem(message, key="mission")])
