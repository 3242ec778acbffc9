"""Find the module that presents a result, and render the result with it: as a page, for a terminal, as plots.

A result at a glance, on a terminal and in a notebook, and all the ways in which `rendering` knows it is shown.
"""

import base64
import io
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from markupsafe import Markup
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.errors import counted
from missionplan.mission.quantity_paths import written_phases
from missionplan.rendering import Plot, Rendered
from missionplan.report.axes import draw_in_units
from missionplan.report.explained import with_assumptions
from missionplan.report.html import render_page
from missionplan.report.page import Block, Drawing, Figure, Listing, Page, PageSection, Table, Terminal, style
from missionplan.report.planned import changed, planned_sections
from missionplan.report.quantities import in_reader_units, reading_in, units_of
from missionplan.report.wording import phases_named, typeset, wrapped
from missionplan.results import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class ReportModule(Protocol):
    """What each module named by `Result.report` has."""

    def page(self, result: Result, /) -> Page:
        """List all that a result shows."""


@contextmanager
def shown_as_asked(result: Result) -> Iterator[None]:
    """Draw in the style of the reports, and write quantities in the units of the run, or of the result's mission."""
    with style(), read_as(result, units_of(result.provenance.data)):
        yield


@contextmanager
def read_as(result: Result, system: str) -> Iterator[None]:
    """Write quantities in a system of units, and phases by the names that the result's mission gives them."""
    with reading_in(system), phases_named({phase.key: phase.name for phase in written_phases(result.provenance.data)}):
        yield


def render_report(result: Result, /) -> Rendered:
    """Render a result as one self-contained page, its figures, and files for other programs."""
    made = result.provenance
    with shown_as_asked(result):
        page = typeset_page(_page(result))
        planned = [
            *changed(made.data, result.recommended_values),
            *planned_sections(made, mapped="tracks" in page.plots),
        ]
        return render_page(page, _sections(planned), made, notices_of(result))


def notices_of(result: Result) -> list[str]:
    """Write a result's notices in the reader's units."""
    with read_as(result, units_of(result.provenance.data)):
        return [typeset(in_reader_units(notice)) for notice in result.provenance.notices]


def terminal_view(result: Result, *, system: str | None = None) -> Terminal:
    """Present a result for a terminal, in the units of the run or the mission, or of a system that is given."""
    with read_as(result, units_of(result.provenance.data) if system is None else system):
        page = _page(result)
        columns, rows = page.table()
    cells = [_cells(row) for row in rows]
    return Terminal(typeset(page.sentence or page.answer), _cells(columns), cells, page.verdict)


def headline(result: Result, /) -> str:
    """Write the answer in a sentence or two, in the units of the mission file, whatever the reader's are."""
    return terminal_view(result, system="").sentence


def drawings_of(result: Result) -> Mapping[str, Drawing]:
    """Return the drawings of a result by name, the main one first; none where it has none."""
    with read_as(result, units_of(result.provenance.data)):
        return _page(result).plots


def plots(result: Result, /) -> dict[str, Plot]:
    """Return the plots of a result by name, the main one first."""
    return {name: partial(_plot, result, draw) for name, draw in drawings_of(result).items()}


def _plot(result: Result, draw: Drawing, *, ax: "Axes | None" = None, **options: object) -> "Axes":
    """Draw on axes, or on new ones of pyplot's, in the style of the reports."""
    from matplotlib.text import Text

    with shown_as_asked(result):
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
        others = set(ax.figure.axes) - {ax}
        draw(ax, result, **options)
        draw_in_units(axes for axes in ax.figure.axes if axes not in others)
        for text in ax.findobj(Text):  # of axes made elsewhere: a name may hold a `$`
            text.set_parse_math("\\mathdefault" in text.get_text())
    return ax


def _page(result: Result) -> Page:
    return with_assumptions(cast(ReportModule, import_module(result.report)).page(result), result.assumed)


