"""Parameters of phases at their means or as drawn: moorings, the held vehicle, transitions, streams of transits."""

import numpy as np

from missionplan.arrays import Array, Normals, Scalars
from missionplan.mission.schema.manoeuvring import TransitionPhase, TunnelThrusterSection
from missionplan.mission.schema.phases import MoorPhase, Phase, TransitPhase
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.mission.views import TransitionMission
from missionplan.montecarlo.streams import NormalSource
from missionplan.phases.hooks import TrialState
from missionplan.phases.mooring import MoorPlan
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.hold import Hold
from missionplan.phases.mooring.motion import CrossFlowBody, TiedBodies
from missionplan.phases.transit.plan import TransitNormals
from missionplan.phases.transition_plan import Manoeuvre, SternplaneControl, ThrusterControl, TransitionVehicle
from missionplan.physics.drag import anchor_drag
from missionplan.physics.held_line import (
    CROSSFLOW_COEFFICIENT,
    LINE_MATERIALS,
    Float,
    HeldBody,
    HeldLine,
    line_drag_factor,
)
from missionplan.physics.seafloor import FRICTION, ROUGHNESS, LyingAnchor, Slope, lateral_coefficient
from missionplan.physics.tunnel_thruster import TunnelThruster
from missionplan.physics.vehicle_dynamics import Body, Derivatives, LineSpring, PitchingBody, mass_at_nose
from missionplan.physics.water import STANDARD_GRAVITY, anchor_added_mass, lamb_lateral_coefficient
from missionplan.scenario.anchors import anchor_flooded_mass, anchor_length, laden, wet_weight_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transits import surge_added_mass, sway_added_mass


def hold_of(scenario: Scenario, phase: MoorPhase[Scalars], weight: Scalars) -> Hold:
    """Return the vehicle on its line, above an anchor of a wet weight [N]."""
    scenario = laden(scenario, phase)
    anchor, site = scenario.mooring.anchor, scenario.mooring.site
    return Hold(
        body=held_body(scenario),
        line=held_line(phase, scenario.water.density),
        anchor=LyingAnchor(
            wet_weight=weight,
            diameter=anchor.diameter,
            length=np.maximum(anchor_length(scenario, weight), anchor.diameter / 2.0),
            friction=FRICTION if anchor.holding_factor is None else anchor.holding_factor,
        ),
        site_depth=scenario.mooring.depth,
        slope=Slope(site.slope.angle, site.slope.toward) if site.slope is not None else Slope(0.0, 0.0),
        roughness=ROUGHNESS if site.roughness is None else site.roughness,
    )


def held_line(phase: MoorPhase[Scalars], density: Scalars) -> HeldLine:
    """Return the line of a mooring in water of a density [kg/m³]; without weight where the mission says none."""
    weight, stiffness = phase.line_wet_weight, line_stiffness(phase)
    if weight is None and phase.line_material is not None:
        weight = LINE_MATERIALS[phase.line_material].wet_weight(phase.line_diameter, density)
    return HeldLine(
        length=phase.line_length,
        drag_factor=line_drag_factor(phase.line_diameter, density),
        wet_weight=0.0 if weight is None else weight,
        compliance=0.0 if stiffness is None else 1.0 / (stiffness * phase.line_length),
        floats=tuple(Float(item.distance, item.buoyancy) for item in phase.line_floats),
    )


def line_stiffness(phase: MoorPhase[Scalars]) -> Scalars | None:
    """Stiffness of a mooring's whole line [N/m]: the mission's, else its material's; None where neither is given."""
    if phase.line_stiffness is not None or phase.line_material is None:
        return phase.line_stiffness
    return LINE_MATERIALS[phase.line_material].stiffness * phase.line_diameter * phase.line_diameter / phase.line_length


def line_strength(phase: MoorPhase[Scalars]) -> Scalars | None:
    """Breaking load of a mooring's line [N]: the mission's, else its material's; None where neither is given."""
    if phase.line_strength is not None or phase.line_material is None:
        return phase.line_strength
    return LINE_MATERIALS[phase.line_material].strength * phase.line_diameter * phase.line_diameter


def crossflow_coefficient(vehicle: Vehicle[Scalars]) -> Scalars:
    """Drag coefficient of the hull across the flow: the vehicle file's, else a cylinder's."""
    coefficient = vehicle.hull.crossflow_drag
    return CROSSFLOW_COEFFICIENT if coefficient is None else coefficient


