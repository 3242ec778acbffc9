"""Changes of a mission's data, by keys as people name them in Python, with numbers in SI."""

import copy
import math
import re
from collections.abc import Iterator, Mapping, Sequence

from pydantic import BaseModel

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, KeyPath, LocalProblem, Problem, counted, did_you_mean, key_path, shown
from missionplan.mission.quantity_paths import is_in_force, name_in_force, overridden, phase_of_path, written_phases
from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.mission.schema.phases import PhaseEntry
from missionplan.mission.validation_errors import fields_at, keys_of, parsers_of, section_in
from missionplan.montecarlo.distributions import Choices, LogNormal, Normal, TruncatedNormal, Uniform

_SPREADS = ("mean", "sd", "low", "high", "median", "choices")
"""Keys of distributions that are in the quantity's unit."""


def as_written(value: object, path: KeyPath, model: type[BaseModel]) -> object:
    """Return a value as a mission file holds it: bare numbers get the SI unit of their key, where that has one.

    `value`: text, a number in SI, a distribution, or mappings and lists of them; `path`: its key path; `model`: that of
    a mission.
    """
    if isinstance(value, Mapping):
        return {str(key): as_written(inner, (*path, str(key)), model) for key, inner in value.items()}
    if isinstance(value, Normal | TruncatedNormal | Uniform | LogNormal | Choices):
        return as_written(_forms(value), path, model)
    if hasattr(value, "tolist"):  # of numpy
        return as_written(value.tolist(), path, model)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_written(inner, (*path, index), model) for index, inner in enumerate(value)]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    unit = unit_at(path, model)
    short = f"{value:g}"
    return f"{short if float(short) == value else repr(value)} {unit}" if unit else value


def unit_of(key: str, data: Mapping[str, object], model: type[BaseModel]) -> str:
    """SI unit of the quantity that a key means, as `find_key` takes it; empty where it has none, or means nothing."""
    try:
        parts = _parts(key)
        return unit_at(parts if parts[0] == "effects" else find_key(key, data, model)[0], model)
    except UnclearKeyError:
        return ""


def unit_at(path: KeyPath, model: type[BaseModel]) -> str:
    """SI unit of the quantity at a key path; empty where it has none, or where it depends on other keys."""
    while path and (isinstance(path[-1], int) or path[-1] in _SPREADS) and path[-1] not in fields_at(path[:-1], model):
        path = path[:-1]
    if path[:1] == ("effects",):
        effect, name = str(path[-2]), str(path[-1])
        parameters = CATALOGUE[effect].parameters if effect in CATALOGUE else {}
        return parameters[name].unit if name in parameters else ""
    field = fields_at(path[:-1], model).get(str(path[-1])) if path else None
    units = {parser.unit for parser in parsers_of(field)} if field is not None else set()
    return units.pop() if len(units) == 1 else ""


def _forms(value: Normal | TruncatedNormal | Uniform | LogNormal | Choices) -> dict[str, object]:
    """A distribution by the keys of a mission file."""
    if isinstance(value, Choices):
        return {"choices": list(value.values)}
    if isinstance(value, TruncatedNormal):
        bounds = {"low": value.low, "high": value.high}
        finite = {key: bound for key, bound in bounds.items() if math.isfinite(bound)}
        return {"mean": value.parent_mean, "sd": value.parent_sd, **finite}
    keys = {Normal: ("mean", "sd"), Uniform: ("low", "high"), LogNormal: ("median", "factor")}[type(value)]
    return {key: getattr(value, key) for key in keys}


_PART = re.compile(r"([^.\[\]]+)((?:\[\d+\])*)")
_OF_EXPLANATIONS = ((), ("probability",), ("effects",), ("correlations",))
"""What may follow an explanation in a path besides an effect's id."""


class UnclearKeyError(ValueError):
    """A key that names nothing, or more than one thing."""

    def __init__(self, key: str, message: str, hint: str = "") -> None:
        self.problem = LocalProblem((key,), message, hint)
        super().__init__(message)


def find_key(key: str, data: Mapping[str, object], model: type[BaseModel]) -> list[KeyPath]:
    """Find the key paths that a key means.

    Raises UnclearKeyError when it means nothing, or several things.

    `key`: a path as messages write it (``navigation.velocity_error.sigma``, ``phases[0].transit.speed``), one that
    starts with a phase's name (``ingress.speed``) or with ``effects.`` and an effect's id, one of an explanation
    (``effects[0].one-of[1].compass-bias.angle``), or a key alone (``speed``): that of every phase that has it, or of
    the one section that has it. `model`: of a mission.
    """
    named = phase_of_path(key, data)
    if named is not None:
        return [named[0].path + _parts(named[1])]
    path = _parts(key)
    if path[0] == "effects" and len(path) > 1 and isinstance(path[1], str):
        return [_effect_path(key, path, data.get("effects"), 1)]
    if path[0] == "effects" and ONE_OF in path[2:3] and path[4:5] not in _OF_EXPLANATIONS:
        return [_effect_path(key, path, value_at(data, (*path[:4], "effects")), 4)]
    if overridden(path, data):
        said = name_in_force(key)
        raise UnclearKeyError(key, f"changes nothing: the mission's own {said} goes before it", f"did you mean {said}?")
    if path[0] in keys_of(model):
        return [path]
    if len(path) > 1:
        keys = [*keys_of(model), *(phase.key for phase in written_phases(data))]
        raise UnclearKeyError(key, "unknown key", did_you_mean(str(path[0]), keys))
    return _alone(key, data, model)


