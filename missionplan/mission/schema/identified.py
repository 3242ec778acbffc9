"""Results of `identify` as sections of a vehicle file: drag, added mass, propulsion and thrusters."""

from typing import Annotated, Generic, Self

from pydantic import model_validator
from typing_extensions import Doc

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.limits import Limit
from missionplan.mission.schema.quantity_parser import QuantityParser
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
    area: _Area
    exponent: _Exponent[V] = q.default(0.0)
    at_reynolds: _FixedNumber | None = None
    length: q.FixedLength | None = None

    @model_validator(mode="after")
    def _exponent_is_scaled(self) -> Self:
        if "exponent" in self.model_fields_set:
            for key in ("at_reynolds", "length"):
                if getattr(self, key) is None:
                    raise invalid("missing; an exponent needs it", (key,))
        return self


class MeasuredAddedMass(FileSection, Generic[V]):
    """Added masses from free oscillation; a descent uses `surge`."""

    surge: q.Mass[V] | None = None
    sway: q.Mass[V] | None = None
    heave: q.Mass[V] | None = None


class Propulsion(FileSection, Generic[V]):
    """A propeller by its open-water lines K_T = α₀ + α₁J and K_Q = β₀ + β₁J (Blanke et al., Eq. 19).

    `thrust_factor` and `drag_factor` are the true thrust and drag over this file's, from which the vehicle infers its
    speed.
    """

    diameter: Annotated[
        q.FixedLength,
        Doc("diameter of the propeller"),
        Limit((5e-3, 5.0), (0.02, 1.5), "AUV propellers are 0.05 m to 1 m across"),
    ]
    thrust_coefficient: tuple[q.PositiveNumber[V], _Negative[V]]
    torque_coefficient: tuple[q.PositiveNumber[V], _Negative[V]]
    wake_fraction: _Fraction = 0.0
    thrust_deduction: _Fraction = 0.0
    axial_flow_factor: _Fraction = 0.0
    flow_mass: q.Mass[V] | None = None
    motor_efficiency: q.Efficiency[V] = q.default(1.0)
    thrust_factor: q.PositiveNumber[V] = q.default(1.0)
    drag_factor: q.PositiveNumber[V] = q.default(1.0)


class StaticThruster(FileSection, Generic[V]):
    """A thruster by its bollard pull against voltage."""

    name: str = "thruster"
    ahead: _PerVolt[V]
    astern: _PerVolt[V] | None = None
    deadband: _Volts[V] = q.default(0.0)
