"""Parameters of the vehicle on its line: body, line, anchor on the seafloor."""

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.phases.mooring.hold import Hold
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.held_body import CROSSFLOW_COEFFICIENT, HeldBody, HeldLine
from missionplan.physics.seafloor import FRICTION, ROUGHNESS, LyingAnchor, Slope
from missionplan.scenario.anchor_weight import anchor_length
from missionplan.scenario.scenario import Scenario


def hold_of(scenario: Scenario, phase: MoorPhase[Scalars], weight: Scalars) -> Hold:
    """Return the vehicle on its line, above an anchor of a wet weight [N]."""
    anchor, site = scenario.mooring.anchor, scenario.mooring.site
    return Hold(
        body=held_body(scenario),
        line=HeldLine(phase.line_length, phase.line_diameter),
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


def crossflow_coefficient(vehicle: Vehicle[Scalars]) -> Scalars:
    """Drag coefficient of the hull across the flow: the vehicle file's, else a cylinder's."""
    given = vehicle.hull.crossflow_drag
    return CROSSFLOW_COEFFICIENT if given is None else given


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
