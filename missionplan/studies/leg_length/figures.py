"""Figures of legs: the cost of each d_max (Fig. 8), surfacings; the policy of a plan, tracks, and what it saves."""

import textwrap
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, GRID, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import PERCENT, SECONDS, WATT_HOURS, Unit, length_in_words, quantity
from missionplan.report.readings import Slider
from missionplan.report.wording import number, share, typeset
from missionplan.studies.leg_length.plan_result import LegPlan
from missionplan.studies.leg_length.sweep_result import Sweep, SweepCurve, SweepPoint


def saving_unit(plan: LegPlan) -> tuple[str, Unit]:
    """Return what the table saves by the aim, as a heading, and its unit."""
    if plan.aim == "energy":
        return "Energy saved", WATT_HOURS
    if plan.aim == "p95":
        return ("On time more often", PERCENT) if np.isfinite(plan.deadline) else ("95 % time saved", SECONDS)
    return "Time saved", SECONDS


def policy_figure(plan: LegPlan) -> Figure:
    """Draw leg length, and where the legs of a table aim, against distance left; a fixed d_max aims at the target."""
    if not plan.recommended:
        figure = MatplotlibFigure(figsize=(6.0, 2.9))
        draw_lengths(figure.subplots(), plan)
        fixed = quantity(plan.fixed_d_max, "m", ".0f")
        alt = f"Leg length against distance left: {fixed}, or what is left where that is less"
        return to_figure(figure, "policy", alt, "The fixed d_max, which aims at the target itself when it can.")
    figure = MatplotlibFigure(figsize=(6.0, 5.4))
    legs, aims = figure.subplots(2, 1)
    draw_lengths(legs, plan)
    draw_aims(aims, plan)
    return to_figure(
        figure,
        "policy",
        alt=(
            "Leg length against distance left: far out legs stop short of the target, near it they end "
            f"just inside the arrival circle of {quantity(plan.arrival_radius, 'm', '.0f')}"
        ),
        caption=(
            "Blue: the table, dots its knots; grey: the best fixed d_max, which aims at the target itself when it can. "
            "Above, leg length; below, how far short of the target a leg is aimed."
        ),
    )


def draw_lengths(axes: Axes, plan: LegPlan) -> None:
    """Draw leg length against distance left, on linear axes."""
    knots = plan.left[(plan.left > plan.arrival_radius) & (plan.left <= plan.distance)]
    left = np.union1d(np.linspace(plan.arrival_radius, plan.distance, 400), knots)
    colour, width = (GREY, 1.0) if plan.recommended else (BLUE, None)
    axes.plot(left / 1000.0, np.minimum(left, plan.fixed_d_max) / 1000.0, color=colour, linewidth=width)
    if plan.recommended:
        axes.plot(left / 1000.0, plan.table(left) / 1000.0, color=BLUE)
        axes.plot(knots / 1000.0, plan.table(knots) / 1000.0, ".", color=BLUE, markersize=5)
    axes.set(xlim=(0.0, None), ylim=(0.0, None))
    name_axis(axes.xaxis, "Distance left", "km")
    name_axis(axes.yaxis, "Leg length", "km")
    axes.annotate("best fixed d_max", (0.03, 0.9), xycoords="axes fraction", color=colour)


def draw_aims(axes: Axes, plan: LegPlan) -> None:
    """Draw how far short of the target legs are aimed, on logarithmic axes."""
    radius = plan.arrival_radius
    knots = plan.left[(plan.left > radius) & (plan.left <= plan.distance)]
    left = np.union1d(np.geomspace(radius, plan.distance, 400), knots)
    legs = [np.minimum(left, plan.fixed_d_max), *([plan.table(left)] if plan.recommended else [])]
    looks = ((GREY, 1.0), (BLUE, None)) if plan.recommended else ((BLUE, None),)
    for leg, (colour, width) in zip(legs, looks, strict=True):
        axes.plot(left, np.where(leg < left, left - leg, np.nan), color=colour, linewidth=width)
    some_stop_short = any(np.any(leg < left) for leg in legs)
    axes.axhline(radius, color=ORANGE, linewidth=1.0, linestyle=(0, (4, 3)))
    axes.annotate(
        "arrival radius", (left[-1], radius), xytext=(0, 3), textcoords="offset points", ha="right", color=ORANGE
    )
    axes.set(xscale="log")
    name_axis(axes.xaxis, "Distance left", "m")
    name_axis(axes.yaxis, "Leg stops short of\nthe target by", "m")
    axes.set_xlim(left[0], left[-1])
    if some_stop_short:
        axes.set(yscale="log")
    else:  # every leg aims at the target itself: a logarithmic axis would have nothing to show
        axes.set(ylim=(0.0, 2.0 * radius))
    for axis in (axes.xaxis, axes.yaxis) if some_stop_short else (axes.xaxis,):
        low, high = axis.get_view_interval()
        axis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set_minor_formatter(_with_first_digit("25" if high > 10.0 * low else "2468"))


