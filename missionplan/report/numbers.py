"""Numbers as people read them: rounded to what their standard error supports, with one minus sign and thin spaces."""

import math

from missionplan.montecarlo.statistics import Probability

NARROW_SPACE, MINUS = "\u202f", "\u2212"
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
    return set_number(text)


def set_number(text: str) -> str:
    """Set a number: a minus sign, none before zero, thin spaces between groups of three, powers of ten raised."""
    number, _, exponent = text.partition("e")
    sign = number[:1] if number[:1] in "+-" else ""
    whole, point, rest = number.removeprefix(sign).partition(".")
    if len(whole) > 4 and whole.isdigit():
        whole = f"{int(whole):,}".replace(",", NARROW_SPACE)
    if sign == "-":
        sign = MINUS if float(text) else ""
    power = f"·10{raised(str(int(exponent)))}" if exponent else ""
    return f"{sign}{whole}{point}{rest}{power}"


def raised(exponent: str) -> str:
    """Write an exponent in superscripts: ``⁻⁶``."""
    return exponent.translate(str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
