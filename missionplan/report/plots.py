"""Plots of a result on given axes: those that the module of its report lists as `PLOTS`."""

from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, cast

from missionplan.rendering import Plot
from missionplan.report.crew.conversion import drawing_in, units_of
from missionplan.report.crew.drawing import draw_in_units
from missionplan.report.drawn import style
from missionplan.results.base import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Drawing = Callable[..., None]
"""Draws on axes: called with the axes, the result, and options of the plot's own."""


def drawings_of(result: Result) -> Mapping[str, Drawing]:
    """Return the drawings of a result by name, the main one first; none where it has none."""
    return cast("Mapping[str, Drawing]", getattr(import_module(result.report), "PLOTS", {}))


def plots_of(result: Result) -> dict[str, Plot]:
    """Return the plots of a result by name, the main one first."""
    return {name: partial(_plot, result, draw) for name, draw in drawings_of(result).items()}


def _plot(result: Result, draw: Drawing, *, ax: "Axes | None" = None, **options: object) -> "Axes":
    """Draw on axes, or on new ones of pyplot's, in the style of the reports."""
    from matplotlib.text import Text

    with style(), drawing_in(units_of(result.provenance.data)):
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
        others = set(ax.figure.axes) - {ax}
        draw(ax, result, **options)
        draw_in_units(axes for axes in ax.figure.axes if axes not in others)
        for text in ax.findobj(Text):  # of axes made elsewhere: a name may hold a `$`
            text.set_parse_math("\\mathdefault" in text.get_text())
    return ax
