"""Parameters of a mission's transitions from survey speed to hover."""

from missionplan.arrays import Scalars
from missionplan.mission.schema.transition import TransitionPhase, TunnelThrusterSection
from missionplan.mission.views import TransitionMission
from missionplan.phases.transition.plan import Manoeuvre, SternplaneControl, ThrusterControl, TransitionVehicle
from missionplan.physics.tunnel_thruster import TunnelThruster
from missionplan.physics.vehicle_dynamics import Body, Derivatives
from missionplan.scenario.scenario import Scenario


def transition_vehicle(scenario: Scenario, phase: TransitionPhase[Scalars]) -> TransitionVehicle:
    """Return body, thrusters and controls of a transition, as drawn.

    Raises
    ------
    InputError
        When the mission lacks what a transition needs.
    """
    needed = TransitionMission.of(scenario.drawn)
    written = needed.manoeuvring
    return TransitionVehicle(
        body=_body(scenario, needed),
        propeller=written.propeller,
        speed_gain=written.speed_gain,
        thrusters=tuple(
            _tunnel_thruster(thruster)
            for thruster in needed.vehicle.thrusters
            if isinstance(thruster, TunnelThrusterSection)
        ),
        suction_moment=phase.suction_moment,
        sternplanes=SternplaneControl(**written.sternplanes.model_dump()),
        thruster_control=ThrusterControl(**written.thruster_control.model_dump()),
    )


def _tunnel_thruster(written: TunnelThrusterSection[Scalars]) -> TunnelThruster:
    return TunnelThruster(
        diameter=written.diameter,
        thrust_constant=written.thrust_constant,
        decay=written.decay,
        position=written.position,
        suction_gradient=written.suction_gradient,
        suction_offset=written.suction_offset,
    )


def _body(scenario: Scenario, needed: TransitionMission[Scalars]) -> Body:
    """Return the rigid body; length and mass at their means, as the derivatives are made dimensionless by them."""
    means, written = TransitionMission.of(scenario.means.drawn), needed.manoeuvring
    return Body(
        length=float(means.vehicle.hull.length),
        mass=float(means.mass),
        inertia=written.inertia,
        excess_buoyancy=needed.vehicle.net_buoyancy,
        x_g=written.centre_of_gravity.ahead,
        z_g=written.centre_of_gravity.below,
        density=float(scenario.means.water.density),
        derivatives=Derivatives(**written.derivatives.model_dump()),
    )


def manoeuvre(phase: TransitionPhase[Scalars]) -> Manoeuvre:
    """Return the manoeuvre that the phase prescribes, as drawn."""
    return Manoeuvre(
        start_speed=phase.start_speed,
        deceleration=phase.deceleration,
        mid_speed=phase.mid_speed,
        steepness=phase.steepness,
        after=phase.settle,
    )
