"""Report of `sweep-dmax`: which d_max to choose, what it saves, and the curve of Fig. 8."""

from collections.abc import Sequence

import numpy as np

from missionplan.report.explained import (
    first_do,
    hangs_on_doubt,
    judged_in_words,
    members_in_words,
    members_section,
    too_few,
    what_would_tell,
    works,
)
from missionplan.report.page import Page, PageSection, Table
from missionplan.report.quantities import (
    MINUTES,
    PERCENT,
    length_in_words,
    quantity,
    reader_unit,
    time_in_words,
    with_error,
)
from missionplan.report.wording import number, percent, phase_in_words, portion_in_words, share
from missionplan.results.decision import FAILURE_LOSS, label
from missionplan.studies.leg_length.figures import cost_figure, draw_costs, draw_surfacings, surfacings_figure
from missionplan.studies.leg_length.sweep_result import Sweep, SweepCurve

_WHY_TEETH = (
    "With d_max at 1/a of the distance, the last of a legs aims at the goal itself. More often than not it misses by "
    "more than the arrival radius, so that the vehicle must surface once more and come back from wherever it ended. "
    "With d_max a little shorter, the long legs stop short of the goal: the extra surfacing then comes on the way, and "
    "a short last leg with a small error takes the vehicle in. So the cost is low just below each critical point, and "
    "high at it and just above. Where a whole leg errs by less than the arrival radius, teeth are small or reversed."
)
_COUNTED = "The surfacing on arrival is counted."
_SAILED = "With the recommended d_max of the middle curve, and all trials in one member."
_FEWEST_FOR_TEETH = 12
"""Points of a curve below which no tooth can be told."""


def page(sweep: Sweep) -> Page:
    """Build the page of a sweep."""
    curve = sweep.middle
    chosen = curve.recommended
    what = "Recommended d_max" if curve.reaches(chosen) else "Best d_max, failures counted"
    toothed = has_teeth(curve, sweep.critical_points)
    surfacings = (
        f"With the d_max chosen for σ_v = {quantity(curve.sigma, 'm/s', '.3g')} the vehicle surfaces "
        f"{chosen.surfacings:.1f} times on average"
    )
    return Page(
        title=f"Maximum leg length for {phase_in_words(sweep.phase)}: {sweep.provenance.mission}",
        answer=answer(sweep),
        draw=lambda: cost_figure(sweep),
        numbers=[
            (what, f"{length_in_words(chosen.d_max)} ({number(chosen.d_max_over_distance)} of the distance)"),
            ("Trials that arrive with it", percent(chosen.arrived)),
            ("Mean cost of those that arrive", with_error(chosen.cost, chosen.standard_error, PERCENT)),
        ],
        write=lambda: [
            PageSection(_choice_heading(sweep), [choice_table(sweep), *filter(None, [_as_good_in_words(sweep)])]),
            *_explanation_section(sweep),
            *members_section(sweep.members, "plan", "arrive (95 % interval)", _SAILED),
            *_table_section(sweep),
            *_arrival_section(sweep),
            *([PageSection("The cost jumps at each critical point", [_WHY_TEETH])] if toothed else []),
            *([PageSection(surfacings, [surfacings_figure(sweep), _COUNTED])] if np.isfinite(chosen.cost) else []),
            PageSection("The numbers behind the curves", [cost_table(sweep)]),
        ],
        verdict="" if works(sweep.judged) and curve.reaches(chosen) else "bad",
        table=lambda: _chosen_rows(sweep),
        plots={"cost": draw_costs, "surfacings": draw_surfacings},
    )


def answer(sweep: Sweep) -> str:
    """Write which d_max to choose, what it saves, and what the mission with it does."""
    curve = sweep.middle
    chosen = curve.recommended
    sigma, d_max = f"σ_v = {quantity(curve.sigma, 'm/s', '.3g')}", length_in_words(chosen.d_max)
    judged, members = judged_in_words(sweep.judged), members_in_words(sweep.members, "arrives")
    members = members and f" {members}"
    if not np.isfinite(chosen.cost):
        return f"With {sigma} no plan of this sweep arrives."
    time, arriving = time_in_words(sweep.nominal_time * (1.0 + chosen.cost)), share(chosen.arrived)
    if not curve.reaches(chosen):
        return (
            f"With {sigma} no d_max of this sweep arrives as often as {100.0 * curve.required_arrival:g}\u00a0%; "
            f"with a failure counted as {FAILURE_LOSS:g} missions, {d_max} is best: {arriving} of the trials arrive, "
            f"and the mean time of the {arriving} that arrive is {time}.{members}{judged}"
        )
    took = f"the transit then takes {time} on average"
    if chosen.arrived.value < 1.0:
        took = f"{arriving} of the trials arrive, and the mean time of the {arriving} that arrive is {time}"
    first = first_do(sweep.judged, sweep.phase)
    hangs = hangs_on_doubt(
        chosen.arrived, [(member.probability, member.good) for member in sweep.members], curve.required_arrival
    )
    few = too_few(chosen.arrived)
    firm = first is None and not (hangs or few) and all(explanation.keeps_choice for explanation in sweep.explanations)
    settles = few or first or (f" first {what_would_tell(())};" if hangs else "")
    lead = "Choose" if firm else f"Nothing to choose yet:{settles} as the mission stands,"
    lead = f"{lead} d_max = {d_max}{'' if firm else ' is best'}"
    return f"{lead} for {sigma}: {took}{_against_one_leg(sweep)}.{_doubt_in_words(sweep)}{members}{judged}"


