"""A probability that is a sum of unbiased estimates, each from independent runs in two stages."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Array

FIRST_WEIGHT = 1.0 / 3.0
"""Of the first stage. Fixed beforehand: how many runs the second stage has depends on what the first found, and a mean
over all runs would be low, as stages that find little also scatter little, and end early."""


@dataclass(frozen=True)
class TwoStages:
    """Runs of one part of the sum.

    Attributes
    ----------
    first, second : array, shape (runs,)
        Unbiased estimates; at least two in all, the second stage may be empty.
    """

    first: Array
    second: Array

    @property
    def value(self) -> float:
        """Weighted mean of the stages."""
        if not self.second.size:
            return float(np.mean(self.first))
        return float(FIRST_WEIGHT * np.mean(self.first) + (1.0 - FIRST_WEIGHT) * np.mean(self.second))

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the scatter of the runs."""
        return self.first.size + self.second.size - 1

    @property
    def scatter(self) -> float:
        """Standard deviation of one run."""
        return float(np.std(np.concatenate([self.first, self.second]), ddof=1))

    @property
    def variance(self) -> float:
        """Variance of the value."""
        if not self.second.size:
            return self.scatter**2 / self.first.size
        return self.scatter**2 * (FIRST_WEIGHT**2 / self.first.size + (1.0 - FIRST_WEIGHT) ** 2 / self.second.size)


@dataclass(frozen=True)
class Estimate:
    """A probability.

    Attributes
    ----------
    value : float
    variation : float
        Coefficient of variation of `value`, from the scatter of the runs; infinite where none found a failure.
    low, high : float
        95 % interval: Student's t on the logarithm of the value, as a product of many random factors is skewed, with
        the degrees of freedom of a sum of variances (Satterthwaite 1946, *Biometrics Bulletin* 2, 110–114).
    """

    value: float
    variation: float
    low: float
    high: float

    @classmethod
    def of(cls, parts: Sequence[TwoStages], left: float = 0.0) -> "Estimate":
        """Add up the parts, which are independent of each other, and what is left out of them as negligible."""
        value, variances = left + sum(part.value for part in parts), np.array([part.variance for part in parts])
        if value <= left:
            return cls(0.0, math.inf, 0.0, 1.0)
        variation = math.sqrt(float(variances.sum())) / value
        if variation == 0.0:
            return cls(value, 0.0, value, value)
        freedoms = np.array([part.freedom for part in parts])
        freedom = float(variances.sum() ** 2 / np.sum(variances**2 / freedoms))
        factor = math.exp(min(float(scipy.special.stdtrit(freedom, 0.975)) * variation, 700.0))
        return cls(value, variation, value / factor, min(1.0, value * factor))


def runs_needed(
    first: Sequence[Array], costs: Sequence[int], *, variation: float, most_cost: float, least: int
) -> tuple[list[int], bool]:
    """Share the second stage's runs among the parts so that the sum is known as well as asked for the least cost.

    Neyman's allocation: runs in proportion to the scatter of a part over the root of what a run of it costs.

    Parameters
    ----------
    first : sequence of array
        Estimates of the first stage, by part.
    costs : sequence of int
        Of one run of each part.
    variation : float
        Coefficient of variation of the sum that is asked for.
    most_cost : float
        Of the whole second stage; fewer runs are made where the accuracy asked for would cost more.
    least : int
        Runs of each part, whatever they cost.

    Returns
    -------
    runs, cut : list of int, bool
        Of each part; and whether they are fewer than the accuracy takes.
    """
    if not first:
        return [], False
    scatters = np.array([np.std(each, ddof=1) for each in first])
    value = float(sum(np.mean(each) for each in first))
    known = float(sum(scatter**2 / each.size for scatter, each in zip(scatters, first, strict=True)))
    roots = np.sqrt(np.array(costs, dtype=float))
    wanted = (variation * value) ** 2 - FIRST_WEIGHT**2 * known
    wanted = max(wanted, 0.05 * (variation * value) ** 2)  # the first stage alone may scatter more than is asked for
    runs = np.zeros(len(first))
    if value > 0.0 and known > 0.0:
        runs = (1.0 - FIRST_WEIGHT) ** 2 * float(np.sum(scatters * roots)) * scatters / roots / wanted
    runs = np.maximum(np.ceil(runs), least)
    spare = max(most_cost - least * float(np.sum(costs)), 0.0)
    more = float(np.sum((runs - least) * costs))
    if more > spare:
        runs = least + np.floor((runs - least) * spare / more)
    return [int(count) for count in runs], more > spare