def held_body(scenario: Scenario) -> HeldBody:
    """Return the egress vehicle as it hangs by its nose.

    Without its centres of gravity and buoyancy the net buoyancy acts at mid-length on the axis.
    """
    drag, vehicle = scenario.vehicle_drag, scenario.mooring.vehicle
    buoyancy, centres = vehicle.net_buoyancy, vehicle.centres
    raising, righting = 0.5 * buoyancy * drag.hull.length, 0.0 * buoyancy
    if centres is not None:
        gravity, displaced = centres
        weight = scenario.mooring.mass * STANDARD_GRAVITY
        raising = (weight + buoyancy) * displaced.from_nose - weight * gravity.from_nose
        righting = (weight + buoyancy) * displaced.below_axis - weight * gravity.below_axis
    return HeldBody(
        length=drag.hull.length,
        diameter=drag.hull.diameter,
        net_buoyancy=buoyancy,
        raising_moment=raising,
        righting_moment=righting,
        crossflow_coefficient=crossflow_coefficient(vehicle),
        axial_drag=drag,
        density=scenario.water.density,
    )


def moor_plan(scenario: Scenario, phase: MoorPhase[Scalars]) -> MoorPlan:
    """Return the parameters of one mooring."""
    dive = dive_of(scenario, phase)
    return MoorPlan(
        dive=dive,
        held=hold_of(scenario, phase, dive.wet_weight),
        radius=phase.radius,
        release_time=phase.release_time,
        moored_time=sum(phase.times_moored),
        surfacing_time=scenario.surfacing_time,
        fix_error=scenario.fix_sd,
        hotel_power=scenario.budget.hotel,
        surfacing_energy=scenario.budget.surfacing,
    )


def dive_of(scenario: Scenario, phase: MoorPhase[Scalars], weight: Scalars | None = None) -> Dive:
    """Return bodies, line and depth of a mooring's descent, with an anchor of a wet weight [N] or the mission's own.

    An anchor that the mission describes by its construction is built once, from the means of its parts.
    """
    if weight is None:
        weight = wet_weight_of(scenario, phase)
    scenario, anchor_mass = laden(scenario, phase), anchor_flooded_mass(scenario, weight)
    water, drag, needed = scenario.water, scenario.vehicle_drag, scenario.mooring
    vehicle, anchor = needed.vehicle, needed.anchor
    return Dive(
        wet_weight=weight,
        anchor_mass=anchor_mass,
        anchor_added_mass=(
            anchor_added_mass(anchor.diameter / 2.0, water.density) if anchor.added_mass is None else anchor.added_mass
        ),
        anchor_drag=anchor_drag(anchor.diameter, anchor.drag_coefficient, water.density),
        vehicle_mass=needed.mass,
        vehicle_added_mass=surge_added_mass(drag.hull, vehicle, needed.mass),
        net_buoyancy=vehicle.net_buoyancy,
        vehicle_drag=drag,
        line_length=phase.line_length,
        site_depth=needed.depth,
        tied=_tied(scenario, weight, anchor_mass) if phase.lateral == "coupled" else None,
        spring=_spring(scenario, phase),
        pitching=_pitching(scenario),
        flooding_time=0.0 if anchor.flooding_time is None else anchor.flooding_time,
    )


def _pitching(scenario: Scenario) -> PitchingBody | None:
    """Return the vehicle as a rigid body that pitches; None where the vehicle file does not give its centres."""
    hull, vehicle, mass = scenario.vehicle_drag.hull, scenario.mooring.vehicle, scenario.mooring.mass
    if vehicle.centres is None:
        return None
    gravity, buoyancy = vehicle.centres
    lateral = mass + sway_added_mass(hull, vehicle, mass)
    return PitchingBody(
        lateral_mass=lateral,
        inertia=lateral * hull.length**2 / 12.0,
        length=hull.length,
        centre=gravity.from_nose,
        ahead=gravity.from_nose - buoyancy.from_nose,
        below=buoyancy.below_axis - gravity.below_axis,
        buoyancy=mass * STANDARD_GRAVITY + vehicle.net_buoyancy,
        drag_per_length=0.5 * scenario.water.density * crossflow_coefficient(vehicle) * hull.diameter,
    )


def _spring(scenario: Scenario, phase: MoorPhase[Scalars]) -> LineSpring | None:
    """Return what bears the snatch of a line; None where its stiffness is not known."""
    stiffness, strength = line_stiffness(phase), line_strength(phase)
    if stiffness is None:
        return None
    hull, vehicle, mass = scenario.vehicle_drag.hull, scenario.mooring.vehicle, scenario.mooring.mass
    lateral = mass + sway_added_mass(hull, vehicle, mass)
    return LineSpring(
        stiffness=stiffness,
        nose_mass=mass_at_nose(lateral, hull.length, vehicle.centres[0].from_nose if vehicle.centres else None),
        strength=np.inf if strength is None else strength,
    )


