"""Arguments of the public functions: every wrong one at once, in Python's terms; the command line has its own."""

from collections.abc import Mapping, Sequence
from pathlib import PurePath

from missionplan.errors import InputError, Problem, shown
from missionplan.mission import Mission, as_mission

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
    return as_mission(mission)


def _choice(known: Sequence[object]) -> str:
    return f"one of {', '.join('None' if each is None else str(each) for each in known)}"


def _is_whole(value: object, least: int, most: float = float("inf")) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _wrong(argument: str, value: object, expected: str) -> Problem:
    return Problem(f"given {shown(value)}, expected {expected}", key=argument)
