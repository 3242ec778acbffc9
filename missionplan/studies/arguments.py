"""What studies of a mission share: their arguments, every wrong one at once, and what their results come from."""

import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path, PurePath

from missionplan.errors import InputError, Problem, shown
from missionplan.identity import digest_of_files, running_program
from missionplan.mission import Mission, as_mission
from missionplan.results.base import Provenance

MAX_JOBS = 10_000


def check_arguments(
    mission: object,
    *,
    trials: object = None,
    seed: object = None,
    jobs: object = 1,
    one_of: Mapping[str, tuple[object, Sequence[object]]] | None = None,
    text: Mapping[str, object] | None = None,
) -> Mission:
    """Check the arguments that studies share, and return the mission, loaded where its path is given.

    Parameters
    ----------
    mission : object
        Expected to be a `Mission` or the path of its file.
    trials, seed, jobs : object
        Expected to be whole numbers; None, for the first two, is the mission's.
    one_of : mapping, optional
        By argument: what is given, and what may be.
    text : mapping, optional
        Arguments that are text or None.

    Raises
    ------
    InputError
        With every argument that is wrong, else every problem of the mission's file.
    """
    kinds = (
        ("mission", mission, isinstance(mission, Mission | str | PurePath), "a Mission, or the path of a mission file"),
        ("trials", trials, trials is None or _is_whole(trials, 1), "a whole number, at least 1"),
        ("seed", seed, seed is None or _is_whole(seed, 0), "a whole number, at least 0"),
        (
            "jobs",
            jobs,
            jobs == -1 or _is_whole(jobs, 1, MAX_JOBS),
            f"a whole number from 1 to {MAX_JOBS}, or -1 for every core",
        ),
        *((name, value, value is None or isinstance(value, str), "text") for name, value in (text or {}).items()),
        *((name, value, value in known, _choice(known)) for name, (value, known) in (one_of or {}).items()),
    )
    problems = [_wrong(name, value, expected) for name, value, is_right, expected in kinds if not is_right]
    if problems:
        raise InputError(problems)
    running_program()  # as it is before anything is computed
    return as_mission(mission)


def identified(mission: Mission) -> dict[str, object]:
    """Return a mission as an input of an identity: trials and seed stand in it by themselves, as they were chosen."""
    return {"mission": {key: value for key, value in mission.identified().items() if key != "monte_carlo"}}


def identified_datasets(folders: Iterable[Path]) -> dict[str, object]:
    """Return data sets as an input of an identity: the SHA-256 of each of their files."""
    from missionplan.datasets.reading import dataset_files  # pandas: half a second

    found = []
    for folder in folders:
        files = {str(path.relative_to(folder)): digest_of_files([path]) for path in dataset_files(folder)}
        found.append({"name": folder.resolve().name, "files": files})
    return {"datasets": found}


def made_by(
    command: str,
    mission: Mission,
    *,
    seed: int,
    trials: int,
    options: Mapping[str, object],
    started: float,
    notices: Sequence[str] = (),
    datasets: Sequence[Path] = (),
) -> Provenance:
    """Tell where the result of a study of a mission comes from.

    Parameters
    ----------
    command : str
    mission : Mission
    seed, trials : int
        As they were chosen, or what a search ran.
    options : mapping
    started : float
        `time.perf_counter` at the study's beginning [s].
    notices : sequence of str
    datasets : sequence of Path
        Folders that it read besides.
    """
    return Provenance(
        command=command,
        mission=mission.name,
        file=mission.file,
        seed=seed,
        trials=trials,
        options=options,
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=tuple(notices),
        inputs={**identified(mission), **(identified_datasets(datasets) if datasets else {})},
    )


def _choice(known: Sequence[object]) -> str:
    return f"one of {', '.join('None' if each is None else str(each) for each in known)}"


def _is_whole(value: object, least: int, most: float = float("inf")) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _wrong(argument: str, value: object, expected: str) -> Problem:
    return Problem(f"given {shown(value)}, expected {expected}", key=argument)
