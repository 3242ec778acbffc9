"""Parameters of the vehicle on its line: body, line, anchor on the seafloor."""

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.phases.mooring.hold import Hold
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.held_body import CROSSFLOW_COEFFICIENT, HeldBody
from missionplan.physics.held_line import Float, HeldLine, line_drag_factor
from missionplan.physics.line_materials import LINE_MATERIALS
from missionplan.physics.seafloor import FRICTION, ROUGHNESS, LyingAnchor, Slope
from missionplan.scenario.anchors import anchor_length, laden
from missionplan.scenario.scenario import Scenario


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
