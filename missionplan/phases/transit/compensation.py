"""Drift compensation: where the vehicle aims instead of straight at the nominal end of a leg.

Each method is a small class: `offset` returns how far to aim off, `update` takes in what the fixes of a leg have shown.
What the vehicle has learnt is kept outside the class, as a tuple of arrays with trials last, so that the transit can
drop trials that have arrived. Briggs et al., Eqs. 21–23 do not converge as printed: see `AsPrinted`.
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
    """The coming leg, as the vehicle knows it before it dives."""

    t: Array
    """Since the mission's start, shape (n,) [s]."""
    fix: Array
    """Fix on diving, shape (2, n) [m]."""
    nominal: Array
    """Nominal leg ℓ′ (Eq. 20); shape (2, n) [m]."""
    duration: Array
    """Planned time ‖ℓ′‖/U, shape (n,) [s]."""
    goal: Array
    """Target, shape (2, 1) or (2, n) [m]."""
    radius: Scalars
    """Of arrival, float or shape (n,) [m]."""


@dataclass(frozen=True)
class CompletedLeg:
    """The leg just ended, as its fixes have shown it."""

    velocity_error: Array
    """(fix on surfacing − x*)/(‖ℓ*‖/U), x* the adjusted destination (Eq. 23); shape (2, n) [m/s]."""
    duration: Array
    """‖ℓ*‖/U [s]; 0 for a trial that did not move; shape (n,)."""
    surface_drift: Array
    """Fix on diving − fix on surfacing, shape (2, n) [m]."""
    miss: Array
    """Fix on diving − nominal destination x′, shape (2, n) [m]."""
    t: Array
    """Start of the leg since the mission's start, shape (n,) [s]."""
    start: Array
    through: Array
    """Shape (2, n). Fix that the leg started from, and its displacement through the water as it was steered, ℓ* [m]."""


class Compensation(ABC):
    """A method of aiming off for the drift that is expected."""

    def begin(self, trials: int) -> Memory:
        """Return the memory before the first leg."""
        return ()

    @abstractmethod
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        """Displacement expected over the coming leg and its surfacing, to be aimed off, shape (2, n) [m]."""

    def undershoot(self, memory: Memory, leg: PlannedLeg) -> Array:
        """Part of the offset by which the leg is meant to end short of its nominal end: shape (2, 1) or (2, n) [m]."""
        return np.zeros((2, 1))

    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        """Return the memory after a leg."""
        return memory


class LastLeg(Compensation):
    """Expect the velocity error and the surface drift of the last leg to recur."""

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


class LastVelocity(LastLeg):
    """Expect the velocity error of the last leg to recur, and no drift at the surface: as gliders aim off."""

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        return memory[0] * leg.duration


@dataclass(frozen=True)
class RunningMean(Compensation):
    """Expect the mean velocity error so far, each leg weighted by (Σ_v + 2σ_fix²/T² I)⁻¹, and the mean drift so far.

    The weighted mean is the recursive least-squares estimate without a prior. Along the eigenvectors of Σ_v the
    weights are the scalars 1/(λ + 2σ_fix²/T²); for isotropic errors λ = σ_v².
    """

    covariance: Array
    """Σ_v that the vehicle assumes, shape (2, 2) [m²/s²]."""
    fix_error: float
    """σ_fix that it assumes, each axis [m]."""

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
        new_weight = np.where(moved, 1.0 / np.where(variance > 0.0, variance, 1.0), 0.0)
        return (
            weighted + new_weight * _rotated(axes.T, leg.velocity_error),
            weight + new_weight,
            drift + leg.surface_drift,
            legs + 1.0,
        )


@dataclass(frozen=True)
class Forecast(Compensation):
    """Expect the means of current and velocity error by their models, never what a trial has drawn."""

    current: Current | None
    """The site's current at its mean parameters; None for still water."""
    mean_error: Array
    """v̄ of Eq. 24; shape (2,) [m/s]."""
    depth: float
    """Run depth [m]."""
    surfacing_time: float
    """Planned time at the surface [s]."""

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
        """Displacement expected while the vehicle is at the surface, shape (2, 1) or (2, n) [m]."""
        if self.current is None:
            return np.zeros((2, 1))
        still = np.zeros((2, 1))
        return self.current.mean_velocity(t, self.surfacing_time, 0.0, position, still) * self.surfacing_time


class AsPrinted(Compensation):
    """Eq. 21 to the letter: subtract how far the last leg ended from its *nominal* destination x′.

    As that miss contains the last correction, full and no compensation alternate: a run may converge or never arrive.
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
    """Return the compensation that a mission names; None for ``none``.

    Raises ValueError when the name is unknown.
    """
    methods: dict[str, Compensation | None] = {
        "none": None,
        "last-leg": LastLeg(),
        "mean": RunningMean(covariance, float(np.mean(fix_error))),
        "forecast": forecast,
        "as-printed": AsPrinted(),
    }
    if name not in methods:
        raise ValueError(f"no drift compensation is named {name!r}; there are {', '.join(methods)}")
    return methods[name]


def _rotated(matrix: Array, vectors: Array) -> Array:
    """Multiply every vector, shape (2, n), by a matrix; without BLAS, whose bits depend on its threads."""
    return np.stack(
        (matrix[0, 0] * vectors[0] + matrix[0, 1] * vectors[1], matrix[1, 0] * vectors[0] + matrix[1, 1] * vectors[1])
    )
