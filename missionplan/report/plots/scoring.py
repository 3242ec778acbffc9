"""Plots of a score: predictions beside what was measured."""

from collections.abc import Mapping

from missionplan.report.plots.catalogue import Drawing
from missionplan.report.scoring.figures import draw_predictions

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"Score": {"predictions": draw_predictions}}
"""By the name of the result's class; the main one first."""
