"""Parameters of the vehicle on its line: body, line, anchor on the seafloor."""

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.hold import Hold
from missionplan.physics.buoyancy import STANDARD_GRAVITY
from missionplan.physics.held_body import CROSSFLOW_COEFFICIENT, HeldBody, HeldLine
from missionplan.physics.seafloor import FRICTION, ROUGHNESS, LyingAnchor, Slope
from missionplan.scenario.anchor_weight import anchor_length
from missionplan.scenario.scenario import Scenario

HOLDING_GIVEN = "vehicle.anchor.holding_factor"
"""Key path of a quantity that a mission has where its vehicle file says how the anchor holds."""
CENTRES_GIVEN = "vehicle.centre_of_gravity.from_nose"
"""Key path of a quantity that a mission has where its vehicle file gives the centres of gravity and buoyancy."""


def hold_of(scenario: Scenario, phase: MoorPhase, weight: Scalars) -> Hold:
    """Return the vehicle on its line, above an anchor of a wet weight [N]."""
    return Hold(
        body=held_body(scenario),
        line=HeldLine(scenario[f"{phase.name}.line_length"], scenario[f"{phase.name}.line_diameter"]),
        anchor=LyingAnchor(
            wet_weight=weight,
            diameter=scenario["vehicle.anchor.diameter"],
            length=np.maximum(anchor_length(scenario, weight), scenario["vehicle.anchor.diameter"] / 2.0),
            friction=scenario.get(HOLDING_GIVEN, FRICTION),
        ),
        site_depth=scenario["site.depth"],
        slope=Slope(scenario.get("site.slope.angle", 0.0), scenario.get("site.slope.toward", 0.0)),
        roughness=scenario.get("site.roughness", ROUGHNESS),
    )


def held_body(scenario: Scenario) -> HeldBody:
    """Return the egress vehicle as it hangs by its nose.

    Without its centres of gravity and buoyancy the net buoyancy acts at mid-length on the axis.
    """
    drag, buoyancy = scenario.vehicle_drag, scenario["vehicle.net_buoyancy"]
    raising, righting = 0.5 * buoyancy * drag.hull.length, 0.0 * buoyancy
    if CENTRES_GIVEN in scenario.draws:
        weight = scenario["vehicle.mass"] * STANDARD_GRAVITY
        raising, righting = (
            (weight + buoyancy) * scenario[f"vehicle.centre_of_buoyancy.{key}"]
            - weight * scenario[f"vehicle.centre_of_gravity.{key}"]
            for key in ("from_nose", "below_axis")
        )
    return HeldBody(
        length=drag.hull.length,
        diameter=drag.hull.diameter,
        net_buoyancy=buoyancy,
        raising_moment=raising,
        righting_moment=righting,
        crossflow_coefficient=scenario.get("vehicle.hull.crossflow_drag", CROSSFLOW_COEFFICIENT),
        axial_drag=drag,
        density=scenario.water.density,
    )
