"""Report of `sweep-dmax`: what to choose, what it saves, and the curve of Fig. 8."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.numbers import Unit, number, with_error
from missionplan.report.page import Figure, Page, PageSection, Table, Terminal, to_figure
from missionplan.results.sweep import Sweep, SweepCurve, SweepPoint

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_PERCENT = Unit("%", 0.01)
_MINUTES = Unit("min", 60.0)


def page(sweep: Sweep) -> Page:
    """Build the page of a sweep."""
    main = middle(sweep)
    best = main.best
    numbers = [
        ("Best d_max", f"{_length(best.d_max)} ({number(best.d_max_over_distance)} of the distance)"),
        ("Its mean cost", with_error(best.cost, best.standard_error, _PERCENT)),
        ("Saved against one leg", with_error(sweep.saving(main), _saving_error(sweep, main), _MINUTES)),
    ]
    return Page(
        title=f"Maximum leg length for {sweep.phase}: {sweep.provenance.mission}",
        answer=answer(sweep),
        figure=cost_figure(sweep),
        numbers=numbers,
        sections=[
            PageSection("What each velocity error asks for", [best_table(sweep), _as_good_words(sweep)]),
            *_table_section(sweep),
            *_arrival_section(sweep),
            PageSection("Why the curve has teeth", [_TEETH, close_up_figure(sweep, main)]),
            PageSection(
                "How often the vehicle surfaces", [surfacings_figure(sweep), "The arrival's surfacing is counted."]
            ),
            PageSection("The numbers behind the curves", [cost_table(sweep)]),
        ],
    )


_TEETH = (
    "With d_max at 1/a of the distance the last of a legs aims at the goal itself. It misses by more than the "
    "arrival radius more often than not, so that one more surfacing is due, and the way back from wherever it ended is "
    "lost. With d_max a little shorter the long legs stop short of the goal: the same surfacing comes on the way, and "
    "a short last leg with a small error takes the vehicle in. So the cost is low just below each critical point and "
    "high at it and above; where a whole leg errs by less than the arrival radius, the teeth are small or turn round."
)


def terminal(sweep: Sweep) -> Terminal:
    """Build the terminal's view of a sweep."""
    return Terminal(answer(sweep), *_best_rows(sweep))


def answer(sweep: Sweep) -> str:
    """Say what to choose and what it saves, in plain words."""
    curve = middle(sweep)
    best, saved = curve.best, sweep.saving(curve)
    if not np.isfinite(best.cost):
        return f"With σ_v = {curve.sigma:g} m/s no plan of this sweep arrives."
    choice = f"Choose d_max = {_length(best.d_max)} for σ_v = {curve.sigma:g} m/s"
    time = f"the transit then takes {_minutes(sweep.nominal_time * (1.0 + best.cost))} on average"
    if saved > 2.0 * _saving_error(sweep, curve):
        return f"{choice}: {time}, {_minutes(saved)} less than in one leg."
    return f"{choice}: {time}; one leg does as well."


def middle(sweep: Sweep) -> SweepCurve:
    """The velocity error that the answer is about: the middle one."""
    return sorted(sweep.curves, key=lambda curve: curve.sigma)[(len(sweep.curves) - 1) // 2]


def _saving_error(sweep: Sweep, curve: SweepCurve) -> float:
    return float(np.hypot(curve.one_leg.standard_error, curve.best.standard_error)) * sweep.nominal_time


def _length(metres: float) -> str:
    return f"{metres / 1000.0:.2f}\u00a0km" if metres >= 1000.0 else f"{metres:.0f}\u00a0m"


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f}\u00a0s" if seconds < 90.0 else f"{seconds / 60.0:.1f}\u00a0min"


def cost_figure(sweep: Sweep) -> Figure:
    """Draw cost against d_max for every velocity error, after Fig. 8."""
    figure = MatplotlibFigure(figsize=(6.0, 4.2))
    axes = figure.subplots()
    top = _top(sweep)
    for curve, colour in zip(sweep.curves, _COLOURS * len(sweep.curves), strict=False):
        _draw_curve(axes, curve, colour, sampled=sweep.method != "analytic")
    for critical in sweep.critical_points:
        if critical >= 0.19:
            axes.axvline(critical, color="#dddddd", linewidth=1.0, linestyle=(0, (4, 3)), zorder=0)
            denominator = round(1.0 / critical)
            axes.annotate(
                "1" if denominator == 1 else f"1/{denominator}",
                (critical, top),
                ha="center",
                va="bottom",
                fontsize=8.5,
                annotation_clip=False,
            )
    axes.set(xlabel="Maximum leg length d_max / distance", ylabel="Mean cost c (%)", ylim=(0.0, top), xlim=(0.0, 1.0))
    _label_curves(axes, sweep.curves, top)
    best = middle(sweep).best
    return to_figure(
        figure,
        "cost",
        alt=(
            f"Mean cost against maximum leg length for {len(sweep.curves)} velocity errors: saw-toothed curves, high "
            f"for short legs; least cost {100 * best.cost:.1f} % at {best.d_max_over_distance:.2f} of the distance"
        ),
        caption=(
            "Cost c = (t_f − t_nom)/t_nom of each maximum leg length, the arrival surfacing not charged. Dots: Monte "
            "Carlo with 95 % bands; thin line: the integral equation, where it applies; circle: the best; dashed: the "
            "critical points 1/a of the distance."
            + (" Level dashes: the mission's own table of legs." if sweep.curves[0].table is not None else "")
        ),
    )


