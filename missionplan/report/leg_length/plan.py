"""Report of `plan-legs`: the table, what it saves, and how far that can be relied on."""

import numpy as np

from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.report.leg_length.plan_figures import cases_figure, policy_figure, tracks_figure
from missionplan.report.numbers import Unit, number, percent, with_error
from missionplan.report.page import Block, Listing, Page, PageSection, Table, Terminal
from missionplan.results.legs import CandidatePlan, LegCase, LegPlan

_PERCENT = Unit("%", 0.01)
_SECONDS = Unit("s", 1.0)
_MINUTES = Unit("min", 60.0)
_WATT_HOURS = Unit("W\u202fh", JOULES_PER_WATT_HOUR)
_BEYOND = "The trials have more than the integral equation knows"
_BEYOND_WORDS = (
    "What the legs were planned with is an approximation here; what they cost is what the mission's own trials say, "
    "other ones than those on which the legs were chosen."
)


def page(plan: LegPlan) -> Page:
    """Build the page of a plan of legs."""
    costs = [] if plan.integral_applies else [PageSection(_BEYOND, [_BEYOND_WORDS, _trials_table(plan)])]
    checked = [PageSection("Trials and integral equation", [_trials_table(plan)])] if plan.integral_applies else []
    return Page(
        title=f"Legs for {plan.phase}: {plan.provenance.mission}",
        answer=answer(plan),
        figure=policy_figure(plan),
        numbers=_numbers(plan),
        sections=[
            *costs,
            *_aim_section(plan),
            PageSection(
                "For the mission file", [*([_how_found(plan)] if plan.adapts else []), Listing(_written(plan))]
            ),
            PageSection("What the legs do", [tracks_figure(plan)]),
            PageSection(
                _robustness_heading(plan), [*([cases_figure(plan)] if plan.adapts else []), _cases_table(plan)]
            ),
            *checked,
        ],
        verdict="good" if plan.recommended else "",
    )


def _numbers(plan: LegPlan) -> list[tuple[str, str]]:
    own = plan.cases[0]
    fixed = (
        f"Mean cost of the best fixed d_max, {_length(plan.fixed_d_max)}",
        with_error(own.fixed.cost, own.fixed.standard_error, _PERCENT),
    )
    if not plan.adapts:
        return [fixed]
    return [
        _saving(plan),
        ("Mean cost of the table", with_error(own.adaptive.cost, own.adaptive.standard_error, _PERCENT)),
        fixed,
    ]


def terminal(plan: LegPlan) -> Terminal:
    """Build the terminal's view of a plan of legs."""
    rows = [
        [f"{left:.1f}", f"{leg:.1f}", f"{max(left - leg, 0.0):.1f}"]
        for left, leg in zip(plan.left, plan.leg, strict=True)
    ]
    return Terminal(answer(plan), ["Distance left (m)", "Leg (m)", "Short of the target by (m)"], rows)


def answer(plan: LegPlan) -> str:
    """Say whether to let the legs adapt, and what it saves."""
    fixed = f"the best fixed d_max, {_length(plan.fixed_d_max)}"
    at_speed = _speed_words(plan) if plan.aim == "energy" else ""
    if not plan.recommended:
        return (
            f"Keep a fixed d_max of {_length(plan.fixed_d_max)}: in the trials no table of legs does better, or not by "
            f"more than chance.{at_speed}"
        )
    own = plan.cases[0]
    if plan.aim == "energy":
        saved = with_error(own.energy_saving, own.energy_saving_error, _WATT_HOURS)
        return f"Let the legs adapt: they need {saved} less energy than {fixed}.{at_speed}"
    if plan.aim == "p95":
        best, table = plan.candidates[0], plan.candidates[-1]
        if np.isfinite(plan.deadline):
            return (
                f"Let the legs adapt: {percent(table.on_time)} of the transits keep the deadline of "
                f"{_time(plan.deadline)}, with {fixed}, {percent(best.on_time)}."
            )
        return (
            f"Let the legs adapt: 95 % of the transits then take at most {_time(table.value)}, "
            f"{_time(best.value - table.value)} less than with {fixed}."
        )
    saved = with_error(own.saving, own.saving_error, _SECONDS if own.saving < 120.0 else _MINUTES)
    return f"Let the legs adapt: the transit then takes {saved} less on average than with {fixed}."


def _speed_words(plan: LegPlan) -> str:
    slow, fast = (plan.candidates[index].energy for index in (0, 1))
    needs, needed = (with_error(energy.mean, energy.standard_error, _WATT_HOURS) for energy in (slow, fast))
    return (
        f" Go at {plan.speed:.3g} m/s: with a fixed d_max that needs {needs}, at the mission's "
        f"{plan.mission_speed:.3g} m/s {needed}."
    )


def _saving(plan: LegPlan) -> tuple[str, str]:
    saved, unit = plan.cases[0].saving_for(plan.aim), _WATT_HOURS if plan.aim == "energy" else _SECONDS
    what = "Energy saved" if plan.aim == "energy" else "Saved"
    return f"{what} against the best fixed d_max", with_error(*saved, unit)


