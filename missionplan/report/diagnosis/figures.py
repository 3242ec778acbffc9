"""Figures that all kinds of data share: ranking, discrepancy, held-out gain."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.diagnosis.causes import names
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import Discrepancy, DiscrepancyShape

_LISTED = 8


def ranking_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the scores of the best sets."""
    entries = diagnosis.ranking[:_LISTED]
    figure = MatplotlibFigure(figsize=(6.2, 0.36 * len(entries) + 0.9))
    draw_ranking(figure.subplots(), diagnosis)
    first = f"; {names(diagnosis.ranking[0].causes)} first" if diagnosis.causes else ""
    alt = f"Scores of the best {len(entries)} sets of causes{first}"
    return to_figure(figure, "ranking", alt=alt, caption="Evidence for each set of causes over the mission's model.")


def draw_ranking(axes: Axes, diagnosis: Diagnosis) -> None:
    """Draw a bar for each of the best sets; those claimed are blue."""
    entries = list(reversed(diagnosis.ranking[:_LISTED]))
    scores = [entry.score for entry in entries]
    colours = [BLUE if entry.causes == diagnosis.causes else GREY for entry in entries]
    axes.barh(range(len(entries)), scores, color=colours, height=0.6)
    axes.set_yticks(range(len(entries)), [names(entry.causes) for entry in entries], fontsize=9)
    axes.axvline(3.0, color=ORANGE, linewidth=1.0, linestyle="--")
    axes.annotate(
        "claimed above 3", (3.0, 1.0), (4, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
        fontsize=9, color=ORANGE, annotation_clip=False,
    )  # fmt: skip
    axes.set_xlabel("Score (nats)")


def discrepancy_figure(found: Discrepancy, shape: DiscrepancyShape) -> Figure:
    """Draw what is left along its axis, with a 90 % band."""
    at, mean, sd = shape.at, shape.mean, shape.sd
    figure = MatplotlibFigure(figsize=(6.4, 2.8))
    axes = figure.subplots()
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.fill_between(at, mean - 1.645 * sd, mean + 1.645 * sd, color=BLUE, alpha=0.2, linewidth=0.0)
    axes.plot(at, mean, "-", color=BLUE, linewidth=1.4)
    axes.set(xlabel=shape.place, ylabel=shape.value, xlim=(at[0], at[-1]))
    return to_figure(
        figure,
        "remainder",
        alt=f"{shape.value} against {shape.place[0].lower()}{shape.place[1:]}: what the claimed causes leave",
        caption=(
            f"What is left beside the causes named, if it is {found.resembles}, the same throughout the data; "
            "band: 90 %. It shows where to look for a cause, and is no part of the extended mission."
        ),
    )


def held_out_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the held-out gain of each part."""
    gains = _gains(diagnosis)
    figure = MatplotlibFigure(figsize=(6.0, 0.32 * len(gains) + 0.9))
    draw_held_out(figure.subplots(), diagnosis)
    better = sum(gain > 0.0 for gain in gains)
    alt = f"Held-out gain of {len(gains)} parts; {better} of them better with the extended model"
    return to_figure(
        figure,
        "held-out",
        alt=alt,
        caption="Gain of the set that scores best, on each part of the data held out in turn.",
    )


def draw_held_out(axes: Axes, diagnosis: Diagnosis) -> None:
    """Draw a bar for each part of the data."""
    gains = _gains(diagnosis)
    axes.barh(range(len(gains)), gains, color=[BLUE if gain > 0.0 else ORANGE for gain in gains], height=0.6)
    axes.set_yticks(range(len(gains)), [score.group for score in diagnosis.scores], fontsize=9)
    axes.invert_yaxis()
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_xlabel("Gain in ln probability of the part, predicted from the others")


def _gains(diagnosis: Diagnosis) -> list[float]:
    return [score.log_score_extended - score.log_score_base for score in diagnosis.scores]