def _doubt_in_words(sweep: Sweep) -> str:
    """Say whether what is in doubt changes the choice; nothing for a mission without doubts."""
    if not sweep.explanations:
        return ""
    others = [explanation for explanation in sweep.explanations if not explanation.keeps_choice]
    if not others:
        return " Whichever explanation holds, this d_max is as good as the best for it, to 1\u00a0% of the time."
    worst = max(others, key=lambda explanation: (not explanation.curve.reaches(explanation.chosen), explanation.excess))
    best = f"with {label(worst.causes)} it is {length_in_words(worst.curve.recommended.d_max)}"
    loses = f"takes {100.0 * worst.excess:.0f}\u00a0% longer"
    if not worst.curve.reaches(worst.chosen):
        loses = f"arrives in {share(worst.chosen.arrived)} of the trials"
    return f" But {best}, and the other {loses} then: first find out which explanation holds."


def _explanation_section(sweep: Sweep) -> list[PageSection]:
    """Tabulate what is best under each explanation, and what the choice over all of them loses."""
    rows = [
        [
            label(explanation.causes),
            portion_in_words(explanation.probability, 1),
            length_in_words(explanation.curve.recommended.d_max),
            share(explanation.chosen.arrived),
            f"{100.0 * explanation.excess:.1f}\u00a0%" if np.isfinite(explanation.excess) else "–",
        ]
        for explanation in sweep.explanations
    ]
    columns = "explanation", "probability", "best d_max for it", "arrive with the choice", "time that the choice loses"
    note = "The middle curve again, with each explanation known to hold; the same random numbers."
    return [PageSection("Which explanation holds", [Table(columns, rows, note)])] if rows else []


def _against_one_leg(sweep: Sweep) -> str:
    """Write what the recommended d_max saves against a single leg, where both arrive as often as required."""
    curve = sweep.middle
    if not curve.reaches(curve.one_leg):
        return f"; in one leg {share(curve.one_leg.arrived)} arrive"
    if curve.recommended_saves > 2.0 * _saving_error(sweep, curve):
        return f", {time_in_words(curve.recommended_saves)} less than in one leg"
    return "; one leg does as well"


def _saving_error(sweep: Sweep, curve: SweepCurve) -> float:
    return float(np.hypot(curve.one_leg.standard_error, curve.recommended.standard_error)) * sweep.nominal_time


def _choice_heading(sweep: Sweep) -> str:
    ratios = sorted(curve.recommended.d_max_over_distance for curve in sweep.curves)
    low, high = f"{ratios[0]:.2f}", f"{ratios[-1]:.2f}"
    if not all(curve.reaches(curve.recommended) for curve in sweep.curves):
        return "Where no d_max arrives as often as required, the best with failures counted is shown"
    if low == high:
        return f"The recommended d_max is {low} of the distance"
    return f"The recommended d_max lies between {low} and {high} of the distance, depending on the velocity error"


def choice_table(sweep: Sweep) -> Table:
    """Tabulate the recommended d_max of each velocity error."""
    caption = (
        f"The question is which one length of all legs of {phase_in_words(sweep.phase)}, sailed alone, is best. "
        f"Nominal time {time_in_words(sweep.nominal_time)} over {length_in_words(sweep.distance)} at "
        f"{quantity(sweep.speed, 'm/s', 'g')}. Recommended is the d_max of least cost among those at which "
        f"{100.0 * sweep.middle.required_arrival:g} % of the trials arrive. Costs are of those that arrive."
    )
    return Table(*_chosen_rows(sweep), caption=caption)


