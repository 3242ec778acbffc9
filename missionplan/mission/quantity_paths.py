"""Key paths: which part of them stands for a phase.

Every quantity in a section of a mission by its name, and the same section with other values in their places.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from pydantic import BaseModel

from missionplan.errors import KeyPath, key_path
from missionplan.montecarlo.normal_transform import NormalTransform

SECTIONS = frozenset(
    {
        *(
            "schema",
            "name",
            "start",
            "units",
            "vehicle",
            "site",
            "navigation",
            "phases",
            "sweep",
            "optimise",
            "monte_carlo",
        ),
        *("energy", "requirements", "correlations", "effects", "posterior", "learned_from", "total"),
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
    return tuple(name if _serves(name) else f"phases[{number}]" for number, name in enumerate(names))


def _serves(name: str) -> bool:
    return len(name) <= _LONGEST and _PLAIN.fullmatch(name) is not None and name not in SECTIONS


def named_phase(path: str, names: Iterable[str], *, with_sections: bool = True) -> tuple[str, str] | None:
    """Split a key path that begins with the name of a phase.

    Parameters
    ----------
    path : str
        As a person writes it.
    names : iterable of str
        Of the phases.
    with_sections : bool
        Whether the path may be that of a section, which goes before a phase of the same name.

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
    found = named_phase(path, names, with_sections=with_sections)
    return path if found is None else f"{phase_keys(names)[names.index(found[0])]}.{found[1]}"


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
    found = [
        (("phases", number, str(kind)), section if isinstance(section, Mapping) else {})
        for number, entry in enumerate(entries if isinstance(entries, list | tuple) else ())
        for kind, section in (entry.items() if isinstance(entry, Mapping) else ())
    ]
    names = [str(section.get("name", path[-1])) for path, section in found]
    return [WrittenPhase(key, name, *each) for key, name, each in zip(phase_keys(names), names, found, strict=True)]


def phase_of_path(path: str, data: Mapping[str, object]) -> tuple[WrittenPhase, str] | None:
    """Split a key path into the phase of a mission file's data in which it begins, and the rest.

    The phase is written by its name, by what stands for it, or by its place with its kind (``phases[1].transit``).
    """
    phases = written_phases(data)
    named = named_phase(path, [each.name for each in phases])
    if named is not None:
        return next(each for each in phases if each.name == named[0]), named[1]
    for each in phases:
        for start in (f"{key_path(each.path)}.", f"{each.key}.", f"phases[{each.path[1]}]."):
            if path.startswith(start):
                return each, path.removeprefix(start)
    return None


_Section = TypeVar("_Section")
_QUANTITY = (float, NormalTransform, np.ndarray)
"""Base class of every distribution rather than their union: the check runs on every value of a mission."""
Change = Callable[[str, Any], Any]
"""From a quantity's name and value to its new value."""


def changed(section: _Section, name: str, change: Change) -> _Section:
    """Return a section, or any value of one, with each of its quantities changed; itself where none is.

    Parameters
    ----------
    name : str
        Of the section in the names of its quantities, which are its key paths with phases by name.
    change : callable
        From a quantity's name and value to its new value.
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
