"""Parameters of a mission's moorings."""

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.horizontal_drift import CrossFlowBody, TiedBodies
from missionplan.phases.mooring.mooring import MoorPlan
from missionplan.physics.added_mass import anchor_added_mass, lamb_lateral_coefficient
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.seafloor import lateral_coefficient
from missionplan.physics.snatch import LineSpring, PitchingBody, mass_at_nose
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.anchors import anchor_flooded_mass, anchor_length, laden, wet_weight_of
from missionplan.scenario.held_vehicle import crossflow_coefficient, hold_of, line_stiffness, line_strength
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.vehicle import surge_added_mass, sway_added_mass


def moor_plan(scenario: Scenario, phase: MoorPhase[Scalars]) -> MoorPlan:
    """Return the parameters of one mooring."""
    dive = dive_of(scenario, phase)
    return MoorPlan(
        dive=dive,
        held=hold_of(scenario, phase, dive.wet_weight),
        radius=phase.radius,
        release_time=phase.release_time,
        hold=phase.hold,
        galvanic_release=phase.galvanic_release,
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
            drag=0.5 * density * lateral_coefficient(length / diameter) * length * diameter,
            mass=anchor_mass + carried,
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
