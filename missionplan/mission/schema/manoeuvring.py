"""How a vehicle moves: what `identify` measured of it, tunnel thrusters, controls, and the transition to hover."""

import math
from typing import Annotated, Generic, Literal, Self

from pydantic import Field, model_validator
from typing_extensions import Doc

from missionplan.mission.schema import FileSection, PhaseSection, ReadBy, V, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser

_Plain = Annotated[float, q.fixed("", -math.inf)]
_Positive = Annotated[float, q.fixed("", open_low=True)]
_Time = Annotated[float, q.fixed("s")]
_PositiveTime = Annotated[float, q.fixed("s", open_low=True)]
_Rate = Annotated[float, q.fixed("1/s", open_low=True)]
_Deflection = Annotated[float, q.fixed("rad", open_low=True, high=1.5)]
_Lever = Annotated[float, q.fixed("m", -math.inf)]
_Fraction = Annotated[float, q.fixed("", high=0.99)]
_Speeds = tuple[Annotated[float, q.fixed("m/s", open_low=True)], ...]
Deceleration = ReadBy(QuantityParser("m/s^2", low=0.0, open_low=True))
_Exponent = Annotated[V, ReadBy(QuantityParser("", low=-2.0, high=2.0))]
_Negative = Annotated[V, ReadBy(QuantityParser("", high=0.0))]
_PerVolt = Annotated[V, ReadBy(QuantityParser("N/V^2", low=0.0, open_low=True))]
_Volts = Annotated[V, ReadBy(QuantityParser("V", low=0.0))]


class MeasuredDrag(FileSection, Generic[V]):
    """Measured drag of the egress vehicle, in place of Briggs et al., Eqs. 3 to 13; a power of Re given an exponent."""

    coefficient: Annotated[
        q.PositiveNumber[V],
        Doc("drag coefficient on `area`"),
        Limit((1e-6, 100.0), (1e-3, 3.0), "streamlined 0.1, bluff 1"),
    ]
    area: Annotated[float, q.fixed("m^2", open_low=True), Doc("area to which the coefficient refers")]
    exponent: Annotated[_Exponent[V], Doc("power of the Reynolds number with which the coefficient goes")] = q.default(
        0.0
    )
    at_reynolds: Annotated[_Positive | None, Doc("Reynolds number at which the coefficient was found")] = None
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
    thrust_coefficient: Annotated[
        tuple[q.PositiveNumber[V], _Negative[V]], Doc("α₀ and α₁ of K_T = α₀ + α₁J"), Field(examples=[[0.35, -0.4]])
    ]
    torque_coefficient: Annotated[
        tuple[q.PositiveNumber[V], _Negative[V]], Doc("β₀ and β₁ of K_Q = β₀ + β₁J"), Field(examples=[[0.05, -0.04]])
    ]
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


class DerivativesSection(FileSection):
    """Hydrodynamic derivatives of Palmer et al., Eqs. 4 to 6, dimensionless; 0 where not given."""

    x_uu: Annotated[_Plain, Doc("surge force by speed ahead squared")] = 0.0
    x_ww: Annotated[_Plain, Doc("surge force by heave speed squared")] = 0.0
    x_uudd: Annotated[_Plain, Doc("surge force by deflection squared")] = 0.0
    x_udot: Annotated[_Plain, Doc("surge force by surge acceleration")] = 0.0
    x_wq: Annotated[_Plain, Doc("surge force by heave speed and pitch rate")] = 0.0
    x_qq: Annotated[_Plain, Doc("surge force by pitch rate squared")] = 0.0
    z_uw: Annotated[_Plain, Doc("heave force by speed ahead and heave speed")] = 0.0
    z_ww: Annotated[_Plain, Doc("heave force by heave speed squared")] = 0.0
    z_uud: Annotated[_Plain, Doc("heave force by deflection of the sternplanes")] = 0.0
    z_wdot: Annotated[_Plain, Doc("heave force by heave acceleration")] = 0.0
    z_uq: Annotated[_Plain, Doc("heave force by speed ahead and pitch rate")] = 0.0
    z_uqd: Annotated[_Plain, Doc("heave force by deflection at a pitch rate")] = 0.0
    z_w_abs_q: Annotated[_Plain, Doc("heave force by heave speed and size of the pitch rate")] = 0.0
    z_qdot: Annotated[_Plain, Doc("heave force by pitch acceleration")] = 0.0
    m_uw: Annotated[_Plain, Doc("pitch moment by speed ahead and heave speed")] = 0.0
    m_ww: Annotated[_Plain, Doc("pitch moment by heave speed squared")] = 0.0
    m_uud: Annotated[_Plain, Doc("pitch moment by deflection of the sternplanes")] = 0.0
    m_wdot: Annotated[_Plain, Doc("pitch moment by heave acceleration")] = 0.0
    m_uq: Annotated[_Plain, Doc("pitch moment by speed ahead and pitch rate")] = 0.0
    m_uqd: Annotated[_Plain, Doc("pitch moment by deflection at a pitch rate")] = 0.0
    m_abs_w_q: Annotated[_Plain, Doc("pitch moment by size of the heave speed and pitch rate")] = 0.0
    m_qdot: Annotated[_Plain, Doc("pitch moment by pitch acceleration")] = 0.0

    @model_validator(mode="after")
    def _sternplanes_act(self) -> "DerivativesSection":
        for key in ("z_uud", "m_uud"):
            if getattr(self, key) >= 0.0:
                raise invalid("missing or not negative; sternplanes push the stern up and the nose down", (key,))
        return self


