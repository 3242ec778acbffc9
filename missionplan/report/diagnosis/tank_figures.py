"""Figures of a diagnosis of tank data."""

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.diagnosis import Diagnosis

TANK_UNITS = {"drag": "N", "free-oscillation": "m", "thruster": "N", "propeller-transient": "N"}
"""Kinds of the tank and the unit of what they explain."""
_LABELS = {"force_n": "Drag (N)", "thrust_n": "Thrust (N)", "displacement_m": "Displacement (m)"}
_AXES = {"at_time": "Time (s)", "at_speed": "Speed (m/s)", "at_command": "Command (V or rev/s)"}


def tank_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the data against the first of their axes, with both models."""
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
    axes.legend(fontsize=8, frameon=False)
    label = _LABELS[quantity].split(" (")[0]
    return to_figure(
        figure,
        "data",
        alt=f"{label} as measured, with the base model and the extended model",
        caption=f"{label} as measured in the tank, with the base model and with the causes found.",
    )


def tank_residual_figure(diagnosis: Diagnosis) -> Figure:
    """Draw what is left before and after along each axis."""
    table, unit = diagnosis.residuals, TANK_UNITS[diagnosis.kind]
    places = [name for name in _AXES if name in table]
    figure = MatplotlibFigure(figsize=(6.4, 4.2))
    panels = figure.subplots(2, len(places), sharey=True, sharex="col", squeeze=False)
    for row, (column, colour) in enumerate((("residual_base", ORANGE), ("residual_extended", BLUE))):
        for axes, place in zip(panels[row], places, strict=True):
            axes.axhline(0.0, color="#dddddd", linewidth=0.8)
            axes.plot(table[place], table[column], ".", color=colour, markersize=3.0)
        panels[row, 0].set_ylabel(f"{('Before', 'After')[row]} ({unit})")
    for axes, place in zip(panels[1], places, strict=True):
        axes.set_xlabel(_AXES[place], fontsize=8.5)
    rms = [float(np.sqrt(np.mean(table[column] ** 2))) for column in ("residual_base", "residual_extended")]
    return to_figure(
        figure,
        "residuals",
        alt=f"Residuals before and after against {', '.join(_AXES[place] for place in places)}",
        caption=f"What is left of the data: {rms[0]:.3g} {unit} rms before and {rms[1]:.3g} {unit} after.",
    )
