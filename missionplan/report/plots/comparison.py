"""Plots of a comparison: the changes in standard errors."""

from collections.abc import Mapping

from missionplan.report.compared.alternatives import draw_alternatives
from missionplan.report.compared.two_runs import draw_changes
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {
    "Comparison": {"changes": draw_changes},
    "Alternatives": {"alternatives": draw_alternatives},
}
"""By the name of the result's class; the main one first."""
