"""Plots of an exploration, a curve along one key or a map over two; and of an optimisation, success against cost."""

from collections.abc import Mapping

from missionplan.report.exploration.figures import draw_exploration
from missionplan.report.optimisation.front import draw_front
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {
    "Exploration": {"cells": draw_exploration},
    "Optimised": {"front": draw_front},
}
"""By the name of the result's class; the main one first."""
