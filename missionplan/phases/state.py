"""The state in which one phase leaves a block of trials, and from which the next one starts."""

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars


@dataclass(frozen=True)
class TrialState:
    """State of a block of trials between two phases.

    Attributes
    ----------
    position : array, shape (2, n)
        True position, east and north of the coordinates' origin [m].
    fix : array, shape (2, n)
        Last fix: where the vehicle believes that it is [m].
    clock : array, shape (n,)
        Time since the mission's start [s].
    energy : array, shape (n,)
        Used so far [J].
    alive : array of bool, shape (n,)
        Whether the trial goes on: it has arrived at every goal and surfaced from every mooring so far.
    """

    position: Array
    fix: Array
    clock: Array
    energy: Array
    alive: NDArray[np.bool_]

    @property
    def trials(self) -> int:
        """Number of trials."""
        return self.clock.size

    def take(self, trials: NDArray[np.intp]) -> "TrialState":
        """Select trials; one may be selected several times."""
        return TrialState(
            self.position[:, trials], self.fix[:, trials], self.clock[trials], self.energy[trials], self.alive[trials]
        )

    @classmethod
    def at(cls, position: Array, trials: int, fix_noise: Array | float = 0.0) -> "TrialState":
        """State at deployment.

        Parameters
        ----------
        position : array, shape (2,) or (2, n)
            Of the deployment [m].
        trials : int
        fix_noise : array, shape (2, n)
            Error of the fix before the first dive [m].
        """
        column = position[:, None] if position.ndim == 1 else position
        true = np.array(np.broadcast_to(column, (2, trials)), dtype=float)
        return cls(true, true + fix_noise, np.zeros(trials), np.zeros(trials), np.ones(trials, dtype=bool))


@overload
def select_trials(value: Array, trials: NDArray[np.intp]) -> Array: ...
@overload
def select_trials(value: Scalars, trials: NDArray[np.intp]) -> Scalars: ...
def select_trials(value: Scalars, trials: NDArray[np.intp]) -> Scalars:
    """Select trials of a parameter: one number, or an array with trials last (of length 1 where all are alike)."""
    if isinstance(value, np.ndarray) and value.ndim and value.shape[-1] > 1:
        return value[..., trials]
    return value
