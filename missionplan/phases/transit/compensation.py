"""What the vehicle does about its drift: where it aims instead of straight at the nominal end of the leg.

Each way is a small class: `offset` says by how much to aim off, `update` takes in what the fixes of a leg have shown.
What is learnt travels beside it as a tuple of arrays with trials last, so that the transit can drop trials that have
arrived. Briggs et al., Eqs. 21–23 do not converge as printed: see `AsPrinted`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Current

Memory = tuple[Array, ...]


@dataclass(frozen=True)
class PlannedLeg:
    """What the vehicle knows before it dives.

    Attributes
    ----------
    t : array, shape (n,)
        Since the mission's start [s].
    fix : array, shape (2, n)
        Fix on diving [m].
    nominal : array, shape (2, n)
        Nominal leg ℓ′ (Eq. 20) [m].
    duration : array, shape (n,)
        Its planned time ‖ℓ′‖/U [s].
    goal : array, shape (2, 1) or (2, n)
        Target [m].
    radius : float or array, shape (n,)
        Of arrival [m].
    """

    t: Array
    fix: Array
    nominal: Array
    duration: Array
    goal: Array
    radius: Scalars


@dataclass(frozen=True)
class CompletedLeg:
    """What the fixes at the end of a leg have shown.

    Attributes
    ----------
    velocity_error : array, shape (2, n)
        (fix on surfacing − x*)/(‖ℓ*‖/U), x* the adjusted destination (Eq. 23) [m/s].
    duration : array, shape (n,)
        ‖ℓ*‖/U [s]; 0 for a trial that did not move.
    surface_drift : array, shape (2, n)
        Fix on diving − fix on surfacing [m].
    miss : array, shape (2, n)
        Fix on diving − nominal destination x′ [m].
    t : array, shape (n,)
        Start of the leg since the mission's start [s].
    start, through : array, shape (2, n)
        Fix that the leg started from, and its displacement through the water as it was steered, ℓ* [m].
    """

    velocity_error: Array
    duration: Array
    surface_drift: Array
    miss: Array
    t: Array
    start: Array
    through: Array


class Compensation(ABC):
    """A way of aiming off."""

    def begin(self, trials: int) -> Memory:
        """Give the memory before the first leg."""
        return ()

    @abstractmethod
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        """Displacement to be aimed off: what is expected over the coming leg and its surfacing, shape (2, n) [m]."""

    def undershoot(self, memory: Memory, leg: PlannedLeg) -> Array:
        """By how much of that the leg is to end short of its nominal end, on purpose: shape (2, 1) or (2, n) [m]."""
        return np.zeros((2, 1))

    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        """Take in what the fixes of a leg have shown."""
        return memory


class LastLeg(Compensation):
    """Expect the velocity error and the surface drift of the last leg again."""

    @override
    def begin(self, trials: int) -> Memory:
        return np.zeros((2, trials)), np.zeros((2, trials))

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        velocity, drift = memory
        return velocity * leg.duration + drift

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        return leg.velocity_error, leg.surface_drift


@dataclass(frozen=True)
class RunningMean(Compensation):
    """Expect the mean velocity error so far, each leg weighted by (Σ_v + 2σ_fix²/T² I)⁻¹, and the mean drift so far.

    The weighted mean is the recursive least-squares estimate without a prior. Along the eigenvectors of Σ_v the
    weights are the scalars 1/(λ + 2σ_fix²/T²); for isotropic errors λ = σ_v².

    Attributes
    ----------
    covariance : array, shape (2, 2)
        Σ_v that the vehicle reckons with [m²/s²].
    fix_error : float
        σ_fix that it reckons with, each axis [m].
    """

    covariance: Array
    fix_error: float

    @override
    def begin(self, trials: int) -> Memory:
        return np.zeros((2, trials)), np.zeros((2, trials)), np.zeros((2, trials)), np.zeros((1, trials))

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        weighted, weight, drift, legs = memory
        _, axes = np.linalg.eigh(self.covariance)
        mean = weighted / np.where(weight > 0.0, weight, 1.0)
        return _rotated(axes, mean) * leg.duration + drift / np.maximum(legs, 1.0)

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        weighted, weight, drift, legs = memory
        variances, axes = np.linalg.eigh(self.covariance)
        variances = np.maximum(variances, 0.0)
        moved = leg.duration > 0.0
        seconds = np.where(moved, leg.duration, 1.0)
        variance = variances[:, None] + 2.0 * self.fix_error**2 / seconds**2
        gained = np.where(moved, 1.0 / np.where(variance > 0.0, variance, 1.0), 0.0)
        return (
            weighted + gained * _rotated(axes.T, leg.velocity_error),
            weight + gained,
            drift + leg.surface_drift,
            legs + 1.0,
        )


@dataclass(frozen=True)
class Forecast(Compensation):
    """Expect what the models of current and velocity error have as their means, never what a trial has drawn.

    Attributes
    ----------
    current : Current or None
        The site's current at its means; None where there is none.
    mean_error : array, shape (2,)
        v̄ of Eq. 24 [m/s].
    depth : float
        Run depth [m].
    surfacing_time : float
        Planned time at the surface [s].
    """

    current: Current | None
    mean_error: Array
    depth: float
    surfacing_time: float

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        under_way = self.under_way(leg.t, leg.duration, leg.fix, leg.nominal) * leg.duration
        return under_way + self.at_surface(leg.t + leg.duration, leg.fix + leg.nominal)

    def under_way(self, t: Array, duration: Array, start: Array, through: Array) -> Array:
        """Mean velocity expected over a leg, shape (2, 1) or (2, n) [m/s]."""
        error = self.mean_error[:, None]
        return (
            error
            if self.current is None
            else error + self.current.mean_velocity(t, duration, self.depth, start, through)
        )

    def at_surface(self, t: Array, position: Array) -> Array:
        """Displacement expected while the vehicle is up, shape (2, 1) or (2, n) [m]."""
        if self.current is None:
            return np.zeros((2, 1))
        still = np.zeros((2, 1))
        return self.current.mean_velocity(t, self.surfacing_time, 0.0, position, still) * self.surfacing_time


class AsPrinted(Compensation):
    """Eq. 21 to the letter: subtract how far the last leg ended from its *nominal* destination x′.

    As that miss contains the last correction, full and no compensation alternate: a run homes in or wanders for ever.
    """

    @override
    def begin(self, trials: int) -> Memory:
        return (np.zeros((2, trials)),)

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        return memory[0]

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        return (leg.miss,)


def compensation_named(name: str, forecast: Forecast, covariance: Array, fix_error: Scalars) -> Compensation | None:
    """Give the compensation that a mission names; None for ``none``.

    Raises
    ------
    ValueError
        When the name is not known.
    """
    ways: dict[str, Compensation | None] = {
        "none": None,
        "last-leg": LastLeg(),
        "mean": RunningMean(covariance, float(np.mean(fix_error))),
        "forecast": forecast,
        "as-printed": AsPrinted(),
    }
    if name not in ways:
        raise ValueError(f"no drift compensation is named {name!r}; there are {', '.join(ways)}")
    return ways[name]


def _rotated(matrix: Array, vectors: Array) -> Array:
    """Multiply every vector, shape (2, n), by a matrix; without BLAS, whose bits depend on its threads."""
    return np.stack(
        (matrix[0, 0] * vectors[0] + matrix[0, 1] * vectors[1], matrix[1, 0] * vectors[0] + matrix[1, 1] * vectors[1])
    )
