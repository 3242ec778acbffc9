"""Plots of an identification: tank data and the models fitted to them."""

from collections.abc import Mapping

from matplotlib.axes import Axes

from missionplan.errors import InputError, Problem, shown
from missionplan.report.identification import draw_fit
from missionplan.report.plots.catalogue import Drawing
from missionplan.results.learned.identification import Identification


def fit(axes: Axes, result: Identification, panel: int = 0) -> None:
    """Draw one panel of data with the models, by its number."""
    panels = result.analysis.panels
    if not isinstance(panel, int) or not 0 <= panel < len(panels):
        raise InputError([Problem(f"given {shown(panel)}, expected 0 to {len(panels) - 1}", key="panel")])
    draw_fit(axes, panels[panel])
    axes.set_xlabel(panels[panel].x_label)


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"Identification": {"fit": fit}}
"""By the name of the result's class; the main one first."""
