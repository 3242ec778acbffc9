"""Types of the quantities in mission files: each a float in SI or a distribution; drawn, a float or an array."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

from pydantic import Field

from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import ReadBy, V, all_invalid
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.distributions import Quantity

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
