"""Quantities of a mission file: text with a unit, or a distribution of such texts, to SI floats or distributions.

Types of the quantities in mission files: each a float in SI or a distribution; drawn, a float or an array.

What is impossible and unusual for a key, and who says so: declared at its field, next to its meaning (`Doc`).
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, cast

from pydantic import Field

from missionplan.errors import LocalProblem, shown
from missionplan.mission.schema import ReadBy, V, all_invalid
from missionplan.mission.units import QuantityError, each_read, parse_number_with_unit
from missionplan.montecarlo.distributions import (
    Choices,
    Distribution,
    LogNormal,
    Normal,
    Quantity,
    TruncatedNormal,
    Uniform,
)

HOUR, DAY = 3600.0, 86_400.0
WATT_HOUR = 3600.0


@dataclass(frozen=True)
class Limit:
    """What one quantity may be. Ends are included; the sign does not count where `signed`."""

    possible: tuple[float, float]
    """Beyond it is an error."""
    usual: tuple[float, float]
    """Beyond it is a notice. Zero is never unusual."""
    source: str
    """Who says so, as messages quote it."""
    signed: bool = False
    """Whether the range is one of sizes, whatever the sign."""
    unit: str | None = None
    """In which the numbers are; None: the one in which the field is read."""


_CURRENT_SOURCE = "tidal currents reach 10 m/s in Saltstraumen, ocean currents 2.5 m/s in the Gulf Stream"
_SPEED_SOURCE = "gliders make 0.25 m/s, survey AUVs 1 to 2 m/s, the fastest about 3 m/s"
_DEPTH_SOURCE = "the deepest sea is 10 984 m (Challenger Deep), deep AUVs are rated for 6000 m"
_DENSITY_SOURCE = "foams start at 30 kg/m^3, the densest metal has 22 600 kg/m^3"
_MASS_SOURCE = "AUVs weigh from about 1 kg to 10 t, the largest 80 t"

DEPTH = Limit((0.0, 11_000.0), (0.0, 6000.0), _DEPTH_SOURCE)
SPEED = Limit((0.0, 10.0), (0.2, 3.2), _SPEED_SOURCE)
CURRENT = Limit((0.0, 12.0), (0.0, 3.0), _CURRENT_SOURCE, signed=True)
SIGMA = Limit((0.0, 5.0), (0.0, 0.5), "Briggs et al., Fig. 8: 0.015 to 0.055 m/s without a Doppler log")
MASS = Limit((0.01, 200_000.0), (0.5, 20_000.0), _MASS_SOURCE)
PART_MASS = Limit((1e-6, 20_000.0), (1e-3, 500.0), "parts of an anchor that an AUV carries")
DENSITY = Limit((10.0, 23_000.0), (100.0, 20_000.0), _DENSITY_SOURCE)
LENGTH = Limit((0.05, 50.0), (0.3, 26.0), "micro-AUVs are 0.5 m long, the longest 26 m")
DIAMETER = Limit((0.01, 10.0), (0.04, 3.0), "AUVs are 0.05 m to 2.6 m across")
CENTRE = Limit((0.0, 50.0), (0.01, 20.0), "it lies inside the vehicle")
OFF_AXIS = Limit((0.0, 5.0), (0.0, 0.5), "centimetres on a small AUV", signed=True)
FIN = Limit((1e-3, 10.0), (5e-3, 3.0), "a sail is smaller than the hull that carries it")

IN_UNIT = {"W*h": 1.0 / WATT_HOUR}
"""From SI to the unit of a limit where they differ."""


_FORMS: dict[frozenset[str], str] = {
    frozenset({"mean", "sd"}): "normal",
    frozenset({"mean", "sd", "low"}): "truncated",
    frozenset({"mean", "sd", "high"}): "truncated",
    frozenset({"mean", "sd", "low", "high"}): "truncated",
    frozenset({"low", "high"}): "uniform",
    frozenset({"median", "factor"}): "log-normal",
    frozenset({"choices"}): "choices",
}
_FARTHEST_BOUND = 9.0
"""Standard deviations from the mean to the nearer bound: one normal draw in 10¹⁹ lies farther out."""
_MAX_FACTOR = 1000.0
"""Of a log-normal: 68 % of its draws lie within six powers of ten."""
_MAX_CHOICES = 1000
_FORMS_IN_WORDS = "{mean, sd}, {mean, sd, low, high}, {low, high}, {median, factor} or {choices}"


_AS_ON_CHARTS = re.compile(
    r"(\d{1,3}(?:\.\d+)?)\s*[°d]?\s*(?:(\d{1,2}(?:\.\d+)?)\s*['′m]?\s*)?(?:(\d{1,2}(?:\.\d+)?)\s*[\"″s]?\s*)?([NSEW])"
)
"""Degrees, minutes, seconds, direction."""


@dataclass(frozen=True)
class QuantityParser:
    """Reads one quantity, or a distribution of it, and checks it against its physical range."""

    unit: str
    """SI unit of the result (temperatures in degC); empty for bare numbers."""
    low: float = -math.inf
    high: float = math.inf
    """Physical range in that unit."""
    open_low: bool = False
    """Whether `low` itself is excluded."""
    fixed: bool = False
    """Whether distributions are refused."""

    def __call__(self, value: object) -> Quantity:
        """Read a value as a pydantic validator does.

        Raises PydanticCustomError with one `LocalProblem` in ``ctx['problems']`` for each key that is wrong.
        """
        try:
            return self.parse(value)
        except QuantityError as error:
            raise all_invalid(error.problems) from None

    def parse(self, value: object) -> Quantity:
        """Read a value.

        Raises QuantityError with every key that is wrong.
        """
        return self._distribution(value) if isinstance(value, Mapping) else self._constant(value)

    @property
    def expected(self) -> str:
        """What a user should write."""
        return f"a quantity in {self.unit}" if self.unit else "a number"

    def _constant(self, value: object) -> float:
        result = parse_number_with_unit(value, self.unit)
        if not (self.low < result if self.open_low else self.low <= result) or result > self.high:
            raise QuantityError(f"given {shown(value)}, expected {self._range_in_words()}")
        return result

    def _range_in_words(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        relation = "more than" if self.open_low else "at least"
        parts = [f"{relation} {self.low:g}{unit}"] if self.low > -math.inf else []
        parts += [f"at most {self.high:g}{unit}"] if self.high < math.inf else []
        return " and ".join(parts)

    def _distribution(self, value: Mapping[str, object]) -> Quantity:
        if self.fixed:
            raise QuantityError("given a distribution, expected a fixed value here")
        form = _FORMS.get(frozenset(value))
        if form is None:
            raise QuantityError(f"given the keys {', '.join(value) or 'none'}; a distribution is {_FORMS_IN_WORDS}")
        if form == "choices":
            return self._choices(value["choices"])
        numbers: dict[str, float] = {}
        problems: list[LocalProblem] = []
        for key, text in value.items():
            unit = "" if key == "factor" else self.unit
            try:
                numbers[key] = parse_number_with_unit(text, unit, difference=key == "sd")
            except QuantityError as error:
                problems.append(LocalProblem((key,), str(error)))
        if problems:
            raise QuantityError(problems)
        distribution = _build(form, numbers)
        name, middle = "mean", distribution.mean
        if isinstance(distribution, LogNormal):  # its tail carries the mean far out of a range that holds most of it
            name, middle = "median", distribution.median
        if not self.low <= middle <= self.high:
            text = f"{middle:g} {self.unit}".strip()
            raise QuantityError(f"the distribution's {name} is {text}, expected {self._range_in_words()}")
        if self.low == -math.inf and self.high == math.inf:
            return distribution
        return cast("Distribution", distribution.truncated(self.low, self.high))

    def _choices(self, values: object) -> Choices:
        if not isinstance(values, list) or not values:
            raise QuantityError(f"given {shown(values)}, expected a list of values", ("choices",))
        if len(values) > _MAX_CHOICES:
            raise QuantityError(f"given {len(values)} values, expected at most {_MAX_CHOICES}", ("choices",))
        return Choices(tuple(each_read(values, lambda _, choice: self._constant(choice), ("choices",))))


@dataclass(frozen=True)
class CoordinateParser(QuantityParser):
    """Reads a latitude or longitude, as a number with a unit or as a chart has it: ``60° 06.0' N``, ``60 06 30 N``."""

    signs: str = "NS"
    """Letters of the positive and the negative direction."""

    def parse(self, value: object) -> Quantity:
        """Read a value; see `QuantityParser.parse`."""
        match = _AS_ON_CHARTS.fullmatch(value.strip()) if isinstance(value, str) and len(value) <= 40 else None
        return super().parse(value) if match is None else self._as_on_charts(value, match)

    def _as_on_charts(self, value: object, match: re.Match[str]) -> float:
        degrees, minutes, seconds = (float(part or 0.0) for part in match.groups()[:3])
        letter = match[4]
        if letter not in self.signs or minutes >= 60.0 or seconds >= 60.0:
            expected = f"degrees, minutes below 60 and {' or '.join(self.signs)}"
            raise QuantityError(f"given {shown(value)}, expected {expected}, such as 60 06.0 {self.signs[0]}")
        angle = math.radians(degrees + minutes / 60.0 + seconds / 3600.0)
        return self._constant(f"{-angle if letter == self.signs[1] else angle!r} rad")


