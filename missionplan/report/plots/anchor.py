"""Plots of a sized anchor: its nominal dive and where its drag comes from."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from missionplan.report.anchor.figures import draw_depths, draw_drag, mark_lowest_point
from missionplan.report.plots.catalogue import Drawing
from missionplan.results.mooring.sizing import AnchorSizing


def descent(axes: Axes, sizing: AnchorSizing) -> None:
    """Draw the depths of anchor and vehicle in the nominal dive of the anchor to build."""
    anchor = sizing.to_build
    seafloor = float(np.asarray(anchor.dive.site_depth))
    draw_depths(axes, anchor.profile, seafloor)
    mark_lowest_point(axes, anchor.profile, seafloor, anchor.lowest_altitude)
    axes.set(xlabel="Time since the last fix (s)", ylabel="Depth (m)", ylim=(1.06 * seafloor, 0.0))


def drag(axes: Axes, sizing: AnchorSizing) -> None:
    """Draw the drag of each part at terminal velocity."""
    draw_drag(axes, sizing.to_build)


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"AnchorSizing": {"descent": descent, "drag": drag}}
"""By the name of the result's class; the main one first."""
