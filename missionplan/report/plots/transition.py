"""Plots of a transition to hover: energy, and depth and pitch against time."""

from collections.abc import Mapping

from matplotlib.axes import Axes

from missionplan.report.plots.catalogue import Drawing
from missionplan.report.transition.figures import draw_energy, draw_histories, pitch_of, rise_of
from missionplan.results.transition import TransitionSweep


def rise(axes: Axes, result: TransitionSweep) -> None:
    """Draw the rise above the target depth for each mid-transition speed."""
    draw_histories(axes, result.by_mid_speed, rise_of, "rise above target (m)")


def pitch(axes: Axes, result: TransitionSweep) -> None:
    """Draw the pitch for each mid-transition speed."""
    draw_histories(axes, result.by_mid_speed, pitch_of, "pitch (°)")


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {
    "TransitionSweep": {"energy": draw_energy, "rise": rise, "pitch": pitch}
}
"""By the name of the result's class; the main one first."""
