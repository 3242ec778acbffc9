"""Numbers and words as people read them.

Numbers are rounded to what their standard error supports, with one minus sign and thin spaces; words are those of
things, lists and names of quantities, and how texts are set.
"""

import math
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from types import MappingProxyType
from typing import TypeVar

from missionplan.montecarlo.statistics import Probability

NARROW_SPACE, MINUS = "\u202f", "\u2212"
_LEAST_SPREAD = 3e-5
"""Spread over the value below which it is left out: no model of a vehicle is true to five digits."""

_SUFFIXES = {"_m_s": "m/s", "_wh": "W*h", "_s": "s", "_m": "m", "_n": "N", "_kg": "kg", "_rad": "rad", "_deg": "deg"}


def split_key(key: str) -> tuple[str, str]:
    """Split ``offset_m`` into the quantity and its unit: ``('offset', 'm')``."""
    for suffix, unit in _SUFFIXES.items():
        if key.endswith(suffix):
            return key.removesuffix(suffix), unit
    return key, ""


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


def significant(value: float, sd: float) -> str:
    """Round a value to two significant figures of its standard deviation."""
    if not math.isfinite(sd) or sd <= 0.0:
        return f"{value:.4g}"
    digits = 1 - math.floor(math.log10(sd))
    return f"{value:.{min(digits, 9)}f}" if digits > 0 else f"{round(value, digits):.0f}"


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
    while any(float(f"{end:.{decimals}f}") in (0.0, 100.0) for end in (low, high) if 1e-6 < end < 100.0):
        decimals += 1  # what was seen, or not always, is not said to be impossible, or certain
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


def portion_in_words(portion: float, decimals: int = 0) -> str:
    """Write a part of a whole, rounded neither to nothing nor to all of it: ``76 %``, ``< 1 %``."""
    least = 10.0**-decimals
    if 0.0 < portion < 1.0 and not 0.005 * least < portion < 1.0 - 0.005 * least:
        return f"< {least:g} %" if portion < 0.5 else f"> {100.0 - least:g} %"
    return f"{100.0 * portion:.{decimals}f} %"


def beside(portion: float, limit: float) -> str:
    """Write a part of a whole beside what it is held to, with the decimals that tell them apart: ``89.96 %``."""
    alike = (places for places in range(1, 6) if f"{100.0 * portion:.{places}f}" != f"{100.0 * limit:.{places}f}")
    return portion_in_words(portion, next(alike, 1))


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


_NO_BREAK_SPACE = "\u00a0"
_UNITS = (
    r"%|°|°C|m|km|mm|cm|ft|nmi|m²|m³|s|ms|min|h|days?|m/s|cm/s|km/h|kn|N|mN|kN|g|kg|W|kW|J|kJ|V|A|Hz|Pa|L|rad|deg|"
    r"W\u202fh|kW\u202fh|rev/s|rpm|nats?|m/s²|kg/m³|N\u202fm|N\u202fs"
)

_RULES: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"\b(k?)W(?:h|[*·]h| h)\b"), rf"\1W{NARROW_SPACE}h"),
    (re.compile(r"\bN\*(?=[ms]\b)"), f"N{NARROW_SPACE}"),
    (re.compile(r"\^2\b"), "²"),
    (re.compile(r"\^3\b"), "³"),
    (re.compile(r"/(\w+)\*\*0\.5\b"), r"/√\1"),
    (re.compile(r"\bdegC\b"), "°C"),
    (re.compile(rf"\[((?:{_UNITS})(?:/(?:m|s|N|V))?)\]"), r"(\1)"),
    (re.compile(r"\(deg\)"), "(°)"),
    (re.compile(r"(?<![\w.)\]\u2013\u202f\u00a0/:=−-])-(?=\d|\.\d)"), MINUS),
    (re.compile(rf"(?<=\d)[ {_NO_BREAK_SPACE}](?:°(?!\w)|deg\b)"), "°"),
    (re.compile(r"(?<=\d\d) (?=UTC\b)"), _NO_BREAK_SPACE),
    (re.compile(r"[−-](?=0(?:\.0+)?(?![\d.]))(?<![\w)−-].)"), ""),
    (re.compile(r"(?<=\d)\u00a0(?=\d{3}(?!\d))"), NARROW_SPACE),
    (re.compile(rf"(?<=\d) (?=(?:{_UNITS})(?![\w²³]))"), _NO_BREAK_SPACE),
    (re.compile(r"(?<=[\d°]) (?=±)|(?<=±) (?=[\d−])"), _NO_BREAK_SPACE),
    (
        re.compile(r"(?<=\d)e([-+−])0*(\d+)(?![\w.])"),
        lambda match: f"·10{raised((match[1] + match[2]).removeprefix('+'))}",
    ),
)
_LONG_WHOLE = re.compile(r"(?<![\w.,:/=\u202f#-])[1-9]\d{4,}(?![\w:/-]|\.\d{5})")

_GROUPS = re.compile(r"(?<=\d)(?=(?:\d{3})+$)")


def typeset(text: str) -> str:
    """Set a sentence, a heading or the cell of a table."""
    for pattern, replacement in _RULES:
        text = pattern.sub(replacement, text)
    return _LONG_WHOLE.sub(lambda match: _GROUPS.sub(NARROW_SPACE, match[0]), text)


def wrapped(sentence: str, width: int) -> str:
    """Break a sentence into lines, at ordinary spaces alone."""
    return textwrap.fill(sentence, max(width, 20), break_long_words=False, break_on_hyphens=False)


