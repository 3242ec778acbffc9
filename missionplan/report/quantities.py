"""Quantities as the reader sees them: rounded to what their errors support, in his units, written once.

A result holds numbers in SI. They become text here, when the page, the terminal's view, the notebook or the drawing is
made: in the system of units that `reading_in` has set, or else as the mission file has them.
"""

import math
import re
from collections.abc import Mapping
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import dataclass

from missionplan.mission.quantity_paths import written_phases
from missionplan.mission.units import FACTORS, QuantityError, number_and_unit, parse_number_with_unit
from missionplan.montecarlo.statistics import Statistic
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.report.wording import has_spread, number, set_number, setting, split_key
from missionplan.results.decision import Axis
from missionplan.results.entries import mapping, mappings

NO_BREAK_SPACE = "\u00a0"
SYSTEMS: Mapping[str, Mapping[str, tuple[tuple[float, str], ...]]] = {
    "metric": {"m": ((1000.0, "m"), (math.inf, "km")), "m/s": ((math.inf, "m/s"),)},
    "nautical": {"m": ((926.0, "m"), (math.inf, "nmi")), "m/s": ((math.inf, "kn"),)},
    "imperial": {
        "m": ((1609.344, "ft"), (math.inf, "mi")),
        "m/s": ((math.inf, "ft/s"),),
        "N": ((math.inf, "lbf"),),
        "kg": ((math.inf, "lb"),),
    },
}
"""Of each system, by the SI unit of a dimension: units, each up to a size in SI; of others, the SI unit itself."""
_CONVERTED = {
    "m": ("m", "km", "ft", "nmi", "mi"),
    "m/s": ("m/s", "cm/s", "kn", "ft/s", "km/h"),
    "N": ("N", "lbf"),
    "kg": ("kg", "lb"),
}
"""Units that are converted, by SI unit; a millimetre of a drawing stays one."""
DIMENSIONS = {name: si for si, names in _CONVERTED.items() for name in names}
"""SI unit of each unit that is converted."""
_SI = {"W*h": "J", "deg": "rad"}
_DEGREE = math.pi / 180.0
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
_chosen: ContextVar[str] = ContextVar("chosen", default="")
_read: ContextVar[str] = ContextVar("read", default="")


def using_units(system: str | None) -> AbstractContextManager[None]:
    """Write reports in a system of units, whatever their missions say; None leaves it to the missions."""
    return setting(_chosen, system or "")


def given_units() -> str:
    """Return the system chosen for the run; empty where the mission's counts."""
    return _chosen.get()


def units_of(data: Mapping[str, object]) -> str:
    """Return the system of units for a mission's report; empty: as the mission file writes them."""
    system = _chosen.get() or data.get("units")
    return system if isinstance(system, str) and system in SYSTEMS else ""


def reading_in(system: str) -> AbstractContextManager[None]:
    """Write quantities in a system of units; empty: as the mission file has them."""
    return setting(_read, system)


def reader_system() -> str:
    """Return the system in which quantities are written; empty: as the mission file has them."""
    return _read.get()


@dataclass(frozen=True)
class Unit:
    """A unit to show a quantity in."""

    name: str
    """As shown; empty for a bare number."""
    size: float
    """One of it, in the unit that the quantity's key ends with."""

    def __call__(self, value: float) -> float:
        """Convert a value of the result to this unit."""
        return value / self.size

    @property
    def suffix(self) -> str:
        """What follows a number: a no-break space and the name, which a degree sign goes without."""
        return self.name if self.name in ("", "°") else f"{NO_BREAK_SPACE}{self.name}"

    @property
    def axis(self) -> str:
        """What follows the words of an axis label, or of a column's head."""
        return f" ({self.name})" if self.name else ""

    @property
    def bare(self) -> "Unit":
        """The same without a name, for cells below a head that has it."""
        return Unit("", self.size)

    def cell(self, value: float | None, form: str) -> str:
        """Write a value without the unit, which stands in the head: with the digits of `form`, or as fine ones."""
        if value is None or not math.isfinite(value):
            return "–"
        return set_number(_as_fine(format(value, form), value, self.size))