def _top(sweep: Sweep) -> float:
    """Upper end of the cost axis [%]: what is worth seeing, cut where short legs cost without bound."""
    right = [p.cost for c in sweep.curves for p in c.points if p.d_max_over_distance >= 0.15 and np.isfinite(p.cost)]
    costs = right or [p.cost for c in sweep.curves for p in c.points if np.isfinite(p.cost)]
    return float(np.ceil(115.0 * max(costs))) if costs else 1.0


def _draw_curve(axes: Axes, curve: SweepCurve, colour: str, *, sampled: bool) -> None:
    ratio = np.array([point.d_max_over_distance for point in curve.points])
    cost = 100.0 * np.array([point.cost for point in curve.points])
    analytic = [point.cost_analytic for point in curve.points]
    if sampled:
        error = 196.0 * np.array([point.standard_error for point in curve.points])
        axes.fill_between(ratio, cost - error, cost + error, color=colour, alpha=0.25, linewidth=0.0)
        axes.plot(ratio, cost, ".", color=colour, markersize=3.5)
    if all(value is not None for value in analytic):
        axes.plot(ratio, 100.0 * np.array(analytic, dtype=float), color=colour, linewidth=0.8)
    elif sampled:
        axes.plot(ratio, cost, color=colour, linewidth=0.8)
    if curve.table is not None:
        axes.axhline(100.0 * curve.table.cost, color=colour, linewidth=1.2, linestyle=(0, (6, 2)))
    best = curve.best
    axes.plot(best.d_max_over_distance, 100.0 * best.cost, "o", color=colour, fillstyle="none", markersize=9)


def _label_curves(axes: Axes, curves: Sequence[SweepCurve], top: float) -> None:
    """Name each curve at its right end, spread so that names do not overlap."""
    ends = sorted((100.0 * curve.points[-1].cost, index) for index, curve in enumerate(curves))
    height = -np.inf
    for cost, index in ends:
        height = max(min(cost, top) if np.isfinite(cost) else 0.0, height + 0.07 * top)
        axes.annotate(
            f"σ_v {curves[index].sigma:g} m/s",
            (1.0, height),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=9,
            color=_COLOURS[index % len(_COLOURS)],
            annotation_clip=False,
        )


def close_up_figure(sweep: Sweep, curve: SweepCurve) -> Figure:
    """Draw the middle curve about its least cost, with what cannot be told from the best."""
    figure = MatplotlibFigure(figsize=(6.0, 3.2))
    axes = figure.subplots()
    colour = _COLOURS[sweep.curves.index(curve) % len(_COLOURS)]
    shown = [point for point in curve.points if point.d_max_over_distance >= 0.3] or list(curve.points)
    ratio = np.array([point.d_max_over_distance for point in shown])
    cost = np.array([_MINUTES(point.cost * sweep.nominal_time) for point in shown])
    error = np.array([1.96 * _MINUTES(point.standard_error * sweep.nominal_time) for point in shown])
    axes.errorbar(ratio, cost, error, fmt=".-", color=colour, linewidth=0.8, markersize=5, elinewidth=0.8)
    good = np.array([point.as_good for point in shown])
    axes.plot(ratio[good], cost[good], "o", color=colour, markersize=8, fillstyle="none")
    axes.set(xlabel="Maximum leg length d_max / distance", ylabel="Mean time lost (min)")
    return to_figure(
        figure,
        "close-up",
        alt="Mean time lost against maximum leg length, with a sharp rise just above each critical point",
        caption=(
            f"Time lost against the nominal {_minutes(sweep.nominal_time)} for σ_v = {curve.sigma:g} m/s, with 95 % "
            "intervals. Circles: what the trials cannot tell from the best."
        ),
    )


