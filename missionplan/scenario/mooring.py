"""Parameters of a mission's moorings."""

import numpy as np
from numpy.typing import NDArray

from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.mooring import MoorPlan
from missionplan.physics.added_mass import anchor_added_mass
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.anchor_weight import anchor_flooded_mass, wet_weight_of
from missionplan.scenario.held_vehicle import hold_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.vehicle import surge_added_mass


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


def dive_of(scenario: Scenario, phase: MoorPhase) -> Dive:
    """Return bodies, line and depth of a mooring's descent.

    An anchor that the mission describes by its construction is built once, from the means of its parts.
    """
    water, drag, diameter = scenario.water, scenario.vehicle_drag, scenario["vehicle.anchor.diameter"]
    weight = wet_weight_of(scenario, phase)
    flooded = scenario.draws.get("vehicle.anchor.flooded_mass")
    return Dive(
        wet_weight=weight,
        anchor_mass=anchor_flooded_mass(scenario.means, weight) if flooded is None else flooded,
        anchor_added_mass=scenario.get("vehicle.anchor.added_mass", anchor_added_mass(diameter / 2.0, water.density)),
        anchor_drag=anchor_drag(diameter, scenario["vehicle.anchor.drag_coefficient"], water.density),
        vehicle_mass=scenario["vehicle.mass"],
        vehicle_added_mass=surge_added_mass(drag.hull, scenario.draws),
        net_buoyancy=scenario["vehicle.net_buoyancy"],
        vehicle_drag=drag,
        line_length=scenario[f"{phase.name}.line_length"],
        site_depth=scenario["site.depth"],
    )


def is_too_shallow(scenario: Scenario, dive: Dive) -> NDArray[np.bool_]:
    """Whether the anchor lies on the seafloor before line and vehicle are under water, shape broadcasting to (n,)."""
    return np.atleast_1d(dive.line_length + scenario["vehicle.hull.length"] >= dive.site_depth)
