"""What a diagnosis means for the plan: anchor or leg length chosen before and after, in words and as a table."""

import math

from missionplan.report.diagnosis.causes import part
from missionplan.report.numbers import number
from missionplan.report.page import PageSection, Table
from missionplan.report.quantities import Unit, quantity, reader_unit
from missionplan.report.wording import capitalised
from missionplan.results.learned.diagnosis import Diagnosis, Plan

_COLUMNS = {
    "d_max_m": "d_max",
    "cost": "Mean cost",
    "arrived": "Arrive",
    "anchor_wet_weight_n": "Anchor's wet weight",
    "within_radius": "Within the radius",
    "struck_seafloor": "Strike the seafloor",
    "success": "Missions that succeed",
}
_UNITS = {"d_max_m": "m", "anchor_wet_weight_n": "N"}
_NOTES = {
    "anchor_wet_weight_n": (
        "Anchors sized for the worst current (Eq. 15), and to carry the vehicle's net buoyancy besides."
    ),
    "d_max_m": "Mean cost: time beyond that of the straight way, as a share of it.",
}
_SAME_SHARE, _SAME_COST = 0.02, 0.002
"""Differences of a probability, and of a mean cost, that call for no other plan."""
_SERVES = 0.9
"""Probability of staying within the radius below which an anchor is no plan."""


def plan_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show the plans side by side, or the reason why there are none."""
    gain = diagnosis.decision
    if not gain.after:
        return [PageSection("No plans to compare", [gain.reason])] if gain.reason else []
    plans = {
        "Plan with the mission's model, as it expects": gain.before,
        "Plan with the extended model": gain.after,
        "The mission's plan, if the extended model is true": gain.base_choice_under_extended,
    }
    keys = [key for key in _COLUMNS if key in gain.after]
    rows = [[name, *(_cell(key, plan.get(key)) for key in keys)] for name, plan in plans.items() if plan]
    table = Table(["", *(f"{_COLUMNS[key]}{_unit(key).axis}" for key in keys)], rows, _NOTES[keys[0]])
    return [PageSection("What it means for the plan", [table], is_summary=True)]


def _cell(key: str, value: float | None) -> str:
    """Write a number of a plan; shares, as everywhere in the report, in per cent."""
    if value is None:
        return ""
    shown = _unit(key)(value)
    return number(shown) if key in _UNITS else number(shown, 0.1 if key == "cost" else 1.0)


def _unit(key: str) -> Unit:
    """Unit of a number of a plan: per cent, or the reader's."""
    return reader_unit(_UNITS[key], 0.0) if key in _UNITS else Unit("%", 0.01)


def plan_words(diagnosis: Diagnosis) -> list[str]:
    """Describe the plan that the extended model asks for, and how the mission's own would fare."""
    gain = diagnosis.decision
    before, after, kept = gain.before, gain.after, gain.base_choice_under_extended
    if not (before and after and kept):
        return []
    words = (_anchor if "anchor_wet_weight_n" in after else _legs)(before, after, kept)
    struck = after.get("struck_seafloor") or 0.0
    if struck > _SAME_SHARE:
        words += f" With that anchor the vehicle strikes the seafloor in {part(struck)}: lengthen the line."
    return [capitalised(words) if diagnosis.verdict == "explained" else f"If that is what it was: {words}"]


def _anchor(before: Plan, after: Plan, kept: Plan) -> str:
    own, other = (quantity(_number(plan, "anchor_wet_weight_n"), "N", ".3g") for plan in (before, after))
    shares = [_number(plan, "within_radius") for plan in (before, kept, after)]
    expected, found, best = map(part, shares)
    if abs(shares[1] - shares[0]) < _SAME_SHARE:
        return f"the anchor that the mission's model asks for, {own} wet, still serves: {found} within the radius."
    fares = f"the anchor that the mission's model asks for, {own} wet, stays within the radius in {found} of the dives"
    more = "size-anchor with --probability finds the weight for more"
    if own == other:
        return f"{fares}, not in {expected}; {more}."
    if shares[2] < _SERVES:
        return f"{fares}, not in {expected}, and one sized with the extended model, {other} wet, in {best}; {more}."
    return f"plan with an anchor of {other} wet, {best} within the radius; {fares}, not in {expected}."


def _legs(before: Plan, after: Plan, kept: Plan) -> str:
    own, other = (_length(_number(plan, "d_max_m")) for plan in (before, after))
    expected, found, best = (_delay(_number(plan, "cost")) for plan in (before, kept, after))
    if own == other or _number(kept, "cost") < _number(after, "cost") + _SAME_COST:
        return (
            f"the d_max that the mission's model asks for, {own}, still serves: it takes {found} beyond the straight "
            f"way's time (expected: {expected})."
        )
    return (
        f"plan with a d_max of {other}, for {best} beyond the straight way's time; {own}, which the mission's model "
        f"asks for, would take {found} and not the expected {expected}."
    )


def _number(plan: Plan, key: str) -> float:
    """A number of a plan; infinite where it has none, as the cost of legs of which some never arrive."""
    value = plan.get(key)
    return math.inf if value is None else value


def _length(metres: float) -> str:
    return quantity(metres, "m", ".0f") if metres < 1000.0 else quantity(metres / 1000.0, "km", ".3g")


def _delay(cost: float) -> str:
    """Write a mean cost as a share of the straight way's time."""
    if math.isinf(cost):
        return "no end"
    share = 100.0 * cost
    return (f"{share:.0f} %" if abs(share) >= 10.0 else f"{share:.2g} %").replace("-", "−")
