"""The kinds of data in the report of a diagnosis: legs, dives and tank data; a new one has a line in `REPORTS`."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.axes import name_axis
from missionplan.report.diagnosis.kind_report import KindReport, ResidualSeries, against_axes, autocorrelation
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.report.quantities import reader_unit, time_in_words
from missionplan.report.wording import in_words, number, split_key
from missionplan.results.learned import Diagnosis

_MOST_PANELS = 9


def _dive_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the depth of each dive against time, with the mission's model and the extended one, if any."""
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
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", fontsize=9, ncols=3)
    for axes in panels[: len(runs)][-columns:]:
        axes.set_xlabel("Time since separation (s)", fontsize=9)
        axes.tick_params(labelbottom=True)
    for axes in panels[::columns]:
        name_axis(axes.yaxis, "Depth", "m", fontsize=9)
    shown = "measured, as the mission simulates it" + (", and extended" if diagnosis.causes else "")
    return to_figure(
        figure,
        "data",
        alt=f"Depth against time of {len(runs)} dives: {shown}",
        caption=f"Depth of the vehicle against time, dive by dive: {shown}.",
    )


def _dive_residuals(diagnosis: Diagnosis) -> list[Figure]:
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
    # one-step-ahead errors of each dive, over their standard deviations
    before, after = ([run[f"innovation_{model}"].to_numpy() for run in runs] for model in ("base", "extended"))
    return [against_axes(places, left), autocorrelation(ResidualSeries(before, after, ""), "Readings")]


def _gained_of_dives(diagnosis: Diagnosis, before: float, after: float) -> str:
    unit = reader_unit("m", before)
    was, now = (f"{number(unit(error), unit(0.2 * error))}{unit.suffix}" for error in (before, after))
    return "" if was == now or after > before else f"; the depth is then predicted to {now}, not {was}"


