"""Figures of a diagnosis: data against both models, ranking, remainder, held-out scores."""

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.diagnosis.tank_figures import TANK_UNITS, tank_figure
from missionplan.report.display_units import split_key
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.report.wording import in_words
from missionplan.results.diagnosis import Diagnosis, DiscrepancyFound

_MOST_PANELS = 9
_LISTED = 8


def main_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the data against the base and the extended model."""
    if diagnosis.kind in TANK_UNITS:
        return tank_figure(diagnosis)
    if diagnosis.kind == "transit":
        return _legs(diagnosis)
    return _dives(diagnosis) if diagnosis.kind == "descent" else _numbers(diagnosis)


def _legs(diagnosis: Diagnosis) -> Figure:
    table = diagnosis.residuals
    hours = (table["t_start_s"] + 0.5 * table["duration_s"]).to_numpy() / 3600.0
    figure = MatplotlibFigure(figsize=(6.4, 4.6))
    panels = figure.subplots(2, 1, sharex=True)
    for axes, component in zip(panels, ("east", "north"), strict=True):
        error = 100.0 * table[f"error_{component}_m_s"].to_numpy()
        expected = 100.0 * table[f"expected_{component}_m_s"].to_numpy()
        axes.plot(hours, error, ".", color=GREY, markersize=4.0, label="measured")
        axes.plot(hours, expected, "--", color=ORANGE, linewidth=1.3, label="mission")
        if diagnosis.causes:
            predicted = error - 100.0 * table[f"residual_extended_{component}_m_s"].to_numpy()
            axes.plot(hours, predicted, "-", color=BLUE, linewidth=1.1, label="extended, a leg ahead")
        axes.set(ylabel=f"{component.capitalize()} (cm/s)")
    panels[0].legend(loc="best", fontsize=8, ncols=3, frameon=False)
    panels[1].set_xlabel("Time (h)")
    return to_figure(
        figure,
        "data",
        alt="Velocity error of each leg toward east and north against time, with both models' predictions",
        caption=(
            "Velocity error of each leg: position error on surfacing over the time under way. Dashed: what the mission "
            "expects. Line: what the extended model predicts from the legs before."
        ),
    )


def _dives(diagnosis: Diagnosis) -> Figure:
    runs = list(diagnosis.residuals.groupby("run", sort=False))[:_MOST_PANELS]
    columns = min(3, len(runs))
    rows = -(-len(runs) // columns)
    figure = MatplotlibFigure(figsize=(6.4, 2.0 * rows + 0.6))
    panels = np.atleast_1d(figure.subplots(rows, columns, sharex=True, sharey=True)).ravel()
    for axes, (name, run) in zip(panels, runs, strict=False):
        axes.plot(run["t_s"], run["depth_m"], ".", color=GREY, markersize=3.0, label="measured")
        axes.plot(run["t_s"], run["base_m"], "--", color=ORANGE, linewidth=1.3, label="mission")
        if diagnosis.causes:
            axes.plot(run["t_s"], run["extended_m"], "-", color=BLUE, linewidth=1.1, label="extended")
        axes.set_title(str(name), fontsize=9)
    for axes in panels[len(runs) :]:
        axes.set_visible(False)
    panels[0].invert_yaxis()
    panels[0].legend(loc="lower left", fontsize=7.5, frameon=False)
    for axes in panels[: len(runs)][-columns:]:
        axes.set_xlabel("Time since separation (s)", fontsize=8.5)
        axes.tick_params(labelbottom=True)
    for axes in panels[::columns]:
        axes.set_ylabel("Depth (m)", fontsize=8.5)
    return to_figure(
        figure,
        "data",
        alt=f"Depth against time of {len(runs)} dives: measured, mission's model and extended model",
        caption="Depth of the vehicle against time, dive by dive: measured, as the mission simulates it, and extended.",
    )


def _numbers(diagnosis: Diagnosis) -> Figure:
    """Draw the numbers of each test, a panel for each quantity."""
    quantities = list(diagnosis.residuals.groupby("quantity", sort=False))
    figure = MatplotlibFigure(figsize=(6.4, 0.35 * diagnosis.residuals["run"].nunique() + 1.6), layout="constrained")
    panels = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
    for axes, (name, table) in zip(panels, quantities, strict=True):
        runs = table["run"].astype(str)
        axes.errorbar(table["measured"], runs, xerr=table["sd"], fmt="o", color=GREY, label="measured")
        axes.plot(table["base"], runs, "s", color=ORANGE, fillstyle="none", label="mission")
        if diagnosis.causes:
            axes.plot(table["extended"], runs, "D", color=BLUE, fillstyle="none", label="extended")
        difference = ",\nmeasured less simulated" if table["less_simulated"].all() else ""
        axes.set_xlabel(f"{in_words(str(name)).capitalize()}{difference} ({split_key(str(name))[1]})")
        axes.margins(y=0.25)
    panels[0].invert_yaxis()
    shown = panels[0].get_legend_handles_labels()
    figure.legend(*shown, loc="outside upper center", ncols=3, fontsize=8, frameon=False)
    return to_figure(
        figure,
        "data",
        alt="Numbers of each test: measured, mission's model, extended model",
        caption="The numbers of each test with their standard deviations, against both models.",
    )


def ranking_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the scores of the best sets."""
    entries = list(reversed(diagnosis.ranking[:_LISTED]))
    figure = MatplotlibFigure(figsize=(6.2, 0.36 * len(entries) + 0.9))
    axes = figure.subplots()
    scores = [entry.score for entry in entries]
    colours = [BLUE if entry.causes == diagnosis.causes else GREY for entry in entries]
    axes.barh(range(len(entries)), scores, color=colours, height=0.6)
    axes.set_yticks(range(len(entries)), [" + ".join(entry.causes) for entry in entries], fontsize=8)
    axes.axvline(3.0, color=ORANGE, linewidth=1.0, linestyle="--")
    axes.annotate("claimed above 3", (3.0, len(entries) - 0.45), fontsize=7.5, color=ORANGE, annotation_clip=False)
    axes.set_xlabel("Score (nats)")
    alt = f"Scores of the best {len(entries)} sets of causes; {' + '.join(diagnosis.ranking[0].causes)} is first"
    return to_figure(figure, "ranking", alt=alt, caption="Evidence for each set of causes over the mission's model.")


