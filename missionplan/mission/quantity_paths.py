"""Key paths: which part of them stands for a phase, and which of two a key has that mission and vehicle file may hold.

Every quantity in a section of a mission by its name, and the same section with other values in their places.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeVar, cast

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from missionplan.errors import KeyPath, key_path
from missionplan.mission.schema import FileSection, ReadBy
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.vehicle import EnergyBudget
from missionplan.montecarlo.normal_transform import NormalTransform

SECTIONS = frozenset(
    {
        *("schema", "name", "start", "units", "vehicle", "site", "navigation", "phases", "sweep", "optimise"),
        *("monte_carlo", "energy", "requirements", "correlations", "effects", "posterior", "learned_from", "total"),
    }
)
"""First parts of key paths that stand for no phase: the sections of a mission file, and the whole mission."""
_PLAIN = re.compile(r"[^\W_][\w-]*(?: [\w-]+)*")
_STEP = re.compile(r"[.\[]")
_LONGEST = 40


def phase_keys(names: Sequence[str]) -> tuple[str, ...]:
    """Return what stands for each phase in key paths: its name, or its number in the mission.

    A name is a label that people choose. It serves in key paths where it is made of words and is no section's; else the
    phase has its place in the file: ``phases[1]``.
    """
    plain = [len(name) <= _LONGEST and _PLAIN.fullmatch(name) and name not in SECTIONS for name in names]
    return tuple(name if plain[number] else f"phases[{number}]" for number, name in enumerate(names))


def named_phase(path: str, names: Iterable[str], *, with_sections: bool = True) -> tuple[str, str] | None:
    """Split a key path that begins with the name of a phase.

    `path`: as a person writes it. `names`: of the phases. `with_sections`: whether the path may be that of a section,
    which goes before a phase of the same name.

    Returns
    -------
    name, rest : str
        None where the path begins with no phase's name; of several names the longest.
    """
    if with_sections:
        names = [name for name in names if _STEP.split(name, 1)[0] not in SECTIONS]
    name = max((name for name in names if path.startswith(f"{name}.")), key=len, default=None)
    return None if name is None else (name, path[len(name) + 1 :])


def resolved_path(path: str, names: Sequence[str], *, with_sections: bool = True) -> str:
    """Return a key path that a person writes by a phase's name, with what stands for the phase; see `named_phase`."""
    named = named_phase(path, names, with_sections=with_sections)
    return path if named is None else f"{phase_keys(names)[names.index(named[0])]}.{named[1]}"


class WrittenPhase(NamedTuple):
    """A phase in a mission file's data: what stands for it in key paths, its name, its place and its keys."""

    key: str
    name: str
    path: KeyPath
    section: Mapping[str, object]

    @property
    def kind(self) -> str:
        """Such as ``transit``."""
        return str(self.path[-1])


def written_phases(data: Mapping[str, object]) -> list[WrittenPhase]:
    """List the phases of a mission file's data that have keys."""
    entries = data.get("phases")
    pairs = [
        (("phases", number, str(kind)), section if isinstance(section, Mapping) else {})
        for number, entry in enumerate(entries if isinstance(entries, list | tuple) else ())
        for kind, section in (entry.items() if isinstance(entry, Mapping) else ())
    ]
    names = [str(section.get("name", path[-1])) for path, section in pairs]
    return [WrittenPhase(key, name, *pair) for key, name, pair in zip(phase_keys(names), names, pairs, strict=True)]


def phase_of_path(path: str, data: Mapping[str, object]) -> tuple[WrittenPhase, str] | None:
    """Split a key path into the phase of a mission file's data in which it begins, and the rest.

    The phase is written by its name, by what stands for it, or by its place with its kind (``phases[1].transit``).
    """
    phases = written_phases(data)
    named = named_phase(path, [phase.name for phase in phases])
    if named is not None:
        return next(phase for phase in phases if phase.name == named[0]), named[1]
    for phase in phases:
        for start in (f"{key_path(phase.path)}.", f"{phase.key}.", f"phases[{phase.path[1]}]."):
            if path.startswith(start):
                return phase, path.removeprefix(start)
    return None


_Section = TypeVar("_Section")
_QUANTITY = (float, NormalTransform, np.ndarray)
"""Base class of every distribution rather than their union: the check runs on every value of a mission."""
Change = Callable[[str, Any], Any]
"""From a quantity's name and value to its new value."""


