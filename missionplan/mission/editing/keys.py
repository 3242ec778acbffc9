"""Keys as people name them in Python: whole paths, paths from a phase's name, or a key alone."""

import re
from collections.abc import Iterator, Mapping, Sequence

from pydantic import BaseModel

from missionplan.errors import KeyPath, LocalProblem, did_you_mean, key_path
from missionplan.mission.quantity_paths import phase_of_path, written_phases
from missionplan.mission.reading.fields import fields_at, keys_of, section_in
from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.mission.schema.phases import PhaseEntry
from missionplan.mission.schema.shared_sections import is_in_force, name_in_force, overridden

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

    Parameters
    ----------
    key : str
        A path as messages write it (``navigation.velocity_error.sigma``, ``phases[0].transit.speed``), one that starts
        with a phase's name (``ingress.speed``) or with ``effects.`` and an effect's id, one of an explanation
        (``effects[0].one-of[1].compass-bias.angle``), or a key alone (``speed``): that of every phase that has it, or
        of the one section that has it.
    data : mapping
        The mission's data.
    model : type
        Of a mission.

    Raises
    ------
    UnclearKeyError
        When it means nothing, or several things.
    """
    named = phase_of_path(key, data)
    if named is not None:
        return [named[0].path + _parts(named[1])]
    path = _parts(key)
    if path[0] == "effects" and len(path) > 1 and isinstance(path[1], str):
        return [_effect_path(key, path, data.get("effects"), 1)]
    if path[0] == "effects" and ONE_OF in path[2:3] and path[4:5] not in _OF_EXPLANATIONS:
        return [_effect_path(key, path, _explained(path, data), 4)]
    if overridden(path, data):
        said = name_in_force(key)
        raise UnclearKeyError(key, f"changes nothing: the mission's own {said} goes before it", f"did you mean {said}?")
    if path[0] in keys_of(model):
        return [path]
    if len(path) > 1:
        known = [*keys_of(model), *(each.key for each in written_phases(data))]
        raise UnclearKeyError(key, "unknown key", did_you_mean(str(path[0]), known))
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
    known = [name for entry in entries if isinstance(entry, dict) for name in entry]
    hint = did_you_mean(str(path[at]), known) or f"it has {', '.join(known) or 'none'}"
    raise UnclearKeyError(key, "the mission has no such effect", hint)


def _explained(path: KeyPath, data: Mapping[str, object]) -> object:
    """Effects of the explanation that a path begins with; None where there is no such explanation."""
    found: object = data
    for part in (*path[:4], "effects"):
        if isinstance(found, list) and isinstance(part, int) and part < len(found):
            found = found[part]
        else:
            found = found.get(part) if isinstance(found, dict) and isinstance(part, str) else None
    return found


def _alone(key: str, data: Mapping[str, object], model: type[BaseModel]) -> list[KeyPath]:
    """Paths of a key given alone: in phases of one kind, or in one section; what the mission has goes first."""
    phases = _in_phases(key, data)
    sections = list(_in_sections(key, model, ()))
    present = [path for path in sections if _has(data, path[:-1]) and is_in_force(path, data)]
    groups = [*phases.values(), *([path] for path in present or ([] if phases else sections))]
    if len(groups) == 1:
        return groups[0]
    if not groups:
        known = {*keys_of(model), *_all_keys(model)}
        for kind in keys_of(PhaseEntry):
            known |= set(fields_at((kind,), PhaseEntry))
        raise UnclearKeyError(key, "unknown key", did_you_mean(key, sorted(known)))
    meant = [_as_named(path, data) for group in groups for path in group]
    raise UnclearKeyError(key, f"could be {', '.join(meant)}", "name one of them")


def _in_phases(key: str, data: Mapping[str, object]) -> dict[str, list[KeyPath]]:
    """Paths of a key in the phases that may have it, by the kind of phase."""
    found: dict[str, list[KeyPath]] = {}
    for phase in written_phases(data):
        if key in fields_at((phase.kind,), PhaseEntry):
            found.setdefault(phase.kind, []).append((*phase.path, key))
    return found


def _in_sections(key: str, model: type[BaseModel], path: KeyPath) -> Iterator[KeyPath]:
    """Paths of a key in sections inside sections; items of lists are left out."""
    for name, field in keys_of(model).items():
        if path and name == key:
            yield (*path, name)
        section = section_in(field.annotation)
        if section is not None and not _is_list(field.annotation):
            yield from _in_sections(key, section, (*path, name))


def _all_keys(model: type[BaseModel]) -> Iterator[str]:
    for name, field in keys_of(model).items():
        yield name
        section = section_in(field.annotation)
        if section is not None and not _is_list(field.annotation):
            yield from _all_keys(section)


def _is_list(annotation: object) -> bool:
    """Whether a section lies in a tuple, or is one of several by name."""
    text = str(annotation)
    return "tuple[" in text or "Mapping[" in text


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