def _how_found(plan: LegPlan) -> str:
    spread = f"σ_v = {number(plan.planned_sigma)} m/s"
    if plan.base_spread > 0.0:
        spread += f" and {number(plan.base_spread)} m that no leg escapes"
    return (
        f"{plan.how_found} The legs reckon with {spread}. Leg length is linear between the knots, [distance left, leg "
        "length]; it is in legs.yaml too, and in its place in mission-with-legs.yaml."
    )


def _written(plan: LegPlan) -> str:
    """Write what changes of the transit as a mission file may hold it, a knot a line."""
    lines = [f"{key}: {value}" for key, value in plan.changes.items() if isinstance(value, str)]
    if not isinstance(plan.d_max, str):
        lines += ["d_max:", "  table:", *(f"    - [{left}, {leg}]" for left, leg in plan.d_max["table"])]
    return "\n".join(lines)


def _aim_section(plan: LegPlan) -> list[PageSection]:
    """Compare the plans by what the legs were chosen for; nothing for the mean time."""
    if not plan.candidates:
        return []
    heads = ["Plan", "Speed (m/s)", "Mean time (min)", "95 % take at most (min)"]
    energies = all(np.isfinite(candidate.energy.mean) for candidate in plan.candidates)
    heads += ["Energy (W\u202fh)"] if energies else []
    heads += ["On time"] if np.isfinite(plan.deadline) else []
    words = {
        "p95": "The deadline decides, not the mean" if np.isfinite(plan.deadline) else "The slow transits decide",
        "energy": "Energy decides, and the speed with it",
    }
    rows = [_candidate_row(candidate, energies, plan.deadline) for candidate in plan.candidates]
    caption = "The same trials for all plans, other than those that the plans were chosen on."
    return [PageSection(words[plan.aim], [plan.how_found, Table(heads, rows, caption=caption)])]


def _candidate_row(candidate: CandidatePlan, energies: bool, deadline: float) -> list[str]:
    duration, energy = candidate.duration, candidate.energy
    row = [
        candidate.name,
        f"{candidate.speed:.3g}",
        with_error(duration.mean, duration.standard_error, Unit("", 60.0)),
        number(duration.p95 / 60.0, 2.1 * duration.standard_error / 60.0),
    ]
    row += [with_error(energy.mean, energy.standard_error, Unit("", JOULES_PER_WATT_HOUR))] if energies else []
    return row + ([percent(candidate.on_time)] if np.isfinite(deadline) else [])


def _trials_table(plan: LegPlan) -> Block:
    own = plan.cases[0]
    plans = (
        (f"fixed d_max {_length(plan.fixed_d_max)}", plan.fixed_cost, own.fixed),
        *([("table of legs", plan.expected_cost, own.adaptive)] if plan.adapts else []),
    )
    rows = [
        [
            name,
            with_error(sampled.cost, sampled.standard_error, Unit("", 0.01)),
            *([number(100.0 * expected, 0.01)] if plan.integral_applies else []),
            f"{sampled.surfacings:.2f}",
            percent(sampled.arrived),
        ]
        for name, expected, sampled in plans
    ]
    heads, caption = ["Plan", "Cost in the trials (%)", "Surfacings", "Arrive"], "Arrival surfacing not charged."
    if plan.integral_applies:
        heads.insert(2, "Cost by the integral equation (%)")
        caption += f" The least that any legs cost by that equation is {number(100.0 * plan.least_cost, 0.01)} %."
    return Table(heads, rows, caption=caption)


def _robustness_heading(plan: LegPlan) -> str:
    if not plan.adapts:
        return "What the transit costs when the errors are not as planned"
    losing = [case.name for case in plan.cases[1:] if not case.saving_for(plan.aim)[0] > 0.0]
    if not losing:
        return "The table still saves when the errors are not as planned"
    return "The table loses its advantage with " + ", or ".join(losing)


def _cases_table(plan: LegPlan) -> Table:
    heads = ["Errors", "Fixed d_max (%)"]
    if plan.adapts:
        heads += ["Table (%)", "Energy saved (W\u202fh)" if plan.aim == "energy" else "Time saved (s)"]
    rows = [_case_row(plan, case) for case in plan.cases]
    return Table(heads, rows, caption="Neither plan is changed." if plan.adapts else "The plan is not changed.")


def _case_row(plan: LegPlan, case: LegCase) -> list[str]:
    costs = [case.fixed, case.adaptive] if plan.adapts else [case.fixed]
    row = [case.name or "as the mission", *(with_error(it.cost, it.standard_error, Unit("", 0.01)) for it in costs)]
    unit = Unit("", JOULES_PER_WATT_HOUR if plan.aim == "energy" else 1.0)
    return [*row, with_error(*case.saving_for(plan.aim), unit)] if plan.adapts else row


def _length(metres: float) -> str:
    return f"{metres / 1000.0:.2f}\u00a0km" if metres >= 1000.0 else f"{metres:.0f}\u00a0m"


def _time(seconds: float) -> str:
    return f"{seconds:.0f}\u00a0s" if seconds < 90.0 else f"{seconds / 60.0:.1f}\u00a0min"
