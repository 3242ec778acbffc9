"""The forward model of dive logs: the descent phase under many settings of the parameters and all dives in one call."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.coordinates import Coordinate, parameters_from
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.effects import CATALOGUE, scattering_effect
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.profile import SensorHistory, sensor_history

RELEASE_EFFECT, DRAG_EFFECT = scattering_effect("release"), scattering_effect("drag")
"""Effects in which dives scatter from one to the next."""
STEP = 0.16
"""Step of the integration [s]; readings are within 5 mm of those with steps of 0.02 s, 1 mm as a rule."""
COARSE = 3.0 * STEP
"""Step during a search, and where one simulation is compared with another [s]."""
MIN_FRACTION = -0.9
"""Least strength of an effect that multiplies a drag or a weight, which -1 would cancel."""
LARGEST_RELEASE_DELAY = 1.0
"""Largest release delay, of either sign: the separation against the log's clock [s]; ten times its scatter."""
NO_BOTTOM = 1e5
"""Site depth for the fit [m]: the logs end above touchdown, so no model of them may reach the bottom."""


def _spread(hook: str, neutral: float) -> Callable[..., Array]:
    """Make a hook that asks the effect for its subset and has the neutral element for all other trials."""

    def spread(self: "SubsetEffect", *arguments: Scalars) -> Array:
        result = self._neutral[neutral].copy()  # three times as fast as a new array
        result[self.trials] = getattr(self.effect, hook)(*map(self._subset, arguments))
        return result

    return spread


@dataclass(frozen=True)
class SubsetEffect(DescentEffect):
    """An effect on a subset of the trials; it is neutral to the others and not computed for them."""

    effect: DescentEffect
    """Its parameters are floats or arrays over the subset, shape (m,)."""
    trials: NDArray[np.intp]
    """Indices of the subset, shape (m,)."""
    count: int
    """Number n of all trials."""

    def refines(self, hook: str) -> bool:
        """Whether the effect refines a hook."""
        return self.effect.refines(hook)

    lone_drag_factor = _spread("lone_drag_factor", 1.0)
    drag_factor = _spread("drag_factor", 1.0)
    local_drag_factor = _spread("local_drag_factor", 1.0)
    wet_weight_factor = _spread("wet_weight_factor", 1.0)
    mass_factor = _spread("mass_factor", 1.0)
    lift = _spread("lift", 0.0)
    water_velocity = _spread("water_velocity", 0.0)
    delay = _spread("delay", 0.0)

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads [m]."""
        result = depth.copy()
        result[:, self.trials] = self.effect.reading(t, depth[:, self.trials])
        return result

    def _subset(self, value: Scalars) -> Scalars:
        """Values of an argument for the subset."""
        return value.take(self.trials, axis=-1) if isinstance(value, np.ndarray) else value

    @cached_property
    def _neutral(self) -> dict[float, Array]:
        """Neutral elements of terms and of factors, of all trials."""
        return {0.0: np.zeros(self.count), 1.0: np.ones(self.count)}


@dataclass(frozen=True)
class DescentForward:
    """Readings of all dives under many settings at once."""

    build: Callable[[Array, Array], Dive]
    """The mission's descent from wet weights [N] and line lengths [m], arrays of shape (d,)."""
    logs: tuple[DiveLog, ...]
    """The d dives, at whose times readings are wanted."""
    given: tuple[DescentEffect, ...] = ()
    """Effects that act under every setting."""
    step: float = STEP
    """Of the integration [s]."""

    @cached_property
    def coarse(self) -> Self:
        """The same model in coarse steps."""
        return replace(self, step=COARSE)

    @cached_property
    def dive(self) -> Dive:
        """Bodies and line of all dives, without a bottom."""
        weights, lines = (np.array([getattr(log, key) for log in self.logs]) for key in ("wet_weight", "line_length"))
        return replace(self.build(weights, lines), site_depth=NO_BOTTOM)

    def readings(self, coordinates: Sequence[Coordinate], values: Array, delays: Scalars = 0.0) -> Array:
        """Readings of all dives, one dive after the other, under b settings, shape (N, b) [m]; see `histories`."""
        return self.histories(coordinates, values).readings(delays)

    def histories(self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars = 1.0) -> "Histories":
        """Run all dives under b settings.

        Parameters
        ----------
        coordinates : sequence of Coordinate, length k
            Of the effects.
        values : array, shape (k, b)
            Their values in b settings.
        weight_factor : float or array, shape (b,)
            Factor on the anchor's wet weight.
        """
        count, settings = len(self.logs), values.shape[1]
        trials = np.repeat(values, count, axis=1)
        effects = (*self.given, *self._effects(coordinates, trials))
        factor = np.repeat(np.broadcast_to(np.asarray(weight_factor, dtype=float), settings), count)
        until = max(float(log.fine[-1]) for log in self.logs) + LARGEST_RELEASE_DELAY
        dive = self._tiled(settings, factor)
        # a start that diverges is abandoned: its objective is infinite
        with np.errstate(over="ignore", invalid="ignore"):
            history = sensor_history(dive, settings * count, until, effects=effects, step=self.step)
        return DiveHistories(self.logs, history)

    @staticmethod
    def _effects(coordinates: Sequence[Coordinate], values: Array) -> Iterator[DescentEffect]:
        """Effects on the trials where their strength is not zero, parameters inside the ranges of the phase."""
        for name in dict.fromkeys(c.effect for c in coordinates):
            indices = [i for i, c in enumerate(coordinates) if c.effect == name]
            strengths = [i for i in indices if coordinates[i].kind != "shape"]
            trials = np.flatnonzero(np.any(values[strengths] != 0.0, axis=0))
            if not len(trials):
                continue
            parameters = parameters_from([coordinates[i] for i in indices], values[indices][:, trials])[name]
            arguments = {key: np.clip(value, *parameter_range(name, key)) for key, value in parameters.items()}
            effect = CATALOGUE[name].make(arguments)
            if not isinstance(effect, DescentEffect):
                raise TypeError(f"{name} is not an effect on a descent")
            yield effect if len(trials) == values.shape[1] else SubsetEffect(effect, trials, values.shape[1])

    def _tiled(self, settings: int, factor: Array) -> Dive:
        def tiled(value: Scalars) -> Scalars:
            return np.tile(value, settings) if isinstance(value, np.ndarray) else value

        dive = self.dive
        return replace(
            dive,
            wet_weight=tiled(dive.wet_weight) * factor,
            anchor_mass=tiled(dive.anchor_mass),
            anchor_added_mass=tiled(dive.anchor_added_mass),
            line_length=tiled(dive.line_length),
            spring=None,  # depths tell nothing of the snatch
        )


