"""What the legs of a data set can show, and what a diagnosis would lack for the rest."""

import math

import pandas as pd

from missionplan.datasets.leg_checks import MIN_LEGS
from missionplan.importers.starter import LegNumbers

STATISTICAL = 20
"""Legs from which statistical descriptions are claimed."""
_TIDE = 12.42 * 3600.0
_ONE_COURSE = 0.9
"""Length of the courses' mean unit vector above which all legs go one way."""
_SURFACE_SHARE = 0.02
"""Share of the legs' time that is spent at the surface, from which drift there shows."""


def prospects(legs: pd.DataFrame, found: LegNumbers) -> tuple[tuple[str, str], ...]:
    """Return what may be found, and whether the legs suffice or what is lacking."""
    kept = legs[legs["ok"] == 1]
    return (
        _constant(len(kept)),
        _statistical(len(kept)),
        _heading(found),
        _tide(found),
        _inertial(found),
        _surface(kept),
        _fix_error(kept),
    )


def _constant(legs: int) -> tuple[str, str]:
    enough = legs >= MIN_LEGS
    verdict = f"yes: {legs} legs" if enough else f"no: {legs} legs, and {MIN_LEGS} are needed to diagnose anything"
    return "a mean current", verdict


def _statistical(legs: int) -> tuple[str, str]:
    enough = legs >= STATISTICAL
    verdict = f"yes: {legs} legs" if enough else f"no: {legs} legs, and {STATISTICAL} are needed"
    return "persistence, a random walk, heavy tails", verdict


def _heading(found: LegNumbers) -> tuple[str, str]:
    what = "compass and speed errors, apart from a current"
    if found.spread > _ONE_COURSE:
        return what, f"no: nearly all legs go {found.course:.0f} deg; legs on opposite courses would separate them"
    return what, "yes: the legs go several ways"


def _tide(found: LegNumbers) -> tuple[str, str]:
    what, hours = "a tide (M2, 12.4 h)", found.record / 3600.0
    if found.record < 0.5 * _TIDE:
        return what, f"no: the record lasts {hours:.1f} h, less than half a period"
    if found.duration > 0.5 * _TIDE:
        return what, f"hardly: a leg lasts {found.duration / 3600.0:.1f} h and averages over the period"
    return what, f"yes: the record lasts {hours:.0f} h"


def _inertial(found: LegNumbers) -> tuple[str, str]:
    what = "an inertial current"
    rate = 2.0 * 7.2921e-5 * abs(math.sin(math.radians(found.latitude)))
    period = 2.0 * math.pi / max(rate, 1e-9)
    hours = period / 3600.0
    if found.record < 0.5 * period:
        return what, f"no: the record lasts {found.record / 3600.0:.1f} h, the period there is {hours:.1f} h"
    return what, f"yes: the period there is {hours:.1f} h"


def _surface(kept: pd.DataFrame) -> tuple[str, str]:
    what = "drift at the surface"
    total = float((kept["t_end_s"] - kept["t_start_s"]).sum())
    share = float(kept["surface_s"].sum()) / total if total > 0.0 else 0.0
    if share < _SURFACE_SHARE:
        return what, f"hardly: {100.0 * share:.1f} % of the legs' time is at the surface"
    return what, f"yes: {100.0 * share:.0f} % of the legs' time is at the surface"


def _fix_error(kept: pd.DataFrame) -> tuple[str, str]:
    what = "errors of the fixes, apart from those under way"
    duration = (kept["t_end_s"] - kept["t_start_s"]).to_numpy()
    ratio = float(duration.max() / duration.min()) if len(duration) else 1.0
    if ratio < 2.0:
        return what, f"no: all legs are alike in length (longest over shortest {ratio:.1f})"
    return what, f"yes: the longest leg is {ratio:.1f} times the shortest"