def _build(form: str, numbers: Mapping[str, float]) -> Distribution:
    """Build a distribution from numbers in SI.

    Raises QuantityError when a spread is not positive or the bounds are in the wrong order.
    """
    low, high = numbers.get("low", -math.inf), numbers.get("high", math.inf)
    if numbers.get("sd", 1.0) < 0.0:
        raise QuantityError(f"given {numbers['sd']:g}, expected a positive spread", ("sd",))
    if low >= high:
        raise QuantityError(f"given low {low:g} and high {high:g}, expected low below high", ("low",))
    if form == "normal":
        return Normal(numbers["mean"], numbers["sd"])
    if form == "uniform":
        return Uniform(low, high)
    if form == "log-normal":
        return _log_normal(numbers["median"], numbers["factor"])
    if numbers["sd"] == 0.0:
        raise QuantityError("given 0, expected a positive spread between bounds", ("sd",))
    away = max(low - numbers["mean"], numbers["mean"] - high) / numbers["sd"]
    if away > _FARTHEST_BOUND:
        raise QuantityError(
            f"lies {away:.3g} standard deviations beyond the bounds: no draw can lie between them", ("mean",)
        )
    return TruncatedNormal(numbers["mean"], numbers["sd"], low, high)


def _log_normal(median: float, factor: float) -> LogNormal:
    if not 1.0 < factor <= _MAX_FACTOR:
        raise QuantityError(f"given {factor:g}, expected a factor above 1 and at most {_MAX_FACTOR:g}", ("factor",))
    if median <= 0.0:
        raise QuantityError(f"given {median:g}, expected a positive median", ("median",))
    return LogNormal(median, factor)


