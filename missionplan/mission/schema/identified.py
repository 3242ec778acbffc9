"""Results of `identify` as sections of a vehicle file: drag, added mass, propulsion and thrusters."""

from typing import Annotated

from pydantic import Discriminator, Tag, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy, invalid
from missionplan.mission.schema.transition import TunnelThrusterSection
from missionplan.montecarlo.distributions import Quantity

_Area = Annotated[float, ReadBy(QuantityParser("m^2", low=0.0, open_low=True, fixed=True))]
_Exponent = Annotated[Quantity, ReadBy(QuantityParser("", low=-2.0, high=2.0))]
_Fraction = Annotated[float, ReadBy(QuantityParser("", low=0.0, high=0.99, fixed=True))]
_Negative = Annotated[Quantity, ReadBy(QuantityParser("", high=0.0))]
_PerVolt = Annotated[Quantity, ReadBy(QuantityParser("N/V^2", low=0.0, open_low=True))]
_Volts = Annotated[Quantity, ReadBy(QuantityParser("V", low=0.0))]
_FixedNumber = Annotated[float, ReadBy(QuantityParser("", low=0.0, open_low=True, fixed=True))]


class MeasuredDrag(FileSection):
    """Measured drag of the egress vehicle, in place of Briggs et al., Eqs. 3 to 13; a power of Re given an exponent."""

    coefficient: q.PositiveNumber
    area: _Area
    exponent: _Exponent = 0.0
    at_reynolds: _FixedNumber | None = None
    length: q.FixedLength | None = None

    @model_validator(mode="after")
    def _exponent_is_scaled(self) -> "MeasuredDrag":
        if "exponent" in self.model_fields_set:
            for key in ("at_reynolds", "length"):
                if getattr(self, key) is None:
                    raise invalid("missing; an exponent needs it", (key,))
        return self


class MeasuredAddedMass(FileSection):
    """Added masses from free oscillation; a descent uses `surge`."""

    surge: q.Mass | None = None
    sway: q.Mass | None = None
    heave: q.Mass | None = None


class Propulsion(FileSection):
    """A propeller by its open-water lines K_T = α₀ + α₁J and K_Q = β₀ + β₁J (Blanke et al., Eq. 19).

    `thrust_factor` and `drag_factor` are the true thrust and drag over this file's, from which the vehicle infers its
    speed.
    """

    diameter: q.FixedLength
    thrust_coefficient: tuple[q.PositiveNumber, _Negative]
    torque_coefficient: tuple[q.PositiveNumber, _Negative]
    wake_fraction: _Fraction = 0.0
    thrust_deduction: _Fraction = 0.0
    axial_flow_factor: _Fraction = 0.0
    flow_mass: q.Mass | None = None
    motor_efficiency: q.Efficiency = 1.0
    thrust_factor: q.PositiveNumber = 1.0
    drag_factor: q.PositiveNumber = 1.0


class StaticThruster(FileSection):
    """A thruster by its bollard pull against voltage."""

    name: str = "thruster"
    ahead: _PerVolt
    astern: _PerVolt | None = None
    deadband: _Volts = 0.0


def _kind(value: object) -> str:
    tunnel = isinstance(value, TunnelThrusterSection) or (isinstance(value, dict) and "diameter" in value)
    return "<tunnel>" if tunnel else "<static>"


Thruster = Annotated[
    Annotated[TunnelThrusterSection, Tag("<tunnel>")] | Annotated[StaticThruster, Tag("<static>")],
    Discriminator(_kind),
]
