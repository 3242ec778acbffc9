"""Find the module that presents a result, and render the result with it: as a page, for a terminal, as plots."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from missionplan.rendering import Plot, Rendered
from missionplan.report.assumptions import with_assumptions
from missionplan.report.axes import draw_in_units
from missionplan.report.drawn import style
from missionplan.report.html.rendering import render_page
from missionplan.report.page import Block, Drawing, Figure, Listing, Page, PageSection, Table, Terminal
from missionplan.report.planned.section import changed, planned_sections
from missionplan.report.quantities import reading_in, units_of
from missionplan.report.wording import typeset
from missionplan.results.base import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class ReportModule(Protocol):
    """What each module named by `Result.report` has."""

    def page(self, result: Result, /) -> Page:
        """List all that a result shows."""


@contextmanager
def shown_as_asked(result: Result) -> Iterator[None]:
    """Draw in the style of the reports, and write quantities in the units of the run, or of the result's mission."""
    with style(), reading_in(units_of(result.provenance.data)):
        yield


def render_report(result: Result) -> Rendered:
    """Render a result as one self-contained page, its figures, and files for other programs."""
    made = result.provenance
    with shown_as_asked(result):
        page, planned = _page(result), [*changed(made.data, result.recommended_values), *planned_sections(made)]
        page = typeset_page(page)
        return render_page(page, _sections(planned), made, [typeset(notice) for notice in made.notices])


def terminal_view(result: Result, *, system: str | None = None) -> Terminal:
    """Present a result for a terminal, in the units of the run or the mission, or of a system that is given."""
    with reading_in(units_of(result.provenance.data) if system is None else system):
        shown = _page(result).glance()
    columns, rows = _cells(shown.columns), [_cells(row) for row in shown.rows]
    return replace(shown, sentence=typeset(shown.sentence), columns=columns, rows=rows)


def drawings_of(result: Result) -> Mapping[str, Drawing]:
    """Return the drawings of a result by name, the main one first; none where it has none."""
    with reading_in(units_of(result.provenance.data)):
        return _page(result).plots


def plots_of(result: Result) -> dict[str, Plot]:
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
        replace(each, heading=typeset(each.heading), blocks=[_block(block) for block in each.blocks])
        for each in sections
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
