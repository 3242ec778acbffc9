"""Units of mission files: their names, and text with a unit to a number in SI."""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, TypeVar

from missionplan.errors import KeyPath, LocalProblem, shown

if TYPE_CHECKING:
    import pint


_Item = TypeVar("_Item")
_Read = TypeVar("_Read")
_LENGTH = {
    **dict.fromkeys(("m", "meter", "metre"), 1.0),
    **{"km": 1000.0, "cm": 0.01, "mm": 0.001},
    **dict.fromkeys(("ft", "foot", "feet"), 0.3048),
    **dict.fromkeys(("in", "inch"), 0.0254),
    **{"yd": 0.9144, "nmi": 1852.0, "mi": 1609.344},
}
_TIME = {
    **dict.fromkeys(("s", "second", "seconds"), 1.0),
    **dict.fromkeys(("min", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hour", "hours"), 3600.0),
    **dict.fromkeys(("d", "day", "days"), 86400.0),
}
FACTORS: Mapping[str, Mapping[str, float]] = {
    "m": _LENGTH,
    "s": _TIME,
    "m/s": {
        **{"m/s": 1.0, "km/h": 1000.0 / 3600.0, "cm/s": 0.01, "mm/s": 0.001, "ft/s": 0.3048},
        **dict.fromkeys(("kn", "kt", "knot", "knots"), 1852.0 / 3600.0),
    },
    "N": {"N": 1.0, "kN": 1000.0, "mN": 0.001, "lbf": 4.4482216152605},
    "kg": {"kg": 1.0, "g": 0.001, "lb": 0.45359237, "t": 1000.0},
    "kg/m^3": {"kg/m^3": 1.0, "kg/m**3": 1.0, "g/cm^3": 1000.0},
    "kg/m": {"kg/m": 1.0, "g/m": 0.001},
    "m^2": {"m^2": 1.0, "m**2": 1.0, "cm^2": 1e-4},
    "m^3": {"m^3": 1.0, "m**3": 1.0, "L": 0.001, "l": 0.001, "cm^3": 1e-6},
    "m^2/s": {"m^2/s": 1.0},
    "m^2/s^2": {"m^2/s^2": 1.0, "cm^2/s^2": 1e-4},
    "rad": {"rad": 1.0, "deg": math.pi / 180.0, "degree": math.pi / 180.0, "degrees": math.pi / 180.0},
    "W": {"W": 1.0, "kW": 1000.0, "mW": 0.001},
    "J": {"J": 1.0, "kJ": 1000.0, "MJ": 1e6, "W*h": 3600.0, "Wh": 3600.0, "kW*h": 3.6e6, "kWh": 3.6e6},
    "1/s": {"1/s": 1.0, "1/h": 1.0 / 3600.0, "1/hour": 1.0 / 3600.0, "1/d": 1.0 / 86400.0, "1/day": 1.0 / 86400.0},
    "1/m": {"1/m": 1.0, "1/km": 1e-3, "1/nmi": 1.0 / 1852.0},
    "V": {"V": 1.0, "mV": 0.001},
    "degC": {"degC": 1.0},
}
"""SI unit of a quantity → unit of the file → factor."""


def factor(name: str, unit: str) -> float | None:
    """Factor from a unit of the file to the SI unit of a quantity; None where the table does not have the pair.

    `name` is as the file writes it; temperatures are in degC.
    """
    return 1.0 if name == unit else FACTORS.get(unit, {}).get(name)


def dimension_of(name: str) -> str | None:
    """SI unit of the quantities that a unit measures; None where the table does not have it."""
    return next((unit for unit, names in FACTORS.items() if name in names), None)


_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?+)\s*((?:1/)?[^\d\s:].*?)?\s*")
_ENDLESS = re.compile(r"\d\s*(\*\*|\^)|(\*\*|\^)[\s(+-]*\d{3}")
"""Powers of numbers, or large ones, which pint would work out for hours."""
_MAX_LENGTH = 80
LEAST, GREATEST = 1e-30, 1e31
_SENSIBLE = f"0, or from {LEAST:g} to {GREATEST:g} in size"
_UNITS_OF_PINT = {"degC": ("degF", "K"), "1/s": ("rpm",)}
"""Units that a hint may name beside the table's."""


class QuantityError(ValueError):
    """A quantity that cannot be read.

    Attributes
    ----------
    problems : tuple of LocalProblem
        What is wrong, with the keys of the distribution that it concerns.
    """

    def __init__(self, problems: str | Iterable[LocalProblem], below: KeyPath = ()) -> None:
        self.problems = (LocalProblem(below, problems),) if isinstance(problems, str) else tuple(problems)
        super().__init__("; ".join(problem.message for problem in self.problems))


def each_read(items: Iterable[_Item], read: Callable[[int, _Item], _Read], below: KeyPath = ()) -> list[_Read]:
    """Read each of some items, given its number and itself.

    Raises QuantityError with the problems of all that are wrong, at their numbers below a key path.
    """
    results: list[_Read] = []
    problems: list[LocalProblem] = []
    for index, item in enumerate(items):
        try:
            results.append(read(index, item))
        except QuantityError as error:
            problems += [problem.within((*below, index)) for problem in error.problems]
    if problems:
        raise QuantityError(problems)
    return results


def number_and_unit(text: object) -> tuple[str, str] | None:
    """Return number and unit of a text as they are written, "" for no unit; None where it is something else."""
    match = _NUMBER_AND_UNIT.fullmatch(text) if isinstance(text, str) else None
    return (match[1], match[2] or "") if match else None


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[float]":
    import pint  # half of what reading a mission would cost, and few files need it

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def parse_number_with_unit(value: object, unit: str, *, difference: bool = False) -> float:
    """Read ``'75 ft'`` as a float in `unit`.

    Raises QuantityError with what was expected.

    `value`: what the file holds. `unit`: unit of the result; empty for a dimensionless quantity, which is a bare
    number. `difference`: whether the value is a difference or a spread (matters for temperatures alone).

    Returns
    -------
    float
        Finite.
    """
    if unit == "":
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(_as_float(value)):
            raise QuantityError(f"given {shown(value)}, expected a bare number")
        if not _is_sensible(float(value)):
            raise QuantityError(f"given {shown(value)}, expected {_SENSIBLE}")
        return float(value)
    example = f"a quantity in {unit} or a unit like it"
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise QuantityError(f"given {shown(value)}, expected {example}")
    if not isinstance(value, str):
        raise QuantityError(f"given the bare number {value}, expected a unit too, such as '{value} {unit}'")
    match = _QUANTITY.fullmatch(value) if len(value) <= _MAX_LENGTH else None
    if match is None:
        raise QuantityError(f"given {shown(value)}, expected {example}, such as '1.5 {unit}'")
    number, name = float(match[1]), match[2]
    if not name:
        raise QuantityError(f"given the bare number {value}, expected a unit too, such as '{value} {unit}'")
    return _convert(number, name, unit, difference)


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        return math.inf


def _convert(number: float, name: str, unit: str, difference: bool) -> float:
    scale = factor(name, unit)
    if scale is None and dimension_of(name) not in (None, dimension_of(unit)):
        raise _other_kind(number, name, unit)
    result = number * scale if scale is not None else _convert_by_pint(number, name, unit, difference)
    if not _is_sensible(result):
        raise QuantityError(f"given {number:g} {name}, expected {_SENSIBLE} {unit}")
    return result


def _is_sensible(number: float) -> bool:
    """Whether squares and quotients of a number can be computed, and any quantity has it."""
    return number == 0.0 or LEAST <= abs(number) <= GREATEST


def _known(unit: str) -> dict[str, str]:
    """Units that a hint may name for a quantity, by their names in small letters: capitals are mistyped too."""
    names = [unit, *FACTORS.get(unit, ()), *_UNITS_OF_PINT.get(unit, ())]
    return {name.casefold(): name for name in reversed(names)}


def _nearest(name: str, unit: str) -> str:
    """Return a hint at the unit that was probably meant, else at some of the usual ones."""
    names = _known(unit)
    close = get_close_matches(name.casefold(), names, n=1)
    if close:
        return f"did you mean {names[close[0]]}?"
    one_name_each: dict[float, str] = {}
    for other, size in FACTORS.get(unit, {unit: 1.0}).items():
        one_name_each.setdefault(size, other)
    return f"expected one such as {', '.join([*one_name_each.values()][:3])}"


def _other_kind(number: float, name: str, unit: str) -> QuantityError:
    meant = _known(unit).get(name.casefold(), "")
    hint = f"; did you mean {meant}?" if meant else ""
    return QuantityError(f"given {number:g} {name}, expected a quantity in {unit} or a unit like it{hint}")


def _convert_by_pint(number: float, name: str, unit: str, difference: bool) -> float:
    import pint

    if _ENDLESS.search(name):
        raise QuantityError(f"given {shown(name)}, which is not a unit")
    registry = _registry()
    try:
        pint_unit = registry.parse_units(name)
    except pint.UndefinedUnitError as error:
        raise QuantityError(f"given the unit {shown(name)}, which is not known; {_nearest(name, unit)}") from error
    except Exception as error:  # pint and its tokenizer raise many kinds for what is no expression of units
        raise QuantityError(f"given {shown(name)}, which is not a unit; {_nearest(name, unit)}") from error
    if pint_unit.dimensionality != registry.parse_units(unit).dimensionality:
        raise _other_kind(number, name, unit)
    if difference and unit == "degC":
        pint_unit, unit = registry.parse_units(name.replace("deg", "delta_deg")), "delta_degC"
    return float(registry.Quantity(number, pint_unit).to(unit).magnitude)