def _with_first_digit(digits: str) -> Callable[[float, float], str]:
    """Label the ticks whose first digit is one of these, so that labels do not overlap."""
    return lambda value, _: f"{value:g}" if f"{value:g}"[0] in digits else ""


def tracks_figure(plan: LegPlan) -> Figure:
    """Draw tracks of the same trials by both plans, or by the one there is, along and across the course."""
    plans = [(f"Best fixed d_max, {quantity(plan.fixed_d_max, 'm', '.0f')}", plan.fixed_tracks)]
    plans += [("Table", plan.adaptive_tracks)] if plan.recommended else []
    figure = MatplotlibFigure(figsize=(6.0, 0.2 + 2.4 * len(plans)))
    rows = figure.subplots(len(plans), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, (title, tracks) in zip(rows, plans, strict=True):
        _draw_tracks(axes, plan, tracks)
        axes.set(title=title)
        name_axis(axes.yaxis, "Across, to port", "m")
    name_axis(rows[-1].xaxis, "Along the course", "km")
    trials, both = (
        counted(plan.fixed_tracks.shape[2], "trial"),
        ", with the same errors, by both plans" if plan.recommended else "",
    )
    return to_figure(
        figure,
        "tracks",
        alt=f"Tracks of {trials}{' by both plans' if plan.recommended else ''}, with dots where they surface",
        caption=(
            f"{'The same ' if plan.recommended else ''}{trials}{both}; across the course the scale is larger. "
            "Dots: at the surface; ellipse: the arrival circle."
        ),
    )


def _draw_tracks(axes: Axes, plan: LegPlan, tracks: Array) -> None:
    """Draw the arrival circle and tracks of shape (2, m, j), turned so that the course runs to the right."""
    start = plan.fixed_tracks[:, 0, :1]
    course = np.array(plan.goal) - start[:, 0]
    length = np.hypot(*course)
    along = course / length
    across = np.array([-along[1], along[0]])
    rim = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = (length + plan.arrival_radius * np.cos(rim), plan.arrival_radius * np.sin(rim))
    axes.plot(circle[0] / 1000.0, circle[1], color=ORANGE, linewidth=1.0)
    for trial in range(tracks.shape[2]):
        points = tracks[:, :, trial] - start
        points = points[:, ~np.isnan(points[0])]
        axes.plot(along @ points / 1000.0, across @ points, ".-", linewidth=0.9, markersize=5)


def cases_figure(plan: LegPlan) -> Figure:
    """Draw the time or energy saved when the errors are as planned and when they are not, with 95 % intervals."""
    figure = MatplotlibFigure(figsize=(6.0, 0.8 + 0.42 * len(plan.cases)))
    draw_savings(figure.subplots(), plan)
    what, _ = saving_unit(plan)
    alt = f"{what} by the table, against the best fixed d_max, when the errors are as planned and when not"
    caption = "With 95 % intervals, paired trial by trial. Right of the line the table is better."
    return to_figure(figure, "robustness", alt, caption)


def draw_savings(axes: Axes, plan: LegPlan) -> None:
    """Draw what the table saves in each case."""
    place = np.arange(len(plan.cases))[::-1]
    what, unit = saving_unit(plan)
    saved, error = np.array([case.saving_for(plan.aim) for case in plan.cases]).T / unit.size
    axes.errorbar(saved, place, xerr=1.96 * np.nan_to_num(error), fmt="o", color=BLUE, markersize=5)
    axes.axvline(0.0, color=GREY, linewidth=1.0)
    axes.set_yticks(place, [textwrap.fill(case.title, 27) for case in plan.cases])
    axes.set(xlabel=f"{what} by the table{unit.axis}", ylim=(-0.6, len(plan.cases) - 0.4))
    axes.grid(visible=False, axis="y")


COLOURS = (BLUE, ORANGE, GREEN, PINK, YELLOW, SKY)
X_LABEL = "Maximum leg length d_max / distance"


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
    """Draw the curve of each velocity error, and the critical points.

    The axis cuts off short legs, whose cost grows without bound, and goes below zero where the arrival circle shortens
    the way by more than errors cost.
    """
    points = [point for curve in sweep.curves for point in curve.points if np.isfinite(point.cost)]
    costs = [point.cost for point in points if point.d_max_over_distance >= 0.15] or [point.cost for point in points]
    top = float(np.ceil(115.0 * max(costs))) if costs else 1.0
    least = min((curve.best.cost for curve in sweep.curves if np.isfinite(curve.best.cost)), default=0.0)
    for curve, colour in zip(sweep.curves, COLOURS * len(sweep.curves), strict=False):
        _draw_curve(axes, curve, colour, sampled=sweep.method != "analytic")
    for critical in (place for place in sweep.critical_points if place >= 0.19):  # the next are too close to each other
        axes.axvline(critical, color=GRID, linewidth=1.0, linestyle=(0, (4, 3)), zorder=0)
        label = "1" if critical == 1.0 else f"1/{round(1.0 / critical)}"
        axes.annotate(label, (critical, top), ha="center", va="bottom", fontsize=8.5, annotation_clip=False)
    bottom = 100.0 * least - 0.05 * top if least < 0.0 else 0.0
    axes.set(xlabel=X_LABEL, ylabel="Mean cost c (%)", ylim=(bottom, top), xlim=(0.0, 1.0))
    _name_curves(axes, sweep, top)


def _name_curves(axes: Axes, sweep: Sweep, top: float) -> None:
    """Write the velocity error of each curve right of its end, below `top` [%] where labels leave room."""
    height = -np.inf
    for cost, index in sorted((100.0 * curve.points[-1].cost, index) for index, curve in enumerate(sweep.curves)):
        height = max(min(cost, top) if np.isfinite(cost) else 0.0, height + 0.07 * top)  # labels do not overlap
        axes.annotate(
            _name(sweep.curves[index]),
            (1.0, height),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=9,
            color=COLOURS[index % len(COLOURS)],
            annotation_clip=False,
        )


def _name(curve: SweepCurve) -> str:
    return f"σ_v {quantity(curve.sigma, 'm/s', '.3g')}"


def _along_d_max(sweep: Sweep) -> Slider:
    """What each d_max comes to, for the control under the figure."""

    def point_in_words(point: SweepPoint) -> str:
        if not np.isfinite(point.cost):
            return "none arrives"
        cost = number(100.0 * point.cost, 100.0 * point.standard_error)
        return f"cost {cost} %, {share(point.arrived)} arrive, {point.surfacings:.1f} surfacings"

    points = sweep.middle.points
    texts = []
    for index, point in enumerate(points):
        costs = "; ".join(f"{_name(curve)}: {point_in_words(curve.points[index])}" for curve in sweep.curves)
        texts.append(typeset(f"{length_in_words(point.d_max)}. {costs}."))
    places = [point.d_max_over_distance for point in points]
    return Slider("d_max", places, texts, places.index(sweep.middle.recommended.d_max_over_distance))


def _draw_curve(axes: Axes, curve: SweepCurve, colour: str, *, sampled: bool) -> None:
    ratio = np.array([point.d_max_over_distance for point in curve.points])
    cost = 100.0 * np.array([point.cost for point in curve.points])
    name = _name(curve)
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


def surfacings_figure(sweep: Sweep) -> Figure:
    """Draw the mean number of surfacings against d_max."""
    figure = MatplotlibFigure(figsize=(6.0, 2.8))
    draw_surfacings(figure.subplots(), sweep)
    return to_figure(figure, "surfacings", alt="Mean number of surfacings falls as legs grow longer")


def draw_surfacings(axes: Axes, sweep: Sweep) -> None:
    """Draw the mean number of surfacings for each velocity error."""
    for curve, colour in zip(sweep.curves, COLOURS * len(sweep.curves), strict=False):
        places, counts = zip(*((point.d_max_over_distance, point.surfacings) for point in curve.points), strict=True)
        axes.plot(places, counts, color=colour, label=_name(curve))
    axes.set(xlabel=X_LABEL, ylabel="Surfacings (mean)", yscale="log", xlim=(0.0, 1.0))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(_with_first_digit("25"))
    axes.legend()
