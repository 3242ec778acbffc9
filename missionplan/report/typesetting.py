"""How text that people read is set: one minus sign, one spelling of units, nothing torn at a line's end.

Numbers are rounded where they are written (`numbers`); here their signs, groups and units get the same form everywhere.
"""

import json
import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import replace

from missionplan.report.drawn import Drawn
from missionplan.report.page import Block, Figure, Listing, Page, PageSection, Table, Terminal

Words = Callable[[str], str]
"""Sets a text, or converts it."""

_NARROW_SPACE, _NO_BREAK_SPACE, _MINUS = "\u202f", "\u00a0", "\u2212"
_UNITS = (
    r"%|°|°C|m|km|mm|cm|ft|nmi|m²|m³|s|ms|min|h|days?|m/s|cm/s|km/h|kn|N|mN|kN|g|kg|W|kW|J|kJ|V|A|Hz|Pa|L|rad|deg|"
    r"W\u202fh|kW\u202fh|rev/s|rpm|nats?|m/s²|kg/m³|N\u202fm|N\u202fs"
)
_SUPERSCRIPTS = str.maketrans("-−+0123456789", "⁻⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹")


def _raised(exponent: str) -> str:
    """Write an exponent in superscripts: ``⁻⁶``."""
    return exponent.removeprefix("+").translate(_SUPERSCRIPTS)


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
    (re.compile(r"(?<=\d)e([-+−])0*(\d+)(?![\w.])"), lambda found: f"·10{_raised(found[1] + found[2])}"),
)
_LONG_WHOLE = re.compile(r"(?<![\w.,:/=\u202f#-])[1-9]\d{4,}(?![\w:/-]|\.\d{5})")

_GROUPS = re.compile(r"(?<=\d)(?=(?:\d{3})+$)")


def typeset(text: str) -> str:
    """Set a sentence, a heading or the cell of a table."""
    for pattern, replacement in _RULES:
        text = pattern.sub(replacement, text)
    return _LONG_WHOLE.sub(lambda found: _GROUPS.sub(_NARROW_SPACE, found[0]), text)


def typeset_page(page: Page, words: Words = typeset) -> Page:
    """Set the texts of a page; listings stay as a program takes them."""
    return replace(
        page,
        title=words(page.title),
        answer=words(page.answer),
        figure=_figure(page.figure, words) if page.figure else None,
        numbers=[(words(label), words(value)) for label, value in page.numbers],
        sections=[typeset_section(section, words) for section in page.sections],
    )


def typeset_section(section: PageSection, words: Words = typeset) -> PageSection:
    """Set the texts of a section."""
    return replace(section, heading=words(section.heading), blocks=[_block(block, words) for block in section.blocks])


def typeset_terminal(shown: Terminal, words: Words = typeset) -> Terminal:
    """Set the texts of a terminal's view."""
    columns, rows = _cells(shown.columns, words), _rows(shown.rows, words)
    return replace(shown, sentence=words(shown.sentence), columns=columns, rows=rows)


def wrapped(sentence: str, width: int) -> str:
    """Break a sentence into lines, at ordinary spaces alone."""
    return textwrap.fill(sentence, max(width, 20), break_long_words=False, break_on_hyphens=False)


def _block(block: Block, words: Words) -> Block:
    if isinstance(block, Listing):
        return block
    if isinstance(block, Figure):
        return _figure(block, words)
    if isinstance(block, Table):
        columns, rows = _cells(block.columns, words), _rows(block.rows, words)
        return replace(block, columns=columns, rows=rows, caption=words(block.caption))
    return words(block)


def _figure(figure: Figure, words: Words) -> Figure:
    svg = re.sub(r"(?<=>)([^<>]*\S[^<>]*)(?=</t(?:ext|span)>)", lambda found: words(found[1]), figure.svg)
    drawing = Drawn(svg, _plot(figure.plot, words))
    return replace(figure, drawing=drawing, alt=words(figure.alt), caption=words(figure.caption))


def _plot(plot: str, words: Words) -> str:
    """Set the names and texts that the page's script shows."""

    def kept(found: dict[str, object]) -> dict[str, object]:
        for key in ("name", "label"):
            if isinstance(text := found.get(key), str):
                found[key] = words(text)
        if isinstance(texts := found.get("text"), list):
            found["text"] = [words(text) for text in texts]
        return found

    return json.dumps(json.loads(plot, object_hook=kept), ensure_ascii=False, separators=(",", ":")) if plot else ""


def _cells(cells: Sequence[str], words: Words) -> list[str]:
    return [words(cell) for cell in cells]


def _rows(rows: Sequence[Sequence[str]], words: Words) -> list[list[str]]:
    return [_cells(row, words) for row in rows]
