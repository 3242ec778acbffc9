"""Text with a unit to a bare float in SI. The only user of pint."""

import math
import re
from collections.abc import Iterable
from functools import lru_cache

import pint

from missionplan.errors import KeyPath, LocalProblem, did_you_mean, shown

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_MAX_LENGTH = 80
_COMMON_UNITS = (
    "m", "km", "cm", "mm", "ft", "in", "nmi", "mi", "m/s", "kn", "cm/s", "mm/s", "ft/s", "km/h", "s", "min", "h", "day",
    "N", "kN", "lbf", "kg", "g", "lb", "kg/m", "kg/m^3", "m^2", "m^2/s", "m^2/s^2", "m^3", "L", "W", "kW", "J", "W*h",
    "kW*h", "deg", "rad", "degC", "degF", "K", "1/s", "s/m", "rpm", "V",
)  # fmt: skip
"""Units that a hint may name."""


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


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[float]":
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def parse_number_with_unit(value: object, unit: str, *, difference: bool = False) -> float:
    """Read ``'75 ft'`` as a float in `unit`.

    Parameters
    ----------
    value : object
        What the file holds.
    unit : str
        Unit of the result; empty for a dimensionless quantity, which is a bare number.
    difference : bool
        Whether the value is a difference or a spread (matters for temperatures alone).

    Returns
    -------
    float
        Finite.

    Raises
    ------
    QuantityError
        With what was expected.
    """
    if unit == "":
        return _bare_number(value)
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


def _bare_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise QuantityError(f"given {shown(value)}, expected a bare number")
    return float(value)


def _convert(number: float, name: str, unit: str, difference: bool) -> float:
    registry = _registry()
    try:
        given = registry.parse_units(name)
    except Exception as error:  # pint raises many kinds, some from its tokenizer
        hint = did_you_mean(name, _COMMON_UNITS, before="; ")
        raise QuantityError(f"given the unit {shown(name)}, which is not known{hint}") from error
    if given.dimensionality != registry.parse_units(unit).dimensionality:
        raise QuantityError(f"given {number:g} {name}, expected a quantity in {unit} or a unit like it")
    if difference and unit == "degC":
        given, unit = registry.parse_units(name.replace("deg", "delta_deg")), "delta_degC"
    result = float(registry.Quantity(number, given).to(unit).magnitude)
    if not math.isfinite(result):
        raise QuantityError(f"given {number:g} {name}, expected a finite quantity")
    return result
