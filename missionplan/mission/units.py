"""Quantities of a mission file: text with a unit in, bare SI floats or distributions out. The only user of pint."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

import pint
from pydantic_core import PydanticCustomError

from missionplan.montecarlo.distributions import (
    Choices,
    Distribution,
    LogNormal,
    Normal,
    Quantity,
    TruncatedNormal,
    Uniform,
)

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_MAX_LENGTH = 80
_FORMS: dict[frozenset[str], str] = {
    frozenset({"mean", "sd"}): "normal",
    frozenset({"mean", "sd", "low"}): "truncated",
    frozenset({"mean", "sd", "high"}): "truncated",
    frozenset({"mean", "sd", "low", "high"}): "truncated",
    frozenset({"low", "high"}): "uniform",
    frozenset({"median", "factor"}): "log-normal",
    frozenset({"choices"}): "choices",
}
_FORMS_IN_WORDS = "{mean, sd}, {mean, sd, low, high}, {low, high}, {median, factor} or {choices}"


class QuantityError(ValueError):
    """A quantity that cannot be read, with the key below it that is wrong."""

    def __init__(self, message: str, below: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.below = below


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[float]":
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def parse_number_with_unit(value: Any, unit: str, *, difference: bool = False) -> float:
    """Read ``'75 ft'`` as a float in `unit`.

    Parameters
    ----------
    value
        What the file holds.
    unit : str
        Unit of the result; empty for a dimensionless quantity, which is a bare number.
    difference : bool
        Whether the value is a difference or a spread (matters for temperatures alone).

    Raises
    ------
    QuantityError
        With what was expected.
    """
    if unit == "":
        return _bare_number(value)
    example = f"a quantity in {unit} or a unit like it"
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise QuantityError(f"given {_shown(value)}, expected {example}")
    if not isinstance(value, str):
        raise QuantityError(f"given the bare number {value}, expected a unit too, such as '{value} {unit}'")
    match = _QUANTITY.fullmatch(value) if len(value) <= _MAX_LENGTH else None
    if match is None:
        raise QuantityError(f"given {_shown(value)}, expected {example}, such as '1.5 {unit}'")
    number, name = float(match[1]), match[2]
    if not name:
        raise QuantityError(f"given the bare number {value}, expected a unit too, such as '{value} {unit}'")
    return _convert(number, name, unit, difference)


def _bare_number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise QuantityError(f"given {_shown(value)}, expected a bare number")
    return float(value)


def _convert(number: float, name: str, unit: str, difference: bool) -> float:
    registry = _registry()
    try:
        given = registry.parse_units(name)
    except Exception as error:  # pint raises many kinds, some from its tokenizer
        close = get_close_matches(name, _COMMON_UNITS, n=1)
        hint = f"; did you mean {close[0]}?" if close else ""
        raise QuantityError(f"given the unit {_shown(name)}, which is not known{hint}") from error
    if given.dimensionality != registry.parse_units(unit).dimensionality:
        raise QuantityError(f"given {number:g} {name}, expected a quantity in {unit} or a unit like it")
    if difference and unit == "degC":
        given, unit = registry.parse_units(name.replace("deg", "delta_deg")), "delta_degC"
    result = float(registry.Quantity(number, given).to(unit).magnitude)
    if not math.isfinite(result):
        raise QuantityError(f"given {number:g} {name}, expected a finite quantity")
    return result


_COMMON_UNITS = (
    *(
        "m",
        "km",
        "cm",
        "mm",
        "ft",
        "in",
        "nmi",
        "mi",
        "m/s",
        "kn",
        "cm/s",
        "mm/s",
        "ft/s",
        "km/h",
        "s",
        "min",
        "h",
        "day",
    ),
    *(
        "N",
        "kN",
        "lbf",
        "kg",
        "g",
        "lb",
        "kg/m",
        "kg/m^3",
        "m^2",
        "m^2/s",
        "m^2/s^2",
        "m^3",
        "L",
        "W",
        "kW",
        "J",
        "W*h",
        "kW*h",
    ),
    *("deg", "rad", "degC", "degF", "K", "1/s", "s/m", "rpm", "V"),
)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


@dataclass(frozen=True)
class QuantityParser:
    """Reads one quantity, or a distribution of it, and holds it to its physical range.

    Attributes
    ----------
    unit : str
        SI unit of the result (temperatures in degC); empty for bare numbers.
    low, high : float
        Physical range in that unit.
    open_low : bool
        Whether `low` itself is excluded.
    fixed : bool
        Whether distributions are refused.
    """

    unit: str
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    fixed: bool = False

    def __call__(self, value: Any) -> Quantity:
        """Read a value; for pydantic.

        Raises
        ------
        PydanticCustomError
            With one entry of ``ctx['problems']`` for each key that is wrong.
        """
        problems: list[tuple[tuple[str | int, ...], str]] = []
        result: Quantity = math.nan
        try:
            result = self._distribution(value, problems) if isinstance(value, Mapping) else self._constant(value)
        except QuantityError as problem:
            problems.append((problem.below, str(problem)))
        if problems:
            raise PydanticCustomError("quantity", "{words}", {"words": problems[0][1], "problems": problems})
        return result

    @property
    def expected(self) -> str:
        """What a user should write."""
        return f"a quantity in {self.unit}" if self.unit else "a number"

    def _constant(self, value: Any) -> float:
        result = parse_number_with_unit(value, self.unit)
        if not (self.low < result if self.open_low else self.low <= result) or result > self.high:
            raise QuantityError(f"given {_shown(value)}, expected {self._range_in_words()}")
        return result

    def _range_in_words(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        relation = "more than" if self.open_low else "at least"
        parts = [f"{relation} {self.low:g}{unit}"] if self.low > -math.inf else []
        parts += [f"at most {self.high:g}{unit}"] if self.high < math.inf else []
        return " and ".join(parts)

    def _distribution(self, value: Mapping[str, Any], problems: list[tuple[tuple[str | int, ...], str]]) -> Quantity:
        if self.fixed:
            raise QuantityError("given a distribution, expected a fixed value here")
        form = _FORMS.get(frozenset(value))
        if form is None:
            raise QuantityError(f"given the keys {', '.join(value) or 'none'}; a distribution is {_FORMS_IN_WORDS}")
        if form == "choices":
            return self._choices(value["choices"], problems)
        numbers: dict[str, float] = {}
        for key, given in value.items():
            unit = "" if key == "factor" else self.unit
            try:
                numbers[key] = parse_number_with_unit(given, unit, difference=key == "sd")
            except QuantityError as problem:
                problems.append(((key,), str(problem)))
        if problems:
            return math.nan
        return self._within_range(_build(form, numbers))

    def _choices(self, values: Any, problems: list[tuple[tuple[str | int, ...], str]]) -> Quantity:
        if not isinstance(values, list) or not values:
            raise QuantityError(f"given {_shown(values)}, expected a list of values", ("choices",))
        numbers = []
        for index, given in enumerate(values):
            try:
                numbers.append(self._constant(given))
            except QuantityError as problem:
                problems.append((("choices", index), str(problem)))
        return Choices(tuple(numbers)) if not problems else math.nan

    def _within_range(self, distribution: Distribution) -> Distribution:
        if not self.low <= distribution.mean <= self.high:
            message = f"the distribution's mean is {distribution.mean:g} {self.unit}, expected {self._range_in_words()}"
            raise QuantityError(message)
        if self.low == -math.inf and self.high == math.inf:
            return distribution
        return distribution.truncated(self.low, self.high)


def _build(form: str, numbers: Mapping[str, float]) -> Distribution:
    """Build a distribution from numbers in SI.

    Raises
    ------
    QuantityError
        When a spread is not positive or the bounds are in the wrong order.
    """
    for key in ("sd",):
        if numbers.get(key, 1.0) < 0.0:
            raise QuantityError(f"given {numbers[key]:g}, expected a positive spread", (key,))
    low, high = numbers.get("low", -math.inf), numbers.get("high", math.inf)
    if low >= high:
        raise QuantityError(f"given low {low:g} and high {high:g}, expected low below high", ("low",))
    if form == "normal":
        return Normal(numbers["mean"], numbers["sd"])
    if form == "uniform":
        return Uniform(low, high)
    if form == "log-normal":
        if numbers["factor"] <= 1.0:
            raise QuantityError(f"given {numbers['factor']:g}, expected a factor above 1", ("factor",))
        if numbers["median"] <= 0.0:
            raise QuantityError(f"given {numbers['median']:g}, expected a positive median", ("median",))
        return LogNormal(numbers["median"], numbers["factor"])
    if numbers["sd"] == 0.0:
        raise QuantityError("given 0, expected a positive spread between bounds", ("sd",))
    return TruncatedNormal(numbers["mean"], numbers["sd"], low, high)
