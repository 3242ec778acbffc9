"""Plots of a tide: its ellipses, and the record."""

from collections.abc import Mapping

from missionplan.report.plots.catalogue import Drawing
from missionplan.report.tide.figures import draw_ellipses, draw_record

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"TideResult": {"ellipses": draw_ellipses, "record": draw_record}}
"""By the name of the result's class; the main one first."""
