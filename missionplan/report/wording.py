"""Words of reports: numbers of things, lists, names of quantities; and how texts are set."""

import re
import textwrap
from collections.abc import Callable, Sequence

from missionplan.report.numbers import raised
from missionplan.report.quantities import split_key

_NARROW_SPACE, _NO_BREAK_SPACE, _MINUS = "\u202f", "\u00a0", "\u2212"
_UNITS = (
    r"%|°|°C|m|km|mm|cm|ft|nmi|m²|m³|s|ms|min|h|days?|m/s|cm/s|km/h|kn|N|mN|kN|g|kg|W|kW|J|kJ|V|A|Hz|Pa|L|rad|deg|"
    r"W\u202fh|kW\u202fh|rev/s|rpm|nats?|m/s²|kg/m³|N\u202fm|N\u202fs"
)

_RULES: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"\b(k?)W(?:h|[*·]h| h)\b"), rf"\1W{_NARROW_SPACE}h"),
    (re.compile(r"\^2\b"), "²"),
    (re.compile(r"\^3\b"), "³"),
    (re.compile(r"\bdegC\b"), "°C"),
    (re.compile(rf"\[((?:{_UNITS})(?:/(?:m|s|N|V))?)\]"), r"(\1)"),
    (re.compile(r"\(deg\)"), "(°)"),
    (re.compile(r"(?<![\w.)\]\u2013\u202f\u00a0/:=−-])-(?=\d|\.\d)"), _MINUS),
    (re.compile(rf"(?<=\d)[ {_NO_BREAK_SPACE}](?:°(?!\w)|deg\b)"), "°"),
    (re.compile(r"(?<=\d\d) (?=UTC\b)"), _NO_BREAK_SPACE),
    (re.compile(r"[−-](?=0(?:\.0+)?(?![\d.]))(?<![\w)−-].)"), ""),
    (re.compile(r"(?<=\d)\u00a0(?=\d{3}(?!\d))"), _NARROW_SPACE),
    (re.compile(rf"(?<=\d) (?=(?:{_UNITS})(?![\w²³]))"), _NO_BREAK_SPACE),
    (re.compile(r"(?<=[\d°]) (?=±)|(?<=±) (?=[\d−])"), _NO_BREAK_SPACE),
    (
        re.compile(r"(?<=\d)e([-+−])0*(\d+)(?![\w.])"),
        lambda found: f"·10{raised((found[1] + found[2]).removeprefix('+'))}",
    ),
)
_LONG_WHOLE = re.compile(r"(?<![\w.,:/=\u202f#-])[1-9]\d{4,}(?![\w:/-]|\.\d{5})")

_GROUPS = re.compile(r"(?<=\d)(?=(?:\d{3})+$)")


def typeset(text: str) -> str:
    """Set a sentence, a heading or the cell of a table."""
    for pattern, replacement in _RULES:
        text = pattern.sub(replacement, text)
    return _LONG_WHOLE.sub(lambda found: _GROUPS.sub(_NARROW_SPACE, found[0]), text)


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
    phase, _, own = quantity.partition(".")
    if not own:
        return _PHRASES.get(quantity, _spaced(quantity))
    if phase.partition("[")[0] in _WHOLES:
        return _PHRASES.get(quantity, _spaced(quantity))
    return f"{_PHRASES.get(own, _spaced(own))} ({phase_in_words(phase)})"


def phase_in_words(phase: str) -> str:
    """Write what stands for a phase in key paths: its name, or ``phase 2`` where that is its place, ``phases[1]``."""
    place = _PLACE.fullmatch(phase)
    return f"phase {int(place[1]) + 1}" if place else phase


def shortened(name: str) -> str:
    """Return a name as figures, tables and terminals show it: on one line, cut where it is long."""
    words = " ".join(name.split())
    return words if len(words) <= _LONGEST_NAME else f"{words[: _LONGEST_NAME - 1]}…"


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