PERCENT, SECONDS, MINUTES, WATT_HOURS = (
    Unit("%", 0.01),
    Unit("s", 1.0),
    Unit("min", 60.0),
    Unit("W\u202fh", JOULES_PER_WATT_HOUR),
)


def reader_unit(unit: str, largest: float, system: str | None = None) -> Unit:
    """Choose the reader's unit for values up to a size.

    `unit`: of the values; one that is not converted stays. `largest`: of the values, in `unit`. `system`: instead of
    the reader's own.
    """
    system = reader_system() if system is None else system
    si = DIMENSIONS.get(unit)
    if si is None or not system:
        return Unit(unit, 1.0)
    factor = FACTORS[si][unit]
    choices = SYSTEMS[system].get(si, ((math.inf, si),))  # the metric and the nautical system have SI's
    name = next((name for limit, name in choices if abs(largest) * factor < limit), choices[0][1])
    return Unit(name, FACTORS[si][name] / factor)


def in_unit_of(was: object, now: object) -> str:
    """Write a quantity of a mission file in the unit of its former value, in brackets; empty where it has that unit."""
    (_, unit), (value, other) = (str(text).strip().partition(" ")[::2] for text in (was, now))
    if reader_system() or unit == other or unit not in DIMENSIONS or DIMENSIONS[unit] != DIMENSIONS.get(other):
        return ""
    factors = FACTORS[DIMENSIONS[unit]]
    return f" ({float(value) * factors[other] / factors[unit]:.4g}\u00a0{unit})"


def quantity(value: float | None, unit: str, form: str, *, largest: float | None = None) -> str:
    """Write a quantity: ``11.8 N``, or as finely in the reader's unit.

    `value`: in `unit`. `form`: format of the number in `unit`, such as ``.1f``: tells how fine the last digit is.
    `largest`: value that chooses the unit, where several are to have one.
    """
    if value is None or not math.isfinite(value):
        return "–"
    shown = reader_unit(unit, value if largest is None else largest)
    return f"{shown.cell(value, form)}{shown.suffix}"


def span_of(low: float, high: float, unit: str, form: str) -> str:
    """Write a range: ``1.2 to 3.4 m``."""
    shown = reader_unit(unit, max(abs(low), abs(high)))
    return f"{shown.cell(low, form)} to {shown.cell(high, form)}{shown.suffix}"


def as_written(number: str, unit: str, *, largest: float | None = None) -> str:
    """Write a quantity with the digits with which a file or a user has written it: ``1.40 m/s``, ``4.6 ft/s``."""
    shown = reader_unit(unit, float(number) if largest is None else largest)
    return f"{set_number(_as_fine(number, float(number), shown.size))}{shown.suffix}"


_IN_WORDS = re.compile(r"(?<![\w.])(?<!e[-+])(?:([\d.]+) to )?([\d.]+) (c?m/s|k?m)\b")


def in_reader_units(words: str) -> str:
    """Write the speeds and lengths within words in the reader's units: ``winds of 0 to 23 kn``."""

    def written(match: re.Match[str]) -> str:
        low, high, unit = match.groups()
        shown = as_written(high, unit)
        return (
            shown
            if low is None
            else f"{as_written(low, unit, largest=float(high)).split(NO_BREAK_SPACE)[0]} to {shown}"
        )

    return _IN_WORDS.sub(written, words) if reader_system() else words


def value_on(axis: Axis, index: int) -> str:
    """Write a value of a key that is varied, with its unit."""
    if axis.numbers is None or axis.unit not in DIMENSIONS or not reader_system():
        return axis.shown(index)
    return as_written(axis.labels[index], axis.unit, largest=max(map(abs, axis.numbers)))


def range_on(axis: Axis, first: int, last: int) -> str:
    """Write a range of values of a key that is varied; its unit stands once."""
    low, high = value_on(axis, first), value_on(axis, last)
    if axis.numbers is None or axis.unit not in DIMENSIONS or not reader_system():
        low = axis.labels[first]
    return f"{low.partition(NO_BREAK_SPACE)[0]} to {high}"


def _as_fine(text: str, value: float, size: float) -> str:
    """Write a value in a unit of another size, with about as fine a last digit as the text has."""
    if size == 1.0:
        return text
    decimals = len(text.partition(".")[2]) if "e" not in text else 2
    return f"{value / size:{'+' if text.startswith('+') else ''}.{max(0, round(decimals + math.log10(size) + 0.3))}f}"


