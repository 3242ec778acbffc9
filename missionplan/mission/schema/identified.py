"""Results of `identify` as sections of a vehicle file: drag, added mass, propulsion and thrusters."""

from typing import Annotated, Generic, Self

from pydantic import model_validator
from typing_extensions import Doc

from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy, V, invalid

_Area = Annotated[float, ReadBy(QuantityParser("m^2", low=0.0, open_low=True, fixed=True))]
_Exponent = Annotated[V, ReadBy(QuantityParser("", low=-2.0, high=2.0))]
_Fraction = Annotated[float, ReadBy(QuantityParser("", low=0.0, high=0.99, fixed=True))]
_Negative = Annotated[V, ReadBy(QuantityParser("", high=0.0))]
_PerVolt = Annotated[V, ReadBy(QuantityParser("N/V^2", low=0.0, open_low=True))]
_Volts = Annotated[V, ReadBy(QuantityParser("V", low=0.0))]
_FixedNumber = Annotated[float, ReadBy(QuantityParser("", low=0.0, open_low=True, fixed=True))]


class MeasuredDrag(FileSection, Generic[V]):
    """Measured drag of the egress vehicle, in place of Briggs et al., Eqs. 3 to 13; a power of Re given an exponent."""

    coefficient: Annotated[
        q.PositiveNumber[V],
        Doc("drag coefficient on `area`"),
        Limit((1e-6, 100.0), (1e-3, 3.0), "streamlined 0.1, bluff 1"),
    ]
    area: Annotated[_Area, Doc("area to which the coefficient refers")]
    exponent: Annotated[_Exponent[V], Doc("power of the Reynolds number with which the coefficient goes")] = q.default(
        0.0
    )
    at_reynolds: Annotated[_FixedNumber | None, Doc("Reynolds number at which the coefficient was found")] = None
    length: Annotated[q.FixedLength | None, Doc("length of that Reynolds number")] = None

    @model_validator(mode="after")
    def _exponent_is_scaled(self) -> Self:
        if "exponent" in self.model_fields_set:
            for key in ("at_reynolds", "length"):
                if getattr(self, key) is None:
                    raise invalid("missing; an exponent needs it", (key,))
        return self


class MeasuredAddedMass(FileSection, Generic[V]):
    """Added masses from free oscillation."""

    surge: Annotated[q.Mass[V] | None, Doc("added mass along the axis, which a descent uses")] = None
    sway: Annotated[q.Mass[V] | None, Doc("added mass across the axis")] = None
    heave: Annotated[q.Mass[V] | None, Doc("added mass across the axis, up and down")] = None


class Propulsion(FileSection, Generic[V]):
    """A propeller by its open-water lines K_T = α₀ + α₁J and K_Q = β₀ + β₁J (Blanke et al., Eq. 19)."""

    diameter: Annotated[
        q.FixedLength,
        Doc("diameter of the propeller"),
        Limit((5e-3, 5.0), (0.02, 1.5), "AUV propellers are 0.05 m to 1 m across"),
    ]
    thrust_coefficient: Annotated[tuple[q.PositiveNumber[V], _Negative[V]], Doc("α₀ and α₁ of K_T = α₀ + α₁J")]
    torque_coefficient: Annotated[tuple[q.PositiveNumber[V], _Negative[V]], Doc("β₀ and β₁ of K_Q = β₀ + β₁J")]
    wake_fraction: Annotated[_Fraction, Doc("share of the speed by which the wake at the propeller is slower")] = 0.0
    thrust_deduction: Annotated[
        _Fraction, Doc("share of the thrust that the propeller's suction on the hull takes")
    ] = 0.0
    axial_flow_factor: Annotated[_Fraction, Doc("factor on the axial flow that the propeller makes")] = 0.0
    flow_mass: Annotated[q.Mass[V] | None, Doc("mass of water that the propeller sets moving")] = None
    motor_efficiency: Annotated[q.Efficiency[V], Doc("power of the shaft over the electrical power")] = q.default(1.0)
    thrust_factor: Annotated[
        q.PositiveNumber[V], Doc("true thrust over this file's, from which the vehicle infers its speed")
    ] = q.default(1.0)
    drag_factor: Annotated[
        q.PositiveNumber[V], Doc("true drag over this file's, from which the vehicle infers its speed")
    ] = q.default(1.0)


class StaticThruster(FileSection, Generic[V]):
    """A thruster by its bollard pull against voltage."""

    name: Annotated[str, Doc("name of the thruster")] = "thruster"
    ahead: Annotated[_PerVolt[V], Doc("bollard pull ahead over voltage squared")]
    astern: Annotated[_PerVolt[V] | None, Doc("bollard pull astern over voltage squared")] = None
    deadband: Annotated[_Volts[V], Doc("voltage below which it gives no thrust")] = q.default(0.0)
