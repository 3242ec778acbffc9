"""The filter's model of the drift, built from the current, the velocity error and the effects of a mission."""

from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.effects.inertial_current import EARTH_ROTATION, InertialCurrent
from missionplan.effects.mean_current import MeanCurrent
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk
from missionplan.effects.surface_drift import SurfaceDrift
from missionplan.effects.tidal_current import PERIODS, TidalCurrent
from missionplan.mission.schema.phases import TransitPhase
from missionplan.mission.views import TransitMission
from missionplan.phases.transit.compensation import Forecast
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES, DriftModel

if TYPE_CHECKING:
    from missionplan.scenario.scenario import Scenario


def drift_model(means: "Scenario", drawn: "Scenario", phase: TransitPhase, forecast: Forecast) -> DriftModel:
    """Build the model; its prior has the mean and the covariance of the mission's own draws.

    Effects that the model has no state for (of the compass, the log, the gradient of the current, heavy tails) are
    not estimated.

    Parameters
    ----------
    means : Scenario
        The mission at its means.
    drawn : Scenario
        A block of draws, to take the prior from.
    phase : TransitPhase
    forecast : Forecast
        What is expected without any fix.
    """
    navigation, trials = TransitMission.of(means.mission).navigation, _trials(drawn)
    tides = [name for name in PERIODS if any(_has(effect, name) for effect in drawn.transit_effects)]
    inertial = [effect for effect in drawn.transit_effects if isinstance(effect, InertialCurrent)]
    persistent = [effect for effect in drawn.transit_effects if isinstance(effect, PersistentError)]
    state = np.zeros((WAVES + 4 * len(tides) + 2 * bool(inertial), trials))
    state[STEADY : STEADY + 2], state[SURFACE : SURFACE + 2] = _steady(drawn, phase, forecast)
    for effect in drawn.transit_effects:
        if isinstance(effect, TidalCurrent):
            for index, name in enumerate(tides):
                first = WAVES + 4 * index
                state[first : first + 4] += _waves(effect, name)
        if isinstance(effect, InertialCurrent):
            state[-2:] += np.stack(np.broadcast_arrays(*_polar(effect.amplitude, effect.phase)))
    prior = np.atleast_2d(np.cov(state)) if trials > 1 else np.zeros((len(state), len(state)))
    times = [float(np.mean(effect.time)) for effect in persistent]
    for axis in (0, 1):
        place = PERSISTENT + axis
        prior[place, place] = sum(float(np.mean(np.square(effect.sigma))) for effect in persistent)
    walks = [effect.rate for effect in drawn.transit_effects if isinstance(effect, RandomWalk)]
    return DriftModel(
        mean=state.mean(axis=1),
        prior=prior,
        tides=tuple(2.0 * np.pi / PERIODS[name] for name in tides),
        turning=2.0 * EARTH_ROTATION * float(np.sin(means.latitude)) if inertial else 0.0,
        persistence=times[0] if times else 1.0,
        walk=float(np.sqrt(sum(np.mean(np.square(rate)) for rate in walks))),
        covariance=navigation.velocity_error.covariance,
        fix_error=float(np.mean(means.fix_sd)),
    )


def _trials(drawn: "Scenario") -> int:
    return max((np.size(value) for value in drawn.draws.values()), default=1)


def _steady(drawn: "Scenario", phase: TransitPhase, forecast: Forecast) -> tuple[Array, Array]:
    """Velocity under way and displacement at the surface beyond the forecast, at the mission's start, (2, n) each."""
    depth, time, still = drawn[f"{phase.name}.depth"], drawn.surfacing_time, np.zeros((2, 1))
    velocity = drawn.transit_plan(phase).velocity_error.mean
    surface: Array | float = 0.0
    if drawn.current is not None and drawn.recorded is None:
        velocity = velocity + drawn.current.velocity(0.0, depth, still)
        surface = drawn.current.velocity(0.0, 0.0, still) * time
    for effect in drawn.transit_effects:
        if isinstance(effect, MeanCurrent):
            velocity = velocity + np.stack(np.broadcast_arrays(effect.east, effect.north)).reshape(2, -1)
        if isinstance(effect, SurfaceDrift):
            surface = surface + np.stack(np.broadcast_arrays(effect.east, effect.north)).reshape(2, -1) * time
    if drawn.recorded is not None:  # the forecast has it as it is
        return velocity - forecast.mean_error[:, None], np.broadcast_to(surface, (2, 1)).astype(float)
    moment = np.zeros(1)
    return velocity - forecast.under_way(moment, moment, still, still), surface - forecast.at_surface(moment, still)


def _has(effect: object, name: str) -> bool:
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


def _polar(amplitude: Array | float, phase: Array | float) -> tuple[Array, Array]:
    """``amplitude·cos(ωt − phase)`` as coefficients of cos ωt and sin ωt."""
    return np.asarray(amplitude * np.cos(phase)), np.asarray(amplitude * np.sin(phase))