def typeset_page(page: Page) -> Page:
    """Set the texts of a page; listings stay as a program takes them."""
    return replace(
        page,
        title=typeset(page.title),
        answer=typeset(page.answer),
        draw=lambda: _figure(page.figure) if page.figure else None,
        numbers=[(typeset(label), typeset(value)) for label, value in page.numbers],
        write=lambda: _sections(page.sections),
    )


def _sections(sections: Iterable[PageSection]) -> list[PageSection]:
    return [
        replace(section, heading=typeset(section.heading), blocks=[_block(block) for block in section.blocks])
        for section in sections
    ]


def _block(block: Block) -> Block:
    if isinstance(block, Listing):
        return block
    if isinstance(block, Figure):
        return _figure(block)
    if isinstance(block, Table):
        rows = [_cells(row) for row in block.rows]
        return replace(block, columns=_cells(block.columns), rows=rows, caption=typeset(block.caption))
    return typeset(block)


def _figure(figure: Figure) -> Figure:
    return replace(figure, alt=typeset(figure.alt), caption=typeset(figure.caption))


def _cells(cells: Sequence[str]) -> list[str]:
    return [typeset(cell) for cell in cells]


GAP = 2
"""Spaces between columns."""
_LEAST_FIRST = 32
"""Characters that the first column keeps beside several others, where it has them."""
_LONGEST_CELL = 24
"""Characters of a cell that is not broken."""
_SPACES = re.compile(r"(?<= )(?=\S)")
_BREAKS = re.compile(r"(?<=[ _./-])(?<!\d\.)(?=\S)")
"""Where a word may be broken: after a space, an underscore, a full stop, a slash, a hyphen."""


def laid_out(columns: Sequence[str], rows: Sequence[Sequence[str]], width: int = 80) -> list[str]:
    """Lay out a table: its first column to the left, the others to the right.

    `columns`: headings. `width`: characters of a line. Returns: lines. Where the columns do not fit side by side they
    follow in parts, the first column in each.
    """
    cells = [list(columns), *(list(row) for row in rows)]
    lines: list[str] = []
    for part in _parts(cells, width):
        lines += ["", *part] if lines else part
    return lines


def _parts(cells: list[list[str]], width: int) -> Iterator[list[str]]:
    """Lines of each group of columns that fits."""
    first = [row[0] for row in cells]
    comfortable = max(_least(first), min(_LEAST_FIRST, max(map(len, first))))
    others = [[row[index] for row in cells] for index in range(1, len(cells[0]))]
    while True:
        count = len(others)
        while count > 1 and comfortable + sum(GAP + _narrow(column) for column in others[:count]) > width:
            count -= 1
        yield _lines(first, others[:count], width)
        others = others[count:]
        if not others:
            return


def _lines(first: list[str], others: list[list[str]], width: int) -> list[str]:
    """Lines of columns that fit side by side; headings are wrapped before the first column is."""
    wide = [max(map(len, column)) for column in others]
    if max(map(len, first)) + sum(wide) + GAP * len(wide) > width:
        wide = [_narrow(column) for column in others]
    room = max(width - sum(wide) - GAP * len(wide), _least(first))
    first_width = min(max(map(len, first)), room)
    lines: list[str] = []
    for number, head in enumerate(first):
        cells = (_broken(column[number], size, _SPACES) for column, size in zip(others, wide, strict=True))
        broken = [_broken(head, first_width), *cells]
        height = max(map(len, broken))
        if number == 0:  # headings stand on the line above the rows
            broken = [[""] * (height - len(cell)) + cell for cell in broken]
        for at in range(height):
            texts = [cell[at] if at < len(cell) else "" for cell in broken]
            numbers = (f"{text:>{size + GAP}}" for text, size in zip(texts[1:], wide, strict=True))
            lines.append(f"{texts[0]:<{first_width}}{''.join(numbers)}".rstrip())
    return lines


def _narrow(column: list[str]) -> int:
    """Least width of a column: that of its heading's longest word, and of its cells, long ones broken at spaces."""
    cells = (piece for cell in column[1:] for piece in ([cell] if len(cell) <= _LONGEST_CELL else cell.split(" ")))
    narrow = max((len(piece) for piece in cells), default=0)
    is_long = any(len(cell) > _LONGEST_CELL for cell in column[1:])
    return max(narrow, *map(len, column[0].split(" ")), _LONGEST_CELL if is_long else 1)


