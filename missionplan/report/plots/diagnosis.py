"""Plots of a diagnosis: the evidence for each set of causes, and the gain on data held out."""

from collections.abc import Mapping

from missionplan.report.diagnosis.figures import draw_held_out, draw_ranking
from missionplan.report.plots.catalogue import Drawing

DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"Diagnosis": {"ranking": draw_ranking, "held_out": draw_held_out}}
"""By the name of the result's class; the main one first."""
