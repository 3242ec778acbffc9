"""What the gap between the fix after a leg and the fix before the next one tells of their errors.

A vehicle that dives a minute after its fix takes another fix, and steers by that one to its target. The error of this
fix is then in the leg's course and, with the other sign, in the leg's error: on one heading that looks like a speed
scale that a current undoes. Where the vehicle hardly drifts in between, the gap between the two fixes shows both
errors. Of a gap d, the error of the fix before the leg is κ·d on average and that of the fix after the previous leg
−κ·d, with κ = σ²/(2σ² + q) for fixes of variance σ² and a drift of variance q: ½ without drift, 0 where drift is all.
What is left of them has the variance (1 − κ)σ² each and the covariance κσ² (conditional normal distribution:
Rasmussen & Williams 2006, *Gaussian Processes for Machine Learning*, Eq. A.6).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData

LONGEST_PAUSE = 0.5
"""Longest time between the two fixes, over the usual time under way: after a longer one a leg is missing."""
LARGEST_GAP = 5.0
"""Largest gap over the median gap: a larger one is no error of a fix."""
LEAST_GAPS = 10
"""Gaps below which κ is not estimated."""
CLEAR = 3.0
"""Standard errors by which κ has to exceed nil; else gaps are taken to tell nothing."""
LARGEST = 0.5
"""κ without any drift."""
WITHIN = 2.0
"""Standard errors below that within which κ is taken to be that: a drift that the gaps do not show is none."""


@dataclass(frozen=True)
class FixGaps:
    """Gaps of a log, and how much of them are errors of fixes."""

    before: Array
    """Shape (2, n). From the fix after the previous leg to the one before this, less the mean drift [m]; 0 where none
    is used."""
    is_gap: NDArray[np.bool_]
    """Whether the gap before a leg is used, shape (n,)."""

    @property
    def after(self) -> NDArray[np.bool_]:
        """Whether the gap after a leg is used, shape (n,)."""
        after = np.zeros_like(self.is_gap)
        after[:-1] = self.is_gap[1:]
        return after

    def velocity_error(self, under_way: Array) -> Array:
        """Velocity error of each leg, were the gaps all errors of the fixes on either side, shape (2, n) [m/s]."""
        after = np.concatenate([self.before[:, 1:], np.zeros((2, 1))], axis=1)
        return np.asarray(-(self.before + after) / under_way)


def fix_gaps(data: TransitData) -> FixGaps:
    """Find the gaps between fixes of a log; none where legs share their fixes."""
    none = FixGaps(np.zeros((2, data.n)), np.zeros(data.n, dtype=bool))
    if data.n < 2:
        return none
    gap = data.start[:, 1:] - data.end[:, :-1]
    size = np.hypot(*gap)
    pause = data.t_start[1:] - (data.t_start + data.under_way + data.surface)[:-1]
    used = (data.run[1:] == data.run[:-1]) & (size > 0.0) & (pause <= LONGEST_PAUSE * np.median(data.under_way))
    if np.count_nonzero(used) < LEAST_GAPS:
        return none
    used &= size <= LARGEST_GAP * np.median(size[used])
    drift = (gap[:, used] @ pause[used]) / max(float(pause[used] @ pause[used]), 1e-9)
    before = np.where(used, gap - drift[:, None] * pause, 0.0)
    return FixGaps(np.concatenate([np.zeros((2, 1)), before], axis=1), np.append(False, used))


def share_of_fix_errors(gaps: FixGaps, error: Array, under_way: Array, sigma: float, fix_sd: float) -> float:
    """Estimate κ, the part of the gaps that is an error of the fix on either side; 0 where it is not clear of nil.

    By weighted least squares of the velocity errors on those that the gaps would mean, its standard error by the
    residuals, whatever their law (White 1980, *Econometrica* 48).

    `error`, shape (2, n): velocity errors less what the mission expects [m/s]. `under_way`, shape (n,) [s]. `sigma`,
    `fix_sd`: standard deviations for the weights: of the velocity error [m/s], of a fix [m].
    """
    if not gaps.is_gap.any():
        return 0.0
    column = gaps.velocity_error(under_way)
    weight = 1.0 / (sigma**2 + 2.0 * fix_sd**2 / under_way**2)
    information = float(np.sum(weight * column**2))
    if information <= 0.0:
        return 0.0
    share = float(np.sum(weight * column * error)) / information
    standard_error = float(np.sqrt(np.sum((weight * column * (error - share * column)) ** 2))) / information
    if share <= CLEAR * standard_error:
        return 0.0
    return LARGEST if share + WITHIN * standard_error >= LARGEST else share
