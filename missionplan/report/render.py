"""Find the module that presents a result, and render the result with it."""

from importlib import import_module
from typing import Protocol, cast

from missionplan.rendering import Rendered
from missionplan.report.html.rendering import render_page
from missionplan.report.page import Page, Terminal, style
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
    with style():
        page = typeset_page(_module(result).page(result))
        planned = [typeset_section(section) for section in planned_sections(made)]
    return render_page(page, planned, made, [typeset(notice) for notice in made.notices])


def terminal_view(result: Result) -> Terminal:
    """Present a result for a terminal."""
    return typeset_terminal(_module(result).terminal(result))


def _module(result: Result) -> ReportModule:
    return cast(ReportModule, import_module(f"missionplan.report.{result.report}"))
