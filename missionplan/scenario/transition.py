"""Parameters of a mission's transitions from survey speed to hover."""

from missionplan.mission.schema.transition import Manoeuvring, TransitionPhase, TunnelThrusterSection
from missionplan.mission.views import TransitionMission
from missionplan.phases.transition.plan import Manoeuvre, SternplaneControl, ThrusterControl, TransitionVehicle
from missionplan.physics.tunnel_thruster import TunnelThruster
from missionplan.physics.vehicle_dynamics import Body, Derivatives
from missionplan.scenario.scenario import Scenario


def transition_vehicle(scenario: Scenario, phase: TransitionPhase) -> TransitionVehicle:
    """Return body, thrusters and controls of a transition, as drawn.

    Raises
    ------
    InputError
        When the mission lacks what a transition needs.
    """
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
    """Return the rigid body; length and mass at their means, as the derivatives are made dimensionless by them."""
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
    """Return the manoeuvre that the phase prescribes, as drawn."""
    return Manoeuvre(
        start_speed=phase.start_speed,
        deceleration=scenario[f"{phase.name}.deceleration"],
        mid_speed=scenario[f"{phase.name}.mid_speed"],
        steepness=scenario[f"{phase.name}.steepness"],
        after=phase.settle,
    )
