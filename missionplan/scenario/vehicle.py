"""Drag, moving mass and propeller of a vehicle, with the draws of a block; what was measured goes before estimates."""

from collections.abc import Mapping

from missionplan.arrays import Scalars
from missionplan.mission.schema.identified import Propulsion
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.physics.added_mass import lamb_axial_coefficient, lamb_lateral_coefficient
from missionplan.physics.buoyancy import displaced_mass
from missionplan.physics.drag import FORM_CONSTANTS
from missionplan.physics.measured_drag import MeasuredVehicleDrag
from missionplan.physics.propeller import Propeller, from_open_water
from missionplan.physics.vehicle_drag import Hull, Sail, VehicleDrag
from missionplan.physics.water import Water

Draws = Mapping[str, Scalars]
"""Quantities by key path, each a float or an array of shape (n,)."""


def vehicle_drag(vehicle: Vehicle, water: Water, draws: Draws) -> VehicleDrag:
    """Return the drag from the tank where the vehicle file has it, else Briggs et al., Eqs. 3 to 13."""
    form, path = vehicle.hull.form_factor, "vehicle.hull"
    constant = FORM_CONSTANTS[form] if isinstance(form, str) else draws[f"{path}.form_factor"]
    hull = Hull(draws[f"{path}.length"], draws[f"{path}.diameter"], constant)
    measured = vehicle.drag
    if measured is None:
        sail = Sail(*(draws[f"vehicle.sail.{key}"] for key in ("chord", "span", "thickness"))) if vehicle.sail else None
        return VehicleDrag(hull, sail, draws["vehicle.appendage_factor"], water)
    return MeasuredVehicleDrag(
        hull=hull,
        sail=None,
        appendage_factor=1.0,
        water=water,
        coefficient=draws["vehicle.drag.coefficient"],
        area=measured.area,
        exponent=draws["vehicle.drag.exponent"],
        at_reynolds=measured.at_reynolds or 1.0,
        reference_length=measured.length or 1.0,
    )


def surge_added_mass(hull: Hull, draws: Draws) -> Scalars:
    """Added mass in surge [kg]: measured, else a fraction of the displaced mass, by default Lamb's spheroid."""
    displaced = displaced_mass(draws["vehicle.mass"], draws["vehicle.net_buoyancy"])
    fraction = draws.get("vehicle.hull.added_mass", lamb_axial_coefficient(hull.length / hull.diameter))
    return draws.get("vehicle.added_mass.surge", fraction * displaced)


def sway_added_mass(hull: Hull, draws: Draws) -> Scalars:
    """Added mass across the axis [kg]: measured, else Lamb's spheroid."""
    displaced = displaced_mass(draws["vehicle.mass"], draws["vehicle.net_buoyancy"])
    fraction = lamb_lateral_coefficient(hull.length / hull.diameter)
    return draws.get("vehicle.added_mass.sway", fraction * displaced)


def propeller(written: Propulsion, density: float, draws: Draws) -> Propeller:
    """Return the propeller of a vehicle file, its open-water lines of thrust and torque as drawn.

    Parameters
    ----------
    written : Propulsion
        The vehicle file's section.
    density : float
        Of the water [kg/m³].
    draws : mapping
    """
    path = "vehicle.propulsion"
    thrust, torque = (
        (draws[f"{path}.{key}[0]"], draws[f"{path}.{key}[1]"]) for key in ("thrust_coefficient", "torque_coefficient")
    )
    return from_open_water(
        written.diameter,
        thrust,
        torque,
        density=density,
        axial_flow_factor=written.axial_flow_factor,
        wake_fraction=written.wake_fraction,
        thrust_deduction=written.thrust_deduction,
    )
