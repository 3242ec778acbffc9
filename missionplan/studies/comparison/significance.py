"""Whether the difference of two estimates is more than Monte-Carlo noise."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from missionplan.studies.comparison.summary_numbers import SummaryNumber


def standard_error_and_p_value(
    first: SummaryNumber, second: SummaryNumber, trials: tuple[int, int]
) -> tuple[float | None, float | None]:
    """Standard error of the difference of two independent estimates, and its two-sided p-value from a z test.

    None where the standard errors are not known. Without noise, the p-value is 1 where the numbers are equal, else 0.
    """
    change = second.value - first.value
    if first.kind == "probability":
        error, pooled = _two_proportions(first.value, second.value, *trials)
    else:
        error = pooled = math.hypot(first.error, second.error)
    if not math.isfinite(error):
        return None, None
    if pooled == 0.0:
        return 0.0, 1.0 if math.isclose(first.value, second.value, rel_tol=1e-9, abs_tol=1e-12) else 0.0
    return error, float(2.0 * ndtr(-abs(change) / pooled))


def _two_proportions(first: float, second: float, n: int, m: int) -> tuple[float, float]:
    """Standard error of the difference of two proportions, and the pooled one of the test that they are equal.

    Fleiss, Levin & Paik 2003, Statistical Methods for Rates and Proportions, ch. 3.
    """
    if n < 1 or m < 1:
        return math.nan, math.nan
    share = (n * first + m * second) / (n + m)
    own = math.sqrt(first * (1.0 - first) / n + second * (1.0 - second) / m)
    return own, math.sqrt(max(share * (1.0 - share), 0.0) * (1.0 / n + 1.0 / m))


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values so that the chance of any false finding stays at the level.

    Step-down procedure of Holm 1979, A simple sequentially rejective multiple test procedure, Scand. J. Statist. 6,
    65–70.
    """
    order = np.argsort(p_values)
    factors = np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(factors * np.asarray(p_values, dtype=float)[order]), 1.0)
    return [float(value) for value in adjusted]