def _least(first: list[str]) -> int:
    """Least width of the first column: of its longest piece."""
    return max((len(piece.rstrip()) for cell in first for piece in _BREAKS.split(cell)), default=0)


def _broken(text: str, width: int, breaks: re.Pattern[str] = _BREAKS) -> list[str]:
    """Break a text into lines, by default at its spaces, underscores, full stops and slashes; pieces stay whole."""
    lines = [""]
    for piece in breaks.split(text):
        if lines[-1] and len((lines[-1] + piece).rstrip()) > width:
            lines[-1] = lines[-1].rstrip()
            lines.append(piece)
        else:
            lines[-1] += piece
    return lines


WIDTH = 79
MOST_LINES = 29
_MOST_OF_ANSWER = 10
"""Lines of the answer."""


def text(result: Result, /) -> str:
    """Write what the result is, its answer, and its main table as far as it fits a screen."""
    shown = terminal_view(result)
    answer = wrapped(shown.sentence, WIDTH).splitlines()
    if len(answer) > _MOST_OF_ANSWER:
        answer = [*answer[: _MOST_OF_ANSWER - 1], f"{answer[_MOST_OF_ANSWER - 1]} ..."]
    head = [heading(result), *answer]
    table = laid_out(shown.columns, shown.rows, WIDTH) if shown.rows else []
    room = MOST_LINES - len(head)
    if len(table) > room:
        table = [*table[: room - 1], f"... {len(table) - room + 1} more lines; to_frame() has all"]
    return "\n".join([*head, *table])


def heading(result: Result) -> str:
    """Name the kind of result, the study, the mission and its trials."""
    provenance = result.provenance
    trials = f", {counted(provenance.trials, 'trial')}, seed {provenance.seed}" if provenance.trials else ""
    start, mission = f"<{type(result).__name__}: {provenance.command}", provenance.mission or provenance.file
    room = WIDTH - len(f"{start} of {trials}>")
    name = mission if len(mission) <= room else f"{mission[: room - 3].rstrip()}..."
    return f"{start}{' of ' if name else ''}{name}{trials}>"


_MOST_ROWS = 20


def notebook(result: Result, /) -> str:
    """Write the part of the page; it holds no style sheet and no script.

    The first of its plots is an image of its own, so that no other figure of the page shares its names.
    """
    shown, drawings = terminal_view(result), drawings_of(result)
    parts: list[str] = [
        Markup("<p><small>{}</small><br><b>{}</b></p>").format(heading(result).strip("<>"), shown.sentence),
        _table(shown.columns, shown.rows) if shown.rows else "",
    ]
    for name, draw in list(drawings.items())[:1]:
        with shown_as_asked(result):
            figure = MatplotlibFigure(figsize=(6.4, 4.0), layout="constrained")
            draw(figure.add_subplot(), result)
            draw_in_units(figure.axes)
            buffer = io.BytesIO()
            figure.savefig(buffer, format="svg", metadata={"Date": None})
        image = base64.b64encode(buffer.getvalue()).decode()
        look = "max-width: 100%; background: white"
        parts.append(f'<img alt="{name}" style="{look}" src="data:image/svg+xml;base64,{image}">')
    return f"<div>{''.join(parts)}</div>"


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head, lines = _row(columns, "th"), [_row(row, "td") for row in rows[:_MOST_ROWS]]
    left = len(rows) - len(lines)
    more = Markup("<p><small>{} more rows: to_frame()</small></p>").format(left) if left > 0 else ""
    return f"<table><thead>{head}</thead><tbody>{''.join(lines)}</tbody></table>{more}"


def _row(row: Sequence[str], tag: str) -> str:
    sides = ["left", *["right"] * (len(row) - 1)]
    cells = (
        Markup('<{0} style="text-align: {1}">{2}</{0}>').format(Markup(tag), side, cell)
        for side, cell in zip(sides, row, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"
