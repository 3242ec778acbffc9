"""What a report says and draws for one kind of data; what the causes of a diagnosis are, as the catalogue has them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.arrays import Array
from missionplan.effects import CATALOGUE
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, PageSection, to_figure
from missionplan.report.quantities import in_reader_units
from missionplan.report.wording import listed, portion_in_words
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.evidence import Causes, ParameterEstimate

_LAGS = 16


@dataclass(frozen=True)
class ResidualSeries:
    """What the base model (`before`) and the extended one (`after`) leave of the data, series by series [`unit`]."""

    before: list[Array]
    after: list[Array]
    unit: str
    weight: Array | float = 1.0
    """What each counts for in a mean of their squares."""


def against_axes(places: Sequence[tuple[str, Array]], left: ResidualSeries) -> Figure:
    """Draw residuals before and after against several axes.

    `places`: axes, and where each residual of a series lies on them. `left`: two series at most: the second is drawn
    with crosses.
    """
    figure = MatplotlibFigure(figsize=(6.4, 4.2))
    panels = figure.subplots(2, len(places), sharey=True, sharex="col", squeeze=False)
    for column, (label, place) in enumerate(places):
        _scatter(panels[0, column], place, left.before, ORANGE)
        _scatter(panels[1, column], place, left.after, BLUE)
        panels[1, column].set_xlabel(label, fontsize=9)
    name_axis(panels[0, 0].yaxis, "Before", left.unit)
    name_axis(panels[1, 0].yaxis, "After", left.unit)
    before, after = (np.sqrt(np.mean((np.stack(axis) * left.weight) ** 2)) for axis in (left.before, left.after))
    return to_figure(
        figure,
        "residuals",
        alt=f"Residuals before and after against {', '.join(label for label, _ in places)}",
        caption=in_reader_units(
            f"What is left of the data: {before:.3g} {left.unit} rms before and {after:.3g} {left.unit} after."
        ),
    )


def _scatter(axes: Axes, place: Array, values: list[Array], colour: str) -> None:
    axes.axhline(0.0, color="#dddddd", linewidth=0.8)
    for marker, part in zip((".", "x"), values, strict=False):
        axes.plot(place, part, marker, color=colour, markersize=3.0, linestyle="none", alpha=0.8)


def autocorrelation(left: ResidualSeries, what: str) -> Figure:
    """Draw the autocorrelation of one-step-ahead errors before and after, by lag.

    The grey band is ±1.96/√n: 95 % of the sample autocorrelations of independent errors (Box, Jenkins and Reinsel
    1994, Sec. 2.1.6).

    `left`: series whose values follow one another. `what`: what lags are counted in, with a capital.
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


@dataclass(frozen=True)
class KindReport:
    """A kind of data in the report; `kinds.REPORTS` lists them all."""

    unit: str
    """Of errors of prediction."""
    data_figure: Callable[[Diagnosis], Figure]
    """Draws the data against the base model, and the extended one where causes are claimed: the report's main figure.
    """
    residual_figures: Callable[[Diagnosis], list[Figure]] = lambda diagnosis: []
    """Draws what is left before and after."""
    gained: Callable[[Diagnosis, float, float], str] = lambda diagnosis, before, after: ""
    """Writes what the causes gain on data held out, from the rms errors before and after [`unit`]: the end of a
    sentence, or nothing."""
    not_constant: str = ""
    """What is said of causes that do not hold still, after their names."""
    more_data: str = "take more data"
    """What to do where it is not known what would tell explanations apart."""
    proves_nothing: str = ""
    """Why no cause found in such data is an order; empty where one may be."""
    calibration: Mapping[str, str] = field(default_factory=dict)
    """Keys of `Diagnosis.calibration` in words."""


_DESCRIBED = 5
MOST_CERTAIN = 0.999
"""Probability beyond which it is not told more exactly: the models are approximate."""


def names(causes: Causes) -> str:
    """Write a set of causes in words."""
    return listed([_name(cause) for cause in causes]) or "no cause"


def _name(cause: str) -> str:
    info = CATALOGUE.get(cause)
    words = cause.replace("-", " ")
    return f"{words} without a name" if info is not None and info.tier == "neutral" else words


def found_causes(causes: Causes, parameters: Iterable[ParameterEstimate]) -> str:
    """Write a set of causes in words, of their sizes as found: one too large to be true is said to be like it."""
    sizes = {(parameter.effect, parameter.name): abs(parameter.value) for parameter in parameters}
    words = []
    for cause in causes:
        like = CATALOGUE[cause].likeness
        is_like = like is not None and sizes.get((cause, like.parameter), 0.0) > like.size
        words.append(like.words if like is not None and is_like else _name(cause))
    return listed(words) or "no cause"


def explanations_in_words(diagnosis: Diagnosis) -> Iterator[str]:
    """Write how probable the explanations are now that the mission had in doubt; nothing where it had none."""
    if any(explanation.prior is not None for explanation in diagnosis.explanations):
        words = [
            f"{names(explanation.causes) if explanation.causes else 'none of them'} {percent(explanation.probability)}"
            + ("" if explanation.prior is None else f" (was {percent(explanation.prior)})")
            for explanation in diagnosis.explanations
        ]
        yield f"Of the mission's explanations the probabilities are now: {', '.join(words)}."


def percent(probability: float) -> str:
    """Write a probability, which is never certain."""
    if probability > MOST_CERTAIN:
        return f"> {100.0 * MOST_CERTAIN:.1f} %"
    if probability < 1.0 - MOST_CERTAIN:
        return f"< {100.0 * (1.0 - MOST_CERTAIN):.1f} %"
    return f"{100.0 * probability:.1f} %"


def part(share: float) -> str:
    """Write a part of a whole, which is never said to be all of it: the models are approximate."""
    return portion_in_words(min(share, MOST_CERTAIN))


def causes_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Describe the causes claimed, then those that would do nearly as well."""
    claimed = [cause for causes in (diagnosis.causes, *diagnosis.rivals) for cause in causes]
    described = list(dict.fromkeys(claimed))[:_DESCRIBED]
    heading = "What such a cause is" if len(described) == 1 else "What such causes are"
    texts = []
    for cause in described:
        info = CATALOGUE[cause]
        words = f"{names((cause,)).capitalize()}. {info.what} Sizes that occur: {info.sizes}"
        if info.confused_with:
            words += f" Easily taken for {', '.join(names((other,)) for other in info.confused_with)}."
        texts.append(
            f"{words} What tells it from others: {info.distinguished_by[0].lower()}{info.distinguished_by[1:]}"
        )
    return [PageSection(heading, texts)] if diagnosis.causes else []
