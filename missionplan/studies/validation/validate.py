"""What a mission, a data set or a folder of them is good for: everything that any command would refuse, at once."""

from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath

from missionplan.errors import InputError
from missionplan.mission import Mission, MissionOrPath, load
from missionplan.store.paths import as_path, is_folder
from missionplan.studies.validation.missions import validated_mission
from missionplan.studies.validation.readiness import Validated


def validate(paths: MissionOrPath | Iterable[MissionOrPath], *, allow_outside: bool = False) -> tuple[Validated, ...]:
    """Check missions and data sets, and say what each is good for.

    Parameters
    ----------
    paths : str, Path, Mission or iterable of them
        Missions, mission files, data sets, and folders: of these all missions and data sets, and what is below.
    allow_outside : bool
        Whether included files may lie outside a mission file's folder, and tables outside their data set's.

    Returns
    -------
    tuple of Validated
        Missions first; a data set is checked with the first of them that gives it what its runs leave to it.
    """
    given = [paths] if isinstance(paths, Mission | str | PurePath) else list(paths)
    found = [
        each for one in given for each in ([one] if isinstance(one, Mission) else _expanded(as_path(one, "paths")))
    ]
    datasets = [each for each in found if isinstance(each, Path) and is_folder(each)]
    done: list[Validated] = []
    valid: list[Mission] = []
    for each in found:
        if each in datasets:
            continue
        path = Path(each.file) if isinstance(each, Mission) else each
        try:
            mission = each if isinstance(each, Mission) else load(each, allow_outside=allow_outside)
            done.append(validated_mission(path, mission))
        except InputError as error:
            done.append(Validated(path, problems=error.problems))
        else:
            valid.append(mission)
    if datasets:
        from missionplan.datasets.reading import files_outside
        from missionplan.studies.validation.datasets import validated_dataset

        with files_outside(allowed=allow_outside):
            done += [validated_dataset(path, valid) for path in datasets]
    return tuple(done)


def _expanded(path: Path) -> Iterator[Path]:
    """Missions and data sets in a folder and below; what is neither stays, to be refused."""
    if not is_folder(path) or (path / "dataset.yaml").is_file():
        yield path
        return
    datasets = sorted(each.parent for each in path.rglob("dataset.yaml"))
    inside = [each for each in sorted((*path.rglob("*.yaml"), *path.rglob("*.yml"))) if each.parent not in datasets]
    missions = [each for each in inside if _is_mission(each)]
    yield from (*missions, *datasets)
    if not missions and not datasets:
        yield path


def _is_mission(path: Path) -> bool:
    """Whether a file of a folder is meant as a mission: it has phases, and is not a vehicle."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return True  # said by whoever loads it
    return any(line.startswith(("phases:", "navigation:", "site:")) for line in lines)
