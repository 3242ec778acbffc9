"""Velocity over the ground beyond the vehicle's own propulsion: velocity error of a leg, site's current, effects."""

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Normals, Scalars
from missionplan.phases.currents import Span
from missionplan.phases.hooks import Leg, velocity_error
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, VelocityError


class GroundVelocity:
    """Velocities over the ground during legs and surfacings, with the memory of effects that persist.

    Attributes
    ----------
    outrun : array of bool, shape (n,)
        Whether on some leg so far the drift was as fast as the vehicle.
    left_record : array of bool, shape (n,)
        Whether the trial has left what is known of the current.
    """

    def __init__(self, plan: TransitPlan, environment: Environment, normals: TransitNormals, trials: int) -> None:
        self._plan, self._environment, self._normals = plan, environment, normals
        self.outrun, self.left_record = np.zeros(trials, dtype=bool), np.zeros(trials, dtype=bool)
        self._memory: list[Array | None] = [None] * len(environment.effects)
        self._mid_leg: Array | None = None
        self._rows: NDArray[np.intp] | int = trials if normals.rows is None else normals.rows

    def of_leg(
        self,
        number: int,
        normals: Array,
        t: Array,
        duration: Array,
        start: Array,
        through: Array,
        speed: Scalars | None = None,
    ) -> Array:
        """Mean velocity over a leg beyond the vehicle's own (Eq. 24, with the site's current), shape (2, n) [m/s].

        Parameters
        ----------
        number : int
            Leg, from 0.
        normals : array, shape (2, n)
            Standard normals of the velocity error.
        t, duration : array, shape (n,)
            Start and length of the leg in time [s].
        start, through : array, shape (2, n)
            True position at the start, and displacement through the water [m].
        speed : float or array, shape (n,), optional
            Through the water, of a leg that was logged; default the plan's [m/s].
        """
        plan, current = self._plan, self._environment.current
        velocity = random_part(plan.velocity_error, normals)
        length = np.sqrt(through[0] * through[0] + through[1] * through[1])
        speed = plan.speed if speed is None else speed
        drift: Array = plan.velocity_error.mean
        carried: Array | float = 0.0
        if current is not None:
            carried = current.mean_velocity(t, duration, plan.depth, start, through)
        if self._environment.effects:
            along = through / np.where(length > 0.0, length, 1.0)
            leg = Leg(t, duration, start, along, speed, plan.latitude, plan.depth)
            velocity, persistent = self._with_effects(number, velocity, leg, carried)
            drift = drift + persistent
        velocity = velocity + drift
        moving = length > 0.0
        if current is not None:
            velocity, drift = velocity + carried, drift + carried
            end = start + through + velocity * duration
            self.left_record |= moving & ~current.covers(Span(t, t + duration, plan.depth, (start, end)))
        self.outrun |= moving & (np.sqrt(drift[0] * drift[0] + drift[1] * drift[1]) >= speed)
        return velocity

    def _with_effects(self, number: int, velocity: Array, leg: Leg, current: Array | float) -> tuple[Array, Array]:
        """Random velocity error of a leg as the effects change it, and the velocity that they add to it [m/s]."""
        effects, trials, first = self._environment.effects, leg.t_start.size, self._normals.first
        mid_leg = leg.t_start + 0.5 * leg.duration
        elapsed = np.zeros(trials) if self._mid_leg is None else mid_leg - self._mid_leg
        persistent: Array | float = 0.0
        gathered: Array | float = 0.0
        for index, effect in enumerate(effects):
            source = self._normals.effects[index] if effect.is_random else None
            normals = np.zeros((2, trials)) if source is None else leg_normals(source, first + number, self._rows)
            velocity = velocity * effect.error_scale(normals)
            self._memory[index], carried = effect.step(self._memory[index], elapsed, normals, leg)
            persistent = persistent + carried
            if source is not None and np.any(rate := effect.position_variance_rate()):
                gathered = gathered + np.sqrt(rate / np.where(leg.duration > 0.0, leg.duration, 1.0)) * normals
        self._mid_leg = mid_leg
        return velocity + gathered, persistent + velocity_error(effects, leg, current)

    def at_surface(self, t: Array, position: Array, moving: Array | None = None) -> Array | float:
        """Mean velocity of the drift while the vehicle is at the surface, shape (2, n); 0 in still water [m/s].

        Parameters
        ----------
        t : array, shape (n,)
            On surfacing [s].
        position : array, shape (2, n)
            [m]
        moving : array, shape (n,), optional
            0 for a trial that is not under way; default: all are.
        """
        current, time = self._environment.current, self._plan.surfacing_time
        velocity: Array | float = 0.0
        if current is not None:
            velocity = current.mean_velocity(t, time, 0.0, position, np.zeros((2, 1)))
            left = ~current.covers(Span(t, t + time, 0.0, (position, position + velocity * time)))
            self.left_record |= left if moving is None else left & (moving > 0.0)
        lasting = np.broadcast_to(np.asarray(time, dtype=float), t.shape)
        for effect in self._environment.effects:
            velocity = velocity + effect.surface_velocity(t, lasting, position)
        return velocity

    def fix_sd(self) -> Scalars:
        """Standard deviation of a fix, each axis, effects included [m]."""
        variance: Scalars = np.square(self._plan.fix_error)
        for effect in self._environment.effects:
            variance = variance + effect.fix_variance()
        sd: Scalars = np.sqrt(variance)
        return sd

    def take(self, plan: TransitPlan, trials: NDArray[np.intp]) -> "GroundVelocity":
        """Select trials."""
        current, count = self._environment.current, self.outrun.size
        effects = tuple(effect.take(trials, count) for effect in self._environment.effects)
        fewer = Environment(current.take(trials) if current else None, self._environment.compensation, effects)
        selected = GroundVelocity(plan, fewer, self._normals, trials.size)
        selected.outrun, selected.left_record = self.outrun[trials], self.left_record[trials]
        selected._memory = [None if memory is None else memory[..., trials] for memory in self._memory]
        selected._mid_leg = None if self._mid_leg is None else self._mid_leg[trials]
        selected._rows = trials if isinstance(self._rows, int) else self._rows[trials]
        return selected


def random_part(error: VelocityError, normals: Array) -> Array:
    """Deviation of the velocity error from its mean, R z, from standard normals z, shape (2, n) [m/s]."""
    root = error.root
    if error.is_isotropic:
        isotropic: Array = root[0, 0] * normals
        return isotropic
    return np.stack((root[0, 0] * normals[0], root[1, 0] * normals[0] + root[1, 1] * normals[1]))


def leg_normals(source: Normals, number: int, trials: NDArray[np.intp] | int) -> Array:
    """Standard normals of a leg for trials of the block by their indices, or for the first of them by their number."""
    whole = source.leg(number)
    return whole[:, :trials] if isinstance(trials, int) else whole.take(trials, axis=1)