_PHRASES = {
    "velocity_error.along": "velocity error along the track",
    "velocity_error.across": "velocity error across the track",
    "fix_error.along": "error of the fix along the track",
    "fix_error.across": "error of the fix across the track",
    "arrived": "arrival",
    "d_max": "maximum leg length",
    "within_radius": "anchor within the radius",
    "struck_seafloor": "strike on the seafloor",
    "offset": "offset of the anchor",
    "lowest_altitude": "lowest altitude of the nose",
    "total.success": "success of the mission",
    "posterior": "which explanation holds",
    "site.current.member": "which member of the current's ensemble",
    "anchor_holds": "anchor that holds",
    "grounded": "vehicle touching the seafloor in the hold",
    "nose_altitude": "least altitude of the nose in the hold",
    "excursion": "radius of the watch circle",
    "line_tension": "greatest line tension in the hold",
    "snatch_tension": "peak tension of the snatch",
    "nose_down_time": "time from the taut line to nose down",
    "depth_lost": "depth lost in the pitch-over",
    "line_parts": "parting of the line",
    "energy.hotel": "hotel load",
    "energy.propulsive_efficiency": "propulsive efficiency",
    "energy.surfacing": "energy of a surfacing",
    "energy.capacity": "energy in the battery",
    "touchdown_speed": "speed at touchdown",
    "holding_margin": "least holding margin of the anchor",
}
"""Quantities and events of a phase whose names do not read as phrases."""
_POINT_OR_UNDERSCORE = re.compile(r"\.(?!\d)|_")
_EXPLAINED = re.compile(r"effects\[\d+\]\.one-of(?:\[(\d+)\]\.(.+))?")
_LONGEST_NAME = 48
"""Characters of a name."""
_PLACE = re.compile(r"phases\[(\d+)\]")
_READS_WELL = re.compile(rf"[\w .,:;'’/+–-]{{1,{_LONGEST_NAME}}}")
"""Names of phases that tables and figures show as they are."""
Value = TypeVar("Value")
_names: ContextVar[Mapping[str, str]] = ContextVar("names", default=MappingProxyType({}))
_WHOLES = ("vehicle", "site", "start", "total", "monte_carlo", "requirements", "energy")
"""First parts of a dotted name that are no phase and read well before the rest: ``vehicle net buoyancy``."""


def in_words(name: str) -> str:
    """Write a dotted name in words: ``release time (moor)``, ``current speed in layer 2``, ``total energy``."""
    quantity = split_key(name)[0]
    explained = _EXPLAINED.fullmatch(quantity)
    if explained:
        number, parameter = explained.groups()
        return f"{_spaced(parameter)} (explanation {int(number) + 1})" if parameter else "which explanation holds"
    for root in ("effects.", "navigation."):
        if quantity.startswith(root):
            return _spaced(quantity.removeprefix(root))
    if quantity.startswith("site.current["):
        layer, _, rest = quantity.removeprefix("site.current[").partition("].")
        return f"current {rest} in layer {int(layer) + 1}"
    phase, _, phase_quantity = quantity.partition(".")
    if not phase_quantity:
        return _PHRASES.get(quantity, _spaced(quantity))
    if phase.partition("[")[0] in _WHOLES:
        return _PHRASES.get(quantity, _spaced(quantity))
    return of_phase(phase_quantity, phase)


def of_phase(quantity: str, phase: str) -> str:
    """Write a quantity of a phase in words: ``release time (moor)``."""
    return f"{_PHRASES.get(quantity, _spaced(quantity))} ({phase_in_words(phase)})"


@contextmanager
def setting(variable: ContextVar[Value], value: Value) -> Iterator[None]:
    """Set a variable while the context lasts."""
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)


def phases_named(names: Mapping[str, str]) -> AbstractContextManager[None]:
    """Write phases by their names where their places stand for them in key paths, such as ``phases[1]``."""
    return setting(_names, {place: name for place, name in names.items() if _READS_WELL.fullmatch(name)})


def phase_in_words(phase: str) -> str:
    """Write what stands for a phase in key paths: its name, or ``phase 2`` where only its place, ``phases[1]``, is."""
    place = _PLACE.fullmatch(phase)
    return _names.get().get(phase, f"phase {int(place[1]) + 1}") if place else phase


def shortened(name: str) -> str:
    """Return a name as figures, tables and terminals show it: on one line, cut where it is long."""
    words = " ".join(name.split())
    return words if len(words) <= _LONGEST_NAME else f"{words[: _LONGEST_NAME - 1]}…"


def listed(words: Sequence[str], last: str = "and") -> str:
    """Write ``one, two and three``; nothing for no words."""
    return f"{', '.join(words[:-1])} {last} {words[-1]}" if len(words) > 1 else "".join(words)


def keys_in_words(keys: Sequence[str]) -> str:
    """Write keys that take the same value: ``speed (ingress, egress)``."""
    names = [in_words(key) for key in keys]
    parts = [name.partition(" (") for name in names]
    if len(names) > 1 and all(phase for *_, phase in parts) and len({what for what, *_ in parts}) == 1:
        return f"{parts[0][0]} ({', '.join(phase.removesuffix(')') for *_, phase in parts)})"
    return " and ".join(names)


def parameter_in_words(effect: str, name: str) -> str:
    """Name a parameter of an effect: ``angle of compass bias``."""
    return f"{_spaced(name)} of {effect.replace('-', ' ')}"


def _spaced(name: str) -> str:
    return _POINT_OR_UNDERSCORE.sub(" ", name)


def capitalised(words: str) -> str:
    """Write the first letter as a capital and leave the rest."""
    return words[:1].upper() + words[1:]
