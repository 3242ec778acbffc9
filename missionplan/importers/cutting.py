"""Cut a track into legs: fix on diving, dead-reckoned position just before the next fix, fix on surfacing."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.importers.dives import (
    Candidate,
    LegRules,
    depth_near,
    depths_of,
    find_candidates,
    from_surface,
    logged_again,
    longest_gap,
)
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.judging import REPEATED, UNSTATED_SD, JudgedFixes, Limits, judge, judge_fixes, shortest_of
from missionplan.importers.reckoning import (
    VehicleCurrent,
    can_be_made,
    current_in_reckoning,
    made_doubt,
    made_reckoning,
    true_from_logged,
)
from missionplan.importers.track import Fixes, Positions, Series, Track
from missionplan.results.imported import Basis, LegPicture

_STANDS_STILL = 1.0
"""Way that a position which stands still makes at most [m]."""
_DEEP = 0.15
"""Share of fixes under water from which on it is said."""
_ABOUT = 900.0
"""Time before and after a leg of which its picture shows fixes and depths [s]."""
_MOST = 0.5
"""Share of dives whose position stands still from which on dead reckoning is made for all."""
_STEP, _FASTER = 5.0, 3.0
"""Way beyond that at so many times the usual speed that the position steps onto a fix [m]."""
_LATEST_START = 120.0
"""How long after a fix its dead-reckoned position still shows whether the fix was taken in [s]."""
LEG_COLUMNS = (
    "leg", "t_start", "t_end", "t_start_s", "t_end_s", "lat_start", "lon_start", "lat_dr_end", "lon_dr_end",
    "lat_end", "lon_end", "surface_s", "speed_m_s", "heading_deg", "fix_sd_m", "dr_sd_m", "depth_m", "max_depth_m",
    "lag_dr_end_s",
    "declination_deg", "rpm", "ok", "reason",
)  # fmt: skip
"""Of the table of legs; those from `lat_dr_end` on are blank where a dive has no dead-reckoned end."""
BASIS_COLUMNS = (
    "depth_at_fix_m", "fix_before_by", "fix_before_sd_m", "fix_after_by", "fix_after_sd_m", "dr_by", "dr_positions",
    "depth_readings", "heading_readings", "speed_readings",
)  # fmt: skip
"""What each dive rests on; standard deviations are blank where none is stated."""


@dataclass(frozen=True)
class CutTrack:
    """Legs of a track."""

    dives: pd.DataFrame
    """Every dive between two fixes, with `LEG_COLUMNS`."""
    depth: Series
    """Below what the gauge reads at the surface [m]."""
    fixes: JudgedFixes
    reckoned: tuple[Positions, ...]
    """Of each dive, as used."""
    current: VehicleCurrent | None
    """What the dead reckoning holds of a current that the vehicle estimated."""
    is_made: bool
    """Whether the dead reckoning was made here, and is not the vehicle's own."""
    reckoning: str
    """Where the dead-reckoned positions come from, in words."""
    basis: Basis
    """What all legs rest on."""
    notices: tuple[str, ...]

    @property
    def legs(self) -> pd.DataFrame:
        """Dives with a dead-reckoned end, whether they count or not."""
        return self.dives[self.dives["lat_dr_end"].notna()]


