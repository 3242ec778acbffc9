"""The drift filter's model of the drift, built from the current, the velocity error and the effects of a mission."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.oscillation import inertial_frequency
from missionplan.phases.currents import Current
from missionplan.phases.hooks import DriftParts, TransitEffect
from missionplan.phases.transit.compensation import Forecast
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES, DriftModel


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
    changing, growth = _modulation(parts, periods, len(states))
    return DriftModel(
        mean=states.mean(axis=1),
        prior=_prior(states, [sigma for sigma, _ in persistent]) + np.diag(changing),
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
    """State of the model (see `DriftModel`) in each draw, without the persistent velocity, shape (k, n)."""
    states = np.zeros((WAVES + 4 * len(periods) + 2 * turns, sample.trials))
    states[STEADY : STEADY + 2], states[SURFACE : SURFACE + 2] = _steady(sample, parts, forecast)
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


def _prior(states: Array, persistent: Sequence[Scalars]) -> Array:
    """Covariance of the states before the first leg, shape (k, k); zero but for the persistent velocity in one draw."""
    prior = np.atleast_2d(np.cov(states)) if states.shape[1] > 1 else np.zeros((len(states), len(states)))
    for place in (PERSISTENT, PERSISTENT + 1):
        prior[place, place] = sum(float(np.mean(np.square(sigma))) for sigma in persistent)
    return prior


def _steady(sample: DriftSample, parts: Sequence[DriftParts], forecast: Forecast) -> tuple[Array, Array]:
    """Velocity under way and displacement at the surface beyond the forecast, at the mission's start, (2, n) each."""
    time, still = sample.surfacing_time, np.zeros((2, 1))
    velocity, surface = sample.velocity_error, np.zeros((2, 1))
    if sample.current is not None and not sample.is_recorded:
        velocity = velocity + sample.current.velocity(0.0, sample.depth, still)
        surface = sample.current.velocity(0.0, 0.0, still) * time
    for part in parts:
        velocity = velocity + _columns(part.velocity)
        surface = surface + _columns(part.surface) * time
    if sample.is_recorded:
        return velocity - forecast.mean_error[:, None], surface
    moment = np.zeros(1)
    return velocity - forecast.under_way(moment, moment, still, still), surface - forecast.at_surface(moment, still)


def _columns(vectors: Array | float) -> Array:
    """Components of a vector, the same in all draws or one a draw, shape (k, 1) or (k, n)."""
    array = np.asarray(vectors)
    return array if array.ndim > 1 else array.reshape(-1, 1)