def changed(section: _Section, name: str, change: Change) -> _Section:
    """Return a section, or any value of one, with each of its quantities changed; itself where none is.

    `name` is the section's in the names of its quantities, which are its key paths with phases by name; `change` goes
    from a quantity's name and value to its new value.
    """
    if isinstance(section, _QUANTITY):
        return cast("_Section", change(name, section))
    if isinstance(section, BaseModel):
        fields = type(section).model_fields
        inside = {
            field: new
            for field, value in section
            if (new := changed(value, f"{name}.{fields[field].alias or field}", change)) is not value
        }
        return section.model_copy(update=inside) if inside else section
    if isinstance(section, tuple):
        items = tuple(changed(item, f"{name}[{index}]", change) for index, item in enumerate(section))
        same = all(new is old for new, old in zip(items, section, strict=True))
        return section if same else cast("_Section", items)
    return section


SHARED: Mapping[str, type[FileSection]] = {"energy": EnergyBudget}
"""Section by its key, the same in both files. Quantities are named as the mission's: ``energy.hotel``."""

_Shared = TypeVar("_Shared", bound=BaseModel)


@dataclass(frozen=True)
class ValueInForce:
    """What holds of one key of a shared section."""

    path: KeyPath
    """As in the mission's file."""
    value: object
    """As written, or the default as one would write it; None where there is none."""
    source: Literal["mission", "vehicle", "default"]
    """Where it is from."""
    overridden: object = None
    """What the vehicle file says, where the mission's value goes before it; else None."""

    def __str__(self) -> str:
        words = "none" if self.value is None else _in_words(self.value)
        instead = "" if self.overridden is None else f", not the vehicle's {_in_words(self.overridden)}"
        return f"{key_path(self.path)}: {words} ({self.source}{instead})"


def joined(mission: _Shared | None, vehicle: _Shared | None) -> _Shared | None:
    """Return the section in force: the mission's keys, then the vehicle's, then the defaults."""
    if mission is None or vehicle is None:
        return mission or vehicle
    values = {key: getattr(mission, key) for key in mission.model_fields_set}
    return vehicle.model_copy(update={key: value for key, value in values.items() if value is not None})


def values_in_force(data: Mapping[str, object]) -> Iterator[ValueInForce]:
    """Yield what is in force of every key of the shared sections of a mission's data, its vehicle's in place."""
    for name, section in SHARED.items():
        of_mission, of_vehicle = _written(data, name), _written(data.get("vehicle"), name)
        if of_mission is None and of_vehicle is None:
            continue
        upper, lower = of_mission or {}, of_vehicle or {}
        for key, field in section.model_fields.items():
            path = (name, key)
            if upper.get(key) is not None:
                yield ValueInForce(path, upper[key], "mission", lower.get(key))
            elif lower.get(key) is not None:
                yield ValueInForce(path, lower[key], "vehicle")
            else:
                yield ValueInForce(path, default_of(field), "default")


def overridden(path: KeyPath, data: Mapping[str, object]) -> bool:
    """Whether a key path is one of the vehicle's for which a mission's data has its own value."""
    if len(path) < 3 or path[0] != "vehicle" or path[1] not in SHARED:
        return False
    return (_written(data, str(path[1])) or {}).get(str(path[2])) is not None


def is_in_force(path: KeyPath, data: Mapping[str, object]) -> bool:
    """Whether a key path is where a value of a shared section stands, or else where one would write it."""
    at = path[1:] if path[0] == "vehicle" else path
    if len(at) != 2 or at[0] not in SHARED:
        return True
    name, key = str(at[0]), at[1]
    of_mission, of_vehicle = _written(data, name), _written(data.get("vehicle"), name)
    if any((section or {}).get(str(key)) is not None for section in (of_mission, of_vehicle)):
        in_mission = (of_mission or {}).get(str(key)) is not None
    else:
        in_mission = of_mission is not None or of_vehicle is None
    return in_mission == (path[0] != "vehicle")


def name_in_force(path: str) -> str:
    """Return the name of a quantity: that of the mission's section, where the path is in the vehicle's of that name."""
    below = path.removeprefix("vehicle.")
    return below if below.split(".")[0] in SHARED else path


def _in_words(value: object) -> str:
    """Write a value as a file does."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_in_words(inner)}' for key, inner in value.items())}}}"
    return f"[{', '.join(map(_in_words, value))}]" if isinstance(value, list) else str(value)


def _written(data: object, name: str) -> Mapping[str, object] | None:
    section = data.get(name) if isinstance(data, Mapping) else None
    return section if isinstance(section, Mapping) else None


def default_of(field: FieldInfo) -> object:
    """Return a field's default as one would write it."""
    parsers = [annotation.read for annotation in field.metadata if isinstance(annotation, ReadBy)]
    unit = next((read.unit for read in parsers if isinstance(read, QuantityParser)), "")
    return f"{field.default:g} {unit}" if unit and isinstance(field.default, float) else field.default