def cut(track: Track, rules: LegRules) -> CutTrack:
    """Cut a track into legs, and say of every dive whether it counts and why not."""
    fixes = judge_fixes(track.fixes)
    notice_count = len(track.notices)
    track, zero, zero_by = from_surface(track, fixes.good)
    depths, gap = depths_of(track.depth, rules), longest_gap(track.depth, rules)
    again = logged_again(fixes.good, track.depth, depths)
    fixes = fixes.without(again, REPEATED)
    candidates = find_candidates(fixes.good, track.depth, depths, gap)
    by, reckoned, how, notices = _reckoned(track, fixes, candidates)
    current = current_in_reckoning(track, fixes.good, candidates, reckoned)
    if current is not None and rules.take_out_current:
        reckoned = [current.taken_out(line) for line in reckoned]
        how += ", with the vehicle's estimate of the current taken out"
    rows = [_row(track, fixes, *pair, by) for pair in zip(candidates, reckoned, strict=True)]
    dives = pd.DataFrame(rows, columns=[*LEG_COLUMNS[1:-2], *BASIS_COLUMNS])
    dives.insert(0, "leg", np.arange(1, len(dives) + 1))
    shortest = shortest_of(rules, track, (dives["t_end_s"] - dives["t_start_s"]).to_numpy())
    dives = pd.concat([dives, judge(dives, track, reckoned, Limits(shortest, gap, depths.surface))], axis=1)
    dives["ok"] = (dives["reason"] == "").astype(int)
    notices = [
        *track.notices[notice_count:],
        *notices,
        *_of_deep_fixes(track.depth, np.delete(fixes.good.t, [dive.before for dive in candidates]), depths.surface),
        *_of_late_fixes(dives, depths.surface),
        *_of_old_ends(dives),
    ]
    speed = "logged" if len(track.speed) else "pitch and depth rate" if by == "made" else "dead-reckoned way"
    north = "a north that is not stated" if track.heading_from == "unknown" else f"{track.heading_from} north"
    north += ", declination added" if track.heading_from == "magnetic" and len(track.declination) else ""
    basis = Basis(depths.dive, depths.surface, zero, zero_by, north, speed, shortest, gap)
    return CutTrack(dives, track.depth, fixes, tuple(reckoned), current, by == "made", how, basis, tuple(notices))


def _reckoned(
    track: Track, fixes: JudgedFixes, candidates: list[Candidate]
) -> tuple[str, list[Positions], str, list[str]]:
    """Dead-reckoned positions of each dive: `logged`, `moved` or `made`, where they come from, and notices."""
    after = [float(np.nextafter(fixes.good.t[candidate.before], np.inf)) for candidate in candidates]
    whole = [track.reckoned.within(t, candidate.reckoned_to) for t, candidate in zip(after, candidates, strict=True)]
    lines = [_until_taken_in(line, fixes.good, candidate) for line, candidate in zip(whole, candidates, strict=True)]
    early = [line.t[-1] - cut.t[-1] for line, cut in zip(whole, lines, strict=True) if len(cut) < len(line)]
    notices = []
    if early:
        notice = (
            f"on {len(early)} of {counted(len(lines), 'dive')} the position steps onto the fix before that is logged, "
        )
        notices.append(f"{notice}up to {max(early):.0f} s: legs end before the step; have both another clock?")
    still = [_stands_still(line) for line in lines]
    if can_be_made(track) and (not len(track.reckoned) or np.mean(still or [True]) > _MOST):
        by = "with speed" if len(track.speed) else "with pitch and depth rate"
        why = track.reckoning if not len(track.reckoned) else "the vehicle's position stands still under water"
        made = [_made(track, fixes, candidate) for candidate in candidates]
        return "made", made, f"made from heading, {by}", [f"{why}: dead reckoning was made from heading, {by}"]
    shifted = _offset_where_fixes_are_ignored(lines, fixes, candidates)
    if shifted is None:
        return "logged", lines, track.reckoning, notices
    notice = "the vehicle's position goes on across its fixes: each leg's is moved to start at the fix"
    return "moved", shifted, f"{track.reckoning}, each leg moved to start at its fix", [notice, *notices]


def _until_taken_in(line: Positions, good: Fixes, dive: Candidate) -> Positions:
    """Cut a line where, from surfacing on, it steps onto a fix that is logged later only."""
    steps = np.hypot(*displacement(line.latitude[:-1], line.longitude[:-1], line.latitude[1:], line.longitude[1:]))
    away = np.hypot(*displacement(good.latitude[dive.after], good.longitude[dive.after], line.latitude, line.longitude))
    usual = np.median(steps / np.diff(line.t)) if len(steps) else 0.0
    is_step = (steps > _STEP + _FASTER * usual * np.diff(line.t)) & (away[1:] < 0.5 * away[:-1])
    taken = np.flatnonzero(is_step & (line.t[1:] >= dive.surfaced))
    return line.within(-np.inf, line.t[taken[0] + 1]) if len(taken) else line


def _stands_still(line: Positions) -> bool:
    if len(line) < 3:
        return False
    way = np.hypot(*displacement(line.latitude[0], line.longitude[0], line.latitude, line.longitude))
    return bool(way.max() < _STANDS_STILL)


