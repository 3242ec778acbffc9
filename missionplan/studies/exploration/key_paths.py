"""Keys of a mission's data by their paths, such as ``ingress.speed``, ``site.current[0].speed``."""

import copy
import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.mission import Mission
from missionplan.mission.quantity_paths import phase_of_path, resolved_path
from missionplan.mission.schema.shared_sections import name_in_force, overridden

_STEP = re.compile(r"[^.\[\]]+|\[\d+\]")
_WHOLES = ("vehicle", "start", "site.current", "site.water", "vehicle.anchor")
"""Keys that may be varied as a whole, besides those that hold one value."""
_OF_THE_RUN = ("monte_carlo", "sweep", "optimise", "requirements", "correlations", "learned_from", "units", "name")
"""Sections that no choice of a mission can lie in."""


def known_key(mission: Mission, key: str, option: str) -> str:
    """Return the key path of a key that a person writes, with what stands for its phase.

    Parameters
    ----------
    mission : Mission
    key : str
    option : str
        How messages name the place where the key stands.

    Raises
    ------
    InputError
        With the nearest key.
    """
    if _STEP.findall(key)[:1] in [[name] for name in _OF_THE_RUN]:
        raise InputError([Problem(f"given the key {shown(key)}, which says how the mission is computed", key=option)])
    if overridden(tuple(key.split(".")), mission.raw):
        said = name_in_force(key)
        message = f"given the key {shown(key)}, which changes nothing: the mission's own {said} goes before it"
        raise InputError([Problem(message, key=option, hint=f"did you mean {said}?")])
    known, key = known_keys(mission), resolved_path(key, [phase.label for phase in mission.phases])
    if key in known or _is_written(mission.raw, key):
        return key
    hint = did_you_mean(key, known) or "such as start, ingress.speed, moor.line_length: key paths, phases by name"
    raise InputError([Problem(f"given the key {shown(key)}, which the mission does not have", key=option, hint=hint)])


def known_keys(mission: Mission) -> set[str]:
    """Return the key paths of a mission that hold one value each, given or not, phases by name."""
    found = set(_WHOLES)
    for name, value in mission:
        if name == "entries":
            for phase in mission.phases:
                _collect(phase, phase.name, found)
        elif name == "effect_list":
            found |= {path for entry in mission.effects for path in entry.names}
        elif name not in _OF_THE_RUN:
            _collect(value, name, found)
    return found | {".".join(map(str, each.path)) for each in mission.values_in_force()}


def _collect(value: object, path: str, found: set[str]) -> None:
    if isinstance(value, BaseModel):
        given = type(value).model_fields
        for name, inner in value:
            if not given[name].exclude:
                _collect(inner, f"{path}.{given[name].alias or name}", found)
    elif isinstance(value, tuple) and any(isinstance(each, BaseModel) for each in value):
        for index, inner in enumerate(value):
            _collect(inner, f"{path}[{index}]", found)
    else:
        found.add(path)


def with_values(data: Mapping[str, object], values: Mapping[str, object]) -> dict[str, object]:
    """Return a mission's data with other values at some key paths; sections that are missing are added.

    Raises
    ------
    InputError
        When a path leads through something that is no section.
    """
    changed = copy.deepcopy(dict(data))
    for key, value in values.items():
        _put(changed, key, copy.deepcopy(value))
    return changed


def _put(data: dict[str, object], key: str, value: object) -> None:
    section, steps = _within(data, key)
    try:
        for step in steps[:-1]:
            section = section[int(step[1:-1])] if step.startswith("[") else _below(section, step)
        last = steps[-1]
        section[int(last[1:-1]) if last.startswith("[") else last] = value
    except (TypeError, IndexError, KeyError):
        raise InputError([Problem("leads through a value that has no keys", key=key)]) from None


def _below(section: Any, step: str) -> Any:
    """Return what a key of a section holds; of a list of effects, the parameters of the one of that name."""
    effects = _effects_of(section, step)
    return section.setdefault(step, {}) if effects is None else _parameters(effects, step)


def _effects_of(section: Any, step: str) -> list[Any] | None:
    """Return the effects in which a step looks for one by its name: a list of them, or those of an explanation."""
    if isinstance(section, list):
        return section
    if not isinstance(section, dict) or "probability" not in section or step in section:
        return None
    held = section.get("effects")
    return held if isinstance(held, list) else None


def _parameters(effects: list[Any], name: str) -> Any:
    return next((entry[name] for entry in effects if isinstance(entry, dict) and name in entry), None)


def _within(data: dict[str, object], key: str) -> tuple[Any, list[str]]:
    """Return the section in which a path begins, the phase's where it begins with the name of one, and its steps."""
    named = phase_of_path(key, data)
    return (data, _STEP.findall(key)) if named is None else (named[0].section, _STEP.findall(named[1]))


def _is_written(data: Mapping[str, object], key: str) -> bool:
    """Whether the mission's file has something at a path."""
    section, steps = _within(dict(data), key)
    for step in steps:
        if isinstance(section, list) and step.startswith("["):
            index = int(step[1:-1])
            section = section[index] if index < len(section) else None
        elif (effects := _effects_of(section, step)) is not None:
            section = _parameters(effects, step)
        else:
            section = section.get(step) if isinstance(section, Mapping) else None
        if section is None:
            return False
    return bool(steps)
