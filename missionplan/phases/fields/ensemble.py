"""An ensemble of forecasts: each trial sails in one of its members; what is expected is their weighted mean."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Span
from missionplan.phases.recorded_currents import RecordedCurrent


@dataclass(frozen=True)
class Ensemble(RecordedCurrent):
    """Members of an ensemble; use `of`.

    Attributes
    ----------
    time, depth : array, shapes (2,)
        Which all members cover [s since the mission's start, m].
    members : tuple of RecordedCurrent
    names : tuple of str
    weights : array, shape (m,)
        Their probabilities.
    chosen : array of int, shape (n,), or None
        The member of each trial; None for the weighted mean.
    given : int or None
        The member of all trials, where it is not drawn. What is expected remains the weighted mean.
    """

    members: tuple[RecordedCurrent, ...]
    names: tuple[str, ...]
    weights: Array
    chosen: NDArray[np.intp] | None = None
    given: int | None = None

    @classmethod
    def of(cls, members: Sequence[RecordedCurrent], names: Sequence[str], weights: Sequence[float]) -> "Ensemble":
        """Build it from members and their weights, in any scale."""
        depths = np.array([member.depths_covered for member in members])
        return cls(
            time=np.array([max(each.time[0] for each in members), min(each.time[-1] for each in members)]),
            depth=np.array([depths[:, 0].max(), depths[:, 1].min()]),
            members=tuple(members),
            names=tuple(names),
            weights=np.asarray(weights, dtype=float) / float(np.sum(weights)),
        )

    def drawn(self, normals: Array) -> "Ensemble":
        """Return it with a member for each trial, from standard normals of shape (n,)."""
        if self.given is not None:
            return replace(self, chosen=np.full(normals.size, self.given, dtype=np.intp))
        return replace(
            self, chosen=np.searchsorted(np.cumsum(self.weights)[:-1], scipy.special.ndtr(normals), side="right")
        )

    @property
    @override
    def depths_covered(self) -> tuple[float, float]:
        """Least and greatest depth at which all members are good [m]."""
        return float(self.depth[0]), float(self.depth[1])

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return self._of_members("velocity", t, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        return self._of_members("mean_velocity", t, duration, depth, start, through)

    @override
    def covers(self, span: Span) -> NDArray[np.bool_]:
        if self.chosen is None:
            return np.asarray(np.all(np.broadcast_arrays(*(each.covers(span) for each in self.members)), axis=0))
        covered = np.zeros(self.chosen.size, dtype=bool)
        for number, trials in self._trials():
            part = [
                _part(value, trials, self.chosen.size) for value in (span.start, span.end, span.depth, *span.places)
            ]
            covered[trials] = self.members[number].covers(Span(part[0], part[1], part[2], tuple(part[3:])))
        return covered

    @override
    def later(self, seconds: float) -> "Ensemble":
        return replace(super().later(seconds), members=tuple(member.later(seconds) for member in self.members))

    @property
    @override
    def steady_for(self) -> float:
        return min(member.steady_for for member in self.members)

    @override
    def take(self, trials: NDArray[np.intp]) -> "Ensemble":
        return self if self.chosen is None else replace(self, chosen=self.chosen[trials])

    def _of_members(self, method: str, *arguments: Scalars) -> Array:
        """Call a method of the members: of each trial's own, or of all for their weighted mean."""
        if self.chosen is None:
            found = [getattr(member, method)(*arguments) for member in self.members]
            return np.asarray(sum(weight * each for weight, each in zip(self.weights, found, strict=True)))
        if self.chosen.size == 1:
            return np.asarray(getattr(self.members[int(self.chosen[0])], method)(*arguments))
        velocity = np.zeros((2, self.chosen.size))
        for number, trials in self._trials():
            part = [_part(value, trials, self.chosen.size) for value in arguments]
            velocity[:, trials] = getattr(self.members[number], method)(*part)
        return velocity

    def _trials(self) -> list[tuple[int, NDArray[np.intp]]]:
        return [
            (number, trials)
            for number in range(len(self.members))
            if (trials := np.flatnonzero(self.chosen == number)).size
        ]


def _part(value: Scalars, trials: NDArray[np.intp], size: int) -> Array:
    """Values of some of the trials; what is the same for all stays."""
    array = np.asarray(value, dtype=float)
    return array[..., trials] if array.ndim and array.shape[-1] == size else array
