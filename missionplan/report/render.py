"""Find the module that presents a result, and render the result with it."""

from importlib import import_module
from typing import Protocol, cast

from missionplan.rendering import Rendered
from missionplan.report.crew.conversion import drawing_in, in_units, units_of
from missionplan.report.crew.pages import page_in_units, section_in_units, terminal_in_units
from missionplan.report.drawn import style
from missionplan.report.html.rendering import render_page
from missionplan.report.page import Page, Terminal
from missionplan.report.planned.section import planned_sections
from missionplan.report.typesetting import typeset, typeset_page, typeset_section, typeset_terminal
from missionplan.results.base import Result


class ReportModule(Protocol):
    """What each module named by `Result.report` has: the result as a page and for a terminal."""

    def page(self, result: Result, /) -> Page:
        """Build the page."""

    def terminal(self, result: Result, /) -> Terminal:
        """Build the view for a terminal."""


def render_report(result: Result) -> Rendered:
    """Render a result as one self-contained page, its figures, and files for other programs."""
    made = result.provenance
    units = units_of(made.data)
    with style(), drawing_in(units):
        page, planned = _module(result).page(result), planned_sections(made)
        page, planned = typeset_page(page), [typeset_section(section) for section in planned]
    notices = [typeset(notice) for notice in made.notices]
    if units:
        page = page_in_units(page, units)
        planned = [section_in_units(section, units) for section in planned]
        notices = [in_units(notice, units) for notice in notices]
    return render_page(page, planned, made, notices)


def terminal_view(result: Result) -> Terminal:
    """Present a result for a terminal."""
    shown = typeset_terminal(_module(result).terminal(result))
    units = units_of(result.provenance.data)
    return terminal_in_units(shown, units) if units else shown


def _module(result: Result) -> ReportModule:
    return cast(ReportModule, import_module(result.report))