def _made(track: Track, fixes: JudgedFixes, candidate: Candidate) -> Positions:
    good, start = fixes.good, candidate.before
    end = float(good.t[candidate.after])
    return made_reckoning(track, float(good.t[start]), end, float(good.latitude[start]), float(good.longitude[start]))


def _offset_where_fixes_are_ignored(
    lines: list[Positions], fixes: JudgedFixes, candidates: list[Candidate]
) -> list[Positions] | None:
    """Move each leg's positions to start at its fix, if fixes are not taken in; None if they are.

    Fixes are taken in where the position, less the way since, stands nearer to the fix just after it than the
    dead-reckoned one does just before the next.
    """
    offsets, misses, moved_lines = [], [], []
    for line, candidate in zip(lines, candidates, strict=True):
        start, end = candidate.before, candidate.after
        if not len(line) or line.t[0] > fixes.good.t[start] + _LATEST_START:
            moved_lines.append(line)
            continue
        east, north = _from_fix(fixes, start, line, 0)
        offsets.append(float(np.hypot(*(np.array([east, north]) - _way_since(line, float(fixes.good.t[start]))))))
        misses.append(float(np.hypot(*_from_fix(fixes, end, line, -1))))
        latitude, longitude = moved(line.latitude, line.longitude, -float(east), -float(north))
        moved_lines.append(replace(line, latitude=latitude, longitude=longitude))
    if not offsets or np.median(offsets) < max(0.5 * float(np.median(misses)), 20.0):
        return None
    return moved_lines


def _way_since(line: Positions, t: float) -> Array:
    """Way from a moment to the first position of a line [m], at the speed of its first step."""
    if len(line) < 2:
        return np.zeros(2)
    step = np.array(displacement(line.latitude[0], line.longitude[0], line.latitude[1], line.longitude[1]))
    return np.asarray(step * (line.t[0] - t) / max(line.t[1] - line.t[0], 1e-9))


def _from_fix(fixes: JudgedFixes, fix: int, line: Positions, which: int) -> tuple[Array, Array]:
    good = fixes.good
    return displacement(good.latitude[fix], good.longitude[fix], line.latitude[which], line.longitude[which])


def _row(track: Track, fixes: JudgedFixes, dive: Candidate, line: Positions, by: str) -> tuple[object, ...]:
    good = fixes.good
    start, end = float(good.t[dive.before]), float(good.t[dive.after])
    has_end = len(line) > 0
    sd, rpm = fixes.sd[dive.after], track.rpm.within(start, dive.surfaced).values
    under_way = max(dive.surfaced - start, 1.0)
    return (
        _iso(start),
        _iso(end),
        start,
        end,
        good.latitude[dive.before],
        good.longitude[dive.before],
        line.latitude[-1] if has_end else np.nan,
        line.longitude[-1] if has_end else np.nan,
        good.latitude[dive.after],
        good.longitude[dive.after],
        end - dive.surfaced,
        _mean_speed(track, line, start, dive.surfaced, under_way),
        _mean_heading(track, start, dive.surfaced),
        sd if np.isfinite(sd) else UNSTATED_SD,
        made_doubt(track, line, end) if by == "made" else np.nan,
        _mean_depth(track, start, dive.surfaced),
        dive.max_depth,
        end - line.t[-1] if has_end else np.nan,
        float(true_from_logged(track, np.array([start]))[0]) if len(track.declination) else np.nan,
        float(rpm.mean()) if len(rpm) else np.nan,
        dive.depth_at_fix,
        fixes.by[dive.before],
        fixes.sd[dive.before],
        fixes.by[dive.after],
        sd,
        by if has_end else "none",
        len(line),
        *(len(series.within(start, dive.surfaced)) for series in (track.depth, track.heading, track.speed)),
    )


def of_the_clock(track: Track) -> Iterator[str]:
    """Say where the clock jumps: no leg across shows it."""
    jumps = [jump for jump in track.breaks if jump.at_surface_too]
    if jumps:
        more = f", and {counted(len(jumps) - 1, 'time')} more" if len(jumps) > 1 else ""
        yield f"{jumps[0].reason} to {_iso(jumps[0].t)}{more}: times before or after are wrong by as much"


