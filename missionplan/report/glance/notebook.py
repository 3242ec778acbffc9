"""A result in a notebook: heading, answer, main table and key figure, as a part of an HTML page."""

import base64
import io
from collections.abc import Sequence

from markupsafe import Markup
from matplotlib.figure import Figure

from missionplan.report.axes import draw_in_units
from missionplan.report.glance.text import heading
from missionplan.report.render import drawings_of, shown_as_asked, terminal_view
from missionplan.results.base import Result

_MOST_ROWS = 20


def notebook(result: Result) -> str:
    """Write the part of the page; it holds no style sheet and no script."""
    shown = terminal_view(result)
    parts = [
        Markup("<p><small>{}</small><br><b>{}</b></p>").format(heading(result).strip("<>"), shown.sentence),
        _table(shown.columns, shown.rows) if shown.rows else "",
        _figure(result),
    ]
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


def _figure(result: Result) -> str:
    """The first of its plots as an image of its own, so that no other figure of the page shares its names."""
    drawings = drawings_of(result)
    if not drawings:
        return ""
    name, draw = next(iter(drawings.items()))
    with shown_as_asked(result):
        figure = Figure(figsize=(6.4, 4.0), layout="constrained")
        draw(figure.add_subplot(), result)
        draw_in_units(figure.axes)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    image = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="{name}" style="max-width: 100%; background: white" src="data:image/svg+xml;base64,{image}">'