class Histories(Protocol):
    """All dives under several settings, readable at any release delays."""

    @property
    def settings(self) -> int:
        """Number of settings, b."""
        ...

    def readings(self, delays: Scalars = 0.0) -> Array:
        """Measured values, shape (N, b), with the separations late on their logs: (d,) or (b, d) [s]."""
        ...

    def subset(self, settings: NDArray[np.intp]) -> "Histories":
        """Return those under some of the settings."""
        ...


@dataclass(frozen=True)
class DiveHistories:
    """Readings of the sensor in all d dives under b settings, at any time."""

    logs: tuple[DiveLog, ...]
    """The d dives."""
    history: SensorHistory
    """Of b·d trials, setting by setting."""

    @property
    def settings(self) -> int:
        """Number of settings, b."""
        return int(self.history.depths.shape[1]) // len(self.logs)

    def readings(self, delays: Scalars = 0.0) -> Array:
        """Readings of all dives, one after the other, shape (N, b) [m].

        Parameters
        ----------
        delays : float or array, shape (d,) or (b, d)
            Of each dive's separation on its log [s].
        """
        count, settings = len(self.logs), self.settings
        times = np.tile(self._fine, (1, settings)) - np.broadcast_to(delays, (settings, count)).ravel()
        depths = self.history.at(times).reshape(-1, settings, count)
        return np.concatenate([_averaged(log, depths[:, :, index]) for index, log in enumerate(self.logs)])

    def subset(self, settings: NDArray[np.intp]) -> "DiveHistories":
        """Return those under some of the settings."""
        count = len(self.logs)
        trials = (settings[:, None] * count + np.arange(count)).ravel()
        return DiveHistories(self.logs, self.history.take(trials))

    @cached_property
    def _fine(self) -> Array:
        """Fine times of each dive, nan where it has fewer than others, shape (k, d) [s]."""
        times = np.full((max(len(log.fine) for log in self.logs), len(self.logs)), np.nan)
        for index, log in enumerate(self.logs):
            times[: len(log.fine), index] = log.fine
        return times


def _averaged(log: DiveLog, depths: Array) -> Array:
    """Average depths at a log's fine times over its bins, shape (m, settings)."""
    starts = np.searchsorted(log.bins, np.arange(len(log.t)))
    return np.asarray(np.add.reduceat(log.shares[:, None] * depths[: len(log.fine)], starts, axis=0))


def parameter_range(effect: str, name: str) -> tuple[float, float]:
    """Range of a parameter inside which the phase is run [unit]; a strength may have the wrong sign, to be judged."""
    parameter = CATALOGUE[effect].parameters[name]
    if parameter.low != 0.0 or parameter.is_shape or not np.isfinite(parameter.high):
        return parameter.low, parameter.high
    return max(-parameter.high, MIN_FRACTION) if parameter.unit == "" else -parameter.high, parameter.high
