"""Parameters of transits: the vehicle's propulsion, and the drift filter's model of the drift.

Drag, moving mass and propeller of a vehicle (what was measured goes before estimates) give speed from shaft rate,
setting off from rest, and speed inferred wrongly. The drift's model is built from the current, the velocity
error and the effects of the mission.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.oscillation import inertial_frequency
from missionplan.mission.schema.manoeuvring import Propulsion
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect
from missionplan.phases.transit.compensation import Forecast
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES, DriftModel
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

    `hull`: with the anchor where the vehicle carries it. `mass`, shape (n,): of the vehicle in air [kg].
    """
    if vehicle.added_mass is not None and vehicle.added_mass.surge is not None:
        return vehicle.added_mass.surge
    added_mass = vehicle.hull.added_mass
    fraction = lamb_axial_coefficient(hull.length / hull.diameter) if added_mass is None else added_mass
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


@dataclass(frozen=True)
class DriftSample:
    """A block of draws of all that moves the vehicle over ground on one transit."""

    trials: int
    """n; 1 where nothing is uncertain."""
    velocity_error: Array
    """Mean of the velocity error of the legs, shape (2, 1) or (2, n) [m/s]."""
    current: Current | None
    """The site's, as drawn; None in still water."""
    is_recorded: bool
    """Whether the current is read from a file, so that the forecast knows it exactly."""
    depth: Scalars
    surfacing_time: Scalars
    """Shape (n,). Of the transit [m, s]."""
    effects: tuple[TransitEffect, ...]
    """As drawn."""
    forecast_error: tuple[Scalars, Scalars] | None = None
    """Standard deviation and correlation time of the recorded current's error along the track, float or shape (n,)
    [m/s, s]."""


def drift_model(
    sample: DriftSample, forecast: Forecast, *, covariance: Array, latitude: float, fix_error: float
) -> DriftModel:
    """Build the model; its prior has the mean and the covariance of the sample.

    Effects without a part in the drift (of the compass, the log, the gradient of the current, heavy tails) are not
    estimated.

    Parameters
    ----------
    sample : DriftSample
        Draws of the mission.
    forecast : Forecast
        What is expected without any fix.
    covariance : array, shape (2, 2)
        Σ_v, of what is drawn anew each leg [m²/s²].
    latitude : float
        Of the origin [rad]; used with an inertial current alone.
    fix_error : float
        Standard deviation of a fix, each axis, with effects [m].
    """
    parts = [effect.drift() for effect in sample.effects]
    if sample.forecast_error is not None:
        parts.append(DriftParts(persistent=sample.forecast_error))
    periods = list(dict.fromkeys(period for part in parts for period in part.waves))
    turns = any(part.inertial is not None for part in parts)
    persistent = [part.persistent for part in parts if part.persistent is not None]
    states = _states(sample, parts, forecast, periods, turns=turns)
    prior = np.atleast_2d(np.cov(states)) if states.shape[1] > 1 else np.zeros((len(states), len(states)))
    for place in (PERSISTENT, PERSISTENT + 1):  # in one draw it is zero but for these
        prior[place, place] = sum(float(np.mean(np.square(sigma))) for sigma, _ in persistent)
    changing, growth = _modulation(parts, periods, len(states))
    return DriftModel(
        mean=states.mean(axis=1),
        prior=prior + np.diag(changing),
        tides=tuple(2.0 * np.pi / period for period in periods),
        turning=inertial_frequency(latitude) if turns else 0.0,
        persistence=_correlation_time(persistent) if persistent else 1.0,
        walk=float(np.sqrt(sum(np.mean(np.square(part.walk)) for part in parts))),
        growth=growth,
        covariance=covariance,
        fix_error=fix_error,
    )


def _correlation_time(persistent: Sequence[tuple[Scalars, Scalars]]) -> float:
    """Correlation time of several persistent velocities, weighted by their mean variances [s]."""
    if len(persistent) == 1:
        return float(np.mean(persistent[0][1]))
    variances = [float(np.mean(np.square(sigma))) for sigma, _ in persistent]
    return float(np.average([float(np.mean(time)) for _, time in persistent], weights=np.maximum(variances, 1e-12)))


def _states(
    sample: DriftSample, parts: Sequence[DriftParts], forecast: Forecast, periods: Sequence[float], *, turns: bool
) -> Array:
    """State of the model (see `DriftModel`) in each draw, without the persistent velocity, shape (k, n).

    Velocity under way and displacement at the surface are those beyond the forecast, at the mission's start.
    """
    states = np.zeros((WAVES + 4 * len(periods) + 2 * turns, sample.trials))
    time, still, moment = sample.surfacing_time, np.zeros((2, 1)), np.zeros(1)
    velocity, surface = sample.velocity_error, np.zeros((2, 1))
    if sample.current is not None and not sample.is_recorded:
        velocity = velocity + sample.current.velocity(0.0, sample.depth, still)
        surface = sample.current.velocity(0.0, 0.0, still) * time
    for part in parts:
        velocity = velocity + _columns(part.velocity)
        surface = surface + _columns(part.surface) * time
    if sample.is_recorded:
        velocity = velocity - forecast.mean_error[:, None]
    else:
        velocity = velocity - forecast.under_way(moment, moment, still, still)
        surface = surface - forecast.at_surface(moment, still)
    states[STEADY : STEADY + 2], states[SURFACE : SURFACE + 2] = velocity, surface
    for part in parts:
        for period, coefficients in part.waves.items():
            first = WAVES + 4 * periods.index(period)
            states[first : first + 4] += _columns(coefficients)
        if part.inertial is not None:
            states[-2:] += _columns(part.inertial)
    return states


def _modulation(parts: Sequence[DriftParts], periods: Sequence[float], size: int) -> tuple[Array, Array]:
    """Variance of each coefficient of a wave by its slow changes, and its growth [1/s], shape (k,) each.

    The filter lets a coefficient walk as fast as the stationary process of that variance begins to.
    """
    variance, growth = np.zeros(size), np.zeros(size)
    for part in parts:
        relative, time = (float(np.mean(value)) for value in part.modulation)
        squares = {
            WAVES + 4 * periods.index(period) + pair: _squared(coefficients[pair : pair + 2])
            for period, coefficients in part.waves.items()
            for pair in (0, 2)
        }
        if part.inertial is not None:
            squares[size - 2] = _squared(part.inertial)
        for first, squared in squares.items():
            variance[first : first + 2] += relative**2 * squared
            growth[first : first + 2] += 2.0 * relative**2 * squared / time
    return variance, growth


def _squared(pair: Array) -> float:
    """Mean over the draws of the squared length of a vector, shape (2,) or (2, n)."""
    return float(np.mean(np.sum(np.square(pair), axis=0)))


def _columns(vectors: Array | float) -> Array:
    """Components of a vector, the same in all draws or one a draw, shape (k, 1) or (k, n)."""
    array = np.asarray(vectors)
    return array if array.ndim > 1 else array.reshape(-1, 1)
