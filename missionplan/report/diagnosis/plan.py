"""What a diagnosis means for the plan: anchor or leg length chosen before and after, in words and as a table."""

import math
from collections.abc import Mapping
from typing import Any

from missionplan.report.page import PageSection, Table
from missionplan.results.diagnosis import Diagnosis

_PLANS = {
    "before": "Plan with the mission's model, as it expects",
    "after": "Plan with the extended model",
    "base_choice_under_extended": "The mission's plan, if the extended model is true",
}
_COLUMNS = {
    "d_max_m": "d_max (m)",
    "cost": "Mean cost",
    "arrived": "P(arrived)",
    "anchor_wet_weight_n": "Anchor's wet weight (N)",
    "within_radius": "P(within radius)",
    "struck_seafloor": "P(struck seafloor)",
    "success": "P(success), all phases",
}
_NOTES = {
    "anchor_wet_weight_n": (
        "Anchors sized for the worst current (Eq. 15), and to carry the vehicle's net buoyancy besides."
    ),
    "d_max_m": "Mean cost: time beyond that of the straight way, as a share of it.",
}
_SAME_SHARE, _SAME_COST = 0.02, 0.002
"""Differences of a probability, and of a mean cost, that are not worth another plan."""
_SERVES = 0.9
"""Probability of staying within the radius below which an anchor is no plan."""


def plan_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Set the plans side by side, or say why there are none."""
    plans = {key: diagnosis.decision.get(key) for key in _PLANS}
    if not plans["after"]:
        reason = diagnosis.decision.get("reason")
        return [PageSection("No plans to compare", [str(reason)])] if reason else []
    keys = [key for key in _COLUMNS if key in plans["after"]]
    rows = [
        [_PLANS[name], *("" if plan.get(key) is None else f"{plan[key]:.3g}" for key in keys)]
        for name, plan in plans.items()
        if plan
    ]
    table = Table(["", *(_COLUMNS[key] for key in keys)], rows, _NOTES[keys[0]])
    return [PageSection("What it means for the plan", [table])]


def plan_words(diagnosis: Diagnosis) -> list[str]:
    """Say which plan the extended model asks for, and how the mission's own would fare."""
    before, after, kept = (diagnosis.decision.get(key) for key in _PLANS)
    if not (before and after and kept):
        return []
    provided = "" if diagnosis.verdict == "explained" else "If that is what it was: "
    words = (_anchor if "anchor_wet_weight_n" in after else _legs)(before, after, kept)
    struck = after.get("struck_seafloor") or 0.0
    if struck > _SAME_SHARE:
        words += f" With that anchor the vehicle strikes the seafloor in {100.0 * struck:.0f} %: lengthen the line."
    return [f"{provided}{words}" if provided else words[0].upper() + words[1:]]


def _anchor(before: Mapping[str, Any], after: Mapping[str, Any], kept: Mapping[str, Any]) -> str:
    own, other = (f"{plan['anchor_wet_weight_n']:.3g} N" for plan in (before, after))
    expected, found, best = (f"{100.0 * plan['within_radius']:.0f} %" for plan in (before, kept, after))
    if abs(kept["within_radius"] - before["within_radius"]) < _SAME_SHARE:
        return f"the anchor that the mission's model asks for, {own} wet, still serves: {found} within the radius."
    fares = f"the anchor that the mission's model asks for, {own} wet, stays within the radius in {found} of the dives"
    more = "size-anchor with --probability finds the weight for more"
    if own == other:
        return f"{fares}, not in {expected}; {more}."
    if after["within_radius"] < _SERVES:
        return f"{fares}, not in {expected}, and one sized with the extended model, {other} wet, in {best}; {more}."
    return f"plan with an anchor of {other} wet, {best} within the radius; {fares}, not in {expected}."


def _legs(before: Mapping[str, Any], after: Mapping[str, Any], kept: Mapping[str, Any]) -> str:
    own, other = (_length(plan["d_max_m"]) for plan in (before, after))
    expected, found, best = (_delay(plan["cost"]) for plan in (before, kept, after))
    if own == other or _least(kept["cost"]) < _least(after["cost"]) + _SAME_COST:
        return (
            f"the d_max that the mission's model asks for, {own}, still serves: it takes {found} beyond the straight "
            f"way's time (expected: {expected})."
        )
    return (
        f"plan with a d_max of {other}, for {best} beyond the straight way's time; {own}, which the mission's model "
        f"asks for, would take {found} and not the expected {expected}."
    )


def _length(metres: float) -> str:
    return f"{metres:.0f} m" if metres < 1000.0 else f"{metres / 1000.0:.3g} km"


def _delay(cost: float | None) -> str:
    """A mean cost as a share of the straight way's time; without end where some do not arrive."""
    return "no end" if cost is None else f"{100.0 * cost:.2g} %".replace("-", "−")


def _least(cost: float | None) -> float:
    return math.inf if cost is None else cost
