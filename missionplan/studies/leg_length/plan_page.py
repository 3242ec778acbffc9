"""Report of `plan-legs`: the table of legs, what it saves, and how far that can be relied on."""

from collections.abc import Iterator

import numpy as np

from missionplan.report.explained import (
    first_do,
    hangs_on_doubt,
    judged_in_words,
    members_in_words,
    members_section,
    too_few,
    works,
)
from missionplan.report.page import Cells, Listing, Page, PageSection, Table
from missionplan.report.quantities import (
    MINUTES,
    PERCENT,
    SECONDS,
    WATT_HOURS,
    length_in_words,
    quantity,
    reader_unit,
    time_in_words,
    with_error,
)
from missionplan.report.wording import number, percent, phase_in_words, share
from missionplan.results.decision import FAILURE_LOSS
from missionplan.studies.leg_length.figures import (
    cases_figure,
    draw_aims,
    draw_lengths,
    draw_savings,
    policy_figure,
    saving_unit,
    tracks_figure,
)
from missionplan.studies.leg_length.plan_result import LegPlan

_SAILED = "The plan that is recommended, with all trials in one member; what it expects is the ensemble's mean."
_APPROXIMATE = (
    "The legs were planned with an approximation. Their cost is taken from the mission's own trials, other ones than "
    "those on which the legs were chosen."
)


def page(plan: LegPlan) -> Page:
    """Build the page of a plan of legs."""
    good = plan.reaches and works(plan.judged)
    case, (head, unit) = plan.cases[0], saving_unit(plan)
    costs = [(f"Mean cost of the best fixed d_max, {length_in_words(plan.fixed_d_max)}", case.fixed)]
    costs = [("Mean cost of the table", case.adaptive), *costs] if plan.adapts else costs
    numbers = [(name, with_error(it.cost, it.standard_error, PERCENT)) for name, it in costs]
    if plan.adapts:
        saved = with_error(*case.saving_for(plan.aim), unit)
        numbers.insert(0, (f"{head}, against the best fixed d_max", saved))
    return Page(
        title=f"Legs for {phase_in_words(plan.phase)}: {plan.provenance.mission}",
        answer=answer(plan),
        draw=lambda: policy_figure(plan),
        numbers=numbers,
        write=lambda: list(_sections(plan)),
        verdict="bad" if not good else "" if not plan.recommended else "good" if _is_firm(plan) else "undecided",
        table=lambda: _cells(plan),
        plots={"legs": draw_lengths, "aims": draw_aims, "savings": draw_savings},
    )


def _cells(plan: LegPlan) -> Cells:
    """Tabulate for a terminal: the table of legs where it is recommended, else what shows that it is not."""
    if not plan.recommended:
        shown = cases_table(plan)
        return shown.columns, shown.rows
    unit = reader_unit("m", float(plan.left.max()))
    rows = [
        [unit.cell(length, ".1f") for length in (left, leg, max(left - leg, 0.0))]
        for left, leg in zip(plan.left, plan.leg, strict=True)
    ]
    columns = [f"{what}{unit.axis}" for what in ("Distance left", "Leg", "Short of the target by")]
    return columns, rows


def answer(plan: LegPlan) -> str:
    """Write whether to let the legs adapt, what it saves, and whether what is in doubt changes that."""
    if not np.isfinite(plan.chosen.cost):
        return _choice(plan)
    sailed = members_in_words(plan.arrivals, "arrives")
    return f"{_choice(plan)}{judged_in_words(plan.judged)}{_doubt_in_words(plan)}{sailed and f' {sailed}'}"


def _is_firm(plan: LegPlan) -> bool:
    """Whether the answer may be an order: a table serves under each explanation; a fixed d_max was tried over all."""
    explained = [case for case in plan.cases if case.probability is not None]
    gains = [case.saving_for(plan.aim)[0] > 0.0 for case in explained]
    if hangs_on_doubt(
        plan.chosen.arrived, [(member.probability, member.good) for member in plan.arrivals], plan.required_arrival
    ):
        return False
    if too_few(plan.chosen.arrived):
        return False
    return first_do(plan.judged, plan.phase) is None and (all(gains) if plan.recommended else not explained)