def si_per_unit(key: str) -> float:
    """Size in SI of the unit that a key of `summary.json` ends with."""
    return JOULES_PER_WATT_HOUR if key.endswith("_wh") else 1.0


def unit_for(phase: str, key: str, data: Mapping[str, object], *, typical: float = math.nan) -> Unit:
    """Find the unit in which to show a quantity: the reader's, or that of the mission file where it has one.

    `phase`, `key`: as in `summary.json`: ``moor``, ``offset_m``. `data`: the mission file's data, `Provenance.data`.
    `typical`: a value of the quantity; chooses between seconds, minutes and hours where the mission has no requirement
    on it.
    """
    quantity, unit = split_key(key)
    if not unit:
        return Unit("", 1.0)
    if reader_system() and unit in DIMENSIONS:
        return reader_unit(unit, typical)
    for text in _texts(phase, quantity, data):
        written_unit = _unit_of(text, unit)
        if written_unit:
            return written_unit
    if unit == "s" and math.isfinite(typical):
        name = next(name for limit, name in _TIMES if abs(typical) < limit)
        return Unit("d" if name == "day" else name, parse_number_with_unit(f"1 {name}", "s"))
    return Unit("°", _DEGREE) if unit == "rad" else Unit(_shown(unit), 1.0)


def _texts(phase: str, quantity: str, data: Mapping[str, object]) -> list[object]:
    """Quantities of the mission file whose unit suits, in order of preference."""
    written = {entry.key: entry.name for entry in written_phases(data)}
    requirements = [
        requirement.get("at_most", requirement.get("at_least"))
        for requirement in mappings(data.get("requirements"))
        if requirement.get("quantity") == f"{written.get(phase, phase)}.{quantity}"
    ]
    section = next((entry.section for entry in written_phases(data) if entry.key == phase), {})
    below = [_at(section, path) for path in _KEYS.get(quantity, ())]
    site = [_at(data, _SITE_KEYS[quantity])] if quantity in _SITE_KEYS else []
    energy = [_at(data, path) for path in _ENERGY_KEYS] if quantity == "energy" else []
    return [*requirements, *below, *site, *energy]


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
    _, written = number_and_unit(value) or ("", "")
    if not written:
        return None
    si = _SI.get(unit, unit)
    try:
        size = parse_number_with_unit(f"1 {written}", si) / parse_number_with_unit(f"1 {unit}", si)
    except QuantityError:
        return None
    return Unit(_shown(written), size)


def _shown(unit: str) -> str:
    if unit in ("deg", "degree"):
        return "°"
    return unit.replace("**", "^").replace("*", "\u202f").replace("^2", "²").replace("^3", "³")


def with_error(value: float, error: float, unit: Unit) -> str:
    """Write ``21.3 ± 0.4 ft``; `value` and `error` in the key's unit."""
    value, error = unit(value), unit(error)
    if not math.isfinite(value):
        return "–"
    if not has_spread(value, error):
        return number(value) + unit.suffix
    return f"{number(value, error)}\u00a0±\u00a0{number(error, error)}{unit.suffix}"


def length_in_words(metres: float) -> str:
    """Write ``747 m`` or ``1.26 km``."""
    return quantity(metres / 1000.0, "km", ".2f") if metres >= 1000.0 else quantity(metres, "m", ".0f")


def time_in_words(seconds: float) -> str:
    """Write ``85 s`` or ``18.2 min``."""
    return f"{seconds:.0f}\u00a0s" if seconds < 90.0 else f"{seconds / 60.0:.1f}\u00a0min"


def span(statistic: Statistic, unit: Unit) -> tuple[str, str, str]:
    """Write the 5, 50 and 95 % points with the digits that their errors support and their spread needs.

    The standard error of the 5 % and 95 % points of a normal sample is 2.1 times the mean's.
    """
    digits = unit(max(0.2 * statistic.sd, 2.1 * statistic.standard_error))
    low, middle, high = (number(unit(value), digits) for value in (statistic.p05, statistic.p50, statistic.p95))
    return low, middle, high