def surfacings_figure(sweep: Sweep) -> Figure:
    """Draw the mean number of surfacings against d_max."""
    figure = MatplotlibFigure(figsize=(6.0, 2.8))
    axes = figure.subplots()
    for curve, colour in zip(sweep.curves, _COLOURS * len(sweep.curves), strict=False):
        ratio = [point.d_max_over_distance for point in curve.points]
        axes.plot(ratio, [point.surfacings for point in curve.points], color=colour, label=f"σ_v {curve.sigma:g} m/s")
    axes.set(xlabel="Maximum leg length d_max / distance", ylabel="Surfacings (mean)", yscale="log", xlim=(0.0, 1.0))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:g}"[0] in "25" else "")
    axes.legend()
    return to_figure(figure, "surfacings", alt="Mean number of surfacings falls as legs grow longer")


def _best_rows(sweep: Sweep) -> tuple[list[str], list[list[str]]]:
    columns = ["σ_v (m/s)", "Best d_max", "of distance", "Mean cost (%)", "One leg (%)", "Saved (min)"]
    rows = [
        [
            f"{curve.sigma:g}",
            _length(curve.best.d_max),
            f"{curve.best.d_max_over_distance:.3f}",
            _bare(curve.best.cost, curve.best.standard_error, _PERCENT),
            _bare(curve.one_leg.cost, curve.one_leg.standard_error, _PERCENT),
            _bare(sweep.saving(curve), _saving_error(sweep, curve), _MINUTES),
        ]
        for curve in sweep.curves
    ]
    return columns, rows


def _bare(value: float, error: float, unit: Unit) -> str:
    """Write a number with its error; the unit stands in the column's head."""
    return with_error(value, error, Unit("", unit.size))


def best_table(sweep: Sweep) -> Table:
    """Tabulate the best d_max of each velocity error."""
    caption = f"Nominal time {_minutes(sweep.nominal_time)} over {_length(sweep.distance)} at {sweep.speed:g} m/s."
    return Table(*_best_rows(sweep), caption=caption)


def _as_good_words(sweep: Sweep) -> str:
    """Say what the trials cannot tell from the best."""
    parts = []
    for curve in sweep.curves:
        ratios = [point.d_max_over_distance for point in curve.as_good]
        if ratios:
            low, high = f"{min(ratios):.3f}", f"{max(ratios):.3f}"
            parts.append(f"{low if low == high else f'{low} to {high}'} for σ_v = {curve.sigma:g} m/s")
    return (
        f"As good as the best, as far as these trials tell (cost higher by less than two standard errors of the paired "
        f"difference), is a d_max of these shares of the distance: {'; '.join(parts)}."
    )


def _table_section(sweep: Sweep) -> list[PageSection]:
    """Set the mission's own table of legs beside the best fixed d_max, where it has one."""
    rows = [
        [
            f"{curve.sigma:g}",
            _bare(curve.table.cost, curve.table.standard_error, _PERCENT),
            _bare(curve.best.cost, curve.best.standard_error, _PERCENT),
            _bare(
                (curve.best.cost - curve.table.cost) * sweep.nominal_time, _table_error(sweep, curve.table), _MINUTES
            ),
        ]
        for curve in sweep.curves
        if curve.table is not None
    ]
    if not rows:
        return []
    heads = ["σ_v (m/s)", "Table (%)", "Best fixed d_max (%)", "The table saves (min)"]
    return [PageSection("The mission's own table of legs beside a fixed d_max", [Table(heads, rows)])]


def _table_error(sweep: Sweep, table: SweepPoint) -> float:
    return table.excess_error * sweep.nominal_time


def _arrival_section(sweep: Sweep) -> list[PageSection]:
    """Say how many never arrive, where any does not."""
    worst = min((p for c in sweep.curves for p in c.points), key=lambda point: point.arrived.value)
    if worst.arrived.value >= 1.0:
        return []
    words = (
        f"At d_max = {_length(worst.d_max)} only {100 * worst.arrived.value:.1f} % of the trials arrive within the "
        "mission's max_legs. Costs are means over the trials that arrived: where some did not, they flatter the plan."
    )
    return [PageSection("Not every trial arrives", [words])]


def cost_table(sweep: Sweep) -> Table:
    """Tabulate cost against d_max, thinned to what a reader takes in; all of it is in `sweep.csv`."""
    count = len(sweep.curves[0].points)
    chosen = sorted({round(index) for index in np.linspace(0, count - 1, min(count, 21))})
    columns = ["d_max / distance", "d_max", *(f"Cost (%), σ_v {curve.sigma:g} m/s" for curve in sweep.curves)]
    rows = [
        [
            f"{_point(sweep, index).d_max_over_distance:.3f}",
            _length(_point(sweep, index).d_max),
            *(_bare(c.points[index].cost, c.points[index].standard_error, _PERCENT) for c in sweep.curves),
        ]
        for index in chosen
    ]
    return Table(columns, rows, caption=f"{len(rows)} of {count} rows; all of them are in sweep.csv.")


def _point(sweep: Sweep, index: int) -> SweepPoint:
    return sweep.curves[0].points[index]
