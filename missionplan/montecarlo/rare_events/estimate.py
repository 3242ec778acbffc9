"""What independent repetitions of an unbiased estimate say together."""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Array

LEAST_REPETITIONS = 8
"""From which a coefficient of variation is worth stating: it is then itself known to about 27 %."""


@dataclass(frozen=True)
class Estimate:
    """A probability from independent repetitions.

    Attributes
    ----------
    value : float
        Mean of the repetitions.
    variation : float
        Coefficient of variation of `value`, from the scatter of the repetitions; infinite where none found a failure.
    low, high : float
        95 % interval: Student's t on the logarithm of the value, as a product of many random factors is skewed.
    repetitions : int
    """

    value: float
    variation: float
    low: float
    high: float
    repetitions: int

    @classmethod
    def of(cls, repetitions: Array) -> "Estimate":
        """Combine at least two repetitions."""
        count, value = len(repetitions), float(np.mean(repetitions))
        if value <= 0.0:
            return cls(0.0, math.inf, 0.0, 1.0, count)
        variation = float(np.std(repetitions, ddof=1)) / math.sqrt(count) / value
        factor = math.exp(float(scipy.special.stdtrit(count - 1, 0.975)) * variation)
        return cls(value, variation, value / factor, min(1.0, value * factor), count)
