"""The drift filter's model of the drift, built from the current, the velocity error and the effects of a mission."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.inertial_current import EARTH_ROTATION, InertialCurrent
from missionplan.effects.mean_current import MeanCurrent
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk
from missionplan.effects.surface_drift import SurfaceDrift
from missionplan.effects.tidal_current import PERIODS, TidalCurrent
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TransitEffect
from missionplan.phases.transit.compensation import Forecast
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES, DriftModel

_Effect = TypeVar("_Effect", bound=TransitEffect)


@dataclass(frozen=True)
class DriftSample:
    """A block of draws of all that moves the vehicle over ground on one transit.

    Attributes
    ----------
    trials : int
        n; 1 where nothing is uncertain.
    velocity_error : array, shape (2, 1) or (2, n)
        Mean of the velocity error of the legs [m/s].
    current : Current or None
        The site's, as drawn; None in still water.
    is_recorded : bool
        Whether the current is read from a file, so that the forecast knows it exactly.
    depth, surfacing_time : float or array, shape (n,)
        Of the transit [m, s].
    effects : tuple of TransitEffect
        As drawn.
    """

    trials: int
    velocity_error: Array
    current: Current | None
    is_recorded: bool
    depth: Scalars
    surfacing_time: Scalars
    effects: tuple[TransitEffect, ...]


def drift_model(
    sample: DriftSample, forecast: Forecast, *, covariance: Array, latitude: float, fix_error: float
) -> DriftModel:
    """Build the model; its prior has the mean and the covariance of the sample.

    Effects that the model has no state for (of the compass, the log, the gradient of the current, heavy tails) are
    not estimated.

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
    tides = [name for name in PERIODS if any(_has_constituent(effect, name) for effect in sample.effects)]
    turns = bool(_effects(sample, InertialCurrent))
    persistent, walks = _effects(sample, PersistentError), _effects(sample, RandomWalk)
    states = _states(sample, forecast, tides, turns=turns)
    return DriftModel(
        mean=states.mean(axis=1),
        prior=_prior(states, persistent),
        tides=tuple(2.0 * np.pi / PERIODS[name] for name in tides),
        turning=2.0 * EARTH_ROTATION * float(np.sin(latitude)) if turns else 0.0,
        persistence=float(np.mean(persistent[0].time)) if persistent else 1.0,
        walk=float(np.sqrt(sum(np.mean(np.square(walk.rate)) for walk in walks))),
        covariance=covariance,
        fix_error=fix_error,
    )


def _effects(sample: DriftSample, kind: type[_Effect]) -> list[_Effect]:
    return [effect for effect in sample.effects if isinstance(effect, kind)]


def _states(sample: DriftSample, forecast: Forecast, tides: Sequence[str], *, turns: bool) -> Array:
    """State of the model (see `DriftModel`) in each draw, without the persistent velocity, shape (k, n)."""
    states = np.zeros((WAVES + 4 * len(tides) + 2 * turns, sample.trials))
    states[STEADY : STEADY + 2], states[SURFACE : SURFACE + 2] = _steady(sample, forecast)
    for effect in sample.effects:
        if isinstance(effect, TidalCurrent):
            for index, name in enumerate(tides):
                first = WAVES + 4 * index
                states[first : first + 4] += _waves(effect, name)
        if isinstance(effect, InertialCurrent):
            states[-2:] += np.stack(np.broadcast_arrays(*_polar(effect.amplitude, effect.phase))).reshape(2, -1)
    return states


def _prior(states: Array, persistent: Sequence[PersistentError]) -> Array:
    """Covariance of the states before the first leg, shape (k, k); zero but for the persistent velocity in one draw."""
    prior = np.atleast_2d(np.cov(states)) if states.shape[1] > 1 else np.zeros((len(states), len(states)))
    for place in (PERSISTENT, PERSISTENT + 1):
        prior[place, place] = sum(float(np.mean(np.square(effect.sigma))) for effect in persistent)
    return prior


def _steady(sample: DriftSample, forecast: Forecast) -> tuple[Array, Array]:
    """Velocity under way and displacement at the surface beyond the forecast, at the mission's start, (2, n) each."""
    time, still = sample.surfacing_time, np.zeros((2, 1))
    velocity, surface = sample.velocity_error, np.zeros((2, 1))
    if sample.current is not None and not sample.is_recorded:
        velocity = velocity + sample.current.velocity(0.0, sample.depth, still)
        surface = sample.current.velocity(0.0, 0.0, still) * time
    for effect in sample.effects:
        if isinstance(effect, MeanCurrent):
            velocity = velocity + np.stack(np.broadcast_arrays(effect.east, effect.north)).reshape(2, -1)
        if isinstance(effect, SurfaceDrift):
            surface = surface + np.stack(np.broadcast_arrays(effect.east, effect.north)).reshape(2, -1) * time
    if sample.is_recorded:
        return velocity - forecast.mean_error[:, None], surface
    moment = np.zeros(1)
    return velocity - forecast.under_way(moment, moment, still, still), surface - forecast.at_surface(moment, still)


def _has_constituent(effect: TransitEffect, name: str) -> bool:
    return isinstance(effect, TidalCurrent) and any(
        np.any(getattr(effect, f"{name}_{component}")) for component in ("east", "north")
    )


def _waves(effect: TidalCurrent, name: str) -> Array:
    """Coefficients of cosine and sine toward east, then north, shape (4, n) or (4, 1)."""
    parts = [
        part
        for component in ("east", "north")
        for part in _polar(getattr(effect, f"{name}_{component}"), getattr(effect, f"{name}_{component}_phase"))
    ]
    return np.stack([np.atleast_1d(part) for part in np.broadcast_arrays(*parts)])


def _polar(amplitude: Scalars, phase: Scalars) -> tuple[Array, Array]:
    """``amplitude·cos(ωt − phase)`` as coefficients of cos ωt and sin ωt."""
    return np.asarray(amplitude * np.cos(phase)), np.asarray(amplitude * np.sin(phase))