def _doubt_in_words(plan: LegPlan) -> str:
    """Say whether the choice between table and fixed d_max is the same under each explanation; nothing without any."""
    explained = [case for case in plan.cases if case.probability is not None]
    if not explained or not plan.adapts:
        return ""
    gaining = [case for case in explained if case.saving_for(plan.aim)[0] > 0.0]
    if len(gaining) in (0, len(explained)):
        return f" Whichever explanation holds, the table {'saves' if gaining else 'saves nothing'}."
    losing = " or ".join(case.name for case in explained if case not in gaining)
    return f" It depends on which explanation holds: with {losing} the table saves nothing."


def _choice(plan: LegPlan) -> str:
    fixed = f"the best fixed d_max, {length_in_words(plan.fixed_d_max)}"
    speed = _speed_in_words(plan) if plan.aim == "energy" else ""
    if not plan.reaches:
        arriving = share(plan.chosen.arrived)
        what = "the table of legs" if plan.recommended else f"a fixed d_max of {length_in_words(plan.fixed_d_max)}"
        rule = f"with a failure counted as {FAILURE_LOSS:g} missions, {what} is best"
        if np.isfinite(plan.deadline):
            rule = f"{what} keeps the deadline of {time_in_words(plan.deadline)} most often"
        if not np.isfinite(plan.chosen.cost):
            return "No legs arrive of all that were tried."
        few = f"No legs arrive as often as {100.0 * plan.required_arrival:g}\u00a0%"
        return f"{few}; {rule}, and arrives in {arriving} of the trials.{speed}"
    settles = too_few(plan.chosen.arrived) or first_do(plan.judged, plan.phase) or ""
    not_yet = f"Nothing to choose yet:{settles} as the mission stands,"
    if not plan.recommended:
        what = f"a fixed d_max of {length_in_words(plan.fixed_d_max)}"
        lead = f"Take {what}" if _is_firm(plan) else f"{not_yet} {what} is best"
        return f"{lead}: {_why_fixed(plan)}.{speed}"
    lead = "Let the legs adapt" if _is_firm(plan) else f"{not_yet} legs that adapt are best"
    if plan.aim == "p95":
        return f"{lead}: {_slow_transits_in_words(plan, fixed)}"
    case = plan.cases[0]
    if plan.aim == "energy":
        saved = with_error(*case.saving_for("energy"), WATT_HOURS)
        return f"{lead}: they need {saved} less energy than {fixed}.{speed}"
    saved = with_error(*case.saving_for("mean"), SECONDS if case.saved.mean < 120.0 else MINUTES)
    return f"{lead}: the transit then takes {saved} less on average than with {fixed}."


def _why_fixed(plan: LegPlan) -> str:
    """Write why the table is not worth taking: the first of the conditions that it fails."""
    would_save = f"a table of legs would {saving_in_words(plan)}"
    if not plan.adapts or not plan.saves_for_certain:
        return "no table of legs does better for certain (three standard errors) in the trials"
    if not plan.saves_enough:
        return f"{would_save}, no more than 1\u00a0% of the whole"
    if not plan.keeps_arrivals:
        case = plan.cases[0]
        return f"a table of legs would arrive less often, {share(case.adaptive.arrived)} of the time"
    doubts = " or with ".join(case.name for case in plan.losing)
    return f"{would_save} in the mission as planned, but save nothing or lose with {doubts}"


def _slow_transits_in_words(plan: LegPlan, fixed: str) -> str:
    best, table = plan.candidates[0], plan.candidates[-1]
    if np.isfinite(plan.deadline):
        return (
            f"{percent(table.on_time)} of the transits keep the deadline of {time_in_words(plan.deadline)}; with "
            f"{fixed}, {percent(best.on_time)} do."
        )
    return (
        f"95 % of the transits then take at most {time_in_words(table.value)}, "
        f"{time_in_words(best.value - table.value)} less than with {fixed}."
    )


