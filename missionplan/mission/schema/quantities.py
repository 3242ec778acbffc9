"""Types of the quantities in mission files: each a float in SI or a distribution."""

from dataclasses import replace
from typing import Annotated

from pydantic import PlainValidator

from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import all_invalid
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.distributions import Quantity

Length = Annotated[Quantity, PlainValidator(QuantityParser("m"))]
Distance = Annotated[Quantity, PlainValidator(QuantityParser("m", low=0.0))]
PositiveLength = Annotated[Quantity, PlainValidator(QuantityParser("m", low=0.0, open_low=True))]
FixedLength = Annotated[float, PlainValidator(QuantityParser("m", low=0.0, open_low=True, fixed=True))]
FixedDistance = Annotated[float, PlainValidator(QuantityParser("m", low=0.0, fixed=True))]
SignedSpeed = Annotated[Quantity, PlainValidator(QuantityParser("m/s"))]
Speed = Annotated[Quantity, PlainValidator(QuantityParser("m/s", low=0.0))]
PositiveSpeed = Annotated[Quantity, PlainValidator(QuantityParser("m/s", low=0.0, open_low=True))]
ShaftRate = Annotated[Quantity, PlainValidator(QuantityParser("rad/s", low=0.0, open_low=True))]
FixedSpeed = Annotated[float, PlainValidator(QuantityParser("m/s", low=0.0, fixed=True))]
FixedVariance = Annotated[float, PlainValidator(QuantityParser("m^2/s^2", fixed=True))]
Duration = Annotated[Quantity, PlainValidator(QuantityParser("s", low=0.0))]
Force = Annotated[Quantity, PlainValidator(QuantityParser("N", low=0.0, open_low=True))]
SignedForce = Annotated[Quantity, PlainValidator(QuantityParser("N"))]
Mass = Annotated[Quantity, PlainValidator(QuantityParser("kg", low=0.0, open_low=True))]
MassPerLength = Annotated[Quantity, PlainValidator(QuantityParser("kg/m", low=0.0, open_low=True))]
Volume = Annotated[Quantity, PlainValidator(QuantityParser("m^3", low=0.0))]
Density = Annotated[Quantity, PlainValidator(QuantityParser("kg/m^3", low=0.0, open_low=True))]
WaterDensity = Annotated[Quantity, PlainValidator(QuantityParser("kg/m^3", low=900.0, high=1300.0))]
Viscosity = Annotated[Quantity, PlainValidator(QuantityParser("m^2/s", low=1e-7, high=1e-4))]
Temperature = Annotated[Quantity, PlainValidator(QuantityParser("degC", low=-2.5, high=45.0))]
Salinity = Annotated[Quantity, PlainValidator(QuantityParser("", low=0.0, high=50.0))]
Angle = Annotated[Quantity, PlainValidator(QuantityParser("rad"))]
FixedAngle = Annotated[float, PlainValidator(QuantityParser("rad", fixed=True))]
Power = Annotated[Quantity, PlainValidator(QuantityParser("W", low=0.0))]
Energy = Annotated[Quantity, PlainValidator(QuantityParser("J", low=0.0))]
PositiveNumber = Annotated[Quantity, PlainValidator(QuantityParser("", low=0.0, open_low=True))]
Number = Annotated[Quantity, PlainValidator(QuantityParser("", low=0.0))]
Efficiency = Annotated[Quantity, PlainValidator(QuantityParser("", low=0.0, high=1.0, open_low=True))]
Probability = Annotated[float, PlainValidator(QuantityParser("", low=0.0, high=1.0, fixed=True))]


def or_word(parser: QuantityParser, *words: str) -> PlainValidator:
    """Return a validator that takes one of some words, or a quantity."""

    def read(value: object) -> Quantity | str:
        if isinstance(value, str) and value in words:
            return value
        try:
            return parser.parse(value)
        except QuantityError as error:
            also = f" (or {', '.join(words)})"
            problems = [replace(problem, message=problem.message + also) for problem in error.problems]
            raise all_invalid(problems) from None

    return PlainValidator(read)
