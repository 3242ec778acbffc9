"""Tables and figures of a plan of legs: costs, candidates, the policy, tracks, and what it saves."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.phases.transit.plan import LegTable
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, Table, to_figure
from missionplan.report.quantities import (
    MINUTES,
    PERCENT,
    SECONDS,
    WATT_HOURS,
    Unit,
    length_in_words,
    quantity,
    reader_unit,
    with_error,
)
from missionplan.report.wording import number, percent
from missionplan.studies.leg_length.plan_result import CandidatePlan, LegCase, LegPlan, SampledCost


def trials_table(plan: LegPlan) -> Table:
    """Tabulate what both plans cost in the trials, and by the integral equation where it covers the mission."""
    own = plan.cases[0]
    rows = [_trials_row(plan, f"fixed d_max {length_in_words(plan.fixed_d_max)}", own.fixed, plan.fixed_cost)]
    if plan.adapts:
        rows.append(_trials_row(plan, "table of legs", own.adaptive, plan.expected_cost))
    heads, caption = ["Plan", "Cost in the trials (%)", "Surfacings", "Arrive"], "Surfacing on arrival not charged."
    if plan.integral_applies:
        heads.insert(2, "Cost by the integral equation (%)")
        caption += f" By that equation, no legs cost less than {number(100.0 * plan.least_cost, 0.01)} %."
    return Table(heads, rows, caption=caption)


def _trials_row(plan: LegPlan, name: str, sampled: SampledCost, expected: float) -> list[str]:
    return [
        name,
        with_error(sampled.cost, sampled.standard_error, PERCENT.bare),
        *([number(100.0 * expected, 0.01)] if plan.integral_applies else []),
        f"{sampled.surfacings:.2f}",
        percent(sampled.arrived),
    ]


def candidates_table(plan: LegPlan) -> Table:
    """Tabulate the candidate plans by their time, energy and probability of being on time."""
    has_energy = all(np.isfinite(candidate.energy.mean) for candidate in plan.candidates)
    has_deadline = bool(np.isfinite(plan.deadline))
    heads = ["Plan", f"Speed{reader_unit('m/s', 0.0).axis}", "Mean time (min)", "95 % take at most (min)"]
    heads += ["Energy (W\u202fh)"] if has_energy else []
    heads += ["On time"] if has_deadline else []
    rows = [_candidate_row(candidate, has_energy, has_deadline) for candidate in plan.candidates]
    return Table(
        heads, rows, caption="The same trials for all plans, other ones than those on which the plans were chosen."
    )


def _candidate_row(candidate: CandidatePlan, has_energy: bool, has_deadline: bool) -> list[str]:
    duration, energy = candidate.duration, candidate.energy
    row = [
        candidate.name,
        reader_unit("m/s", 0.0).cell(candidate.speed, ".3g"),
        with_error(duration.mean, duration.standard_error, MINUTES.bare),
        number(duration.p95 / 60.0, 2.1 * duration.standard_error / 60.0),
    ]
    row += [with_error(energy.mean, energy.standard_error, WATT_HOURS.bare)] if has_energy else []
    return row + ([percent(candidate.on_time)] if has_deadline else [])


def cases_table(plan: LegPlan) -> Table:
    """Tabulate the costs when the errors are as planned and when they are not."""
    heads = ["Errors", "Fixed d_max (%)"]
    if plan.adapts:
        what, unit = saving_unit(plan)
        heads += ["Table (%)", f"{what}{unit.axis}"]
    rows = [_case_row(plan, case) for case in plan.cases]
    return Table(heads, rows, caption=f"Every row has the same {'two plans' if plan.adapts else 'plan'}.")


def _case_row(plan: LegPlan, case: LegCase) -> list[str]:
    costs = [case.fixed, case.adaptive] if plan.adapts else [case.fixed]
    named = case.name if case.probability is None else f"{case.name} ({100.0 * case.probability:.0f}\u00a0%)"
    row = [named or "as the mission", *(with_error(it.cost, it.standard_error, PERCENT.bare) for it in costs)]
    unit = saving_unit(plan)[1].bare
    return [*row, with_error(*case.saving_for(plan.aim), unit)] if plan.adapts else row


def saving_unit(plan: LegPlan) -> tuple[str, Unit]:
    """Return what the table saves by the aim, as a heading, and its unit."""
    if plan.aim == "energy":
        return "Energy saved", Unit("W\u202fh", JOULES_PER_WATT_HOUR)
    if plan.aim == "p95":
        return ("On time more often", Unit("%", 0.01)) if np.isfinite(plan.deadline) else ("95 % time saved", SECONDS)
    return "Time saved", SECONDS


def saving_in_words(plan: LegPlan) -> str:
    """Write what the table would save by the aim: ``save 2.6 ± 0.4 s on average``."""
    saved = with_error(*plan.cases[0].saving_for(plan.aim), saving_unit(plan)[1])
    if plan.aim == "energy":
        return f"save {saved}"
    if plan.aim == "p95":
        return f"bring {saved} more in time" if np.isfinite(plan.deadline) else f"save 95 % of the transits {saved}"
    return f"save {saved} on average"


def policy_figure(plan: LegPlan) -> Figure:
    """Draw leg length, and where the legs of a table aim, against distance left."""
    if not plan.recommended:
        return _fixed_figure(plan)
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


def _fixed_figure(plan: LegPlan) -> Figure:
    """Draw the leg length of a fixed d_max; it aims at the target itself, so that there is no more to show."""
    figure = MatplotlibFigure(figsize=(6.0, 2.9))
    draw_lengths(figure.subplots(), plan)
    return to_figure(
        figure,
        "policy",
        alt=(
            f"Leg length against distance left: {quantity(plan.fixed_d_max, 'm', '.0f')}, or what is left "
            "where that is less"
        ),
        caption="The fixed d_max, which aims at the target itself when it can.",
    )


def draw_lengths(axes: Axes, plan: LegPlan) -> None:
    """Draw leg length against distance left, on linear axes."""
    knots = _knots(plan)
    left = np.union1d(np.linspace(plan.arrival_radius, plan.distance, 400), knots)
    colour, width = _fixed_look(plan)
    axes.plot(left / 1000.0, np.minimum(left, plan.fixed_d_max) / 1000.0, color=colour, linewidth=width)
    if plan.recommended:
        table = LegTable(plan.left, plan.leg)
        axes.plot(left / 1000.0, table(left) / 1000.0, color=BLUE)
        axes.plot(knots / 1000.0, table(knots) / 1000.0, ".", color=BLUE, markersize=5)
    axes.set(xlim=(0.0, None), ylim=(0.0, None))
    name_axis(axes.xaxis, "Distance left", "km")
    name_axis(axes.yaxis, "Leg length", "km")
    axes.annotate("best fixed d_max", (0.03, 0.9), xycoords="axes fraction", color=colour)


def draw_aims(axes: Axes, plan: LegPlan) -> None:
    """Draw how far short of the target legs are aimed, on logarithmic axes."""
    left = np.union1d(np.geomspace(plan.arrival_radius, plan.distance, 400), _knots(plan))
    colour, width = _fixed_look(plan)
    short = _short(left, np.minimum(left, plan.fixed_d_max))
    axes.plot(left, short, color=colour, linewidth=width)
    some_stop_short = bool(np.isfinite(short).any())
    if plan.recommended:
        by_table = _short(left, LegTable(plan.left, plan.leg)(left))
        axes.plot(left, by_table, color=BLUE)
        some_stop_short |= bool(np.isfinite(by_table).any())
    radius = plan.arrival_radius
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


def _knots(plan: LegPlan) -> Array:
    """Knots of the table within the transit's range [m]."""
    return plan.left[(plan.left > plan.arrival_radius) & (plan.left <= plan.distance)]


