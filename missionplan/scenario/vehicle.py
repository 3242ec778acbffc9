"""Drag, moving mass and propeller of a vehicle; what was measured goes before estimates."""

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


def vehicle_drag(vehicle: Vehicle[Scalars], water: Water) -> VehicleDrag:
    """Return the drag from the tank where the vehicle file has it, else Briggs et al., Eqs. 3 to 13."""
    form, measured = vehicle.hull.form_factor, vehicle.drag
    constant = FORM_CONSTANTS[form] if isinstance(form, str) else form
    hull = Hull(vehicle.hull.length, vehicle.hull.diameter, constant)
    if measured is None:
        fin = vehicle.sail
        sail = Sail(fin.chord, fin.span, fin.thickness) if fin else None
        return VehicleDrag(hull, sail, vehicle.appendage_factor, water)
    return MeasuredVehicleDrag(
        hull=hull,
        sail=None,
        appendage_factor=1.0,
        water=water,
        coefficient=measured.coefficient,
        area=measured.area,
        exponent=measured.exponent,
        at_reynolds=measured.at_reynolds or 1.0,
        reference_length=measured.length or 1.0,
    )


def surge_added_mass(hull: Hull, vehicle: Vehicle[Scalars], mass: Scalars) -> Scalars:
    """Added mass in surge [kg]: measured, else a fraction of the displaced mass, by default Lamb's spheroid.

    Parameters
    ----------
    hull : Hull
        With the anchor where the vehicle carries it.
    vehicle : Vehicle
    mass : float or array, shape (n,)
        Of the vehicle in air [kg].
    """
    if vehicle.added_mass is not None and vehicle.added_mass.surge is not None:
        return vehicle.added_mass.surge
    given = vehicle.hull.added_mass
    fraction = lamb_axial_coefficient(hull.length / hull.diameter) if given is None else given
    return fraction * displaced_mass(mass, vehicle.net_buoyancy)


def sway_added_mass(hull: Hull, vehicle: Vehicle[Scalars], mass: Scalars) -> Scalars:
    """Added mass across the axis [kg]: measured, else Lamb's spheroid; parameters as of `surge_added_mass`."""
    if vehicle.added_mass is not None and vehicle.added_mass.sway is not None:
        return vehicle.added_mass.sway
    return lamb_lateral_coefficient(hull.length / hull.diameter) * displaced_mass(mass, vehicle.net_buoyancy)


def propeller(written: Propulsion[Scalars], density: float) -> Propeller:
    """Return the propeller of a vehicle file, in water of a density [kg/m³]."""
    return from_open_water(
        written.diameter,
        written.thrust_coefficient,
        written.torque_coefficient,
        density=density,
        axial_flow_factor=written.axial_flow_factor,
        wake_fraction=written.wake_fraction,
        thrust_deduction=written.thrust_deduction,
    )
