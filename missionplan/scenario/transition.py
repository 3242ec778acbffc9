"""A mission's transition phase as the parameters of the model: the draws of a block in, SI numbers and arrays out."""

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.transition import Manoeuvring, TransitionPhase, TunnelThrusterSection
from missionplan.mission.views import TransitionMission
from missionplan.phases.transition.plan import Manoeuvre, SternplaneControl, ThrusterControl, TransitionVehicle
from missionplan.physics.tunnel_thruster import TunnelThruster
from missionplan.physics.vehicle_dynamics import Body, Derivatives
from missionplan.scenario.scenario import Scenario


def check_transition(mission: Mission) -> list[tuple[str, str]]:
    """List the keys that a transition needs and the mission lacks, with the reason."""
    vehicle, site = mission.vehicle, mission.site
    missing = [] if site and site.water is not None else [("site.water", "a transition needs it")]
    if vehicle is None:
        return [*missing, ("vehicle", "a transition needs it")]
    missing += [] if vehicle.manoeuvring else [("vehicle.manoeuvring", "a transition needs it")]
    missing += [] if vehicle.mass is not None else [("vehicle.mass", "a transition needs it")]
    return missing


def transition_phase(mission: Mission, name: str | None = None) -> TransitionPhase:
    """Find the mission's transition of that name; by default its first.

    Raises
    ------
    InputError
        When it has none, or lacks what it needs.
    """
    found = [phase for phase in mission.phases if isinstance(phase, TransitionPhase) and name in (None, phase.name)]
    if not found:
        words = (
            "the mission has no transition phase" if name is None else f"given {name!r}, which is no transition phase"
        )
        raise InputError([Problem(words, mission.file, key="phases")])
    missing = check_transition(mission)
    if missing:
        raise InputError([Problem(f"missing; {words}", mission.file, key=key) for key, words in missing])
    return found[0]


def transition_vehicle(scenario: Scenario, phase: TransitionPhase) -> TransitionVehicle:
    """Vehicle, thrusters and controls of a transition, with the block's draws."""
    mission = TransitionMission.of(scenario.mission)
    written = mission.manoeuvring
    return TransitionVehicle(
        body=_body(scenario, written),
        propeller=written.propeller,
        speed_gain=written.speed_gain,
        thrusters=tuple(
            _tunnel_thruster(scenario, thruster, f"vehicle.thrusters[{index}]")
            for index, thruster in enumerate(mission.vehicle.thrusters)
            if isinstance(thruster, TunnelThrusterSection)
        ),
        suction_moment=phase.suction_moment,
        sternplanes=SternplaneControl(**written.sternplanes.model_dump()),
        thruster_control=ThrusterControl(**written.thruster_control.model_dump()),
    )


def _tunnel_thruster(scenario: Scenario, written: TunnelThrusterSection, path: str) -> TunnelThruster:
    return TunnelThruster(
        diameter=written.diameter,
        thrust_constant=scenario[f"{path}.thrust_constant"],
        decay=scenario[f"{path}.decay"],
        position=written.position,
        suction_gradient=written.suction_gradient,
        suction_offset=written.suction_offset,
    )


def _body(scenario: Scenario, written: Manoeuvring) -> Body:
    """Body of the vehicle file; length and mass at their means, as the derivatives are made dimensionless by them."""
    means = scenario.means
    return Body(
        length=float(means["vehicle.hull.length"]),
        mass=float(means["vehicle.mass"]),
        inertia=written.inertia,
        excess_buoyancy=scenario["vehicle.net_buoyancy"],
        x_g=scenario["vehicle.manoeuvring.centre_of_gravity.ahead"],
        z_g=written.centre_of_gravity.below,
        density=float(means.water.density),
        derivatives=Derivatives(**written.derivatives.model_dump()),
    )


def manoeuvre(scenario: Scenario, phase: TransitionPhase) -> Manoeuvre:
    """What the phase asks of the vehicle, with the block's draws."""
    return Manoeuvre(
        start_speed=phase.start_speed,
        deceleration=scenario[f"{phase.name}.deceleration"],
        mid_speed=scenario[f"{phase.name}.mid_speed"],
        steepness=scenario[f"{phase.name}.steepness"],
        after=phase.settle,
    )
