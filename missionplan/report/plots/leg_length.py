"""Plots of leg lengths: the cost of each d_max, and legs that adapt to the distance left."""

from collections.abc import Mapping

from missionplan.report.leg_length.plan_figures import draw_aims, draw_lengths, draw_savings
from missionplan.report.leg_length.sweep_figures import draw_costs, draw_surfacings
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {
    "Sweep": {"cost": draw_costs, "surfacings": draw_surfacings},
    "LegPlan": {"legs": draw_lengths, "aims": draw_aims, "savings": draw_savings},
}
"""By the name of the result's class; the main one first."""
