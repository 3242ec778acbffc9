"""Which dives count as legs, and the reason where one does not."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.importers.dives import LegRules
from missionplan.importers.geodesy import displacement
from missionplan.importers.track import Positions, Track

FASTEST_UNDER_WATER = 6.0
"""Speed between dead-reckoned positions beyond which the position has jumped [m/s]."""
_JUMP = 50.0
"""Distance of such a jump at least [m]."""
_SILENT = 3600.0
"""Time without a reading in which a vehicle may have dived again [s]."""
LONG_ENOUGH = 900.0
"""Time from fix to fix from which a leg counts, however long the others are [s]."""
LEAST_SHARE = 0.4
"""Part of a leg's time that its dead reckoning has to cover."""
IMPOSSIBLE = 3.0
"""Velocity error that neither water nor vehicle explains [m/s]."""


@dataclass(frozen=True)
class Limits:
    """What a leg has to keep to count."""

    shortest: float
    longest_gap: float
    """Time from fix to fix, and without a reading under water [s]."""
    surface: float
    """Depth of the surface [m]."""


def judge(dives: pd.DataFrame, track: Track, reckoned: Sequence[Positions], limits: Limits) -> pd.DataFrame:
    """Judge each dive.

    Parameters
    ----------
    dives : DataFrame
        With the columns of a leg but `ok` and `reason`; dead-reckoned ends that are none become blank.
    reckoned : sequence of Positions
        Of each dive.

    Returns
    -------
    DataFrame
        Of each dive `gap_s`, the longest time without a reading under water, `covered`, the share of its time that
        dead reckoning covers, `error_m_s`, and the `reason` why it does not count; empty where it does.
    """
    rows = []
    starts, ends, pauses = (dives[name].to_numpy() for name in ("t_start_s", "t_end_s", "surface_s"))
    errors = _errors(dives)
    for k, line in enumerate(reckoned):
        start, end = float(starts[k]), float(ends[k])
        surfaced = end - float(pauses[k])
        covered = (float(line.t[-1]) - start) / (end - start) if len(line) else 0.0
        missing = _missing_end(covered, start, end, line)
        if missing:
            dives.loc[k, ["lat_dr_end", "lon_dr_end", "speed_m_s"]] = errors[k] = np.nan
        gap = _gap(track, line, start, surfaced, limits.surface)
        checks = (
            missing,
            _interrupted(track, start, end, limits.surface),
            f"a gap in the log ({gap:.0f} s)" if gap > limits.longest_gap else "",
            _gap_at_surface(track, surfaced, end),
            _jump(line),
            _short(end - start, limits.shortest),
            f"an impossible error, a wrong fix or position ({errors[k]:.1f} m/s)" if errors[k] > IMPOSSIBLE else "",
        )
        rows.append((gap, covered, errors[k], "; ".join(filter(None, checks))))
    return pd.DataFrame(rows, columns=["gap_s", "covered", "error_m_s", "reason"])


def shortest_of(rules: LegRules, track: Track, durations: Array) -> float:
    """Shortest leg that counts [s]: as given, else the reader's own, else half of a leg as planned, or as usual."""
    if rules.shortest is not None:
        return rules.shortest
    if track.planned is not None:
        return 0.5 * track.planned
    if track.shortest is not None:
        return track.shortest
    return min(LONG_ENOUGH, 0.5 * float(np.median(durations))) if len(durations) else LONG_ENOUGH


def _missing_end(covered: float, start: float, end: float, line: Positions) -> str:
    if not len(line):
        return "no dead-reckoned position between the fixes"
    if covered < LEAST_SHARE:
        return f"dead reckoning ends long before the fix ({end - line.t[-1]:.0f} of {end - start:.0f} s)"
    return ""


def _interrupted(track: Track, start: float, end: float, surface: float) -> str:
    found = [each for each in track.breaks if start < each.t <= end]
    under = [
        each.reason
        for each in found
        if each.at_surface_too or not len(track.depth) or track.depth.at(np.array([each.t]))[0] > surface
    ]
    return "; ".join(dict.fromkeys(under))


def _gap(track: Track, line: Positions, start: float, surfaced: float, surface: float) -> float:
    """Longest time under water in which neither depth nor position was logged [s]."""
    if len(track.depth):
        during = track.depth.within(start, surfaced)
        under = np.flatnonzero(during.values > surface)
        read = during.t[under[0] :] if len(under) else during.t
    else:
        read = np.append(start, line.t)
    return float(np.diff(np.append(read, surfaced)).max(initial=0.0))


def _gap_at_surface(track: Track, surfaced: float, end: float) -> str:
    """Where nothing was logged between surfacing and the fix for so long that the vehicle may have dived again."""
    read = np.concatenate([track.depth.within(surfaced, end).t, track.reckoned.within(surfaced, end).t])
    gap = float(np.diff(np.concatenate([[surfaced], np.sort(read), [end]])).max())
    return f"nothing was logged before the fix ({gap:.0f} s)" if gap > _SILENT else ""


def _jump(line: Positions) -> str:
    if len(line) < 2:
        return ""
    steps = np.hypot(*displacement(line.latitude[:-1], line.longitude[:-1], line.latitude[1:], line.longitude[1:]))
    jumped = steps - FASTEST_UNDER_WATER * np.diff(line.t)
    if jumped.max() <= _JUMP:
        return ""
    return f"the dead-reckoned position jumps under water ({steps[int(np.argmax(jumped))]:.0f} m)"


def _short(duration: float, shortest: float) -> str:
    return f"shorter than {shortest / 60.0:g} min ({duration / 60.0:.1f} min)" if duration < shortest else ""


def _errors(dives: pd.DataFrame) -> Array:
    """Size of each dive's velocity error, shape (n,) [m/s]."""
    ends = (dives[name].to_numpy(dtype=float) for name in ("lat_dr_end", "lon_dr_end", "lat_end", "lon_end"))
    duration = (dives["t_end_s"] - dives["t_start_s"]).to_numpy()
    return np.asarray(np.hypot(*displacement(*ends)) / np.maximum(duration, 1.0))