def _iso(t: float) -> str:
    """Write a time since 1970 [s] by ISO 8601."""
    return pd.Timestamp(round(t, 3), unit="s", tz="UTC").isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _mean_speed(track: Track, line: Positions, start: float, end: float, under_way: float) -> float:
    """Mean speed under way: the logged one, else the way made by dead reckoning over its time [m/s]."""
    logged = track.speed.within(start, end)
    if len(logged):
        return float(logged.values.mean())
    if len(line) < 2:
        return float("nan")
    steps = np.hypot(*displacement(line.latitude[:-1], line.longitude[:-1], line.latitude[1:], line.longitude[1:]))
    return float(steps.sum() / min(max(line.t[-1] - line.t[0], 1.0), under_way))


def _mean_depth(track: Track, start: float, end: float) -> float:
    """Mean depth under way over time [m]; nan where none was logged."""
    logged = track.depth.within(start, end)
    if len(logged) < 2:
        return float("nan")
    area = np.sum(np.diff(logged.t) * (logged.values[1:] + logged.values[:-1]) / 2.0)
    return max(float(area / (logged.t[-1] - logged.t[0])), 0.0)


def _mean_heading(track: Track, start: float, end: float) -> float:
    """Mean heading under way, from true north where that is known [deg]."""
    logged = track.heading.within(start, end)
    if not len(logged):
        return float("nan")
    angle = np.radians(logged.values + true_from_logged(track, logged.t))
    return float(np.degrees(np.angle(np.exp(1j * angle).sum())) % 360.0)


def _of_deep_fixes(depth: Series, t: Array, surface: float) -> Iterator[str]:
    """Say how many fixes that begin no dive stand in the log while the vehicle is under water, where many do."""
    at_fix = depth_near(depth, t, _LATEST_START)
    deep = at_fix[at_fix > surface]
    if len(deep) > _DEEP * len(t):
        yield (
            f"{len(deep)} fixes that begin no dive stand in the log while the vehicle is under water, as deep as "
            f"{deep.max():.0f} m: have fixes and depths another clock?"
        )


def _of_late_fixes(dives: pd.DataFrame, surface: float) -> Iterator[str]:
    """Say where the fix before a dive stands in the log while the vehicle is deep."""
    late = dives["depth_at_fix_m"] > 2.0 * surface
    if late.any():
        deepest = float(dives.loc[late, "depth_at_fix_m"].max())
        yield (
            f"the fix before the dive is logged late on {int(late.sum())} of {counted(len(dives), 'dive')}, when the "
            f"vehicle is already as deep as {deepest:.0f} m: these legs began up to some minutes before their start"
        )


def _of_old_ends(dives: pd.DataFrame) -> Iterator[str]:
    """Say how much older than surfacing the last dead-reckoned position is, where it is."""
    kept = dives[dives["ok"] == 1]
    old = kept["lag_dr_end_s"] - kept["surface_s"]
    share = old / (kept["t_end_s"] - kept["t_start_s"])
    if len(kept) and float(share.median()) > 0.005:
        yield (
            f"the last dead-reckoned position is {old.median():.0f} s older than the surfacing (median): the way made "
            f"in that time, about {100.0 * share.median():.1f} % of a leg, counts as error"
        )


def leg_picture(parts: CutTrack, row: int) -> LegPicture:
    """Gather what was logged about a leg."""
    dive = parts.dives.iloc[row]
    start, end, begin = float(dive["t_start_s"]), float(dive["t_end_s"]), (dive["lat_start"], dive["lon_start"])

    def near(t: Array) -> NDArray[np.bool_]:
        return np.asarray((t >= start - _ABOUT) & (t <= end + _ABOUT))

    def places(of: Fixes | Positions) -> Array:
        return np.stack(displacement(*begin, of.latitude, of.longitude)) if len(of) else np.empty((2, 0))

    is_near = near(parts.fixes.rejected.t)
    good, rejected = parts.fixes.good[near(parts.fixes.good.t)], parts.fixes.rejected[is_near]
    line, depth = parts.reckoned[row], parts.depth.within(start - _ABOUT, end + _ABOUT)
    return LegPicture(
        row,
        good.t - start,
        places(good),
        rejected.t - start,
        places(rejected),
        tuple(reason for reason, kept in zip(parts.fixes.reasons, is_near, strict=True) if kept),
        line.t - start,
        places(line),
        depth.t - start,
        depth.values,
    )
