"""The lightest anchor that reaches a probability, or why there is none and how long a line would do."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from missionplan.results.mooring.sized_anchor import DiveProbabilities

MAX_WEIGHT_RATIO = 10.0
"""Heaviest anchor tried over the worst-case one; it sinks three times as fast, so that drift before the descent is
what is left."""
MAX_LINE_RATIO = 20.0
"""Longest line tried over the given one."""
WEIGHT_STEP = 1.02
"""Ratio of the weights tried where heavier anchors strike more often."""

ProbabilitiesOf = Callable[[float, float | None], DiveProbabilities]
"""Probabilities of a wet weight [N] with a line [m], None for the mission's own."""


@dataclass(frozen=True)
class LightestAnchor:
    """Result of the search.

    Attributes
    ----------
    weight : float or None
        Lightest wet weight that reaches the probability [N].
    best : float
        Highest probability found.
    reason : str
        Why none reaches it; empty otherwise.
    line_length, line_weight : float or None
        Shortest line with which an anchor does, and the anchor's wet weight [m, N].
    """

    weight: float | None
    best: float
    reason: str = ""
    line_length: float | None = None
    line_weight: float | None = None


def lightest_anchor(
    probabilities: ProbabilitiesOf, required: float, start: float, line_length: float
) -> LightestAnchor:
    """Search wet weights for the lightest that reaches a probability.

    On common random numbers (Law 2015, Simulation Modeling and Analysis, sect. 11.2) the share of trials within the
    radius, and that of anchors that hold, only rise with the weight, and so does the share of trials that strike. The
    lightest candidate is therefore the weight at which the first two reach the probability; from there on only strikes
    can prevent it.

    Parameters
    ----------
    probabilities : ProbabilitiesOf
    required : float
        P(within the radius, not struck, and holding where that counts).
    start : float
        Wet weight to begin with, such as the worst case's [N].
    line_length : float
        The mission's [m].
    """
    first = _lightest(probabilities, required, start, None)
    if first.weight is not None or first.reason:
        return first
    reason = (
        f"an anchor heavy enough for the radius drives the vehicle into the seafloor: at best "
        f"{100 * first.best:.1f} % of dives stay within the radius and do not strike"
    )
    line, weight = _shortest_line(probabilities, required, start, line_length)
    if line is None:
        reason += f"; no line up to {MAX_LINE_RATIO:g} times as long prevents it"
    return LightestAnchor(None, first.best, reason, line, weight)


def _lightest(
    probabilities: ProbabilitiesOf, required: float, start: float, line: float | None, resolution: float = 1.001
) -> LightestAnchor:
    """Lightest weight, to a ratio, with one line; neither weight nor reason where strikes prevent it."""
    heaviest = start * MAX_WEIGHT_RATIO
    heavy = probabilities(heaviest, line)
    share = heavy.enough.value
    if share < required:
        reason = f"even an anchor of {heaviest:.0f} N "
        if heavy.within.value < required:
            reason += (
                f"comes down within the radius in {100 * heavy.within.value:.1f} % of dives: the drift before the "
            )
            reason += "line is taut takes the rest"
        else:
            reason += f"comes down within the radius and holds in {100 * share:.1f} % of dives"
        return LightestAnchor(None, share, reason)

    def is_heavy_enough(weight: float) -> bool:
        return probabilities(weight, line).enough.value >= required

    def is_good(weight: float) -> bool:
        return probabilities(weight, line).good.value >= required

    light = _bisect(is_heavy_enough, start / MAX_WEIGHT_RATIO, heaviest, resolution)
    best, weight = 0.0, light
    while weight <= heaviest:
        found = probabilities(weight, line)
        best = max(best, found.good.value)
        if found.good.value >= required:
            break
        if 1.0 - found.struck.value < required:
            return LightestAnchor(None, best)
        weight *= WEIGHT_STEP
    if weight > light:
        weight = _bisect(is_good, weight / WEIGHT_STEP, weight, resolution)
    return LightestAnchor(weight, probabilities(weight, line).good.value)


def _shortest_line(
    probabilities: ProbabilitiesOf, required: float, start: float, given: float
) -> tuple[float | None, float | None]:
    """Shortest line with which an anchor reaches the probability, and its wet weight; None where none does."""
    weights: dict[float, float] = {}

    def is_enough(length: float) -> bool:
        found = _lightest(probabilities, required, start, length, 1.02)
        if found.weight is not None:
            weights[length] = found.weight
        return found.weight is not None

    length = given
    while not is_enough(length):
        length *= 1.25
        if length > given * MAX_LINE_RATIO:
            return None, None
    shortest = _bisect(is_enough, length / 1.25, length, 1.02)
    return shortest, weights[shortest]


def _bisect(holds: Callable[[float], bool], low: float, high: float, resolution: float) -> float:
    """Least value, to a ratio, at which a condition holds that holds at `high` and above that value.

    Bisection of the logarithm (Press et al. 2007, Numerical Recipes, sect. 9.1).
    """
    while high / low > resolution:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