def _tied(scenario: Scenario, weight: Scalars, anchor_mass: Scalars) -> TiedBodies:
    """Return both bodies across the flow: upright cylinders."""
    density, hull = scenario.water.density, scenario.vehicle_drag.hull
    vehicle, mass, diameter = scenario.mooring.vehicle, scenario.mooring.mass, scenario.mooring.anchor.diameter
    length = np.maximum(anchor_length(scenario, weight), diameter / 2.0)
    displaced = (anchor_mass - weight / STANDARD_GRAVITY) + density * scenario.mooring.anchor.overlap_volume
    carried = lamb_lateral_coefficient(np.maximum(length / diameter, 1.0)) * displaced
    return TiedBodies(
        anchor=CrossFlowBody(
            drag=0.5 * density * lateral_coefficient(length / diameter) * length * diameter, mass=anchor_mass + carried
        ),
        vehicle=CrossFlowBody(
            drag=0.5 * density * crossflow_coefficient(vehicle) * hull.length * hull.diameter,
            mass=mass + sway_added_mass(hull, vehicle, mass),
            centre=hull.length / 2.0,
        ),
    )


def room_in_depth(dive: Dive, length: Scalars) -> Array:
    """Depth of the water beyond line and vehicle, of a length [m]: at 0 the anchor lies before both are under water.

    Of a shape that broadcasts to (n,) [m].
    """
    return np.atleast_1d(dive.site_depth - dive.line_length - length)


def start_of(scenario: Scenario, phase: MoorPhase[Scalars]) -> tuple[Array, float]:
    """Planned position [m] and time [s] of a mooring's last fix: the goal of the transits before, at their speeds."""
    place, time = np.zeros(2), 0.0
    means = scenario.means
    for earlier in means.drawn.phases:
        if earlier.name == phase.name:
            break
        if isinstance(earlier, TransitPhase):
            if earlier.start is not None:
                place = means.position(earlier.start).reshape(2)
            goal = means.position(earlier.to).reshape(2)
            time += float(np.hypot(*(goal - place))) / float(earlier.speed)
            place = goal
    return place, time


def transition_vehicle(scenario: Scenario, phase: TransitionPhase[Scalars]) -> TransitionVehicle:
    """Return body, thrusters and controls of a transition, as drawn.

    Raises InputError when the mission lacks what a transition needs.
    """
    needed, means = TransitionMission.of(scenario.drawn), TransitionMission.of(scenario.means.drawn)
    written = needed.manoeuvring
    return TransitionVehicle(
        body=Body(  # length and mass at their means, as the derivatives are made dimensionless by them
            length=float(means.vehicle.hull.length),
            mass=float(means.mass),
            inertia=written.inertia,
            excess_buoyancy=needed.vehicle.net_buoyancy,
            x_g=written.centre_of_gravity.ahead,
            z_g=written.centre_of_gravity.below,
            density=float(scenario.means.water.density),
            derivatives=Derivatives(**written.derivatives.model_dump()),
        ),
        propeller=written.propeller,
        speed_gain=written.speed_gain,
        thrusters=tuple(
            TunnelThruster(
                diameter=thruster.diameter,
                thrust_constant=thruster.thrust_constant,
                decay=thruster.decay,
                position=thruster.position,
                suction_gradient=thruster.suction_gradient,
                suction_offset=thruster.suction_offset,
            )
            for thruster in needed.vehicle.thrusters
            if isinstance(thruster, TunnelThrusterSection)
        ),
        suction_moment=phase.suction_moment,
        sternplanes=SternplaneControl(**written.sternplanes.model_dump()),
        thruster_control=ThrusterControl(**written.thruster_control.model_dump()),
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


def transit_normals(scenario: Scenario, phase: TransitPhase[Scalars], source: NormalSource) -> TransitNormals:
    """Open the streams of a transit's legs.

    They depend on the phase alone, so that every σ_v and every d_max has the same ones (common random numbers).
    """

    def legs(quantity: str) -> Normals:
        return source.legs(f"{phase.name}.{quantity}")

    return TransitNormals(
        velocity=legs("velocity_error"),
        fix_on_surfacing=legs("fix_on_surfacing"),
        fix_on_diving=legs("fix_on_diving"),
        effects=[legs(name) for name in scenario.transit_effect_streams],
    )


def deployed(
    scenario: Scenario, phase: "Phase[Scalars]", position: Array, source: NormalSource, trials: int
) -> TrialState:
    """Deploy a block of trials at a position, shape (2,) or (2, n) [m], with a fix before the first dive of a phase."""
    sd = scenario.fix_sd
    noise = sd * fix_normals(f"{phase.name}.fix_at_start", source, trials) if np.any(sd) else 0.0
    return TrialState.at(position, trials, noise)


def fix_normals(quantity: str, source: NormalSource, trials: int) -> Array:
    """Standard normals of a fix that is taken once, shape (2, n)."""
    return source.legs(quantity).leg(0)[:, :trials]
