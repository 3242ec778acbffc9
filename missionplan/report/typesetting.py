"""How text that people read is set: one minus sign, one spelling of units, nothing torn at a line's end.

Numbers are rounded where they are written (`numbers`); here their signs, groups and units get the same form everywhere.
"""

import re
import textwrap
from collections.abc import Callable

from missionplan.report.numbers import raised

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
