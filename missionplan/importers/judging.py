"""Which fixes count, by flags, neighbours and stated quality, and which dives count as legs; the reasons why not."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.importers.dives import LegRules
from missionplan.importers.geodesy import displacement
from missionplan.importers.track import Fixes, Positions, Track, columns_of

WORST_ACCURACY = 100.0
"""Stated horizontal accuracy beyond which a fix does not count [m]."""
WORST_HDOP = 8.0
FEWEST_SATELLITES = 4
RANGE_ERROR = 5.0
"""Standard deviation of a satellite's range that turns a dilution of precision into an error [m]: the Standard
Positioning Service Performance Standard (2020) allows 8 m at 95 %, receivers add their own."""
UNSTATED_SD = 5.0
"""Standard deviation of a fix, each axis, of which nothing is known [m]."""
FASTEST = 10.0
"""Speed between fixes that no vehicle at the surface has [m/s]."""
_ALLOWED = 30.0
"""Distance beyond that speed which scatter explains [m]."""
_WINDOW = 5
"""Fixes about one, itself included, whose median it is compared with."""
_ROUNDS = 20
_LATER = 60.0
"""Time after which the very same place is no new fix [s]."""
_CONFIRMS = 120.0
"""Time within which a good fix confirms another [s]."""
_DRIFT = 1.5
"""Drift at the surface that it allows for [m/s]."""
JUMPED = f"farther from its neighbours than {FASTEST:g} m/s explains"
REPEATED = "the fix before the dive, logged again"
_FLAGGED, _UNSEEN = "not valid by its flag", "no satellites"
"""What no neighbour mends: there was no fix."""


@dataclass(frozen=True)
class JudgedFixes:
    """Fixes that count, with standard deviations of each axis, and those that do not, with the reason."""

    good: Fixes
    sd: Array
    """Shape (n,). Of each good one, each axis [m]; nan where nothing is known of it."""
    rejected: Fixes
    reasons: tuple[str, ...]
    """Of each rejected one."""
    by: NDArray[np.object_]
    """What speaks for each good one: its ``flag``, its ``quality``, its ``neighbours`` against a bad quality, or
    ``place``: nothing is stated of it, and it does not jump, shape (n,)."""

    def without(self, which: NDArray[np.bool_], reason: str) -> "JudgedFixes":
        """Reject some of the good ones, shape (n,), too."""
        if not which.any():
            return self
        every = columns_of(Fixes, (self.rejected, self.good[which]))
        reasons = (*self.reasons, *[reason] * int(which.sum()))
        return JudgedFixes(self.good[~which], self.sd[~which], Fixes(**every), reasons, self.by[~which])


def judge_fixes(fixes: Fixes) -> JudgedFixes:
    """Tell good fixes from bad ones."""
    reasons = _reasons_of_quality(fixes)
    good = reasons == ""
    reasons[np.flatnonzero(good)[_repeated(fixes[good])]] = REPEATED
    good = reasons == ""
    jumps = _jumps(fixes[good])
    reasons[np.flatnonzero(good)[jumps]] = JUMPED
    mended = (reasons != "") & _confirmed(fixes, reasons == "") & ~np.isin(reasons, (_FLAGGED, _UNSEEN))
    reasons[mended] = ""
    which = np.flatnonzero(reasons == "")
    reasons[which[1:][np.diff(fixes.t[which]) == 0.0]] = "another fix has the same time"
    good = reasons == ""
    stated = np.isfinite(fixes.hdop) | np.isfinite(fixes.accuracy) | (fixes.satellites >= FEWEST_SATELLITES)
    by = np.select([mended, fixes.valid == 1.0, stated], ["neighbours", "flag", "quality"], "place").astype(object)
    rejected = tuple(str(reason) for reason in reasons[~good])
    return JudgedFixes(fixes[good], fix_sd(fixes[good]), fixes[~good], rejected, by[good])


def fix_sd(fixes: Fixes) -> Array:
    """Standard deviation of fixes, each axis, shape (n,) [m]; nan where nothing is known."""
    by_dilution = np.where(fixes.hdop > 0.0, fixes.hdop, np.nan) * RANGE_ERROR
    return np.asarray(np.where(np.isfinite(fixes.accuracy), fixes.accuracy, by_dilution) / np.sqrt(2.0))


def _reasons_of_quality(fixes: Fixes) -> NDArray[np.object_]:
    """What speaks against fixes: the flag, else a bad quality; a count of satellites only where there is no flag.

    A count that is never enough for a fix was not logged.
    """
    reasons = np.full(len(fixes), "", dtype=object)
    with np.errstate(invalid="ignore"):
        few = (fixes.satellites < FEWEST_SATELLITES) & ~(fixes.valid == 1.0)
        counted = np.any(fixes.satellites >= FEWEST_SATELLITES)
        reasons[few & counted] = f"fewer than {FEWEST_SATELLITES} satellites"
        is_stated = np.any(fixes.hdop > 0.0)  # one that is always 0 was not logged
        reasons[(fixes.hdop > WORST_HDOP) | ((fixes.hdop <= 0.0) & is_stated)] = (
            f"dilution of precision above {WORST_HDOP:g}"
        )
        reasons[(fixes.accuracy > WORST_ACCURACY)] = f"stated accuracy worse than {WORST_ACCURACY:g} m"
        reasons[(fixes.satellites == 0.0) & few & counted] = _UNSEEN
        reasons[fixes.valid == 0.0] = _FLAGGED
    return reasons


def _confirmed(fixes: Fixes, good: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fixes that lie where the good one nearest in time has them, but for the scatter and the drift since."""
    which = np.flatnonzero(good)
    if not len(which):
        return np.zeros(len(fixes), dtype=bool)
    after = np.clip(np.searchsorted(fixes.t[which], fixes.t), 0, len(which) - 1)
    before = np.maximum(after - 1, 0)
    away = [np.abs(fixes.t[which[neighbour]] - fixes.t) for neighbour in (before, after)]
    nearest = which[np.where(away[0] < away[1], before, after)]
    apart = np.hypot(*displacement(fixes.latitude[nearest], fixes.longitude[nearest], fixes.latitude, fixes.longitude))
    elapsed = np.minimum(*away)
    return np.asarray((elapsed <= _CONFIRMS) & (apart <= _ALLOWED + _DRIFT * elapsed))