def _chosen_rows(sweep: Sweep) -> tuple[list[str], list[list[str]]]:
    speed = reader_unit("m/s", 0.0)
    columns = [f"σ_v{speed.axis}", "d_max", "of distance", "Arrive", "Mean cost (%)", "One leg (%)", "Saved (min)"]
    rows = [
        [
            speed.cell(curve.sigma, ".3g"),
            length_in_words(curve.recommended.d_max),
            f"{curve.recommended.d_max_over_distance:.3f}",
            share(curve.recommended.arrived),
            with_error(curve.recommended.cost, curve.recommended.standard_error, PERCENT.bare),
            with_error(curve.one_leg.cost, curve.one_leg.standard_error, PERCENT.bare),
            with_error(curve.recommended_saves, _saving_error(sweep, curve), MINUTES.bare),
        ]
        for curve in sweep.curves
    ]
    return columns, rows


def _as_good_in_words(sweep: Sweep) -> str:
    """Write which d_max the trials cannot distinguish from the best; nothing where none arrives."""
    parts = []
    for curve in sweep.curves:
        ratios = [point.d_max_over_distance for point in curve.as_good]
        if ratios and np.isfinite(curve.recommended.cost):
            low, high = f"{min(ratios):.3f}", f"{max(ratios):.3f}"
            parts.append(
                f"{low if low == high else f'{low} to {high}'} for σ_v = {quantity(curve.sigma, 'm/s', '.3g')}"
            )
    as_good = (
        "As good as the best, as far as these trials show (cost higher by less than two standard errors of the paired "
        f"difference), is a d_max of these shares of the distance: {'; '.join(parts)}."
    )
    return as_good if parts else ""


def _table_section(sweep: Sweep) -> list[PageSection]:
    """Compare the mission's own table of legs with the best fixed d_max, where it has one."""
    speed = reader_unit("m/s", 0.0)
    rows = [
        [
            speed.cell(curve.sigma, ".3g"),
            with_error(curve.table.cost, curve.table.standard_error, PERCENT.bare),
            with_error(curve.best.cost, curve.best.standard_error, PERCENT.bare),
            with_error(
                (curve.best.cost - curve.table.cost) * sweep.nominal_time,
                curve.table.excess_error * sweep.nominal_time,
                MINUTES.bare,
            ),
        ]
        for curve in sweep.curves
        if curve.table is not None
    ]
    if not rows:
        return []
    heads = [f"σ_v{speed.axis}", "Table (%)", "Best fixed d_max (%)", "The table saves (min)"]
    return [PageSection("The mission's own table of legs beside the best fixed d_max", [Table(heads, rows)])]


def _arrival_section(sweep: Sweep) -> list[PageSection]:
    worst = min((p for c in sweep.curves for p in c.points), key=lambda point: point.arrived.value)
    if worst.arrived.value >= 1.0:
        return []
    words = (
        f"At d_max = {length_in_words(worst.d_max)} only {share(worst.arrived)} of the trials arrive within "
        "the mission's max_legs. Costs are means over the trials that arrived: where some did not, they are too low."
    )
    return [PageSection("Not every trial arrives", [words])]


def has_teeth(curve: SweepCurve, critical_points: Sequence[float]) -> bool:
    """Whether the cost jumps up at a critical point: beyond chance, and by more than it changes on either side.

    A step of the curve counts as at a critical point if it begins or ends within half a step of it.
    """
    ratio = np.array([point.d_max_over_distance for point in curve.points])
    cost = np.array([point.cost for point in curve.points])
    error = np.array([point.standard_error for point in curve.points])
    if len(ratio) < _FEWEST_FOR_TEETH or not np.isfinite(cost).all():
        return False
    rise, noise, width = np.diff(cost), np.hypot(error[1:], error[:-1]), np.diff(ratio)
    around = np.maximum(np.abs(np.roll(rise, 2)), np.abs(np.roll(rise, -2)))
    jumps = (rise > 3.0 * noise) & (rise > 2.0 * around)
    jumps[:2] = jumps[-2:] = False
    near = [
        np.minimum(np.abs(ratio[1:] - place), np.abs(ratio[:-1] - place)) <= 0.55 * width
        for place in critical_points
        if place < 1.0
    ]
    return bool(np.any(jumps & np.any(near, axis=0))) if near else False


def cost_table(sweep: Sweep) -> Table:
    """Tabulate cost against d_max at about 20 places; `sweep.csv` has all of them."""
    count = len(sweep.curves[0].points)
    chosen = sorted({round(index) for index in np.linspace(0, count - 1, min(count, 21))})
    costs = [f"Cost (%), σ_v {quantity(curve.sigma, 'm/s', '.3g')}" for curve in sweep.curves]
    rows = []
    for first, *others in ([curve.points[index] for curve in sweep.curves] for index in chosen):
        cells = [with_error(point.cost, point.standard_error, PERCENT.bare) for point in (first, *others)]
        rows.append([f"{first.d_max_over_distance:.3f}", length_in_words(first.d_max), *cells])
    caption = f"{len(rows)} of {count} rows; all of them are in sweep.csv."
    return Table(["d_max / distance", "d_max", *costs], rows, caption)
