"""Figures of a score: predictions beside what was measured, and probability integral transforms."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.errors import InputError, Problem, shown
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.log_book.score import PIT_BINS, DatasetScore, Prediction, Score, pit_counts

Q90 = 1.645
"""Normal quantile: half the width of a 90 % interval in standard deviations."""


def prediction_figure(each: DatasetScore) -> Figure:
    """Draw what was measured with both predictions and their 90 % bands."""
    legs = each.kind == "transit"
    figure = MatplotlibFigure(figsize=(6.4, 4.4))
    panels = figure.subplots(2, 1, sharex=True, sharey=not legs)
    for axes, part in zip(panels, (0, 1), strict=True):
        _panel(axes, each, part)
    panels[0].set_xlabel("")
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=9, frameon=False, ncols=3)
    what = "Position errors of the legs" if legs else "Departures of the depths from what was expected"
    return to_figure(
        figure,
        "predictions",
        alt=f"{what} with the mission's predictions",
        caption=f"{what} (points) and the mission's 90 % bands: blue one step ahead, grey without the past.",
    )


def draw_predictions(axes: Axes, score: Score, dataset: int = 0, part: int = 0) -> None:
    """Draw a data set of the score, by its number.

    Parameters
    ----------
    part : int
        Of legs, 0 for errors east and 1 for north; of dives, 0 for one step ahead and 1 for all the way.
    """
    for given, most, key in ((dataset, len(score.datasets), "dataset"), (part, 2, "part")):
        if not isinstance(given, int) or not 0 <= given < most:
            raise InputError([Problem(f"given {shown(given)}, expected 0 to {most - 1}", key=key)])
    _panel(axes, score.datasets[dataset], part)
    axes.legend()


def _panel(axes: Axes, each: DatasetScore, part: int) -> None:
    if each.kind == "transit":
        _leg_panel(axes, each, part)
        axes.set_xlabel("Leg")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    else:
        _dive_panel(axes, each, list(each.predictions.values())[part], ("one step ahead", "all the way")[part])
        axes.set_xlabel("Reading, dive after dive")


def _leg_panel(axes: Axes, each: DatasetScore, axis: int) -> None:
    rows = slice(axis, None, 2)
    at = np.arange(each.groups) + 1
    unit, word = (1000.0, "km") if np.max(np.abs(each.measured)) > 2000.0 else (1.0, "m")
    for prediction, colour, label in ((each.whole, GREY, "all the way"), (each.one_step, BLUE, "one step ahead")):
        mean, sd = prediction.mean[rows] / unit, prediction.sd[rows] / unit
        axes.fill_between(at, mean - Q90 * sd, mean + Q90 * sd, color=colour, alpha=0.25, linewidth=0.0, label=label)
    axes.plot(at, each.measured[rows] / unit, ".", color=ORANGE, markersize=4.0, label="measured")
    name_axis(axes.yaxis, f"{('East', 'North')[axis]} error", word)


def _dive_panel(axes: Axes, each: DatasetScore, prediction: Prediction, title: str) -> None:
    at, left = np.arange(len(each.measured)) + 1, each.measured - prediction.mean
    axes.fill_between(
        at, -Q90 * prediction.sd, Q90 * prediction.sd, color=BLUE, alpha=0.25, linewidth=0.0, label="90 %"
    )
    axes.plot(at, left, ".", color=ORANGE, markersize=3.0, label="measured")
    name_axis(axes.yaxis, "Error", "m")
    axes.set_title(title, fontsize=9)


def pit_figure(each: DatasetScore) -> Figure:
    """Draw histograms of the probability integral transforms, which are flat where the predictions are right."""
    figure = MatplotlibFigure(figsize=(6.4, 2.5))
    panels = figure.subplots(1, 2, sharey=True)
    expected = len(each.measured) / PIT_BINS
    spread = 1.645 * np.sqrt(expected * (1.0 - 1.0 / PIT_BINS))
    for axes, (title, prediction) in zip(
        panels, (("one step ahead", each.one_step), ("all the way", each.whole)), strict=True
    ):
        at = (np.arange(PIT_BINS) + 0.5) / PIT_BINS
        axes.bar(at, pit_counts(prediction.pit), width=0.9 / PIT_BINS, color=BLUE)
        axes.axhspan(max(expected - spread, 0.0), expected + spread, color=GREY, alpha=0.25, linewidth=0.0)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("Probability of less")
    panels[0].set_ylabel("Values")
    return to_figure(
        figure,
        f"pit-{each.kind}-{_slug(each.name)}",
        alt="Histograms of the probability integral transforms",
        caption=(
            "Where each value fell in its predicted distribution. Right predictions are flat; the grey band holds "
            "90 % of independent bins. Heaps at both ends: intervals too narrow; a heap in the middle: too wide."
        ),
    )


def _slug(name: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in name.lower())[:40].strip("-")
