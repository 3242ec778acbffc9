"""Text with a unit to a bare float in SI: by the project's own table, else by pint, whose only user this is."""

import math
import re
from collections.abc import Iterable
from functools import lru_cache
from typing import TYPE_CHECKING

from missionplan.errors import KeyPath, LocalProblem, did_you_mean, shown
from missionplan.mission.unit_table import FACTORS, dimension_of, factor

if TYPE_CHECKING:
    import pint

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_ENDLESS = re.compile(r"\d\s*(\*\*|\^)|(\*\*|\^)[\s(+-]*\d{3}")
"""Powers of numbers, or large ones, which pint would work out for hours."""
_MAX_LENGTH = 80
LEAST, GREATEST = 1e-30, 1e31
_SENSIBLE = f"0, or from {LEAST:g} to {GREATEST:g} in size"
_COMMON_UNITS = (*(name for names in FACTORS.values() for name in names), "degF", "K", "1/s", "s/m", "rpm")
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
    import pint  # half of what reading a mission would cost, and few files need it

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
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(_as_float(value)):
        raise QuantityError(f"given {shown(value)}, expected a bare number")
    if not _is_sensible(float(value)):
        raise QuantityError(f"given {shown(value)}, expected {_SENSIBLE}")
    return float(value)


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        return math.inf


def _convert(number: float, name: str, unit: str, difference: bool) -> float:
    known = factor(name, unit)
    if known is None and dimension_of(name) not in (None, dimension_of(unit)):
        raise QuantityError(f"given {number:g} {name}, expected a quantity in {unit} or a unit like it")
    result = number * known if known is not None else _convert_by_pint(number, name, unit, difference)
    if not _is_sensible(result):
        raise QuantityError(f"given {number:g} {name}, expected {_SENSIBLE} {unit}")
    return result


def _is_sensible(number: float) -> bool:
    """Whether squares and quotients of a number can be computed, and any quantity has it."""
    return number == 0.0 or LEAST <= abs(number) <= GREATEST


def _convert_by_pint(number: float, name: str, unit: str, difference: bool) -> float:
    import pint

    if _ENDLESS.search(name):
        raise QuantityError(f"given {shown(name)}, which is not a unit")
    registry = _registry()
    try:
        given = registry.parse_units(name)
    except pint.UndefinedUnitError as error:
        hint = did_you_mean(name, _COMMON_UNITS, before="; ")
        raise QuantityError(f"given the unit {shown(name)}, which is not known{hint}") from error
    except Exception as error:  # pint and its tokenizer raise many kinds for what is no expression of units
        hint = did_you_mean(name, _COMMON_UNITS, before="; ")
        raise QuantityError(f"given {shown(name)}, which is not a unit{hint}") from error
    if given.dimensionality != registry.parse_units(unit).dimensionality:
        raise QuantityError(f"given {number:g} {name}, expected a quantity in {unit} or a unit like it")
    if difference and unit == "degC":
        given, unit = registry.parse_units(name.replace("deg", "delta_deg")), "delta_degC"
    return float(registry.Quantity(number, given).to(unit).magnitude)
