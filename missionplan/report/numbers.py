"""Numbers as people read them: rounded to what their standard error supports."""

import math

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.report.display_units import Unit

NARROW_SPACE = "\u202f"


_LEAST_SPREAD = 3e-5
"""Spread over the value below which it is left out: no model of a vehicle is true to five digits."""


def has_spread(value: float, spread: float) -> bool:
    """Whether a spread or an error is large enough to be told."""
    return math.isfinite(spread) and spread > _LEAST_SPREAD * abs(value)


def number(value: float, error: float = 0.0) -> str:
    """Write a number with the digits that its standard error supports; four where it has none but rounding.

    The last digit shown stands in the place of the error's first digit, or of its second where the first is 1.
    """
    if not math.isfinite(value):
        return "–"
    if not has_spread(value, error):
        return _grouped(value, max(0, 3 - _exponent(value)) if value else 0, strip=True)
    return _grouped(value, _decimals(error))


def rounded_up(value: float) -> float:
    """Round to three digits, never to less."""
    if not math.isfinite(value) or value == 0.0:
        return value
    decimals = 2 - _exponent(value)
    nearest = round(value, decimals)
    return nearest if nearest >= value else round(nearest + 10.0**-decimals, decimals)


def rounded_down(value: float) -> float:
    """Round to three digits, never to more."""
    return -rounded_up(-value)


def with_error(value: float, error: float, unit: Unit) -> str:
    """Write ``21.3 ± 0.4 ft``; `value` and `error` in the key's unit."""
    value, error = unit(value), unit(error)
    if not math.isfinite(value):
        return "–"
    if not has_spread(value, error):
        return number(value) + unit.suffix
    return f"{number(value, error)}\u00a0±\u00a0{_grouped(error, _decimals(error))}{unit.suffix}"


def length_in_words(metres: float) -> str:
    """Write ``747 m`` or ``1.26 km``."""
    return f"{metres / 1000.0:.2f}\u00a0km" if metres >= 1000.0 else f"{metres:.0f}\u00a0m"


def time_in_words(seconds: float) -> str:
    """Write ``85 s`` or ``18.2 min``."""
    return f"{seconds:.0f}\u00a0s" if seconds < 90.0 else f"{seconds / 60.0:.1f}\u00a0min"


def span(statistic: Statistic, unit: Unit) -> tuple[str, str, str]:
    """Write the 5, 50 and 95 % points with the digits that their errors support and their spread needs.

    The standard error of the 5 % and 95 % points of a normal sample is 2.1 times the mean's.
    """
    digits = unit(max(0.2 * statistic.sd, 2.1 * statistic.standard_error))
    low, middle, high = (number(unit(value), digits) for value in (statistic.p05, statistic.p50, statistic.p95))
    return low, middle, high


def percent(probability: Probability) -> str:
    """Write a probability with its 95 % interval: ``87.0 ± 0.7 %``, or the interval itself near 0 and 1."""
    value, low, high = (100.0 * part for part in (probability.value, probability.low, probability.high))
    if not math.isfinite(value):
        return "–"
    half = 0.5 * (high - low)
    if half == 0.0 and value in (0.0, 100.0):  # certain: computed, not counted in trials
        return f"{value:.0f}\u00a0%"
    decimals = max(0, _decimals(half)) if half > 0.0 else 1
    if min(value, 100.0 - value) > 3.0 * half:
        return f"{value:.{decimals}f}\u00a0±\u00a0{half:.{decimals}f}\u00a0%"
    if value in (0.0, 100.0):
        bound = f"at least {_towards(low, -1)}" if value else f"at most {_towards(high, 1)}"
        return f"{value:.0f}\u00a0% ({bound}\u00a0%)"
    return f"{value:.{decimals}f}\u00a0% ({low:.{decimals}f} to {high:.{decimals}f}\u00a0%)"


def share(probability: Probability) -> str:
    """Write a probability without its interval, never rounded to certainty: ``76 %``."""
    value, half = 100.0 * probability.value, 50.0 * (probability.high - probability.low)
    if value in (0.0, 100.0) or not math.isfinite(value):
        return f"{value:.0f}\u00a0%" if math.isfinite(value) else "–"
    decimals = max(0, _decimals(half)) if half > 0.0 else 1
    while float(f"{value:.{decimals}f}") in (0.0, 100.0):
        decimals += 1
    return f"{value:.{decimals}f}\u00a0%"


def _towards(value: float, direction: int) -> str:
    """Round a bound outwards at the first digit of its distance from 0 or 100."""
    decimals = max(0, _decimals(min(value, 100.0 - value)))
    scale = 10.0**decimals
    return f"{(math.floor if direction < 0 else math.ceil)(value * scale) / scale:.{decimals}f}"


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _decimals(error: float) -> int:
    first = _exponent(error)
    return -first + (1 if error < 1.95 * 10.0**first else 0)


def _grouped(value: float, decimals: int, *, strip: bool = False) -> str:
    """Fixed point with `decimals` (negative: rounded before the point), groups of three from 10 000 on."""
    text = f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"
    if strip and "." in text:
        text = text.rstrip("0").rstrip(".")
    whole, point, rest = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", NARROW_SPACE)
    sign = "−" if text.startswith("-") and float(text) != 0.0 else ""
    return sign + whole + point + rest