def _speed_in_words(plan: LegPlan) -> str:
    chosen, base = (plan.candidates[index].energy for index in (0, 1))
    needs, needed = (with_error(energy.mean, energy.standard_error, WATT_HOURS) for energy in (chosen, base))
    lead = "Go at" if _is_firm(plan) else "The best speed is"
    return (
        f" {lead} {quantity(plan.speed, 'm/s', '.3g')}: with a fixed d_max that needs {needs}; at the mission's "
        f"{quantity(plan.mission_speed, 'm/s', '.3g')} it needs {needed}."
    )


def _cases_section(plan: LegPlan) -> PageSection:
    """Show what errors other than planned cost."""
    if not plan.adapts:
        return PageSection("What the transit costs when the errors are not as planned", [cases_table(plan)])
    heading = "The table still saves when the errors are not as planned"
    if plan.losing:
        heading = "The table saves nothing with " + ", or ".join(case.name for case in plan.losing)
    return PageSection(heading, [cases_figure(plan), cases_table(plan)])


def _surfacings_in_words(plan: LegPlan) -> str:
    case = plan.cases[0]
    if not plan.recommended:
        return f"The vehicle surfaces {number(case.fixed.surfacings, 0.02)} times on average"
    return (
        f"The vehicle surfaces {case.adaptive.surfacings:.2f} times on average with the table, "
        f"{case.fixed.surfacings:.2f} times with the best fixed d_max"
    )


def _sections(plan: LegPlan) -> Iterator[PageSection]:
    case = plan.cases[0]
    if not plan.integral_applies:
        yield PageSection("Only the trials show what the legs cost", [_APPROXIMATE, trials_table(plan)])
    if plan.candidates:
        yield _candidates_section(plan)
    yield from members_section(plan.arrivals, "plan", "arrive (95 % interval)", _SAILED)
    if plan.recommended:  # a fixed d_max stands among what changes
        spread = f"σ_v = {with_error(plan.planned_sigma, 0.0, reader_unit('m/s', 0.0))}"
        if plan.base_spread > 0.0:
            spread += (
                f" and for {with_error(plan.base_spread, 0.0, reader_unit('m', plan.base_spread))} of spread "
                "at the end of any leg, however short"
            )
        words = (
            f"{plan.how_found} The legs are planned for {spread}. Each knot is [distance left, leg length]; between "
            "knots, leg length is linear. The table is also in legs.yaml, and in its place in mission-with-legs.yaml."
        )
        yield PageSection("What to write in the mission file", [words, _changes_as_written(plan)])
    if np.isfinite(case.fixed.surfacings):
        yield PageSection(_surfacings_in_words(plan), [tracks_figure(plan)])
    yield _cases_section(plan)
    if plan.integral_applies:
        compared = [(case.fixed, plan.fixed_cost), *([(case.adaptive, plan.expected_cost)] if plan.adapts else [])]
        agree = all(abs(trials.cost - expected) <= 3.0 * trials.standard_error for trials, expected in compared)
        is_known = all(np.isfinite(trials.standard_error) for trials, _ in compared)
        differ = "differ by more than chance" if is_known else "cannot be compared"
        heading = f"Trials and integral equation {'agree' if agree else differ}"
        yield PageSection(heading, [trials_table(plan)])


def _candidates_section(plan: LegPlan) -> PageSection:
    """Write which candidate does best by the aim, or why the fixed d_max is kept."""
    has_deadline = bool(np.isfinite(plan.deadline))
    best = max(plan.candidates, key=lambda candidate: candidate.value if has_deadline else -candidate.value)
    choice = best.name if plan.recommended else f"the fixed d_max is kept, as {_why_fixed(plan)}"
    what = "Least energy" if plan.aim == "energy" else "Most often on time" if has_deadline else "Shortest 95 % time"
    return PageSection(f"{what}: {choice}", [plan.how_found, candidates_table(plan)])


def _changes_as_written(plan: LegPlan) -> Listing:
    """Write the changed keys of the transit as a mission file may hold them, one knot per line."""
    lines = [f"{key}: {value}" for key, value in plan.changes.items() if isinstance(value, str)]
    if not isinstance(plan.d_max, str):
        lines += ["d_max:", "  table:", *(f"    - [{left}, {leg}]" for left, leg in plan.d_max["table"])]
    return Listing("\n".join(lines))


