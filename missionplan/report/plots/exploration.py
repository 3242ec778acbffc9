"""Plots of an exploration: a curve along one key, a map over two."""

from collections.abc import Mapping

from missionplan.report.exploration.figures import draw_exploration
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"Exploration": {"cells": draw_exploration}}
"""By the name of the result's class; the main one first."""
