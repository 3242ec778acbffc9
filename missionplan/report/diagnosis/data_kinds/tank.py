"""Tank data in the report: data and what is left of them against speed, command or time."""

from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.diagnosis.data_kinds.kind_report import KindReport, ResidualSeries, against_axes
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.learned.diagnosis import Diagnosis

_UNITS = {"drag": "N", "free-oscillation": "m", "thruster": "N", "propeller-transient": "N"}
"""Kinds of tank data, and the unit of what is measured."""
_LABELS = {"force_n": "Drag (N)", "thrust_n": "Thrust (N)", "displacement_m": "Displacement (m)"}
_AXES = {"at_time": "Time (s)", "at_speed": "Speed (m/s)", "at_command": "Command (V or rev/s)"}


def _data_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the data against the first of their axes, with the base model and the extended one, if any."""
    table = diagnosis.residuals
    place = next(name for name in _AXES if name in table and (name != "at_speed" or "at_command" not in table))
    quantity = next(name for name in _LABELS if name in table)
    shown = table.sort_values(place)
    figure = MatplotlibFigure(figsize=(6.4, 3.4))
    axes = figure.subplots()
    axes.plot(shown[place], shown[quantity], ".", color=GREY, markersize=4.0, label="measured")
    line = "-" if place == "at_time" else ""
    axes.plot(
        shown[place], shown["base"], line + "s", color=ORANGE, fillstyle="none", markersize=3.0, label="base model"
    )
    if diagnosis.causes:
        axes.plot(
            shown[place], shown["extended"], line + "D", color=BLUE, fillstyle="none", markersize=3.0, label="extended"
        )
    axes.set(xlabel=_AXES[place], ylabel=_LABELS[quantity])
    axes.legend(fontsize=9, frameon=False)
    label = _LABELS[quantity].split(" (")[0]
    extended, found = (" and the extended model", " and with the causes found") if diagnosis.causes else ("", "")
    return to_figure(
        figure,
        "data",
        alt=f"{label} as measured, with the base model{extended}",
        caption=f"{label} as measured in the tank, with the base model{found}.",
    )


def _residual_figures(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left before and after along each axis."""
    table = diagnosis.residuals
    places = [(label, table[name].to_numpy()) for name, label in _AXES.items() if name in table]
    before, after = ([table[f"residual_{model}"].to_numpy()] for model in ("base", "extended"))
    return [against_axes(places, ResidualSeries(before, after, _UNITS[diagnosis.kind]))]


REPORTS = {
    kind: KindReport(unit=unit, data_figure=_data_figure, residual_figures=_residual_figures)
    for kind, unit in _UNITS.items()
}
"""By kind."""
