"""Figures of a sweep of d_max: the cost curve of Fig. 8, a close-up about its least cost, and the surfacings."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.html.readings import Slider
from missionplan.report.page import BLUE, GREEN, GRID, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import MINUTES, length_in_words, quantity, time_in_words
from missionplan.report.wording import number, share, typeset
from missionplan.studies.leg_length.sweep_result import Sweep, SweepCurve

_COLOURS = (BLUE, ORANGE, GREEN, PINK, YELLOW, SKY)
_X_LABEL = "Maximum leg length d_max / distance"


def cost_figure(sweep: Sweep) -> Figure:
    """Draw cost against d_max for every velocity error, after Fig. 8."""
    figure = MatplotlibFigure(figsize=(6.0, 4.2))
    draw_costs(figure.subplots(), sweep)
    best, count = sweep.middle.best, len(sweep.curves)
    return to_figure(
        figure,
        "cost",
        alt=(
            f"Mean cost against maximum leg length for {count} velocity error{'s' if count > 1 else ''}: saw-toothed "
            f"curves, high for short legs; least cost {100 * best.cost:.1f} % at {best.d_max_over_distance:.2f} of the "
            "distance"
        ),
        caption=(
            "Cost c = (t_f − t_nom)/t_nom of each maximum leg length, the surfacing on arrival not charged. Dots: "
            "Monte Carlo with 95 % bands; thin line: the integral equation, where it applies; circle: the best; "
            "dashed: the critical points 1/a of the distance."
            + (" Level dashes: the mission's own table of legs." if sweep.curves[0].table is not None else "")
        ),
        slider=_along_d_max(sweep),
    )


def draw_costs(axes: Axes, sweep: Sweep) -> None:
    """Draw the curve of each velocity error, and the critical points."""
    top = _upper_limit(sweep)
    for curve, colour in zip(sweep.curves, _COLOURS * len(sweep.curves), strict=False):
        _draw_curve(axes, curve, colour, sampled=sweep.method != "analytic")
    _mark_critical_points(axes, sweep.critical_points, top)
    axes.set(xlabel=_X_LABEL, ylabel="Mean cost c (%)", ylim=(_lower_limit(sweep), top), xlim=(0.0, 1.0))
    _label_curves(axes, sweep.curves, top)


def _upper_limit(sweep: Sweep) -> float:
    """Upper end of the cost axis [%]; it cuts off short legs, whose cost grows without bound."""
    points = [point for curve in sweep.curves for point in curve.points if np.isfinite(point.cost)]
    costs = [point.cost for point in points if point.d_max_over_distance >= 0.15] or [point.cost for point in points]
    return float(np.ceil(115.0 * max(costs))) if costs else 1.0


def _lower_limit(sweep: Sweep) -> float:
    """Lower end of the cost axis [%]: below zero where the arrival circle shortens the way by more than errors cost."""
    least = min((curve.best.cost for curve in sweep.curves if np.isfinite(curve.best.cost)), default=0.0)
    return 100.0 * least - 0.05 * _upper_limit(sweep) if least < 0.0 else 0.0


def _along_d_max(sweep: Sweep) -> Slider:
    """What each d_max comes to, for the control under the figure."""
    points = sweep.middle.points
    texts = []
    for index, point in enumerate(points):
        costs = [
            f"σ_v {quantity(curve.sigma, 'm/s', 'g')}: "
            + (
                f"cost {number(100.0 * curve.points[index].cost, 100.0 * curve.points[index].standard_error)} %, "
                f"{share(curve.points[index].arrived)} arrive, {curve.points[index].surfacings:.1f} surfacings"
                if np.isfinite(curve.points[index].cost)
                else "none arrives"
            )
            for curve in sweep.curves
        ]
        texts.append(typeset(f"{length_in_words(point.d_max)}. {'; '.join(costs)}."))
    places = [point.d_max_over_distance for point in points]
    return Slider("d_max", places, texts, places.index(sweep.middle.recommended.d_max_over_distance))


def _draw_curve(axes: Axes, curve: SweepCurve, colour: str, *, sampled: bool) -> None:
    ratio = np.array([point.d_max_over_distance for point in curve.points])
    cost = 100.0 * np.array([point.cost for point in curve.points])
    name = f"σ_v {quantity(curve.sigma, 'm/s', 'g')}"
    if sampled:
        error = 196.0 * np.array([point.standard_error for point in curve.points])
        axes.fill_between(ratio, cost - error, cost + error, color=colour, alpha=0.25, linewidth=0.0, label=name)
        axes.plot(ratio, cost, ".", color=colour, markersize=3.5, label=name)
    analytic = [point.cost_analytic for point in curve.points if point.cost_analytic is not None]
    if len(analytic) == len(curve.points):
        axes.plot(ratio, 100.0 * np.array(analytic), color=colour, linewidth=0.8, label="" if sampled else name)
    elif sampled:
        axes.plot(ratio, cost, color=colour, linewidth=0.8)
    if curve.table is not None:
        axes.axhline(100.0 * curve.table.cost, color=colour, linewidth=1.2, linestyle=(0, (6, 2)))
    best = curve.best
    axes.plot(
        best.d_max_over_distance, 100.0 * best.cost, "o", color=colour, fillstyle="none", markersize=9, label=name
    )


def _mark_critical_points(axes: Axes, critical_points: Sequence[float], top: float) -> None:
    """Draw a line at each d_max/L = 1/a (Briggs et al., Eq. 27) that is not too close to the next."""
    for critical in (place for place in critical_points if place >= 0.19):
        axes.axvline(critical, color=GRID, linewidth=1.0, linestyle=(0, (4, 3)), zorder=0)
        denominator = round(1.0 / critical)
        label = "1" if denominator == 1 else f"1/{denominator}"
        axes.annotate(label, (critical, top), ha="center", va="bottom", fontsize=8.5, annotation_clip=False)


def _label_curves(axes: Axes, curves: Sequence[SweepCurve], top: float) -> None:
    """Label each curve at its right end, spaced so that labels do not overlap."""
    ends = sorted((100.0 * curve.points[-1].cost, index) for index, curve in enumerate(curves))
    height = -np.inf
    for cost, index in ends:
        height = max(min(cost, top) if np.isfinite(cost) else 0.0, height + 0.07 * top)
        axes.annotate(
            f"σ_v {quantity(curves[index].sigma, 'm/s', 'g')}",
            (1.0, height),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=9,
            color=_COLOURS[index % len(_COLOURS)],
            annotation_clip=False,
        )


def close_up_figure(sweep: Sweep, curve: SweepCurve) -> Figure:
    """Draw one curve about its least cost, and mark what cannot be distinguished from the best."""
    figure = MatplotlibFigure(figsize=(6.0, 3.2))
    axes = figure.subplots()
    colour = _COLOURS[sweep.curves.index(curve) % len(_COLOURS)]
    shown = [point for point in curve.points if point.d_max_over_distance >= 0.3] or list(curve.points)
    ratio = np.array([point.d_max_over_distance for point in shown])
    cost = np.array([MINUTES(point.cost * sweep.nominal_time) for point in shown])
    error = np.array([1.96 * MINUTES(point.standard_error * sweep.nominal_time) for point in shown])
    axes.errorbar(ratio, cost, error, fmt=".-", color=colour, linewidth=0.8, markersize=5, elinewidth=0.8)
    good = np.array([point.as_good for point in shown])
    axes.plot(ratio[good], cost[good], "o", color=colour, markersize=8, fillstyle="none")
    axes.set(xlabel=_X_LABEL, ylabel="Mean time lost (min)")
    return to_figure(
        figure,
        "close-up",
        alt="Mean time lost against maximum leg length, with a sharp rise just above each critical point",
        caption=(
            f"Time lost against the nominal {time_in_words(sweep.nominal_time)} for σ_v = "
            f"{quantity(curve.sigma, 'm/s', 'g')}, with "
            "95 % intervals. Circles: the trials cannot distinguish these d_max from the best."
        ),
    )


def surfacings_figure(sweep: Sweep) -> Figure:
    """Draw the mean number of surfacings against d_max."""
    figure = MatplotlibFigure(figsize=(6.0, 2.8))
    draw_surfacings(figure.subplots(), sweep)
    return to_figure(figure, "surfacings", alt="Mean number of surfacings falls as legs grow longer")


def draw_surfacings(axes: Axes, sweep: Sweep) -> None:
    """Draw the mean number of surfacings for each velocity error."""
    for curve, colour in zip(sweep.curves, _COLOURS * len(sweep.curves), strict=False):
        ratio = [point.d_max_over_distance for point in curve.points]
        axes.plot(
            ratio,
            [point.surfacings for point in curve.points],
            color=colour,
            label=f"σ_v {quantity(curve.sigma, 'm/s', 'g')}",
        )
    axes.set(xlabel=_X_LABEL, ylabel="Surfacings (mean)", yscale="log", xlim=(0.0, 1.0))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:g}"[0] in "25" else "")
    axes.legend()
