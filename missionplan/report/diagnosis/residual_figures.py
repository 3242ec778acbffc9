"""Figures of what a diagnosis leaves of the data: against time, depth, speed, heading and place, and by lag."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.diagnosis.tank_figures import TANK_UNITS, tank_residual_figure
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.results.diagnosis import Diagnosis

_LAGS = 16


def residual_figures(diagnosis: Diagnosis) -> list[Figure]:
    """Draw what is left before and after: against the axes that matter to the kind of data, over the place, by lag."""
    if diagnosis.kind == "summary":
        return []
    if diagnosis.kind in TANK_UNITS:
        return [tank_residual_figure(diagnosis)]
    places = [_place_figure(diagnosis)] if diagnosis.kind == "transit" else []
    return [_axes_figure(diagnosis), *places, _autocorrelation_figure(diagnosis)]


def _axes_figure(diagnosis: Diagnosis) -> Figure:
    table = diagnosis.residuals
    if diagnosis.kind == "transit":
        pairs = [
            ("Time (h)", table["t_start_s"].to_numpy() / 3600.0),
            ("Heading (deg)", table["heading_deg"].to_numpy()),
        ]
        pairs.append(("Leg duration (min)", table["duration_s"].to_numpy() / 60.0))
    else:
        pairs = [("Time since separation (s)", table["t_s"].to_numpy()), ("Depth (m)", table["base_m"].to_numpy())]
        pairs.append(("Speed (m/s)", _speeds(table)))
    figure = MatplotlibFigure(figsize=(6.4, 4.2))
    panels = figure.subplots(2, len(pairs), sharey=True, sharex="col")
    before, after, unit = _before_and_after(diagnosis)
    for column, (label, place) in enumerate(pairs):
        _scatter(panels[0, column], place, before, ORANGE)
        _scatter(panels[1, column], place, after, BLUE)
        panels[1, column].set_xlabel(label, fontsize=8.5)
    panels[0, 0].set_ylabel(f"Before ({unit})")
    panels[1, 0].set_ylabel(f"After ({unit})")
    rms = [float(np.sqrt(np.mean(np.concatenate(values) ** 2))) for values in (before, after)]
    return to_figure(
        figure,
        "residuals",
        alt=f"Residuals before and after against {', '.join(label for label, _ in pairs)}",
        caption=f"What is left of the data: {rms[0]:.3g} {unit} rms before and {rms[1]:.3g} {unit} after.",
    )


def _speeds(table: pd.DataFrame) -> Array:
    parts = [
        np.gradient(run["base_m"].to_numpy(), run["t_s"].to_numpy()) for _, run in table.groupby("run", sort=False)
    ]
    return np.concatenate(parts)


def _before_and_after(diagnosis: Diagnosis) -> tuple[list[Array], list[Array], str]:
    table = diagnosis.residuals
    if diagnosis.kind == "transit":
        names = ("east", "north")
        values = [[100.0 * table[f"residual_{m}_{c}_m_s"].to_numpy() for c in names] for m in ("base", "extended")]
        return values[0], values[1], "cm/s"
    return [table["residual_base_m"].to_numpy()], [table["residual_extended_m"].to_numpy()], "m"


def _scatter(axes: Axes, place: Array, values: list[Array], colour: str) -> None:
    axes.axhline(0.0, color="#dddddd", linewidth=0.8)
    for marker, part in zip((".", "x"), values, strict=False):
        axes.plot(place, part, marker, color=colour, markersize=3.0, linestyle="none", alpha=0.8)


def _place_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the velocity errors of the legs as arrows where the legs began."""
    table = diagnosis.residuals
    east, north = (table[f"{axis}_start_m"].to_numpy() / 1000.0 for axis in ("x", "y"))
    before, after, unit = _before_and_after(diagnosis)
    longest = max(float(np.max(np.hypot(*before))), 1e-9)
    figure = MatplotlibFigure(figsize=(6.4, 3.3))
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    extent = max(float(np.ptp(east)), float(np.ptp(north)), 1e-3)
    for axes, values, colour, title in zip(panels, (before, after), (ORANGE, BLUE), ("Before", "After"), strict=True):
        axes.plot(east, north, "-", color=GREY, linewidth=0.6, alpha=0.6)
        arrows = axes.quiver(
            east, north, *values, color=colour, angles="xy", scale_units="xy", scale=5.0 * longest / extent, width=0.005
        )
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("East (km)")
        axes.set_aspect("equal")
    axes.quiverkey(
        arrows, 0.85, 0.06, 0.5 * longest, f"{0.5 * longest:.1f} {unit}", labelpos="N", fontproperties={"size": 8}
    )
    panels[0].set_ylabel("North (km)")
    return to_figure(
        figure,
        "places",
        alt="Velocity errors of the legs as arrows at the places where the legs began, before and after",
        caption="Velocity error of each leg where the leg began: what depends on the place shows as a pattern.",
    )


def _autocorrelation_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the autocorrelation of what is left: leg by leg, or reading by reading in each dive."""
    legs = diagnosis.kind == "transit"
    before, after = _series(diagnosis)
    lags = np.arange(1, max(2, min(_LAGS, min(len(part) for part in before) // 3)))
    figure = MatplotlibFigure(figsize=(6.0, 2.6))
    axes = figure.subplots()
    for values, colour, label, shift in ((before, ORANGE, "mission", -0.15), (after, BLUE, "extended", 0.15)):
        axes.vlines(
            lags + shift,
            0.0,
            [_correlation(values, lag) for lag in lags.tolist()],
            color=colour,
            linewidth=3.0,
            label=label,
        )
    limit = 1.96 / np.sqrt(sum(len(part) for part in before))
    axes.axhspan(-limit, limit, color=GREY, alpha=0.15, linewidth=0.0)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    what = "Legs" if legs else "Readings"
    axes.set(xlabel=f"{what} apart", ylabel="Autocorrelation")
    axes.legend(fontsize=8, frameon=False)
    caption = (
        f"How alike errors are some {what.lower()} apart, each the error of predicting one from those before it; "
        "independent ones stay in the grey band 19 times of 20."
    )
    return to_figure(
        figure,
        "autocorrelation",
        alt=f"Autocorrelation of what the mission's and the extended model leave, by lag in {what.lower()}",
        caption=caption,
    )


def _series(diagnosis: Diagnosis) -> tuple[list[Array], list[Array]]:
    """What is left before and after: both components of the legs, or each dive by itself."""
    if diagnosis.kind == "transit":
        before, after, _ = _before_and_after(diagnosis)
        return before, after
    runs = [run for _, run in diagnosis.residuals.groupby("run", sort=False)]
    left = [[run[f"innovation_{model}"].to_numpy() for run in runs] for model in ("base", "extended")]
    return left[0], left[1]


def _correlation(values: list[Array], lag: int) -> float:
    """Autocorrelation at a lag, about the mean of each series."""
    centred = [part - part.mean() for part in values]
    return float(sum(p[lag:] @ p[:-lag] for p in centred) / max(sum(p @ p for p in centred), 1e-30))