Length = Annotated[V, ReadBy(QuantityParser("m"))]
Distance = Annotated[V, ReadBy(QuantityParser("m", low=0.0))]
PositiveLength = Annotated[V, ReadBy(QuantityParser("m", low=0.0, open_low=True))]
FixedLength = Annotated[float, ReadBy(QuantityParser("m", low=0.0, open_low=True, fixed=True))]
FixedDistance = Annotated[float, ReadBy(QuantityParser("m", low=0.0, fixed=True))]
SignedSpeed = Annotated[V, ReadBy(QuantityParser("m/s"))]
Speed = Annotated[V, ReadBy(QuantityParser("m/s", low=0.0))]
PositiveSpeed = Annotated[V, ReadBy(QuantityParser("m/s", low=0.0, open_low=True))]
ShaftRate = Annotated[V, ReadBy(QuantityParser("rad/s", low=0.0, open_low=True))]
FixedSpeed = Annotated[float, ReadBy(QuantityParser("m/s", low=0.0, fixed=True))]
FixedVariance = Annotated[float, ReadBy(QuantityParser("m^2/s^2", fixed=True))]
Duration = Annotated[V, ReadBy(QuantityParser("s", low=0.0))]
Force = Annotated[V, ReadBy(QuantityParser("N", low=0.0, open_low=True))]
SignedForce = Annotated[V, ReadBy(QuantityParser("N"))]
Stiffness = Annotated[V, ReadBy(QuantityParser("N/m", low=0.0, open_low=True))]
WeightPerLength = Annotated[V, ReadBy(QuantityParser("N/m"))]
Mass = Annotated[V, ReadBy(QuantityParser("kg", low=0.0, open_low=True))]
MassPerLength = Annotated[V, ReadBy(QuantityParser("kg/m", low=0.0, open_low=True))]
Volume = Annotated[V, ReadBy(QuantityParser("m^3", low=0.0))]
Density = Annotated[V, ReadBy(QuantityParser("kg/m^3", low=0.0, open_low=True))]
WaterDensity = Annotated[V, ReadBy(QuantityParser("kg/m^3", low=900.0, high=1300.0))]
Viscosity = Annotated[V, ReadBy(QuantityParser("m^2/s", low=1e-7, high=1e-4))]
Temperature = Annotated[V, ReadBy(QuantityParser("degC", low=-2.5, high=45.0))]
Salinity = Annotated[V, ReadBy(QuantityParser("", low=0.0, high=50.0))]
Angle = Annotated[V, ReadBy(QuantityParser("rad"))]
FixedAngle = Annotated[float, ReadBy(QuantityParser("rad", fixed=True))]
Power = Annotated[V, ReadBy(QuantityParser("W", low=0.0))]
Energy = Annotated[V, ReadBy(QuantityParser("J", low=0.0))]
PositiveNumber = Annotated[V, ReadBy(QuantityParser("", low=0.0, open_low=True))]
Number = Annotated[V, ReadBy(QuantityParser("", low=0.0))]
Efficiency = Annotated[V, ReadBy(QuantityParser("", low=0.0, high=1.0, open_low=True))]
Probability = Annotated[float, ReadBy(QuantityParser("", low=0.0, high=1.0, fixed=True))]


def fixed(unit: str, low: float = 0.0, high: float = math.inf, *, open_low: bool = False) -> ReadBy:
    """Return a validator of a quantity in a unit that cannot be a distribution."""
    return ReadBy(QuantityParser(unit, low, high, open_low, fixed=True))


def default(value: float | tuple[float, ...]) -> Any:  # whatever the quantities of a section are
    """Return the field of a quantity that a file may leave out."""
    return Field(default=value)


@dataclass(frozen=True)
class OrWord:
    """Reads one of some words, or a quantity."""

    parser: QuantityParser
    words: tuple[str, ...]

    def __call__(self, value: object) -> Quantity | str:
        """Read a value as a pydantic validator does."""
        if isinstance(value, str) and value in self.words:
            return value
        try:
            return self.parser.parse(value)
        except QuantityError as error:
            also = f" (or {', '.join(self.words)})"
            problems = [replace(problem, message=problem.message + also) for problem in error.problems]
            raise all_invalid(problems) from None


def or_word(parser: QuantityParser, *words: str) -> ReadBy:
    """Return a validator that takes one of some words, or a quantity."""
    return ReadBy(OrWord(parser, words))
