"""What the tank found of a vehicle, with the draws of a block: drag, added mass and propulsion of its phases."""

from collections.abc import Mapping

from missionplan.arrays import Scalars
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.physics.cruise import shaft_power, shaft_rate_for
from missionplan.physics.measured_drag import MeasuredVehicleDrag
from missionplan.physics.propeller import Propeller, from_open_water
from missionplan.physics.vehicle_drag import VehicleDrag


def measured_drag(vehicle: Vehicle, built_up: VehicleDrag, draws: Mapping[str, Scalars]) -> VehicleDrag:
    """Drag from the tank where the vehicle file has it, else the one built up from the hull.

    Parameters
    ----------
    built_up : VehicleDrag
        From hull, sail and appendages (Briggs et al., Eqs. 3 to 13).
    draws : mapping
        Quantities by key path.
    """
    written = vehicle.drag
    if written is None:
        return built_up
    return MeasuredVehicleDrag(
        hull=built_up.hull,
        sail=None,
        appendage_factor=1.0,
        water=built_up.water,
        coefficient=draws["vehicle.drag.coefficient"],
        area=written.area,
        exponent=draws["vehicle.drag.exponent"],
        at_reynolds=written.at_reynolds or 1.0,
        reference_length=written.length or 1.0,
    )


def propeller(vehicle: Vehicle, density: float, draws: Mapping[str, Scalars]) -> Propeller | None:
    """The vehicle's propeller, None where its file has none; lines of thrust and torque as drawn."""
    written, path = vehicle.propulsion, "vehicle.propulsion"
    if written is None:
        return None
    lines = [tuple(draws[f"{path}.{key}[{i}]"] for i in (0, 1)) for key in ("thrust_coefficient", "torque_coefficient")]
    return from_open_water(
        written.diameter,
        (lines[0][0], lines[0][1]),
        (lines[1][0], lines[1][1]),
        density=density,
        axial_flow_factor=written.axial_flow_factor,
        wake_fraction=written.wake_fraction,
        thrust_deduction=written.thrust_deduction,
    )


def propeller_power(unit: Propeller, drag: Scalars, speed: Scalars, motor_efficiency: Scalars) -> Scalars:
    """Electrical power that holds a speed [m/s] against a drag [N]: shaft power over the motor's efficiency [W]."""
    return shaft_power(unit, shaft_rate_for(unit, drag, speed), speed) / motor_efficiency
