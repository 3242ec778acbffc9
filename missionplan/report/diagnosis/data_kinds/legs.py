"""Navigation logs in the report: velocity errors leg by leg, against time, heading and duration, and on the chart."""

import math

import numpy as np
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
from missionplan.report.quantities import quantity, reader_unit, time_in_words
from missionplan.results.learned.diagnosis import Diagnosis

_COMPONENTS = ("east", "north")


def _data_figure(diagnosis: Diagnosis) -> Figure:
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


def _residual_figures(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left against time, heading and duration, where the legs began, and by lag."""
    table, left = diagnosis.residuals, _residuals(diagnosis)
    places = [
        ("Time (h)", table["t_start_s"].to_numpy() / 3600.0),
        ("Heading (deg)", table["heading_deg"].to_numpy()),
        ("Leg duration (min)", table["duration_s"].to_numpy() / 60.0),
    ]
    return [against_axes(places, left), _chart(diagnosis, left), autocorrelation(left, "Legs")]


def _residuals(diagnosis: Diagnosis) -> ResidualSeries:
    before, after = (
        [100.0 * diagnosis.residuals[f"residual_{model}_{component}_m_s"].to_numpy() for component in _COMPONENTS]
        for model in ("base", "extended")
    )
    return ResidualSeries(before, after, "cm/s")


def _chart(diagnosis: Diagnosis, left: ResidualSeries) -> Figure:
    """Draw the velocity errors of the legs as arrows where the legs began."""
    table = diagnosis.residuals
    east, north = (table[f"{axis}_start_m"].to_numpy() / 1000.0 for axis in ("x", "y"))
    longest = max(float(np.max(np.hypot(*left.before))), 1e-9)
    figure = MatplotlibFigure(figsize=(6.4, 3.3))
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    shown: tuple[tuple[list[Array], str, str], ...] = (
        (left.before, ORANGE, "Before"),
        (left.after, BLUE, "After"),
    )
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
    _not_too_narrow(axes)
    axes.quiverkey(
        arrows, 0.6, 1.06, 0.5 * longest, f"{0.5 * longest:.1f} {left.unit}", labelpos="E", fontproperties={"size": 8}
    )
    name_axis(panels[0].yaxis, "North", "km")
    return to_figure(
        figure,
        "places",
        alt="Velocity errors of the legs as arrows at the places where the legs began, before and after",
        caption="Velocity error of each leg where the leg began: what depends on the place shows as a pattern.",
    )


def _not_too_narrow(axes: Axes) -> None:
    """Widen limits so that neither side is shorter than half of the other: legs may all lie on one line."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    wide, high = max(east - west, 0.5 * (north - south)), max(north - south, 0.5 * (east - west))
    across, up = 0.5 * (west + east), 0.5 * (south + north)
    axes.set(xlim=(across - 0.5 * wide, across + 0.5 * wide), ylim=(up - 0.5 * high, up + 0.5 * high))


def _numbers(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Write how well the next leg's position error is predicted, with and without the causes."""
    model = diagnosis.calibration.get("next_leg_model_rms_m")
    if model is None or not diagnosis.causes:
        return []
    mean = diagnosis.calibration["next_leg_mean_so_far_rms_m"]
    return [
        (
            "Next leg's position error: mean so far, and model",
            f"{quantity(mean, 'm', '.0f')} → {quantity(model, 'm', '.0f')}",
        )
    ]


def _gained(diagnosis: Diagnosis, before: float, after: float) -> str:
    """Write how far a usual leg ends from where it is expected, before and after; both errors are of one axis [m/s]."""
    duration = float(diagnosis.residuals["duration_s"].median())
    off = [math.sqrt(2.0) * error * duration for error in (before, after)]
    unit = reader_unit("m", max(off))
    was, now = (f"{number(unit(each), unit(0.2 * each))}{unit.suffix}" for each in off)
    if was == now:
        return ""
    return f"; a leg of {time_in_words(duration)} then ends {now} from where it is expected, not {was}"


REPORT = KindReport(
    unit="m/s",
    gained=_gained,
    data_figure=_data_figure,
    residual_figures=_residual_figures,
    numbers=_numbers,
    not_constant="not constant over the record: the halves of the record disagree",
    calibration={
        "sigma_v_m_s": "Velocity error of a leg, σ_v (m/s)",
        "sigma_v_factor": "Factor within which σ_v is known in two of three cases",
        "fix_sd_m": "Error of a fix (m)",
        "next_leg_mean_so_far_rms_m": "Next leg's position error, predicted by the mean so far (m)",
        "next_leg_last_leg_rms_m": "Next leg's position error, predicted by the last leg (m)",
        "next_leg_model_rms_m": "Next leg's position error, predicted by this model (m)",
    },
)
