"""Transits of a vehicle with a propeller: speed from shaft rate, setting off from rest, speed inferred wrongly.

Drag, moving mass and propeller of a vehicle; what was measured goes before estimates.
"""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.manoeuvring import Propulsion
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.phases.hooks import Leg, TransitEffect
from missionplan.physics.drag import FORM_CONSTANTS, Hull, MeasuredVehicleDrag, Sail, VehicleDrag
from missionplan.physics.propeller import Propeller, Resistance, from_open_water
from missionplan.physics.propulsion import cruise_speed, distance_lost, shaft_power, shaft_rate_for, speed_error
from missionplan.physics.water import Water, displaced_mass, lamb_axial_coefficient, lamb_lateral_coefficient


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


LONG_AGO = 1e9
"""A leg so long that setting off does not count [s]."""


@dataclass(frozen=True)
class InferredSpeed(TransitEffect):
    """Error of a speed inferred from the shaft rate: the true one is ``1 + fraction`` times as large."""

    fraction: Scalars

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.asarray(self.fraction * leg.speed * leg.along)


@dataclass(frozen=True)
class PropelledVehicle:
    """A vehicle with a propeller, with the draws of a block."""

    propeller: Propeller
    vehicle: Vehicle[Scalars]
    propulsion: Propulsion[Scalars]
    """The vehicle's."""
    drag: VehicleDrag
    """Drag [N] from speed [m/s]."""
    carried_mass: Scalars = 0.0
    """That moves with the vehicle, such as its anchor's, float or shape (n,) [kg]."""

    def speed(self, shaft_rate: Scalars) -> Scalars:
        """Speed through the water at a shaft rate [rad/s], in m/s."""
        return _scalar(cruise_speed(self.propeller, shaft_rate, self.drag))

    def length_lost(self, speed: Scalars) -> Scalars | None:
        """Distance by which a leg falls short while the vehicle gathers way [m]; None without the vehicle's mass."""
        mass = self.moving_mass
        if mass is None:
            return None
        force = self.drag(speed)
        resistance = Resistance(mass=mass, linear=0.0, quadratic=force / speed**2)
        return _scalar(distance_lost(self.propeller, resistance, shaft_rate_for(self.propeller, force, speed)))

    @property
    def moving_mass(self) -> Scalars | None:
        """Mass and added mass of the vehicle in surge, with what it carries [kg]; None without the vehicle's mass."""
        mass = self.vehicle.mass
        return None if mass is None else mass + self.carried_mass + surge_added_mass(self.drag.hull, self.vehicle, mass)

    def inferred_speed(self, speed: Scalars) -> tuple[InferredSpeed, ...]:
        """Return the error of a speed [m/s] that is inferred from the shaft rate; none where thrust and drag are right.

        The vehicle assumes the speed that its file's propeller and drag give; the true ones are `thrust_factor` and
        `drag_factor` times as large. Gathering way is not in it: the vehicle's clock allows for that.
        """
        thrust, drag = self.propulsion.thrust_factor, self.propulsion.drag_factor
        if np.all(np.equal(thrust, 1.0)) and np.all(np.equal(drag, 1.0)):
            return ()
        force = self.drag(speed)
        resistance = Resistance(mass=1.0, linear=0.0, quadratic=force / speed**2)
        rate = shaft_rate_for(self.propeller, force, speed)
        error = speed_error(self.propeller, resistance, rate, LONG_AGO, thrust_factor=thrust, drag_factor=drag)
        return (InferredSpeed(_scalar(error / speed)),)

    def power(self, speed: Scalars) -> Scalars:
        """Electrical power that holds a speed [m/s]: shaft power over the motor's efficiency [W]."""
        rate = shaft_rate_for(self.propeller, self.drag(speed), speed)
        return shaft_power(self.propeller, rate, speed) / self.propulsion.motor_efficiency


def _scalar(value: Scalars) -> Scalars:
    """Return a float where nothing was drawn."""
    array = np.asarray(value)
    return float(array) if array.ndim == 0 else array
