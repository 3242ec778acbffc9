"""Sections that a mission and its vehicle file may both hold: one value is in force of each key, whoever gives it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, TypeVar

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from missionplan.errors import KeyPath, key_path
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy
from missionplan.mission.schema.vehicle import EnergyBudget

SHARED: Mapping[str, type[FileSection]] = {"energy": EnergyBudget}
"""Section by its key, the same in both files. Quantities are named as the mission's: ``energy.hotel``."""

_Section = TypeVar("_Section", bound=BaseModel)


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
        given = "none" if self.value is None else _in_words(self.value)
        instead = "" if self.overridden is None else f", not the vehicle's {_in_words(self.overridden)}"
        return f"{key_path(self.path)}: {given} ({self.source}{instead})"


def joined(mission: _Section | None, vehicle: _Section | None) -> _Section | None:
    """Return the section in force: the mission's keys, then the vehicle's, then the defaults."""
    if mission is None or vehicle is None:
        return mission or vehicle
    return vehicle.model_copy(update={key: getattr(mission, key) for key in _given(mission)})


def values_in_force(data: Mapping[str, object]) -> Iterator[ValueInForce]:
    """Yield what is in force of every key of the shared sections that a mission has.

    Parameters
    ----------
    data : mapping
        A mission's data, its vehicle's in place.
    """
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
                yield ValueInForce(path, _default(field), "default")


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


def _given(section: BaseModel) -> Iterator[str]:
    return (key for key in section.model_fields_set if getattr(section, key) is not None)


def _written(data: object, name: str) -> Mapping[str, object] | None:
    section = data.get(name) if isinstance(data, Mapping) else None
    return section if isinstance(section, Mapping) else None


def _default(field: FieldInfo) -> object:
    """Return a field's default as one would write it."""
    parsers = [each.read for each in field.metadata if isinstance(each, ReadBy)]
    unit = next((read.unit for read in parsers if isinstance(read, QuantityParser)), "")
    return f"{field.default:g} {unit}" if unit and isinstance(field.default, float) else field.default
