"""Dive logs and summaries of dives in the report: depths, what is left of them, and the numbers of each test."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.diagnosis.data_kinds.kind_report import (
    KindReport,
    ResidualSeries,
    against_axes,
    autocorrelation,
)
from missionplan.report.numbers import number
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.report.quantities import reader_unit, split_key
from missionplan.report.wording import in_words
from missionplan.results.learned.diagnosis import Diagnosis

_MOST_PANELS = 9


def _data_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the depth of each dive against time, with the mission's model and the extended one, if any."""
    runs = list(diagnosis.residuals.groupby("run", sort=False))[:_MOST_PANELS]
    columns = min(3, len(runs))
    rows = -(-len(runs) // columns)
    figure = MatplotlibFigure(figsize=(6.4, 2.0 * rows + 0.6))
    panels = np.atleast_1d(figure.subplots(rows, columns, sharex=True, sharey=True)).ravel()
    for axes, (name, run) in zip(panels, runs, strict=False):
        _draw_dive(axes, str(name), run, extended=bool(diagnosis.causes))
    for axes in panels[len(runs) :]:
        axes.set_visible(False)
    panels[0].invert_yaxis()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", fontsize=9, ncols=3)
    for axes in panels[: len(runs)][-columns:]:
        axes.set_xlabel("Time since separation (s)", fontsize=9)
        axes.tick_params(labelbottom=True)
    for axes in panels[::columns]:
        name_axis(axes.yaxis, "Depth", "m", fontsize=9)
    models = "measured, mission's model and extended model" if diagnosis.causes else "measured and mission's model"
    shown = "measured, as the mission simulates it" + (", and extended" if diagnosis.causes else "")
    return to_figure(
        figure,
        "data",
        alt=f"Depth against time of {len(runs)} dives: {models}",
        caption=f"Depth of the vehicle against time, dive by dive: {shown}.",
    )


def _draw_dive(axes: Axes, name: str, run: pd.DataFrame, *, extended: bool) -> None:
    axes.plot(run["t_s"], run["depth_m"], ".", color=GREY, markersize=3.0, label="measured")
    axes.plot(run["t_s"], run["base_m"], "--", color=ORANGE, linewidth=1.3, label="mission")
    if extended:
        axes.plot(run["t_s"], run["extended_m"], "-", color=BLUE, linewidth=1.1, label="extended")
    axes.set_title(name, fontsize=9)


def _residual_figures(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left against time, depth and speed, and by lag in each dive."""
    table = diagnosis.residuals
    runs = [run for _, run in table.groupby("run", sort=False)]
    speeds = [np.gradient(run["base_m"].to_numpy(), run["t_s"].to_numpy()) for run in runs]
    places = [
        ("Time since separation (s)", table["t_s"].to_numpy()),
        ("Depth (m)", table["base_m"].to_numpy()),
        ("Speed (m/s)", np.concatenate(speeds)),
    ]
    left = ResidualSeries([table["residual_base_m"].to_numpy()], [table["residual_extended_m"].to_numpy()], "m")
    return [against_axes(places, left), autocorrelation(_innovations(runs), "Readings")]


def _innovations(runs: list[pd.DataFrame]) -> ResidualSeries:
    """One-step-ahead errors of each dive, over their standard deviations."""
    before, after = (_column(runs, f"innovation_{model}") for model in ("base", "extended"))
    return ResidualSeries(before, after, "")


def _column(runs: list[pd.DataFrame], name: str) -> list[Array]:
    return [run[name].to_numpy() for run in runs]


def _gained(diagnosis: Diagnosis, before: float, after: float) -> str:
    unit = reader_unit("m", before)
    was, now = (f"{number(unit(each), unit(0.2 * each))}{unit.suffix}" for each in (before, after))
    return "" if was == now else f"; the depth is then predicted to {now}, not {was}"


REPORT = KindReport(
    unit="m",
    gained=_gained,
    data_figure=_data_figure,
    residual_figures=_residual_figures,
    not_constant="not the same in all dives",
    calibration={
        "dive_scatter": "Scatter from dive to dive, of the usual",
        "depth_walk_m2_s": "Turbulence: rate at which the depth wanders (m²/s)",
        "eddy_time_s": "Turbulence: how long a velocity lasts (s)",
    },
)


def _summary_figure(diagnosis: Diagnosis) -> Figure:
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
    figure.legend(*shown, loc="outside upper center", ncols=3, fontsize=9, frameon=False)
    extended = ", extended model" if diagnosis.causes else ""
    against = "the mission's and the extended model" if diagnosis.causes else "the mission's model"
    return to_figure(
        figure,
        "data",
        alt=f"Numbers of each test: measured, mission's model{extended}",
        caption=f"The numbers of each test with their standard deviations, against {against}.",
    )


SUMMARY_REPORT = KindReport(unit="sd", data_figure=_summary_figure, calibration=REPORT.calibration)