_DIVE_REPORT = KindReport(
    unit="m",
    gained=_gained_of_dives,
    data_figure=_dive_figure,
    residual_figures=_dive_residuals,
    not_constant="not the same in all dives",
    more_data="dive with another anchor and another line",
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
    against = "the mission's and the extended model" if diagnosis.causes else "the mission's model"
    return to_figure(
        figure,
        "data",
        alt=f"Numbers of each test: measured, and {against}",
        caption=f"The numbers of each test with their standard deviations, against {against}.",
    )


_SUMMARY_REPORT = KindReport(
    unit="sd",
    data_figure=_summary_figure,
    more_data="log depth and time all the way down",
    proves_nothing="so few numbers prove nothing",
    calibration=_DIVE_REPORT.calibration,
)


_COMPONENTS = ("east", "north")


def _leg_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the velocity error of each leg against time, with the mission's model and the extended one, if any."""
    table = diagnosis.residuals
    hours = (table["t_start_s"] + 0.5 * table["duration_s"]).to_numpy() / 3600.0
    figure = MatplotlibFigure(figsize=(6.4, 4.6))
    panels = figure.subplots(2, 1, sharex=True)
    for axes, component in zip(panels, _COMPONENTS, strict=True):
        error = 100.0 * table[f"error_{component}_m_s"].to_numpy()
        expected = 100.0 * table[f"expected_{component}_m_s"].to_numpy()
        axes.plot(hours, error, ".", color=GREY, markersize=4.0, label="measured")
        axes.plot(hours, expected, "--", color=ORANGE, linewidth=1.3, label="mission")
        if diagnosis.causes:
            predicted = error - 100.0 * table[f"residual_extended_{component}_m_s"].to_numpy()
            axes.plot(hours, predicted, "-", color=BLUE, linewidth=1.1, label="extended, a leg ahead")
        name_axis(axes.yaxis, component.capitalize(), "cm/s")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", fontsize=9, ncols=3)
    panels[1].set_xlabel("Time (h)")
    models = "the mission's and the extended model's predictions" if diagnosis.causes else "the mission's prediction"
    line = " Line: what the extended model predicts from the legs before." if diagnosis.causes else ""
    return to_figure(
        figure,
        "data",
        alt=f"Velocity error of each leg toward east and north against time, with {models}",
        caption=(
            "Velocity error of each leg: position error on surfacing over the time under way. Dashed: what the mission "
            f"expects.{line}"
        ),
    )


def _leg_residuals(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left against time, heading and duration, where the legs began, and by lag."""
    table = diagnosis.residuals
    before, after = (
        [100.0 * table[f"residual_{model}_{component}_m_s"].to_numpy() for component in _COMPONENTS]
        for model in ("base", "extended")
    )
    times = table["duration_s"].to_numpy()
    left = ResidualSeries(before, after, "cm/s", times / np.sqrt(np.mean(times**2)))
    places = [
        ("Time (h)", table["t_start_s"].to_numpy() / 3600.0),
        ("Heading (deg)", table["heading_deg"].to_numpy()),
        ("Leg duration (min)", table["duration_s"].to_numpy() / 60.0),
    ]
    return [against_axes(places, left), _chart(diagnosis, left), autocorrelation(left, "Legs")]


def _chart(diagnosis: Diagnosis, left: ResidualSeries) -> Figure:
    """Draw the velocity errors of the legs as arrows where the legs began."""
    table = diagnosis.residuals
    east, north = (table[f"{axis}_start_m"].to_numpy() / 1000.0 for axis in ("x", "y"))
    longest = max(float(np.max(np.hypot(*left.before))), 1e-9)
    figure = MatplotlibFigure(figsize=(6.4, 3.3))
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    shown = ((left.before, ORANGE, "Before"), (left.after, BLUE, "After"))
    scale = 5.0 * longest / max(float(np.ptp(east)), float(np.ptp(north)), 1e-3)
    for axes, (values, colour, title) in zip(panels, shown, strict=True):
        axes.plot(east, north, "-", color=GREY, linewidth=0.6, alpha=0.6)
        arrows = axes.quiver(
            east, north, *values, color=colour, angles="xy", scale_units="xy", scale=scale, width=0.005
        )
        axes.set_title(title, fontsize=9)
        name_axis(axes.xaxis, "East", "km")
        axes.set_aspect("equal")
    tips = [np.array([east, north]) + np.array(values) / scale for values in (left.before, left.after)]
    for tip in tips:  # arrows are no part of the limits by themselves
        axes.plot(*tip, " ")
    axes.autoscale_view()
    # widen limits so that neither side is shorter than half of the other: legs may all lie on one line
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    wide, high = max(east - west, 0.5 * (north - south)), max(north - south, 0.5 * (east - west))
    across, up = 0.5 * (west + east), 0.5 * (south + north)
    axes.set(xlim=(across - 0.5 * wide, across + 0.5 * wide), ylim=(up - 0.5 * high, up + 0.5 * high))
    key = f"{0.5 * longest:.1f}\u00a0{left.unit}"
    axes.quiverkey(arrows, 0.6, 1.06, 0.5 * longest, key, labelpos="E", fontproperties={"size": 8})
    name_axis(panels[0].yaxis, "North", "km")
    return to_figure(
        figure,
        "places",
        alt="Velocity errors of the legs as arrows at the places where the legs began, before and after",
        caption="Velocity error of each leg where the leg began: what depends on the place shows as a pattern.",
    )


def _gained_of_legs(diagnosis: Diagnosis, before: float, after: float) -> str:
    """Write how far a usual leg ends from where it is expected, before and after; both errors are of one axis [m/s].

    Before is as the mission stands, also where it would learn from leg to leg what it knows already.
    """
    legs = diagnosis.residuals
    times = legs["duration_s"].to_numpy()
    duration = float(np.median(times))
    axes = legs[["residual_base_east_m_s", "residual_base_north_m_s"]].to_numpy()
    before = max(before, math.sqrt(0.5 * float(np.sum((axes.T * times) ** 2) / np.sum(times**2))))
    off = [math.sqrt(2.0) * error * duration for error in (before, after)]
    unit = reader_unit("m", max(off))
    was, now = (f"{number(unit(distance), unit(0.2 * distance))}{unit.suffix}" for distance in off)
    if was == now or after > before:
        return ""
    return f"; a leg of {time_in_words(duration)} then ends {now} from where it is expected, not {was}"


_LEG_REPORT = KindReport(
    unit="m/s",
    gained=_gained_of_legs,
    data_figure=_leg_figure,
    residual_figures=_leg_residuals,
    not_constant="not constant over the record: the halves of the record disagree",
    more_data="sail legs on other headings, at another speed and of other lengths",
    calibration={
        "sigma_v_m_s": "Velocity error of a leg, σ_v (m/s)",
        "sigma_v_factor": "Factor within which σ_v is known in two of three cases",
        "fix_sd_m": "Error of a fix (m)",
        "next_leg_mean_so_far_rms_m": "Next leg's position error, predicted by the mean so far (m)",
        "next_leg_last_leg_rms_m": "Next leg's position error, predicted by the last leg (m)",
        "next_leg_model_rms_m": "Next leg's position error, predicted by this model (m)",
    },
)


_UNITS = {"drag": "N", "free-oscillation": "m", "thruster": "N", "propeller-transient": "N"}
"""Kinds of tank data, and the unit of what is measured."""
_LABELS = {"force_n": "Drag (N)", "thrust_n": "Thrust (N)", "displacement_m": "Displacement (m)"}
_AXES = {"at_time": "Time (s)", "at_speed": "Speed (m/s)", "at_command": "Command (V or rev/s)"}


def _tank_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the data against the first of their axes, with the base model and the extended one, if any."""
    table = diagnosis.residuals
    place = next(name for name in _AXES if name in table and (name != "at_speed" or "at_command" not in table))
    quantity = next(name for name in _LABELS if name in table)
    shown = table.sort_values(place)
    figure = MatplotlibFigure(figsize=(6.4, 3.4))
    axes = figure.subplots()
    axes.plot(shown[place], shown[quantity], ".", color=GREY, markersize=4.0, label="measured")
    line = "-" if place == "at_time" else ""
    models = (("base", "s", ORANGE, "base model"), ("extended", "D", BLUE, "extended"))
    for name, marker, colour, label in models if diagnosis.causes else models[:1]:
        look: dict[str, Any] = {"color": colour, "fillstyle": "none", "markersize": 3.0, "label": label}
        axes.plot(shown[place], shown[name], line + marker, **look)
    axes.set(xlabel=_AXES[place], ylabel=_LABELS[quantity])
    axes.legend(fontsize=9, frameon=False)
    label = _LABELS[quantity].split(" (")[0]
    extended, with_causes = (" and the extended model", " and with the causes found") if diagnosis.causes else ("", "")
    return to_figure(
        figure,
        "data",
        alt=f"{label} as measured, with the base model{extended}",
        caption=f"{label} as measured in the tank, with the base model{with_causes}.",
    )


def _tank_residuals(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left before and after along each axis."""
    table = diagnosis.residuals
    places = [(label, table[name].to_numpy()) for name, label in _AXES.items() if name in table]
    before, after = ([table[f"residual_{model}"].to_numpy()] for model in ("base", "extended"))
    return [against_axes(places, ResidualSeries(before, after, _UNITS[diagnosis.kind]))]


REPORTS: Mapping[str, KindReport] = {
    "transit": _LEG_REPORT,
    "descent": _DIVE_REPORT,
    "summary": _SUMMARY_REPORT,
    **{
        kind: KindReport(
            unit=unit,
            data_figure=_tank_figure,
            residual_figures=_tank_residuals,
            more_data="measure again, at other speeds too",
        )
        for kind, unit in _UNITS.items()
    },
}
"""By the data set's kind."""
