"""Numbers as people read them: rounded to what their standard error supports, in the units the mission file used."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.physics.energy import JOULES_PER_WATT_HOUR

NARROW_SPACE = "\u202f"
_SUFFIXES = {"_m_s": "m/s", "_wh": "W*h", "_s": "s", "_m": "m", "_n": "N", "_kg": "kg", "_rad": "rad", "_deg": "deg"}
_POINT_OR_UNDERSCORE = re.compile(r"\.(?!\d)|_")
_SI = {"W*h": "J", "deg": "rad"}
_TRAILING_UNIT = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*(\S.*?)\s*")
_TIMES = ((600.0, "s"), (5.0 * 3600.0, "min"), (4.0 * 86400.0, "h"), (math.inf, "day"))
_KEYS: dict[str, tuple[tuple[str, ...], ...]] = {
    "offset": (("radius",),),
    "target_offset": (("radius",),),
    "arrival_error": (("arrival_radius",),),
    "distance": (("to",), ("d_max",)),
    "terminal_velocity": (("speed",),),
}
"""Keys of a phase whose unit a quantity is shown in, most telling first."""
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


def plain(name: str) -> str:
    """Say a dotted name in words: ``moor release time``, ``current speed in layer 2``."""
    quantity = split_key(name)[0].removeprefix("effects.")
    if quantity.startswith("site.current["):
        layer, _, rest = quantity.removeprefix("site.current[").partition("].")
        return f"current {rest} in layer {int(layer) + 1}"
    return _POINT_OR_UNDERSCORE.sub(" ", quantity)


def unit_for(phase: str, key: str, data: Mapping[str, Any], *, typical: float = math.nan) -> Unit:
    """Find the unit in which the mission's author thinks of a quantity.

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
    return Unit(_shown(unit), 1.0)


def _texts(phase: str, quantity: str, data: Mapping[str, Any]) -> list[Any]:
    """Quantities of the mission file whose unit suits, most telling first."""
    requirements = [
        requirement.get("at_most", requirement.get("at_least"))
        for requirement in _items(data.get("requirements"))
        if requirement.get("quantity") == f"{phase}.{quantity}"
    ]
    section = _phase(phase, data)
    below = [_at(section, path) for path in _KEYS.get(quantity, ())]
    site = [_at(data, _SITE_KEYS[quantity])] if quantity in _SITE_KEYS else []
    energy = [_at(data, path) for path in _ENERGY_KEYS] if quantity == "energy" else []
    return [*requirements, *below, *site, *energy]


def _items(value: Any) -> list[Mapping[str, Any]]:
    return [item for item in value if isinstance(item, Mapping)] if isinstance(value, list | tuple) else []


def _phase(name: str, data: Mapping[str, Any]) -> Mapping[str, Any]:
    for entry in _items(data.get("phases")):
        for kind, section in entry.items():
            if isinstance(section, Mapping) and section.get("name", kind) == name:
                return section
    return {}


def _at(data: Any, path: tuple[str, ...]) -> Any:
    for key in path:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data


def _unit_of(value: Any, unit: str) -> Unit | None:
    """Unit that a quantity of the file is written in, if it is of the same kind as `unit`."""
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
    return unit.replace("**", "^").replace("*", "\u202f").replace("^2", "²").replace("^3", "³")


def has_spread(value: float, spread: float) -> bool:
    """Whether a spread or an error is more than rounding."""
    return math.isfinite(spread) and spread > 1e-9 * abs(value)


def number(value: float, error: float = 0.0) -> str:
    """Write a number with the digits that its standard error supports; four where it has none but rounding.

    The last digit shown is that of the error's first, or of its second where the first is 1.
    """
    if not math.isfinite(value):
        return "–"
    if not has_spread(value, error):
        return _grouped(value, max(0, 3 - _exponent(value)) if value else 0, strip=True)
    return _grouped(value, _decimals(error))


def with_error(value: float, error: float, unit: Unit) -> str:
    """Write ``21.3 ± 0.4 ft``; `value` and `error` in the key's unit."""
    value, error = unit(value), unit(error)
    if not math.isfinite(value):
        return "–"
    if not has_spread(value, error):
        return number(value) + unit.suffix
    return f"{number(value, error)}\u00a0±\u00a0{_grouped(error, _decimals(error))}{unit.suffix}"


def span(statistic: Statistic, unit: Unit) -> tuple[str, str, str]:
    """Write the 5, 50 and 95 % points with the digits that their errors support and their spread asks for.

    The standard error of an outer point of a normal sample is 2.1 times the mean's.
    """
    digits = unit(max(0.2 * statistic.sd, 2.1 * statistic.standard_error))
    low, middle, high = (number(unit(value), digits) for value in (statistic.p05, statistic.p50, statistic.p95))
    return low, middle, high


def percent(probability: Probability) -> str:
    """Write a probability with its 95 % interval: ``87.0 ± 0.7 %``, or the interval itself near 0 and 1."""
    value, low, high = (100.0 * part for part in (probability.value, probability.low, probability.high))
    if not math.isfinite(value):
        return "–"
    half = 0.5 * (high - low)
    decimals = max(0, _decimals(half)) if half > 0.0 else 1
    if min(value, 100.0 - value) > 3.0 * half:
        return f"{value:.{decimals}f}\u00a0±\u00a0{half:.{decimals}f}\u00a0%"
    if value in (0.0, 100.0):
        bound = f"at least {_towards(low, -1)}" if value else f"at most {_towards(high, 1)}"
        return f"{value:.0f}\u00a0% ({bound}\u00a0%)"
    return f"{value:.{decimals}f}\u00a0% ({low:.{decimals}f} to {high:.{decimals}f}\u00a0%)"


def _towards(value: float, direction: int) -> str:
    """Round a bound outwards at the first digit of its distance from 0 or 100."""
    decimals = max(0, _decimals(min(value, 100.0 - value)))
    scale = 10.0**decimals
    return f"{(math.floor if direction < 0 else math.ceil)(value * scale) / scale:.{decimals}f}"


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _decimals(error: float) -> int:
    first = _exponent(error)
    return -first + (1 if error < 1.95 * 10.0**first else 0)


def _grouped(value: float, decimals: int, *, strip: bool = False) -> str:
    """Fixed point with `decimals` (negative: rounded before the point), groups of three from 10 000 on."""
    text = f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"
    if strip and "." in text:
        text = text.rstrip("0").rstrip(".")
    whole, point, rest = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", NARROW_SPACE)
    sign = "−" if text.startswith("-") and float(text) != 0.0 else ""
    return sign + whole + point + rest
