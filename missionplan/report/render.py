"""Find the module that pictures a result, and render it."""

from importlib import import_module
from types import ModuleType

from missionplan.report.page import Rendered, Terminal, render_page, style
from missionplan.results.base import Result


def render(result: Result) -> Rendered:
    """Render a result as one self-contained page and its figures."""
    with style():
        page = _module(result).page(result)
    return render_page(page, result.provenance)


def terminal(result: Result) -> Terminal:
    """Render a result for a terminal."""
    table: Terminal = _module(result).terminal(result)
    return table


def _module(result: Result) -> ModuleType:
    return import_module(f"missionplan.report.{result.report}")
