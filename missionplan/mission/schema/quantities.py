"""Types of the quantities in mission files: each a float in SI or a distribution."""

from dataclasses import dataclass, replace
from typing import Annotated

from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import ReadBy, all_invalid
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.distributions import Quantity

Length = Annotated[Quantity, ReadBy(QuantityParser("m"))]
Distance = Annotated[Quantity, ReadBy(QuantityParser("m", low=0.0))]
PositiveLength = Annotated[Quantity, ReadBy(QuantityParser("m", low=0.0, open_low=True))]
FixedLength = Annotated[float, ReadBy(QuantityParser("m", low=0.0, open_low=True, fixed=True))]
FixedDistance = Annotated[float, ReadBy(QuantityParser("m", low=0.0, fixed=True))]
SignedSpeed = Annotated[Quantity, ReadBy(QuantityParser("m/s"))]
Speed = Annotated[Quantity, ReadBy(QuantityParser("m/s", low=0.0))]
PositiveSpeed = Annotated[Quantity, ReadBy(QuantityParser("m/s", low=0.0, open_low=True))]
ShaftRate = Annotated[Quantity, ReadBy(QuantityParser("rad/s", low=0.0, open_low=True))]
FixedSpeed = Annotated[float, ReadBy(QuantityParser("m/s", low=0.0, fixed=True))]
FixedVariance = Annotated[float, ReadBy(QuantityParser("m^2/s^2", fixed=True))]
Duration = Annotated[Quantity, ReadBy(QuantityParser("s", low=0.0))]
Force = Annotated[Quantity, ReadBy(QuantityParser("N", low=0.0, open_low=True))]
SignedForce = Annotated[Quantity, ReadBy(QuantityParser("N"))]
Stiffness = Annotated[Quantity, ReadBy(QuantityParser("N/m", low=0.0, open_low=True))]
Mass = Annotated[Quantity, ReadBy(QuantityParser("kg", low=0.0, open_low=True))]
MassPerLength = Annotated[Quantity, ReadBy(QuantityParser("kg/m", low=0.0, open_low=True))]
Volume = Annotated[Quantity, ReadBy(QuantityParser("m^3", low=0.0))]
Density = Annotated[Quantity, ReadBy(QuantityParser("kg/m^3", low=0.0, open_low=True))]
WaterDensity = Annotated[Quantity, ReadBy(QuantityParser("kg/m^3", low=900.0, high=1300.0))]
Viscosity = Annotated[Quantity, ReadBy(QuantityParser("m^2/s", low=1e-7, high=1e-4))]
Temperature = Annotated[Quantity, ReadBy(QuantityParser("degC", low=-2.5, high=45.0))]
Salinity = Annotated[Quantity, ReadBy(QuantityParser("", low=0.0, high=50.0))]
Angle = Annotated[Quantity, ReadBy(QuantityParser("rad"))]
FixedAngle = Annotated[float, ReadBy(QuantityParser("rad", fixed=True))]
Power = Annotated[Quantity, ReadBy(QuantityParser("W", low=0.0))]
Energy = Annotated[Quantity, ReadBy(QuantityParser("J", low=0.0))]
PositiveNumber = Annotated[Quantity, ReadBy(QuantityParser("", low=0.0, open_low=True))]
Number = Annotated[Quantity, ReadBy(QuantityParser("", low=0.0))]
Efficiency = Annotated[Quantity, ReadBy(QuantityParser("", low=0.0, high=1.0, open_low=True))]
Probability = Annotated[float, ReadBy(QuantityParser("", low=0.0, high=1.0, fixed=True))]


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