def _repeated(fixes: Fixes) -> NDArray[np.bool_]:
    """Fixes at the very place of one some time before, from which the next one jumps: the old one, shape (n,)."""
    old = np.zeros(len(fixes), dtype=bool)
    is_new = np.append(True, (np.diff(fixes.latitude) != 0.0) | (np.diff(fixes.longitude) != 0.0))[: len(fixes)]
    news, copies = np.flatnonzero(is_new), np.flatnonzero(~is_new)
    place = np.searchsorted(news, copies)
    copies, place = copies[place < len(news)], place[place < len(news)]
    first, last, new = fixes[news[place - 1]], fixes[copies], fixes[news[place]]
    away = np.hypot(*displacement(last.latitude, last.longitude, new.latitude, new.longitude))
    old[copies] = (away - _ALLOWED > FASTEST * (new.t - last.t)) & (last.t - first.t >= _LATER)
    return old


def _jumps(fixes: Fixes) -> NDArray[np.bool_]:
    """Fixes that lie off the line of the others, found a few at a time."""
    wrong = np.zeros(len(fixes), dtype=bool)
    for _ in range(_ROUNDS):
        left = np.flatnonzero(~wrong)
        outliers = _worst_of_pairs(fixes[left]) if len(left) >= 3 else np.empty(0, dtype=np.intp)
        if not len(outliers):
            break
        wrong[left[outliers]] = True
    return wrong


def _worst_of_pairs(fixes: Fixes) -> NDArray[np.intp]:
    """Of each two neighbours too far from one another, the one farther from the median of those nearest in time."""
    steps = np.hypot(*displacement(fixes.latitude[:-1], fixes.longitude[:-1], fixes.latitude[1:], fixes.longitude[1:]))
    pairs = np.flatnonzero(steps - _ALLOWED > FASTEST * np.diff(fixes.t))
    if not len(pairs):
        return np.empty(0, dtype=np.intp)
    about = np.arange(len(fixes))[:, None] + np.arange(1 - _WINDOW, _WINDOW)
    is_one, about = (about >= 0) & (about < len(fixes)), np.clip(about, 0, len(fixes) - 1)
    apart = np.where(is_one, np.abs(fixes.t[about] - fixes.t[:, None]), np.inf)
    nearest = np.argsort(apart, axis=1, kind="stable")[:, : min(_WINDOW, len(fixes))]
    about = np.take_along_axis(about, nearest, axis=1)
    middle = np.median(fixes.latitude[about], axis=1), np.median(fixes.longitude[about], axis=1)
    away = np.hypot(*displacement(*middle, fixes.latitude, fixes.longitude))
    return np.unique(np.where(away[pairs] >= away[pairs + 1], pairs, pairs + 1))


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

    `dives`: with the columns of a leg but `ok` and `reason`; dead-reckoned ends that are none become blank. `reckoned`:
    of each dive.

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
            f"shorter than {limits.shortest / 60.0:g} min ({(end - start) / 60.0:.1f} min)"
            if end - start < limits.shortest
            else "",
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
    breaks = [moment for moment in track.breaks if moment.t <= end and start < max(moment.t, moment.until)]
    under = [
        moment.reason
        for moment in breaks
        if moment.at_surface_too or not len(track.depth) or track.depth.at(np.array([moment.t]))[0] > surface
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


def _errors(dives: pd.DataFrame) -> Array:
    """Size of each dive's velocity error, shape (n,) [m/s]."""
    ends = (dives[name].to_numpy(dtype=float) for name in ("lat_dr_end", "lon_dr_end", "lat_end", "lon_end"))
    duration = (dives["t_end_s"] - dives["t_start_s"]).to_numpy()
    return np.asarray(np.hypot(*displacement(*ends)) / np.maximum(duration, 1.0))