class CentreOfGravity(FileSection, Generic[V]):
    """Centre of gravity from the centre of buoyancy."""

    ahead: Annotated[q.Length[V], Doc("distance ahead of the centre of buoyancy")] = q.default(0.0)
    below: Annotated[float, q.fixed("m", open_low=True), Doc("distance below the centre of buoyancy")]


class Sternplanes(FileSection):
    """Controller of Palmer et al., Fig. 2: depth error to pitch demand, pitch error to deflection."""

    limit: Annotated[_Deflection, Doc("greatest deflection")] = 0.3490658503988659
    depth_gain: Annotated[float, q.fixed("rad/m", open_low=True), Doc("pitch asked for a metre of depth error")]
    depth_integral: Annotated[float, q.fixed("rad/m/s", open_low=True), Doc("the same for its integral over time")]
    pitch_limit: Annotated[_Deflection, Doc("greatest pitch that is asked for")]
    pitch_gain: Annotated[_Positive, Doc("deflection for a radian of pitch error")]
    rate_gain: Annotated[_Time, Doc("deflection for a radian a second of pitch rate")]


class ThrusterController(FileSection):
    """Controller of section 5.1: depth error to shaft rate; and the allocation to a pair of section 7.2."""

    depth_gain: Annotated[float, q.fixed("1/s/m", open_low=True), Doc("revolutions for a metre of depth error")]
    depth_integral: Annotated[float, q.fixed("1/s/m/s"), Doc("the same for its integral over time")]
    depth_rate: Annotated[float, q.fixed("1/m"), Doc("revolutions for a metre a second of depth rate")]
    limit: Annotated[_Rate, Doc("greatest revolutions")]
    pair_steepness: Annotated[_Positive, Doc("how sharply a pair shares its force by the pitch")] = 1.0
    pair_limit: Annotated[_Deflection, Doc("pitch at which one of a pair does all")] = 0.17453292519943295
    pair_lead: Annotated[_Time, Doc("time by which the sharing leads the pitch")] = 0.0


class Manoeuvring(FileSection, Generic[V]):
    """Dynamics in the vertical plane, and controls."""

    inertia: Annotated[float, q.fixed("kg*m^2", open_low=True), Doc("moment of inertia in pitch")]
    centre_of_gravity: Annotated[CentreOfGravity[V], Doc("where the mass is")]
    derivatives: Annotated[DerivativesSection, Doc("hydrodynamic derivatives, dimensionless by ½ρ and the length")]
    propeller: Annotated[
        tuple[_Plain, _Plain, _Plain],
        Doc("b₁, b₂ and b₃ of Eq. 3: thrust by speed and the speed asked for"),
        Field(examples=[[0, -0.0075, 0.01]]),
    ]
    speed_gain: Annotated[_Positive, Doc("how fast the speed asked for is followed")]
    sternplanes: Annotated[Sternplanes, Doc("controller of the sternplanes")]
    thruster_control: Annotated[ThrusterController, Doc("controller of the tunnel thrusters")]


