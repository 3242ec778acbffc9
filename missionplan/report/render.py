"""Find the module that pictures a result, and render it."""

from dataclasses import replace
from importlib import import_module
from types import ModuleType

from missionplan.rendering import Rendered
from missionplan.report.page import Terminal, render_page, style
from missionplan.results.base import Result


def render_report(result: Result) -> Rendered:
    """Render a result as one self-contained page, its figures, and what its module's `files` has for other programs."""
    module = _module(result)
    with style():
        page = module.page(result)
    rendered = render_page(page, result.provenance)
    return replace(rendered, files=module.files(result)) if hasattr(module, "files") else rendered


def terminal_view(result: Result) -> Terminal:
    """Render a result for a terminal."""
    table: Terminal = _module(result).terminal(result)
    return table


def _module(result: Result) -> ModuleType:
    return import_module(f"missionplan.report.{result.report}")
