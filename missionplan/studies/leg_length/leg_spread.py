"""How far legs end from where they were sent in a mission's own trials: the spread that best legs are computed for.

The integral equation allows for errors that grow with the leg, σℓ/U, and a spread s₀ that does not. Where a mission has
currents, compensation, errors of fixes or effects, both are estimated from pilot trials: the miss of each leg, fix on
diving minus where the leg was sent, has mean square 2((σ T)² + s₀²) over legs of duration T.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import lsq_linear, nnls
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.phases.transit.analytic.expectation import MAX_RATIO
from missionplan.phases.transit.compensation import Compensation, CompletedLeg, Memory, PlannedLeg
from missionplan.studies.leg_length.paired_trials import PILOT_BLOCK, LegsAtSpeed, run_plans
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

LEARNING_COMPENSATIONS = ("last-leg", "mean", "filter")
"""Drift compensations that estimate the drift from legs made."""
LENGTH_SHARES = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0)
"""Maximum leg lengths of the pilot trials, as shares of the distance."""
BINS = 24
"""Classes of duration, of equal numbers of legs, to which the spread is fitted."""


@dataclass(frozen=True)
class LegSpread:
    """Standard deviation of a leg's end on each axis, √((sigma T)² + base²).

    Attributes
    ----------
    sigma : float
        Of the velocity, as if drawn anew each leg [m/s].
    base : float
        Of any leg [m].
    """

    sigma: float
    base: float


@dataclass
class _RecordingCompensation(Compensation):
    """Compensation that records each leg's planned duration [s] and the square of its miss [m²]."""

    inner: Compensation | None
    durations: list[Array] = field(default_factory=list)
    squared_misses: list[Array] = field(default_factory=list)

    @override
    def begin(self, trials: int) -> Memory:
        own = self.inner.begin(trials) if self.inner else ()
        return (np.zeros(trials), np.zeros((2, trials)), *own)

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        duration, short, *own = memory
        np.copyto(duration, leg.duration)
        if self.inner is None:
            return np.zeros((2, 1))
        np.copyto(short, self.inner.undershoot(tuple(own), leg))
        return self.inner.offset(tuple(own), leg)

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        duration, short, *own = memory
        moved = leg.duration > 0.0
        self.durations.append(duration[moved])
        self.squared_misses.append(np.sum((leg.miss + short)[:, moved] ** 2, axis=0))
        return (duration, short, *(self.inner.update(tuple(own), leg) if self.inner else ()))


def fit_leg_spread(scenario: SweepScenario, seed: int) -> LegSpread:
    """Fit the spread of legs to pilot trials of the mission, with maximum leg lengths from short to the distance.

    Non-negative least squares (Lawson & Hanson 1974, ch. 23) on medians in classes of duration, so that a few outliers
    do not decide; the square of an isotropic normal miss is exponential, its median 2 ln 2 times the variance on each
    axis. A vehicle that estimates its drift from legs made has no estimate on the first leg, which is left out.
    """
    records: list[_RecordingCompensation] = []

    def recorded(compensation: Compensation | None) -> Compensation:
        records.append(_RecordingCompensation(compensation))
        return records[-1]

    plans = [LegsAtSpeed(share * scenario.distance) for share in LENGTH_SHARES]
    run_plans(scenario, plans, seed, PILOT_BLOCK, wrap_compensation=recorded)
    first = 1 if scenario.navigation.drift_compensation in LEARNING_COMPENSATIONS else 0
    duration = np.concatenate([part for record in records for part in record.durations[first:]])
    squared = np.concatenate([part for record in records for part in record.squared_misses[first:]])
    classes = [part for part in np.array_split(np.argsort(duration, kind="stable"), BINS) if part.size]
    seconds = np.array([np.sqrt(np.mean(duration[part] ** 2)) for part in classes])
    variance = np.array([np.median(squared[part]) for part in classes]) / (2.0 * np.log(2.0))
    weight = 1.0 / np.maximum(variance, 1e-12)
    terms = np.stack([seconds**2, np.ones_like(seconds)], axis=1)
    rate, base = _non_negative(terms * weight[:, None], variance * weight)
    return LegSpread(min(float(np.sqrt(rate)), 0.9 * MAX_RATIO * scenario.speed), float(np.sqrt(base)))


def _non_negative(terms: Array, values: Array) -> Array:
    """Least squares with coefficients that are not negative."""
    try:
        return np.asarray(nnls(terms, values)[0])
    except ValueError:  # early versions of nnls in Python stop so where nothing is left to free
        return np.asarray(lsq_linear(terms, values, bounds=(0.0, np.inf)).x)
