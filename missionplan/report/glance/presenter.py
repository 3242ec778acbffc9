"""What `missionplan.rendering` knows of reports: a result as a report, as text, in a notebook and as plots."""

from collections.abc import Mapping

from missionplan.rendering import Plot, Rendered
from missionplan.report.glance import notebook as notebook_view
from missionplan.report.glance import text as text_view
from missionplan.report.render import plots_of, render_report
from missionplan.results.base import Result


def report(result: object, /) -> Rendered:
    """Render the report."""
    return render_report(_checked(result))


def text(result: object, /) -> str:
    """Write one screen of text."""
    return text_view.text(_checked(result))


def notebook(result: object, /) -> str:
    """Write a part of an HTML page: heading, answer, main table and key figure."""
    return notebook_view.notebook(_checked(result))


def plots(result: object, /) -> Mapping[str, Plot]:
    """Return the plots of a result by name, the main one first."""
    return plots_of(_checked(result))


def _checked(result: object) -> Result:
    if not isinstance(result, Result):
        raise TypeError(f"{type(result).__name__} is not the result of a study")
    return result
