"""Map of a simulated mission: tracks, goals and circles of error, seen from above."""

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.geography.frame import Frame, emptiest_corner, frame, north_and_scale
from missionplan.report.geography.plan_view import median_trial, rings, track
from missionplan.report.page import ORANGE, SKY, Figure, to_figure
from missionplan.report.simulation.close_ups import draw_ring
from missionplan.report.simulation.figures import WIDTH
from missionplan.results.simulation import Outcome

_MAPPED = 200
"""Trials drawn."""


def track_map(outcome: Outcome) -> Figure:
    """Draw tracks from above, with goals, arrival circles, CEP and mooring ellipses."""
    count, shown = len(_lines(outcome)), _frame(outcome)
    figure = MatplotlibFigure(figsize=(WIDTH, 0.6 + (WIDTH - 0.9) * shown.shape))
    draw_tracks(figure.add_subplot(), outcome)
    return to_figure(
        figure,
        "track-map",
        f"Map of {count} trials from above, with the goals of the phases; north is up.",
        f"{count} trials (light), the median trial (orange, a dot at each fix), and the circles and ellipses that "
        f"the close-ups explain. Both axes have the same scale.{shown.outliers_in_words()}",
    )


def _lines(outcome: Outcome) -> list[Array]:
    """Tracks that are drawn."""
    tracks = outcome.tracks
    return [track(tracks, trial) for trial in range(min(tracks.position.shape[2], _MAPPED))]


def _circles(outcome: Outcome) -> list[Array]:
    return [ring.line for ring in rings(outcome)]


def _frame(outcome: Outcome) -> Frame:
    return frame(_lines(outcome), _circles(outcome))


def draw_tracks(axes: Axes, outcome: Outcome) -> None:
    """Draw tracks, the median trial, circles and ellipses, the north arrow and a scale."""
    tracks, lines, shown = outcome.tracks, _lines(outcome), _frame(outcome)
    axes.add_collection(LineCollection([line.T for line in lines], colors=SKY, linewidths=0.5, alpha=0.45))
    middle = track(tracks, median_trial(tracks))
    axes.plot(*middle, color=ORANGE, linewidth=1.4, marker="o", markersize=2.5, label="median trial")
    for ring in rings(outcome):
        draw_ring(axes, ring, ring.line, linewidth=1.0)
    axes.set(xlim=shown.west_east, ylim=shown.south_north, aspect="equal")
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    north_and_scale(axes, shown.width, emptiest_corner([*lines, *_circles(outcome)], shown.limits))
