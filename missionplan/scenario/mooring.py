"""Parameters of a mission's moorings."""

import numpy as np
from numpy.typing import NDArray

from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.horizontal_drift import CrossFlowBody, TiedBodies
from missionplan.phases.mooring.mooring import MoorPlan
from missionplan.physics import cross_flow
from missionplan.physics.added_mass import anchor_added_mass, lamb_axial_coefficient
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.anchor_weight import anchor_flooded_mass, wet_weight_of
from missionplan.scenario.held_vehicle import hold_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.vehicle import lateral_area, surge_added_mass, sway_added_mass


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
    flooded = scenario.draws.get("vehicle.anchor.flooded_mass")
    anchor_mass = anchor_flooded_mass(scenario.means, weight) if flooded is None else flooded
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
    )


def _tied(scenario: Scenario, weight: Scalars, anchor_mass: Scalars) -> TiedBodies:
    """Return both bodies across the flow; the anchor's size follows from the mass that it displaces (Eqs. 16, 17)."""
    density, diameter = scenario.water.density, scenario["vehicle.anchor.diameter"]
    volume = (anchor_mass - weight / STANDARD_GRAVITY) / density + scenario["vehicle.anchor.overlap_volume"]
    length = cross_flow.round_nosed_length(volume, diameter)
    swept = cross_flow.round_nosed_silhouette(length, diameter)
    carried = cross_flow.lateral_coefficient(lamb_axial_coefficient(length / diameter)) * density * volume
    draws = scenario.draws
    return TiedBodies(
        anchor=CrossFlowBody(
            cross_flow.drag_factor(cross_flow.ANCHOR_COEFFICIENT, swept, density), anchor_mass + carried
        ),
        vehicle=CrossFlowBody(
            cross_flow.drag_factor(cross_flow.HULL_COEFFICIENT, lateral_area(draws), density),
            draws["vehicle.mass"] + sway_added_mass(scenario.vehicle_drag.hull, draws),
            centre=draws["vehicle.hull.length"] / 2.0,
        ),
    )


def is_too_shallow(scenario: Scenario, dive: Dive) -> NDArray[np.bool_]:
    """Whether the anchor lies on the seafloor before line and vehicle are under water, shape broadcasting to (n,)."""
    return np.atleast_1d(dive.line_length + scenario["vehicle.hull.length"] >= dive.site_depth)
