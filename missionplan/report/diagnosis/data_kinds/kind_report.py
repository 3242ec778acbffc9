"""What a report says and draws for one kind of data, with the figures of residuals that several kinds share."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.learned.diagnosis import Diagnosis

_LAGS = 16


@dataclass(frozen=True)
class ResidualSeries:
    """What the base model (`before`) and the extended one (`after`) leave of the data, series by series [`unit`]."""

    before: list[Array]
    after: list[Array]
    unit: str


def against_axes(places: Sequence[tuple[str, Array]], left: ResidualSeries) -> Figure:
    """Draw residuals before and after against several axes.

    Parameters
    ----------
    places : sequence of (label, array)
        Axes, and where each residual of a series lies on them.
    left : ResidualSeries
        Two series at most: the second is drawn with crosses.
    """
    figure = MatplotlibFigure(figsize=(6.4, 4.2))
    panels = figure.subplots(2, len(places), sharey=True, sharex="col", squeeze=False)
    for column, (label, place) in enumerate(places):
        _scatter(panels[0, column], place, left.before, ORANGE)
        _scatter(panels[1, column], place, left.after, BLUE)
        panels[1, column].set_xlabel(label, fontsize=9)
    name_axis(panels[0, 0].yaxis, "Before", left.unit)
    name_axis(panels[1, 0].yaxis, "After", left.unit)
    before, after = (float(np.sqrt(np.mean(np.concatenate(values) ** 2))) for values in (left.before, left.after))
    return to_figure(
        figure,
        "residuals",
        alt=f"Residuals before and after against {', '.join(label for label, _ in places)}",
        caption=f"What is left of the data: {before:.3g} {left.unit} rms before and {after:.3g} {left.unit} after.",
    )


def _scatter(axes: Axes, place: Array, values: list[Array], colour: str) -> None:
    axes.axhline(0.0, color="#dddddd", linewidth=0.8)
    for marker, part in zip((".", "x"), values, strict=False):
        axes.plot(place, part, marker, color=colour, markersize=3.0, linestyle="none", alpha=0.8)


def autocorrelation(left: ResidualSeries, what: str) -> Figure:
    """Draw the autocorrelation of one-step-ahead errors before and after, by lag.

    The grey band is ±1.96/√n: 95 % of the sample autocorrelations of independent errors (Box, Jenkins and Reinsel
    1994, Sec. 2.1.6).

    Parameters
    ----------
    left : ResidualSeries
        Series whose values follow one another.
    what : str
        What lags are counted in, with a capital.
    """
    lags = np.arange(1, max(2, min(_LAGS, min(len(part) for part in left.before) // 3)))
    figure = MatplotlibFigure(figsize=(6.0, 2.6))
    axes = figure.subplots()
    drawn = ((left.before, ORANGE, "mission", -0.15), (left.after, BLUE, "extended", 0.15))
    for values, colour, label, shift in drawn:
        heights = [_correlation(values, lag) for lag in lags.tolist()]
        axes.vlines(lags + shift, 0.0, heights, color=colour, linewidth=3.0, label=label)
    limit = 1.96 / np.sqrt(sum(len(part) for part in left.before))
    axes.axhspan(-limit, limit, color=GREY, alpha=0.15, linewidth=0.0)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.set(xlabel=f"{what} apart", ylabel="Autocorrelation")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=9, frameon=False, ncols=2)
    return to_figure(
        figure,
        "autocorrelation",
        alt=f"Autocorrelation of what the mission's and the extended model leave, by lag in {what.lower()}",
        caption=(
            f"How alike errors are some {what.lower()} apart, each the error of predicting one from those before it; "
            "independent ones stay in the grey band 19 times of 20."
        ),
    )


def _correlation(values: list[Array], lag: int) -> float:
    """Autocorrelation at a lag, about the mean of each series."""
    centred = [part - part.mean() for part in values]
    return float(sum(p[lag:] @ p[:-lag] for p in centred) / max(sum(p @ p for p in centred), 1e-30))


def _no_figures(diagnosis: Diagnosis) -> list[Figure]:
    return []


def _no_numbers(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    return []


def _no_gain(diagnosis: Diagnosis, before: float, after: float) -> str:
    return ""


@dataclass(frozen=True)
class KindReport:
    """A kind of data in the report; `kinds.REPORTS` lists them all.

    Attributes
    ----------
    unit : str
        Of errors of prediction.
    data_figure : callable
        Draws the data against the base model, and the extended one where causes are claimed: the report's main figure.
    residual_figures : callable
        Draws what is left before and after.
    numbers : callable
        Further main numbers, as label and value.
    gained : callable
        Writes what the causes gain on data held out, from the rms errors before and after [`unit`]: the end of a
        sentence, or nothing.
    not_constant : str
        What is said of causes that do not hold still, after their names.
    calibration : mapping
        Keys of `Diagnosis.calibration` in words.
    """

    unit: str
    data_figure: Callable[[Diagnosis], Figure]
    residual_figures: Callable[[Diagnosis], list[Figure]] = _no_figures
    numbers: Callable[[Diagnosis], list[tuple[str, str]]] = _no_numbers
    gained: Callable[[Diagnosis, float, float], str] = _no_gain
    not_constant: str = ""
    calibration: Mapping[str, str] = field(default_factory=dict)
