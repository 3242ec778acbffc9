"""The transition from survey speed to hover: derivatives, controls, tunnel thrusters, and the phase."""

from typing import Annotated, Generic, Literal

from pydantic import Field, model_validator
from typing_extensions import Doc

from missionplan.mission.schema import limits
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.limits import Limit
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, PhaseSection, ReadBy, V, invalid


def _fixed(unit: str, low: float | None = 0.0, *, open_low: bool = False, high: float | None = None) -> ReadBy:
    return ReadBy(
        QuantityParser(
            unit,
            low=float("-inf") if low is None else low,
            high=float("inf") if high is None else high,
            open_low=open_low,
            fixed=True,
        )
    )


_Plain = Annotated[float, _fixed("", None)]
_Positive = Annotated[float, _fixed("", open_low=True)]
_Time = Annotated[float, _fixed("s")]
_PositiveTime = Annotated[float, _fixed("s", open_low=True)]
_Rate = Annotated[float, _fixed("1/s", open_low=True)]
_Deflection = Annotated[float, _fixed("rad", open_low=True, high=1.5)]
_Lever = Annotated[float, _fixed("m", None)]
_Speeds = tuple[Annotated[float, _fixed("m/s", open_low=True)], ...]
Deceleration = ReadBy(QuantityParser("m/s^2", low=0.0, open_low=True))


class DerivativesSection(FileSection):
    """Hydrodynamic derivatives of Palmer et al., Eqs. 4 to 6, dimensionless; 0 where not given."""

    x_uu: _Plain = 0.0
    x_ww: _Plain = 0.0
    x_uudd: _Plain = 0.0
    x_udot: _Plain = 0.0
    x_wq: _Plain = 0.0
    x_qq: _Plain = 0.0
    z_uw: _Plain = 0.0
    z_ww: _Plain = 0.0
    z_uud: _Plain = 0.0
    z_wdot: _Plain = 0.0
    z_uq: _Plain = 0.0
    z_uqd: _Plain = 0.0
    z_w_abs_q: _Plain = 0.0
    z_qdot: _Plain = 0.0
    m_uw: _Plain = 0.0
    m_ww: _Plain = 0.0
    m_uud: _Plain = 0.0
    m_wdot: _Plain = 0.0
    m_uq: _Plain = 0.0
    m_uqd: _Plain = 0.0
    m_abs_w_q: _Plain = 0.0
    m_qdot: _Plain = 0.0

    @model_validator(mode="after")
    def _sternplanes_act(self) -> "DerivativesSection":
        for key in ("z_uud", "m_uud"):
            if getattr(self, key) >= 0.0:
                raise invalid("missing or not negative; sternplanes push the stern up and the nose down", (key,))
        return self


class CentreOfGravity(FileSection, Generic[V]):
    """Centre of gravity from the centre of buoyancy."""

    ahead: q.Length[V] = q.default(0.0)
    below: Annotated[float, _fixed("m", open_low=True)]


class Sternplanes(FileSection):
    """Controller of Palmer et al., Fig. 2: depth error to pitch demand, pitch error to deflection."""

    limit: _Deflection = 0.3490658503988659
    depth_gain: Annotated[float, _fixed("rad/m", open_low=True)]
    depth_integral: Annotated[float, _fixed("rad/m/s", open_low=True)]
    pitch_limit: _Deflection
    pitch_gain: _Positive
    rate_gain: _Time


class ThrusterController(FileSection):
    """Controller of section 5.1: depth error to shaft rate; and the allocation to a pair of section 7.2."""

    depth_gain: Annotated[float, _fixed("1/s/m", open_low=True)]
    depth_integral: Annotated[float, _fixed("1/s/m/s")]
    depth_rate: Annotated[float, _fixed("1/m")]
    limit: _Rate
    pair_steepness: _Positive = 1.0
    pair_limit: _Deflection = 0.17453292519943295
    pair_lead: _Time = 0.0


class Manoeuvring(FileSection, Generic[V]):
    """Dynamics in the vertical plane, and controls."""

    inertia: Annotated[float, _fixed("kg*m^2", open_low=True)]
    centre_of_gravity: CentreOfGravity[V]
    derivatives: DerivativesSection
    propeller: tuple[_Plain, _Plain, _Plain]
    speed_gain: _Positive
    sternplanes: Sternplanes
    thruster_control: ThrusterController


class TunnelThrusterSection(FileSection, Generic[V]):
    """A tunnel thruster."""

    name: str = "tunnel thruster"
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
        float, _fixed(""), Doc("k of Eq. 6: the centre of suction lies k D u/u_j aft of the thruster")
    ] = 0.0
    suction_offset: Annotated[_Lever, Doc("distance of the centre of suction aft of the thruster at any speed")] = 0.0


class TransitionGrid(FileSection):
    """Grid of `sweep-transition`, which runs every combination; default: Table 2 of Palmer et al.

    Variants with suction and with a pair are run at `shown_deceleration` alone, as in the paper. Time histories are
    shown at `shown_deceleration`, `shown_steepness` and `shown_mid_speed`. The pair is the vehicle's first thruster
    twice, `pair_spacing` apart (default: half the hull's length).
    """

    deceleration: tuple[Annotated[float, _fixed("m/s^2", open_low=True)], ...] = (0.005, 0.0075, 0.01, 0.0125, 0.015)
    steepness: _Speeds = (0.01, 0.10, 0.15, 0.20, 0.30)
    mid_speed: _Speeds = (0.5, 0.5625, 0.625, 0.75, 0.875, 1.0, 1.125, 1.25)
    shown_deceleration: Annotated[float, _fixed("m/s^2", open_low=True)] = 0.01
    shown_steepness: Annotated[float, _fixed("m/s", open_low=True)] = 0.10
    shown_mid_speed: Annotated[float, _fixed("m/s", open_low=True)] = 0.75
    pair_spacing: q.FixedLength | None = None

    @model_validator(mode="after")
    def _shown_is_run(self) -> "TransitionGrid":
        for key in ("deceleration", "steepness", "mid_speed"):
            if getattr(self, f"shown_{key}") not in getattr(self, key):
                raise invalid(f"expected one of the values of {key}", (f"shown_{key}",))
        return self


class TransitionPhase(PhaseSection, Generic[V]):
    """From survey speed to hover; `suction_moment`: whether the thrusters' suction pitches the vehicle."""

    kind: Literal["transition"] = Field(default="transition", exclude=True)
    name: str = "transition"
    start_speed: Annotated[
        float, _fixed("m/s", open_low=True), Doc("speed at which the manoeuvre begins"), limits.SPEED
    ]
    deceleration: Annotated[
        V,
        Deceleration,
        Doc("rate at which the speed is reduced"),
        Limit((0.0, 10.0), (1e-4, 0.5), "Palmer et al.: 0.005 to 0.015 m/s^2"),
    ]
    mid_speed: Annotated[
        q.PositiveSpeed[V],
        Doc("speed at which the thrusters take over half of the control"),
        Limit((0.0, 10.0), (0.05, 3.2), limits.SPEED.source),
    ]
    steepness: Annotated[q.PositiveSpeed[V], Doc("width in speed of that hand-over")]
    suction_moment: bool = True
    settle: Annotated[
        _PositiveTime,
        Doc("time that is simulated after the speed has reached zero"),
        Limit((0.0, limits.DAY), (1.0, 2 * limits.HOUR), "hover is reached in minutes"),
    ] = 200.0
    sweep: TransitionGrid = TransitionGrid()
