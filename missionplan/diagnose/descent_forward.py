"""The descent phase as the diagnosis calls it: many settings of the parameters and all dives in one call."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.coordinates import Coordinate, parameters_from
from missionplan.diagnose.descent_data import DiveLog
from missionplan.effects import CATALOGUE
from missionplan.phases.descent_forces import Dive
from missionplan.phases.hooks import DescentEffect, Scalars
from missionplan.phases.readings import simulate_readings

Array = NDArray[np.float64]

STEP = 0.16
"""Step of the integration [s]; readings are within 5 mm of those with steps of 0.02 s, 1 mm as a rule."""
LEAST_FACTOR = -0.9
"""Least strength of an effect that multiplies a drag or a weight: less would turn it round."""
NO_BOTTOM = 1e5
"""Site depth for the fit [m]: the logs end above touchdown, and so must no model of them reach it."""


@dataclass(frozen=True)
class DescentForward:
    """Readings of all dives under many settings at once.

    Attributes
    ----------
    build : callable
        The mission's descent from wet weights [N] and line lengths [m], arrays of shape (d,).
    logs : tuple of DiveLog
        The d dives, whose times are asked for.
    given : tuple of DescentEffect
        Effects that the mission has already.
    """

    build: Callable[[Array, Array], Dive]
    logs: tuple[DiveLog, ...]
    given: tuple[DescentEffect, ...] = ()

    @cached_property
    def dive(self) -> Dive:
        """Bodies and line of all dives, without a bottom."""
        weights, lines = (np.array([getattr(log, key) for log in self.logs]) for key in ("wet_weight", "line_length"))
        return replace(self.build(weights, lines), site_depth=NO_BOTTOM)

    @property
    def samples(self) -> int:
        """Number of readings of all dives together."""
        return sum(len(log.t) for log in self.logs)

    def readings(
        self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars = 1.0, late: Scalars = 0.0
    ) -> Array:
        """Readings of all dives, one after the other.

        Parameters
        ----------
        coordinates : sequence of Coordinate, length k
            What varies.
        values : array, shape (k, b)
            Their values in b settings.
        weight_factor : float or array, shape (b,)
            Factor on the anchor's wet weight.
        late : float or array, shape (d,) or (b, d)
            By how much each dive's separation is late on its log [s].

        Returns
        -------
        array, shape (N, b)
            [m]
        """
        count, settings = len(self.logs), values.shape[1]
        present = _present(coordinates, values)
        there = [i for i, c in enumerate(coordinates) if c.effect in present]
        named = parameters_from([coordinates[i] for i in there], np.repeat(values[there], count, axis=1)).items()
        effects = [*self.given, *(self._effect(name, parameters) for name, parameters in named)]
        factor = np.repeat(np.broadcast_to(np.asarray(weight_factor, dtype=float), settings), count)
        dive = self._tiled(settings, factor)
        times = self._times(settings) - np.broadcast_to(late, (settings, count)).ravel()
        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # a start that runs away is given up: its objective is infinite
            depths = simulate_readings(dive, times, effects=effects, step=STEP)
        by_setting = depths.reshape(-1, settings, count)
        return np.concatenate([_averaged(log, by_setting[:, :, index]) for index, log in enumerate(self.logs)])

    @staticmethod
    def _effect(name: str, parameters: Mapping[str, Scalars]) -> DescentEffect:
        """The effect with its parameters held inside what the phase can integrate."""
        info = CATALOGUE[name]
        held = {key: np.clip(value, *_limits(name, key)) for key, value in parameters.items()}
        effect = info.make(held)
        assert isinstance(effect, DescentEffect)
        return effect

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
        )

    def _times(self, settings: int) -> Array:
        longest = max(len(log.fine) for log in self.logs)
        times = np.full((longest, len(self.logs)), np.nan)
        for index, log in enumerate(self.logs):
            times[: len(log.fine), index] = log.fine
        return np.tile(times, (1, settings))


def _present(coordinates: Sequence[Coordinate], values: Array) -> set[str]:
    """Effects whose strength is not zero in every setting: the others do nothing."""
    return {c.effect for c, row in zip(coordinates, values, strict=True) if c.kind != "shape" and np.any(row)}


def _averaged(log: DiveLog, depths: Array) -> Array:
    """Average depths at a log's fine times over its bins, shape (m, settings)."""
    starts = np.searchsorted(log.bins, np.arange(len(log.t)))
    return np.asarray(np.add.reduceat(log.shares[:, None] * depths[: len(log.fine)], starts, axis=0))


def limits(coordinate: Coordinate) -> tuple[float, float]:
    """Range inside which the phase is asked for a parameter [unit]; a strength may go through zero to be judged."""
    return _limits(coordinate.effect, coordinate.name)


def _limits(effect: str, name: str) -> tuple[float, float]:
    parameter = CATALOGUE[effect].parameters[name]
    if parameter.low != 0.0 or parameter.is_shape or not np.isfinite(parameter.high):
        return parameter.low, parameter.high
    return max(-parameter.high, LEAST_FACTOR) if parameter.unit == "" else -parameter.high, parameter.high
