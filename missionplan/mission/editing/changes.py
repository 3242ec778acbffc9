"""Changes of a mission's data, by keys as people name them."""

import copy
from collections.abc import Mapping

from pydantic import BaseModel

from missionplan.errors import InputError, KeyPath, Problem, key_path, shown
from missionplan.mission.editing.keys import UnclearKeyError, find_key
from missionplan.mission.editing.units import as_written


def changed_data(
    data: Mapping[str, object], changes: Mapping[str, object], model: type[BaseModel], file: str = ""
) -> dict[str, object]:
    """Return a mission's data with changes.

    Parameters
    ----------
    data : mapping
        The mission's data; copied.
    changes : mapping
        New values by key, see `find_key`; None removes a key.
    model : type
        Of a mission.
    file : str
        How messages name the mission.

    Raises
    ------
    InputError
        With every key that means nothing, or several things.
    """
    changed = copy.deepcopy(dict(data))
    problems: list[Problem] = []
    for key, value in changes.items():
        try:
            for path in find_key(str(key), changed, model):
                _set(changed, path, as_written(value, path, model), str(key))
        except UnclearKeyError as error:
            problems.append(Problem(error.problem.message, file, key=str(key), hint=error.problem.hint))
    if problems:
        raise InputError(problems)
    return changed


def _set(data: dict[str, object], path: KeyPath, value: object, key: str) -> None:
    """Set or remove the value at a path; sections on the way that are missing are made."""
    parent: object = data
    for depth, part in enumerate(path[:-1]):
        if isinstance(parent, dict):
            if parent.get(str(part)) is None:
                parent[str(part)] = {}
            parent = parent[str(part)]
        else:
            parent = _item(parent, part, path[: depth + 1], key)
    last = path[-1]
    if isinstance(parent, dict):
        if value is None:
            parent.pop(str(last), None)
        else:
            parent[str(last)] = value
    else:
        _item(parent, last, path, key)
        if isinstance(parent, list) and isinstance(last, int):
            parent[last : last + 1] = [] if value is None else [value]


def _item(parent: object, part: str | int, path: KeyPath, key: str) -> object:
    """Return an item of a list, or say that there is none."""
    if isinstance(parent, list) and isinstance(part, int):
        if part < len(parent):
            return parent[part]
        raise UnclearKeyError(key, f"{key_path(path[:-1])} has {len(parent)} items, counted from 0")
    raise UnclearKeyError(key, f"{key_path(path[:-1])} is {shown(parent)}, which has no key {part}")
