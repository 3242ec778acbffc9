"""The lightest anchor that reaches a probability, or why there is none and how long a line would do."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from missionplan.results.anchor import DiveProbabilities

_HEAVIEST = 10.0
"""Times the worst-case anchor, which sinks three times as fast: what drifts too far then drifted before."""
_LONGEST = 20.0
"""Times the given line."""

ProbabilitiesOf = Callable[[float, float | None], DiveProbabilities]
"""Probabilities of a wet weight [N] with a line [m], None for the mission's own."""


@dataclass(frozen=True)
class Found:
    """Outcome of the search.

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


def lightest_anchor(probabilities: ProbabilitiesOf, required: float, start: float, line_length: float) -> Found:
    """Search wet weights for the lightest that reaches a probability.

    On common random numbers the share of trials within the radius only rises with the weight, and so does the share
    of trials that strike; so the lightest candidate is where the first reaches the probability, and from there on the
    second is all that can spoil it.

    Parameters
    ----------
    probabilities : ProbabilitiesOf
    required : float
        P(within the radius and not struck).
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
        reason += f"; no line up to {_LONGEST:g} times as long mends it"
    return Found(None, first.best, reason, line, weight)


def _lightest(
    probabilities: ProbabilitiesOf, required: float, start: float, line: float | None, resolution: float = 1.001
) -> Found:
    """Lightest weight, to a ratio, with one line; neither weight nor reason where striking is what fails."""
    heaviest = start * _HEAVIEST
    if probabilities(heaviest, line).within.value < required:
        share = probabilities(heaviest, line).within.value
        words = (
            f"even an anchor of {heaviest:.0f} N comes down within the radius in {100 * share:.1f} % of dives: "
            "the drift before the line is taut takes the rest"
        )
        return Found(None, share, words)
    light = _bisect(
        lambda weight: probabilities(weight, line).within.value >= required, start / _HEAVIEST, heaviest, resolution
    )
    best, weight = 0.0, light
    while weight <= heaviest:
        found = probabilities(weight, line)
        best = max(best, found.good.value)
        if found.good.value >= required:
            break
        if 1.0 - found.struck.value < required:
            return Found(None, best)
        weight *= 1.02
    if weight > light:
        weight = _bisect(
            lambda value: probabilities(value, line).good.value >= required, weight / 1.02, weight, resolution
        )
    return Found(weight, probabilities(weight, line).good.value)


def _shortest_line(
    probabilities: ProbabilitiesOf, required: float, start: float, given: float
) -> tuple[float | None, float | None]:
    weights: dict[float, float] = {}

    def does(length: float) -> bool:
        found = _lightest(probabilities, required, start, length, 1.02)
        if found.weight is not None:
            weights[length] = found.weight
        return found.weight is not None

    long = given
    while not does(long):
        long *= 1.25
        if long > given * _LONGEST:
            return None, None
    line = _bisect(does, long / 1.25, long, 1.02)
    return line, weights[line]


def _bisect(does: Callable[[float], bool], low: float, high: float, resolution: float) -> float:
    """Least value, to a ratio, for which a condition that stays true once it is holds; it holds at `high`."""
    while high / low > resolution:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if does(middle) else (middle, high)
    return high