def trials_table(plan: LegPlan) -> Table:
    """Tabulate what both plans cost in the trials, and by the integral equation where it covers the mission."""
    case = plan.cases[0]
    plans = [(f"fixed d_max {length_in_words(plan.fixed_d_max)}", case.fixed, plan.fixed_cost)]
    plans += [("table of legs", case.adaptive, plan.expected_cost)] if plan.adapts else []
    rows = [
        [name, with_error(it.cost, it.standard_error, PERCENT.bare), number(it.surfacings, 0.02), percent(it.arrived)]
        for name, it, _ in plans
    ]
    heads = ["Plan", "Cost in the trials (%)", "Surfacings", "Arrive"]
    caption = (
        "The question is whether legs that depend on the distance left beat all of one length, the best by the legs' "
        "equation. Surfacing on arrival not charged."
    )
    if plan.integral_applies:
        heads.insert(2, "Cost by the integral equation (%)")
        for row, (_, _, expected) in zip(rows, plans, strict=True):
            row.insert(2, number(100.0 * expected, 0.01))
        caption += f" By that equation, no legs cost less than {number(100.0 * plan.least_cost, 0.01)} %."
    return Table(heads, rows, caption=caption)


def candidates_table(plan: LegPlan) -> Table:
    """Tabulate the candidate plans by their time, energy and probability of being on time."""
    has_energy = all(np.isfinite(candidate.energy.mean) for candidate in plan.candidates)
    has_deadline, speed = bool(np.isfinite(plan.deadline)), reader_unit("m/s", 0.0)
    heads = ["Plan", f"Speed{speed.axis}", "Mean time (min)", "95 % take at most (min)"]
    heads += ["Energy (W\u202fh)"] if has_energy else []
    heads += ["On time"] if has_deadline else []
    rows = []
    for candidate in plan.candidates:
        duration, energy = candidate.duration, candidate.energy
        row = [candidate.name, speed.cell(candidate.speed, ".3g")]
        row.append(with_error(duration.mean, duration.standard_error, MINUTES.bare))
        late = candidate.value if plan.aim == "p95" and plan.reaches and not has_deadline else duration.p95
        row.append(number(late / 60.0, 2.1 * duration.standard_error / 60.0))
        row += [with_error(energy.mean, energy.standard_error, WATT_HOURS.bare)] if has_energy else []
        rows.append(row + ([percent(candidate.on_time)] if has_deadline else []))
    caption = "The same trials for all plans, other ones than those on which the plans were chosen."
    return Table(heads, rows, caption=caption)


def cases_table(plan: LegPlan) -> Table:
    """Tabulate the costs when the errors are as planned and when they are not."""
    what, unit = saving_unit(plan)
    heads = ["Errors", "Fixed d_max (%)", *(["Table (%)", f"{what}{unit.axis}"] if plan.adapts else [])]
    rows = []
    for case in plan.cases:
        likely = "" if case.probability is None else f" ({100.0 * case.probability:.0f}\u00a0%)"
        costs = [case.fixed, case.adaptive] if plan.adapts else [case.fixed]
        row = [case.title + likely, *(with_error(it.cost, it.standard_error, PERCENT.bare) for it in costs)]
        rows.append([*row, *([with_error(*case.saving_for(plan.aim), unit.bare)] if plan.adapts else [])])
    caption = f"Every row has the same {'two plans' if plan.adapts else 'plan'}."
    if plan.aim == "p95" and not np.isfinite(plan.deadline):
        caption += f" Where fewer than 95\u00a0% arrive, each failure counts as {FAILURE_LOSS:g} missions."
    return Table(heads, rows, caption=caption)


def saving_in_words(plan: LegPlan) -> str:
    """Write what the table would save by the aim: ``save 2.6 ± 0.4 s on average``."""
    saved = with_error(*plan.cases[0].saving_for(plan.aim), saving_unit(plan)[1])
    if plan.aim == "energy":
        return f"save {saved}"
    if plan.aim == "p95":
        return f"bring {saved} more in time" if np.isfinite(plan.deadline) else f"save 95 % of the transits {saved}"
    return f"save {saved} on average"
