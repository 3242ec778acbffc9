"""Parameters of a mission's moorings."""

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.horizontal_drift import CrossFlowBody, TiedBodies
from missionplan.phases.mooring.mooring import MoorPlan
from missionplan.physics.added_mass import anchor_added_mass, lamb_lateral_coefficient
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.held_body import CROSSFLOW_COEFFICIENT
from missionplan.physics.seafloor import lateral_coefficient
from missionplan.physics.snatch import LineSpring, PitchingBody, mass_at_nose
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.anchor_weight import anchor_flooded_mass, anchor_length, wet_weight_of
from missionplan.scenario.held_vehicle import CENTRES_GIVEN, hold_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.vehicle import surge_added_mass, sway_added_mass


def moor_plan(scenario: Scenario, phase: MoorPhase) -> MoorPlan:
    """Return the parameters of one mooring."""
    name, dive = phase.name, dive_of(scenario, phase)
    return MoorPlan(
        dive=dive,
        held=hold_of(scenario, phase, dive.wet_weight),
        radius=scenario[f"{name}.radius"],
        release_time=scenario[f"{name}.release_time"],
        hold=scenario[f"{name}.hold"],
        galvanic_release=scenario[f"{name}.galvanic_release"],
        surfacing_time=scenario.surfacing_time,
        fix_error=scenario.fix_sd,
        hotel_power=scenario.energy("hotel"),
        surfacing_energy=scenario.energy("surfacing"),
    )


def dive_of(scenario: Scenario, phase: MoorPhase, weight: Scalars | None = None) -> Dive:
    """Return bodies, line and depth of a mooring's descent, with an anchor of a wet weight [N] or the mission's own.

    An anchor that the mission describes by its construction is built once, from the means of its parts.
    """
    water, drag, diameter = scenario.water, scenario.vehicle_drag, scenario["vehicle.anchor.diameter"]
    if weight is None:
        weight = wet_weight_of(scenario, phase)
    anchor_mass = anchor_flooded_mass(scenario, weight)
    return Dive(
        wet_weight=weight,
        anchor_mass=anchor_mass,
        anchor_added_mass=scenario.get("vehicle.anchor.added_mass", anchor_added_mass(diameter / 2.0, water.density)),
        anchor_drag=anchor_drag(diameter, scenario["vehicle.anchor.drag_coefficient"], water.density),
        vehicle_mass=scenario["vehicle.mass"],
        vehicle_added_mass=surge_added_mass(drag.hull, scenario.draws),
        net_buoyancy=scenario["vehicle.net_buoyancy"],
        vehicle_drag=drag,
        line_length=scenario[f"{phase.name}.line_length"],
        site_depth=scenario["site.depth"],
        tied=_tied(scenario, weight, anchor_mass) if phase.lateral == "coupled" else None,
        spring=_spring(scenario, phase) if phase.line_stiffness is not None else None,
        pitching=_pitching(scenario) if CENTRES_GIVEN in scenario.draws else None,
        flooding_time=scenario.get("vehicle.anchor.flooding_time", 0.0),
    )


def _pitching(scenario: Scenario) -> PitchingBody:
    """Return the vehicle as a rigid body that pitches, of a vehicle file that gives its centres."""
    hull, draws = scenario.vehicle_drag.hull, scenario.draws
    lateral = scenario["vehicle.mass"] + sway_added_mass(hull, draws)
    gravity, buoyancy = "vehicle.centre_of_gravity", "vehicle.centre_of_buoyancy"
    coefficient = scenario.get("vehicle.hull.crossflow_drag", CROSSFLOW_COEFFICIENT)
    return PitchingBody(
        lateral_mass=lateral,
        inertia=lateral * hull.length**2 / 12.0,
        length=hull.length,
        centre=scenario[f"{gravity}.from_nose"],
        ahead=scenario[f"{gravity}.from_nose"] - scenario[f"{buoyancy}.from_nose"],
        below=scenario[f"{buoyancy}.below_axis"] - scenario[f"{gravity}.below_axis"],
        buoyancy=scenario["vehicle.mass"] * STANDARD_GRAVITY + scenario["vehicle.net_buoyancy"],
        drag_per_length=0.5 * scenario.water.density * coefficient * hull.diameter,
    )


def _spring(scenario: Scenario, phase: MoorPhase) -> LineSpring:
    """Return what bears the snatch of a line whose stiffness the mission gives."""
    hull, draws = scenario.vehicle_drag.hull, scenario.draws
    lateral = scenario["vehicle.mass"] + sway_added_mass(hull, draws)
    return LineSpring(
        stiffness=scenario[f"{phase.name}.line_stiffness"],
        nose_mass=mass_at_nose(lateral, hull.length, draws.get("vehicle.centre_of_gravity.from_nose")),
        strength=scenario.get(f"{phase.name}.line_strength", np.inf),
    )


def _tied(scenario: Scenario, weight: Scalars, anchor_mass: Scalars) -> TiedBodies:
    """Return both bodies across the flow: upright cylinders."""
    density, hull = scenario.water.density, scenario.vehicle_drag.hull
    diameter = scenario["vehicle.anchor.diameter"]
    length = np.maximum(anchor_length(scenario, weight), diameter / 2.0)
    displaced = (anchor_mass - weight / STANDARD_GRAVITY) + density * scenario["vehicle.anchor.overlap_volume"]
    carried = lamb_lateral_coefficient(np.maximum(length / diameter, 1.0)) * displaced
    coefficient = scenario.get("vehicle.hull.crossflow_drag", CROSSFLOW_COEFFICIENT)
    return TiedBodies(
        anchor=CrossFlowBody(
            drag=0.5 * density * lateral_coefficient(length / diameter) * length * diameter,
            mass=anchor_mass + carried,
        ),
        vehicle=CrossFlowBody(
            drag=0.5 * density * coefficient * hull.length * hull.diameter,
            mass=scenario["vehicle.mass"] + sway_added_mass(hull, scenario.draws),
            centre=hull.length / 2.0,
        ),
    )


def is_too_shallow(scenario: Scenario, dive: Dive) -> NDArray[np.bool_]:
    """Whether the anchor lies on the seafloor before line and vehicle are under water, shape broadcasting to (n,)."""
    return np.atleast_1d(dive.line_length + scenario["vehicle.hull.length"] >= dive.site_depth)


def start_of(scenario: Scenario, phase: MoorPhase) -> tuple[Array, float]:
    """Planned position [m] and time [s] of a mooring's last fix: the goal of the transits before, at their speeds."""
    place, time = np.zeros(2), 0.0
    means = scenario.means
    for earlier in scenario.mission.phases:
        if earlier is phase:
            break
        if isinstance(earlier, TransitPhase):
            if earlier.start is not None:
                place = means.position(earlier.start, f"{earlier.name}.from").reshape(2)
            goal = means.position(earlier.to, f"{earlier.name}.to").reshape(2)
            time += float(np.hypot(*(goal - place))) / float(means[f"{earlier.name}.speed"])
            place = goal
    return place, time
