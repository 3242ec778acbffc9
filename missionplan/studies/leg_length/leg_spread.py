"""How far from where they were sent legs end, in the mission's own trials: the spread that the best legs reckon with.

The integral equation knows errors that grow with the leg, σℓ/U, and a spread s₀ that does not. Where a mission has
currents, compensation, errors of fixes or effects, both are taken from a pilot: the miss of each leg, fix on diving
minus where the leg was sent, has mean square 2((σ T)² + s₀²) over legs of duration T.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import nnls
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.phases.transit.analytic.expectation import MAX_RATIO
from missionplan.phases.transit.compensation import Compensation, LegAhead, LegBehind, Memory
from missionplan.studies.leg_length.paired_trials import PILOT_BLOCK, LegsAtSpeed, run_plans
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

LEARNING_COMPENSATIONS = ("last-leg", "mean", "filter")
"""Ways of compensating that need a leg to learn from."""
SHARES = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0)
"""Maximum leg lengths of the pilot, of the distance."""
BINS = 24
"""Classes of duration, of equal numbers of legs, between which the spread is fitted."""


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
    """Compensation that notes how long each leg was planned to last, and how far from where it was sent it ended."""

    way: Compensation | None
    durations: list[Array] = field(default_factory=list)
    misses: list[Array] = field(default_factory=list)

    @override
    def begin(self, trials: int) -> Memory:
        own = self.way.begin(trials) if self.way else ()
        return (np.zeros(trials), np.zeros((2, trials)), *own)

    @override
    def offset(self, memory: Memory, leg: LegAhead) -> Array:
        duration, short, *own = memory
        np.copyto(duration, leg.duration)
        if self.way is None:
            return np.zeros((2, 1))
        np.copyto(short, self.way.short(tuple(own), leg))
        return self.way.offset(tuple(own), leg)

    @override
    def learn(self, memory: Memory, leg: LegBehind) -> Memory:
        duration, short, *own = memory
        moved = leg.duration > 0.0
        self.durations.append(duration[moved])
        self.misses.append(np.sum((leg.miss + short)[:, moved] ** 2, axis=0))
        return (duration, short, *(self.way.learn(tuple(own), leg) if self.way else ()))


def fit_leg_spread(scenario: SweepScenario, seed: int) -> LegSpread:
    """Fit the spread of legs to a pilot of the mission, run with maximum leg lengths from short to the distance.

    Medians in classes of duration, so that a few wild legs do not decide; for an isotropic normal miss the median of
    its square is 2 ln 2 times the variance on each axis. A vehicle that learns its drift knows nothing on the first
    leg, which is left out.
    """
    ears: list[_RecordingCompensation] = []

    def listening(way: Compensation | None) -> Compensation:
        ears.append(_RecordingCompensation(way))
        return ears[-1]

    plans = [LegsAtSpeed(share * scenario.distance) for share in SHARES]
    run_plans(scenario, plans, seed, PILOT_BLOCK, listening=listening)
    first = 1 if scenario.navigation.drift_compensation in LEARNING_COMPENSATIONS else 0
    duration = np.concatenate([part for ear in ears for part in ear.durations[first:]])
    squared = np.concatenate([part for ear in ears for part in ear.misses[first:]])
    classes = [part for part in np.array_split(np.argsort(duration, kind="stable"), BINS) if part.size]
    seconds = np.array([np.sqrt(np.mean(duration[part] ** 2)) for part in classes])
    variance = np.array([np.median(squared[part]) for part in classes]) / (2.0 * np.log(2.0))
    weight = 1.0 / np.maximum(variance, 1e-12)
    terms = np.stack([seconds**2, np.ones_like(seconds)], axis=1)
    (rate, base), _ = nnls(terms * weight[:, None], variance * weight)
    return LegSpread(min(float(np.sqrt(rate)), 0.9 * MAX_RATIO * scenario.speed), float(np.sqrt(base)))