class TunnelThrusterSection(FileSection, Generic[V]):
    """A tunnel thruster."""

    name: Annotated[str, Doc("name of the thruster")] = "tunnel thruster"
    diameter: Annotated[
        q.FixedLength,
        Doc("diameter of the tunnel"),
        Limit((5e-3, 5.0), (0.02, 1.5), "tunnels are 0.05 m to 0.3 m across"),
    ]
    thrust_constant: Annotated[
        V, ReadBy(QuantityParser("N*s^2", low=0.0, open_low=True)), Doc("thrust over shaft rate squared, without way")
    ]
    decay: Annotated[q.PositiveNumber[V], Doc("how fast thrust goes with the speed ahead")]
    position: Annotated[_Lever, Doc("distance ahead of the centre of buoyancy")] = 0.0
    suction_gradient: Annotated[
        float, q.fixed(""), Doc("k of Eq. 6: the centre of suction lies k D u/u_j aft of the thruster")
    ] = 0.0
    suction_offset: Annotated[_Lever, Doc("distance of the centre of suction aft of the thruster at any speed")] = 0.0


class TransitionGrid(FileSection):
    """Grid of `sweep-transition`, which runs every combination; default: Table 2 of Palmer et al.

    Variants with suction and with a pair are run at `shown_deceleration` alone, as in the paper. Time histories are
    shown at `shown_deceleration`, `shown_steepness` and `shown_mid_speed`. The pair is the vehicle's first thruster
    twice, `pair_spacing` apart (default: half the hull's length).
    """

    deceleration: Annotated[
        tuple[Annotated[float, q.fixed("m/s^2", open_low=True)], ...], Doc("decelerations that are tried")
    ] = (0.005, 0.0075, 0.01, 0.0125, 0.015)
    steepness: Annotated[_Speeds, Doc("widths of the hand-over that are tried")] = (0.01, 0.10, 0.15, 0.20, 0.30)
    mid_speed: Annotated[_Speeds, Doc("mid-transition speeds that are tried")] = (
        0.5,
        0.5625,
        0.625,
        0.75,
        0.875,
        1.0,
        1.125,
        1.25,
    )
    shown_deceleration: Annotated[
        float, q.fixed("m/s^2", open_low=True), Doc("deceleration of which tracks are drawn")
    ] = 0.01
    shown_steepness: Annotated[float, q.fixed("m/s", open_low=True), Doc("width of which tracks are drawn")] = 0.10
    shown_mid_speed: Annotated[
        float, q.fixed("m/s", open_low=True), Doc("mid-transition speed of which tracks are drawn")
    ] = 0.75
    pair_spacing: Annotated[q.FixedLength | None, Doc("distance between the two thrusters of a pair")] = None

    @model_validator(mode="after")
    def _shown_is_run(self) -> "TransitionGrid":
        for key in ("deceleration", "steepness", "mid_speed"):
            if getattr(self, f"shown_{key}") not in getattr(self, key):
                raise invalid(f"expected one of the values of {key}", (f"shown_{key}",))
        return self


class TransitionPhase(PhaseSection, Generic[V]):
    """From survey speed to hover; `suction_moment`: whether the thrusters' suction pitches the vehicle."""

    kind: Literal["transition"] = Field(default="transition", exclude=True)
    name: Annotated[str, Doc("name of the phase, for reports")] = "transition"
    start_speed: Annotated[float, q.fixed("m/s", open_low=True), Doc("speed at which the manoeuvre begins"), q.SPEED]
    deceleration: Annotated[
        V,
        Deceleration,
        Doc("rate at which the speed is reduced"),
        Limit((0.0, 10.0), (1e-4, 0.5), "Palmer et al.: 0.005 to 0.015 m/s^2"),
    ]
    mid_speed: Annotated[
        q.PositiveSpeed[V],
        Doc("speed at which the thrusters take over half of the control"),
        Limit((0.0, 10.0), (0.05, 3.2), q.SPEED.source),
    ]
    steepness: Annotated[q.PositiveSpeed[V], Doc("width in speed of that hand-over")]
    suction_moment: Annotated[bool, Doc("whether the jet's suction pitches the vehicle")] = True
    settle: Annotated[
        _PositiveTime,
        Doc("time that is simulated after the speed has reached zero"),
        Limit((0.0, q.DAY), (1.0, 2 * q.HOUR), "hover is reached in minutes"),
    ] = 200.0
    sweep: Annotated[TransitionGrid, Doc("grid that `sweep-transition` computes")] = TransitionGrid()