def _fixed_look(plan: LegPlan) -> tuple[str, float | None]:
    """Colour and line width of the fixed d_max: thin and grey beside a table."""
    return (GREY, 1.0) if plan.recommended else (BLUE, None)


def _short(left: Array, leg: Array) -> Array:
    """Distance by which legs stop short of the target; nan where they aim at it [m]."""
    return np.where(leg < left, left - leg, np.nan)


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
    count, both = plan.fixed_tracks.shape[2], ", with the same errors, by both plans" if plan.recommended else ""
    return to_figure(
        figure,
        "tracks",
        alt=f"Tracks of {count} trials{' by both plans' if plan.recommended else ''}, with dots where they surface",
        caption=(
            f"{'The same ' if plan.recommended else ''}{count} trials{both}; across the course the scale is larger. "
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
    return to_figure(
        figure,
        "robustness",
        alt=f"{what} by the table, against the best fixed d_max, when the errors are as planned and when not",
        caption="With 95 % intervals, paired trial by trial. Right of the line the table is better.",
    )


def draw_savings(axes: Axes, plan: LegPlan) -> None:
    """Draw what the table saves in each case."""
    place = np.arange(len(plan.cases))[::-1]
    what, unit = saving_unit(plan)
    saved, error = np.array([case.saving_for(plan.aim) for case in plan.cases]).T / unit.size
    axes.errorbar(saved, place, xerr=1.96 * np.nan_to_num(error), fmt="o", color=BLUE, markersize=5)
    axes.axvline(0.0, color=GREY, linewidth=1.0)
    axes.set_yticks(place, [_wrapped(case.name or "as the mission") for case in plan.cases])
    axes.set(xlabel=f"{what} by the table{unit.axis}", ylim=(-0.6, len(plan.cases) - 0.4))
    axes.grid(visible=False, axis="y")


def _wrapped(words: str) -> str:
    """Break long words of a label in two lines."""
    if len(words) < 28:
        return words
    middle = words.rfind(" ", 0, 28)
    return f"{words[:middle]}\n{words[middle + 1 :]}"
