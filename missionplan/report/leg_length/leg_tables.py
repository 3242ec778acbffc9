"""Tables of a plan of legs: costs in the trials, costs when errors are not as planned, and plans by their aim."""

import numpy as np

from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.report.numbers import number, percent
from missionplan.report.page import Table
from missionplan.report.quantities import Unit, length_in_words, reader_unit, with_error
from missionplan.results.leg_length.leg_cases import CandidatePlan, LegCase, SampledCost
from missionplan.results.leg_length.legs import LegPlan

_BARE_PERCENT = Unit("", 0.01)
_BARE_MINUTES = Unit("", 60.0)
_SECONDS = Unit("s", 1.0)
_BARE_WATT_HOURS = Unit("", JOULES_PER_WATT_HOUR)


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
        with_error(sampled.cost, sampled.standard_error, _BARE_PERCENT),
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
        with_error(duration.mean, duration.standard_error, _BARE_MINUTES),
        number(duration.p95 / 60.0, 2.1 * duration.standard_error / 60.0),
    ]
    row += [with_error(energy.mean, energy.standard_error, _BARE_WATT_HOURS)] if has_energy else []
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
    row = [named or "as the mission", *(with_error(it.cost, it.standard_error, _BARE_PERCENT) for it in costs)]
    unit = Unit("", saving_unit(plan)[1].size)
    return [*row, with_error(*case.saving_for(plan.aim), unit)] if plan.adapts else row


def saving_unit(plan: LegPlan) -> tuple[str, Unit]:
    """Return what the table saves by the aim, as a heading, and its unit."""
    if plan.aim == "energy":
        return "Energy saved", Unit("W\u202fh", JOULES_PER_WATT_HOUR)
    if plan.aim == "p95":
        return ("On time more often", Unit("%", 0.01)) if np.isfinite(plan.deadline) else ("95 % time saved", _SECONDS)
    return "Time saved", _SECONDS


def saving_in_words(plan: LegPlan) -> str:
    """Write what the table would save by the aim: ``save 2.6 ± 0.4 s on average``."""
    saved = with_error(*plan.cases[0].saving_for(plan.aim), saving_unit(plan)[1])
    if plan.aim == "energy":
        return f"save {saved}"
    if plan.aim == "p95":
        return f"bring {saved} more in time" if np.isfinite(plan.deadline) else f"save 95 % of the transits {saved}"
    return f"save {saved} on average"
