"""A mission's moorings as the parameters of the model: the draws of a block in, SI numbers and arrays out."""

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.mooring import MoorPlan
from missionplan.physics.added_mass import anchor_added_mass, lamb_axial_coefficient
from missionplan.physics.buoyancy import displaced_mass
from missionplan.physics.vehicle_drag import anchor_drag
from missionplan.scenario.anchor_weight import anchor_flooded_mass, worst_case_weight
from missionplan.scenario.scenario import Setting


def moor_plan(setting: Setting, phase: MoorPhase) -> MoorPlan:
    """What a mooring is told."""
    name = phase.name
    return MoorPlan(
        dive=dive_of(setting, phase),
        radius=setting[f"{name}.radius"],
        release_time=setting[f"{name}.release_time"],
        hold=setting[f"{name}.hold"],
        galvanic_release=setting[f"{name}.galvanic_release"],
        surfacing_time=setting.surfacing_time,
        fix_error=setting.fix_sd,
        hotel_power=setting.energy("hotel"),
        surfacing_energy=setting.energy("surfacing"),
    )


def dive_of(setting: Setting, phase: MoorPhase) -> Dive:
    """Bodies, line and depth of a mooring's descent.

    An anchor that the mission describes by its construction is built once, from the means of its parts.
    """
    water, drag, diameter = setting.water, setting.vehicle_drag, setting["vehicle.anchor.diameter"]
    weight = wet_weight_of(setting, phase)
    displaced = displaced_mass(setting["vehicle.mass"], setting["vehicle.net_buoyancy"])
    fraction = setting.get("vehicle.hull.added_mass", lamb_axial_coefficient(drag.hull.length / drag.hull.diameter))
    if "vehicle.added_mass.surge" in setting.draws:
        fraction = setting["vehicle.added_mass.surge"] / displaced
    flooded = setting.draws.get("vehicle.anchor.flooded_mass")
    return Dive(
        wet_weight=weight,
        anchor_mass=anchor_flooded_mass(setting.means, weight) if flooded is None else flooded,
        anchor_added_mass=setting.get("vehicle.anchor.added_mass", anchor_added_mass(diameter / 2.0, water.density)),
        anchor_drag=anchor_drag(diameter, setting["vehicle.anchor.drag_coefficient"], water.density),
        vehicle_mass=setting["vehicle.mass"],
        vehicle_added_mass=fraction * displaced,
        net_buoyancy=setting["vehicle.net_buoyancy"],
        vehicle_drag=drag,
        line_length=setting[f"{phase.name}.line_length"],
        site_depth=setting["site.depth"],
    )


def wet_weight_of(setting: Setting, phase: MoorPhase) -> Scalars:
    """Wet weight of the anchor [N]: the mission's, or the one that `sized` asks for."""
    if phase.anchor_wet_weight == "sized":
        return worst_case_weight(setting.means, phase)
    return setting[f"{phase.name}.anchor_wet_weight"]