def _parts(key: str) -> KeyPath:
    """Split a key path: ``current[0].speed`` is current, 0, speed."""
    path: list[str | int] = []
    for part in key.split("."):
        match = _PART.fullmatch(part)
        if match is None:
            raise UnclearKeyError(
                key, "is not a key path, such as navigation.velocity_error.sigma or site.current[0].speed"
            )
        path += [match[1], *(int(index) for index in re.findall(r"\d+", match[2]))]
    return tuple(path)


def _effect_path(key: str, path: KeyPath, effects: object, at: int) -> KeyPath:
    """Path of an effect of a list, by its id, which stands at a place in the path."""
    entries = effects if isinstance(effects, list) else []
    for index, entry in enumerate(entries):
        if isinstance(entry, dict) and path[at] in entry:
            return (*path[:at], *(("effects",) if at > 1 else ()), index, *path[at:])
    names = [name for entry in entries if isinstance(entry, dict) for name in entry]
    hint = did_you_mean(str(path[at]), names) or f"it has {', '.join(names) or 'none'}"
    raise UnclearKeyError(key, "the mission has no such effect", hint)


def _alone(key: str, data: Mapping[str, object], model: type[BaseModel]) -> list[KeyPath]:
    """Paths of a key given alone: in phases of one kind, or in one section; what the mission has goes first."""
    phases = _in_phases(key, data)
    sections = [path for path in _paths_below(model, ()) if len(path) > 1 and path[-1] == key]
    present = [path for path in sections if _has(data, path[:-1]) and is_in_force(path, data)]
    groups = [*phases.values(), *([path] for path in present or ([] if phases else sections))]
    if len(groups) == 1:
        return groups[0]
    if not groups:
        keys = {str(path[-1]) for path in _paths_below(model, ())}
        for kind in keys_of(PhaseEntry):
            keys |= set(fields_at((kind,), PhaseEntry))
        raise UnclearKeyError(key, "unknown key", did_you_mean(key, sorted(keys)))
    meant = [_as_named(path, data) for group in groups for path in group]
    raise UnclearKeyError(key, f"could be {', '.join(meant)}", "name one of them")


def _in_phases(key: str, data: Mapping[str, object]) -> dict[str, list[KeyPath]]:
    """Paths of a key in the phases that may have it, by the kind of phase."""
    paths: dict[str, list[KeyPath]] = {}
    for phase in written_phases(data):
        if key in fields_at((phase.kind,), PhaseEntry):
            paths.setdefault(phase.kind, []).append((*phase.path, key))
    return paths


def _paths_below(model: type[BaseModel], path: KeyPath) -> Iterator[KeyPath]:
    """Paths of all keys, in sections inside sections too; items of lists, and what is by name, are left out."""
    for name, field in keys_of(model).items():
        yield (*path, name)
        section, text = section_in(field.annotation), str(field.annotation)
        if section is not None and "tuple[" not in text and "Mapping[" not in text:
            yield from _paths_below(section, (*path, name))


def _has(data: object, path: Sequence[str | int]) -> bool:
    for part in path:
        if not isinstance(data, Mapping) or part not in data:
            return False
        data = data[part]
    return True


def _as_named(path: KeyPath, data: Mapping[str, object]) -> str:
    for phase in written_phases(data):
        if path[: len(phase.path)] == phase.path:
            return f"{phase.key}.{key_path(path[len(phase.path) :])}"
    return key_path(path)


def changed_data(
    data: Mapping[str, object],
    changes: Mapping[str, object],
    model: type[BaseModel],
    file: str = "",
    *,
    in_si: bool = True,
) -> dict[str, object]:
    """Return a mission's data with changes.

    Raises InputError with every key that means nothing, or several things.

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
    in_si : bool
        Whether bare numbers are in SI, as in Python, and get the unit of their key; else they stay as a file's.
    """
    changed = copy.deepcopy(dict(data))
    problems: list[Problem] = []
    for key, value in changes.items():
        try:
            for path in find_key(str(key), changed, model):
                _set(changed, path, as_written(value, path, model) if in_si else copy.deepcopy(value), str(key))
        except UnclearKeyError as error:
            problems.append(Problem(error.problem.message, file, key=str(key), hint=error.problem.hint))
    if problems:
        raise InputError(problems)
    return changed


def value_at(data: object, path: KeyPath) -> object:
    """Return what data hold at a key path; None where they hold nothing."""
    for part in path:
        if isinstance(data, Mapping):
            data = data.get(str(part))
        else:
            data = data[part] if isinstance(data, list) and isinstance(part, int) and part < len(data) else None
    return data


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
        raise UnclearKeyError(key, f"{key_path(path[:-1])} has {counted(len(parent), 'item')}, counted from 0")
    raise UnclearKeyError(key, f"{key_path(path[:-1])} is {shown(parent)}, which has no key {part}")
