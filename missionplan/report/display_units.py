"""Units in which a quantity is shown: those of the mission file where it has one, else those of `summary.json`."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from missionplan.mission.quantity_paths import written_phases
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.results.plain_data import mapping, mappings

_SUFFIXES = {"_m_s": "m/s", "_wh": "W*h", "_s": "s", "_m": "m", "_n": "N", "_kg": "kg", "_rad": "rad", "_deg": "deg"}
_SI = {"W*h": "J", "deg": "rad"}
_DEGREE = math.pi / 180.0
_TRAILING_UNIT = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(\S.*?)\s*")
_TIMES = ((600.0, "s"), (5.0 * 3600.0, "min"), (4.0 * 86400.0, "h"), (math.inf, "day"))
_KEYS: dict[str, tuple[tuple[str, ...], ...]] = {
    "offset": (("radius",),),
    "target_offset": (("radius",),),
    "arrival_error": (("arrival_radius",),),
    "distance": (("to",), ("d_max",)),
    "terminal_velocity": (("speed",),),
    "touchdown_speed": (("speed",),),
}
"""Keys of a phase in whose unit a quantity is shown, in order of preference."""
_SITE_KEYS = {"lowest_altitude": ("site", "depth")}
_ENERGY_KEYS = (("energy", "capacity"), ("vehicle", "energy", "capacity"))


@dataclass(frozen=True)
class Unit:
    """A unit to show a quantity in.

    Attributes
    ----------
    name : str
        As shown; empty for a bare number.
    size : float
        One of it, in the unit that the quantity's key ends with.
    """

    name: str
    size: float

    def __call__(self, value: float) -> float:
        """Convert a value of the result to this unit."""
        return value / self.size

    @property
    def suffix(self) -> str:
        """What follows a number: a no-break space and the name."""
        return f"\u00a0{self.name}" if self.name else ""

    @property
    def axis(self) -> str:
        """What follows the words of an axis label."""
        return f" ({self.name})" if self.name else ""


def split_key(key: str) -> tuple[str, str]:
    """Split ``offset_m`` into the quantity and its unit: ``('offset', 'm')``."""
    for suffix, unit in _SUFFIXES.items():
        if key.endswith(suffix):
            return key.removesuffix(suffix), unit
    return key, ""


def si_per_unit(key: str) -> float:
    """Size in SI of the unit that a key of `summary.json` ends with."""
    return JOULES_PER_WATT_HOUR if key.endswith("_wh") else 1.0


def unit_for(phase: str, key: str, data: Mapping[str, object], *, typical: float = math.nan) -> Unit:
    """Find the unit in which to show a quantity: that of the mission file where it has one.

    Parameters
    ----------
    phase, key : str
        As in `summary.json`: ``moor``, ``offset_m``.
    data : mapping
        The mission file's data, `Provenance.data`.
    typical : float
        A value of the quantity; chooses between seconds, minutes and hours where the mission has no requirement on it.
    """
    quantity, unit = split_key(key)
    if not unit:
        return Unit("", 1.0)
    for text in _texts(phase, quantity, data):
        found = _unit_of(text, unit)
        if found:
            return found
    if unit == "s" and math.isfinite(typical):
        name = next(name for limit, name in _TIMES if abs(typical) < limit)
        return Unit("d" if name == "day" else name, parse_number_with_unit(f"1 {name}", "s"))
    return Unit("°", _DEGREE) if unit == "rad" else Unit(_shown(unit), 1.0)


def _texts(phase: str, quantity: str, data: Mapping[str, object]) -> list[object]:
    """Quantities of the mission file whose unit suits, in order of preference."""
    written = {each.key: each.name for each in written_phases(data)}
    requirements = [
        requirement.get("at_most", requirement.get("at_least"))
        for requirement in mappings(data.get("requirements"))
        if requirement.get("quantity") == f"{written.get(phase, phase)}.{quantity}"
    ]
    section = _phase(phase, data)
    below = [_at(section, path) for path in _KEYS.get(quantity, ())]
    site = [_at(data, _SITE_KEYS[quantity])] if quantity in _SITE_KEYS else []
    energy = [_at(data, path) for path in _ENERGY_KEYS] if quantity == "energy" else []
    return [*requirements, *below, *site, *energy]


def _phase(name: str, data: Mapping[str, object]) -> Mapping[str, object]:
    return next((each.section for each in written_phases(data) if each.key == name), {})


def _at(data: object, path: tuple[str, ...]) -> object:
    for key in path:
        data = mapping(data).get(key)
    return data


def _unit_of(value: object, unit: str) -> Unit | None:
    """Unit in which a quantity of the file is written, if it has the dimension of `unit`."""
    if isinstance(value, Mapping):
        value = next((value[key] for key in ("mean", "median", "low", "choices") if key in value), None)
    if isinstance(value, list | tuple) and value:
        value = value[0]
    match = _TRAILING_UNIT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return None
    si = _SI.get(unit, unit)
    try:
        size = parse_number_with_unit(f"1 {match[1]}", si) / parse_number_with_unit(f"1 {unit}", si)
    except QuantityError:
        return None
    return Unit(_shown(match[1]), size)


def _shown(unit: str) -> str:
    if unit in ("deg", "degree"):
        return "°"
    return unit.replace("**", "^").replace("*", "\u202f").replace("^2", "²").replace("^3", "³")