def discrepancy_figure(found: DiscrepancyFound) -> Figure:
    """Draw what is left along its axis, with a 90 % band."""
    assert found.shape is not None
    at, mean, sd = (found.shape[name].to_numpy() for name in ("at", "mean", "sd"))
    figure = MatplotlibFigure(figsize=(6.4, 2.8))
    axes = figure.subplots()
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.fill_between(at, mean - 1.645 * sd, mean + 1.645 * sd, color=BLUE, alpha=0.2, linewidth=0.0)
    axes.plot(at, mean, "-", color=BLUE, linewidth=1.4)
    axes.set(xlabel=found.place, ylabel=found.value, xlim=(at[0], at[-1]))
    return to_figure(
        figure,
        "remainder",
        alt=f"{found.value} against {found.place[0].lower()}{found.place[1:]}: what the claimed causes leave",
        caption=(
            f"What is left beside the causes named, if it is {found.resembles}, the same in all dives; band: 90 %. "
            "It says where to look for a cause, and is no part of the extended mission."
        ),
    )


def held_out_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the held-out gain of each part."""
    gains = [score.log_score_extended - score.log_score_base for score in diagnosis.scores]
    figure = MatplotlibFigure(figsize=(6.0, 0.32 * len(gains) + 0.9))
    axes = figure.subplots()
    axes.barh(range(len(gains)), gains, color=[BLUE if gain > 0.0 else ORANGE for gain in gains], height=0.6)
    axes.set_yticks(range(len(gains)), [score.group for score in diagnosis.scores], fontsize=8)
    axes.invert_yaxis()
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_xlabel("Gain in ln probability of the part, predicted from the others")
    better = sum(gain > 0.0 for gain in gains)
    alt = f"Held-out gain of {len(gains)} parts; {better} of them better with the extended model"
    return to_figure(
        figure, "held-out", alt=alt, caption="Gain of the first set on each part of the data, held out in turn."
    )
