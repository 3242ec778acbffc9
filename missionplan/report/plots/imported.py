"""Plots of imported logs: the track with its errors."""

from collections.abc import Mapping

from missionplan.report.imported.figures import draw_track
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"ImportedData": {"track": draw_track}}
"""By the name of the result's class; the main one first."""
