"""The descent phase as the diagnosis calls it: many settings of the parameters and all dives in one call."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.coordinates import Coordinate, parameters_from
from missionplan.diagnose.descent_data import DiveLog
from missionplan.effects import CATALOGUE
from missionplan.phases.descent_forces import Dive
from missionplan.phases.hooks import DescentEffect, Scalars
from missionplan.phases.readings import simulate_readings

Array = NDArray[np.float64]

STEP = 0.1
"""Step of the integration [s]; readings are within a few mm of exact ones, 2 cm where the line goes taut."""
NO_BOTTOM = 1e5
"""Site depth for the fit [m]: the logs end above touchdown, and so must no model of them reach it."""


@dataclass(frozen=True)
class DescentForward:
    """Readings of all dives under many settings at once.

    Attributes
    ----------
    dive : Dive
        The mission's descent with the weights and line lengths of the d dives, arrays of shape (d,).
    logs : tuple of DiveLog
        Whose times are asked for.
    """

    dive: Dive
    logs: tuple[DiveLog, ...]

    @property
    def samples(self) -> int:
        """Number of readings of all dives together."""
        return sum(len(log.t) for log in self.logs)

    def readings(self, coordinates: Sequence[Coordinate], values: Array, weight_factor: Scalars = 1.0) -> Array:
        """Readings of all dives, one after the other.

        Parameters
        ----------
        coordinates : sequence of Coordinate, length k
            What varies.
        values : array, shape (k, b)
            Their values in b settings.
        weight_factor : float or array, shape (b,)
            Factor on the anchor's wet weight.

        Returns
        -------
        array, shape (N, b)
            [m]
        """
        count, settings = len(self.logs), values.shape[1]
        spread = np.repeat(values, count, axis=1)
        effects = [self._effect(name, parameters) for name, parameters in parameters_from(coordinates, spread).items()]
        factor = np.repeat(np.broadcast_to(np.asarray(weight_factor, dtype=float), settings), count)
        depths = simulate_readings(self._tiled(settings, factor), self._times(settings), effects=effects, step=STEP)
        by_setting = depths.reshape(-1, settings, count)
        return np.concatenate([by_setting[: len(log.t), :, index] for index, log in enumerate(self.logs)])

    @staticmethod
    def _effect(name: str, parameters: Mapping[str, Scalars]) -> DescentEffect:
        """The effect with its parameters held inside what the phase can integrate."""
        info = CATALOGUE[name]
        held = {
            key: np.clip(value, *_limits(info.parameters[key].low, info.parameters[key].high))
            for key, value in parameters.items()
        }
        effect = info.make(held)
        assert isinstance(effect, DescentEffect)
        return effect

    def _tiled(self, settings: int, factor: Array) -> Dive:
        tiled = {
            field.name: np.tile(getattr(self.dive, field.name), settings)
            for field in fields(Dive)
            if isinstance(getattr(self.dive, field.name), np.ndarray)
        }
        dive = replace(self.dive, **{**tiled, "site_depth": NO_BOTTOM})
        return replace(dive, wet_weight=dive.wet_weight * factor)

    def _times(self, settings: int) -> Array:
        longest = max(len(log.t) for log in self.logs)
        times = np.full((longest, len(self.logs)), np.nan)
        for index, log in enumerate(self.logs):
            times[: len(log.t), index] = log.t
        return np.tile(times, (1, settings))


def _limits(low: float, high: float) -> tuple[float, float]:
    """Limits for the integration: a strength may go through zero so that its sign can be judged."""
    return (-high if low == 0.0 and np.isfinite(high) else low), high
