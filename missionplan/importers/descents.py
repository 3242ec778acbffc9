"""Dives of a depth record, each from the moment the anchor separates: `--kind descent`."""

from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import files
from itertools import pairwise

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, counted, shown
from missionplan.importers.dives import from_surface, shallowest
from missionplan.importers.judging import judge_fixes
from missionplan.importers.sources import Reading
from missionplan.importers.track import Series
from missionplan.moments import epoch_of
from missionplan.results.imported import Ability, ImportedData, LogFigures, TrackLines

STEADY = 0.05
"""Rate of depth from which a vehicle sinks [m/s]."""
STEADY_TIME = 3.0
"""How long it has to, for its first moment to be the separation [s]."""
LEAST_DEPTH = 1.0
"""Depth that a dive reaches [m]."""
GAUGE_OFF = 1.0
"""What a gauge reads at the surface from which depths count from there [m]: less is waves, or the gauge's place."""
LONGEST_GAP = 10.0
"""Longest time without a reading in a dive that counts [s]."""
FEWEST = 8
"""Readings of a dive that counts."""
_BY_SINKING = "by the first steady sinking"


def descent_data(reading: Reading, marks: Sequence[float] = ()) -> ImportedData:
    """Make a data set of dives, a run a dive.

    Raises InputError when no depth was logged, or no dive is found.

    `marks`: times at which the anchor separated, since 1970 [s]; else those of the log's marks, else the first steady
    sinking of each dive.
    """
    if not len(reading.track.depth):
        raise InputError([Problem("these logs hold no depth", key="kind")])
    track, _, by = from_surface(reading.track, judge_fixes(reading.track.fixes).good)
    zero = shallowest(track.depth)
    if by == "assumed" and zero > GAUGE_OFF:
        notice = f"the depth gauge reads {zero:.1f} m at the surface, its shallowest: depths count from there"
        track = replace(track, depth=_counted_from(track.depth, zero), notices=(*track.notices, notice))
    reading = replace(reading, track=track)
    starts, how = (marks, "as given") if len(marks) else (track.marks, "by the log's marks")
    if not len(starts):
        starts, how = separations_by_sinking(track.depth), _BY_SINKING
    parts = [_dive(track.depth, *map(float, pair)) for pair in pairwise([*starts, np.inf])]
    if not parts:
        message = f"no dive: the depth never grows by {STEADY:g} m/s for {STEADY_TIME:g} s below {LEAST_DEPTH:g} m"
        raise InputError([Problem(message, key="kind")])
    dives = _judged(parts, [float(start) for start in starts])
    table = _table(reading, parts, dives)
    text = _mission(reading.name, parts)
    return ImportedData(
        provenance=reading.provenance(text, (f"the anchor's separation is taken {how}", _ASSUMED)),
        kind="descent",
        name=reading.name,
        format=track.format,
        dataset=_dataset(reading, table),
        table=table,
        dives=dives,
        sources=reading.sources,
        passed_over=reading.passed_over,
        reckoning="",
        rejected_fixes=pd.DataFrame({"t_s": [], "reason": []}),
        mission_text=text,
        extra_files={"vehicle.yaml": (files("missionplan") / "starter" / "vehicle.yaml").read_text(encoding="utf-8")},
        can_show=tuple(map(Ability._make, _prospects(how, dives, parts))),
        next_commands=("missionplan diagnose mission.yaml .",),
        figures=LogFigures(float(track.depth.values.max())),
        lines=_lines(track.depth),
    )


_ASSUMED = (
    "vehicle, anchor and line are those of the starter: a log does not hold them. Correct vehicle.yaml, mission.yaml "
    "and runs: in dataset.yaml before you trust a diagnosis"
)


def read_marks(marks: Sequence[str]) -> list[float]:
    """Read times of separation [s], in their order.

    Raises InputError with each that is no time.
    """
    times, problems = [], []
    for mark in marks:
        try:
            times.append(epoch_of(mark))
        except ValueError:
            message = f"given {shown(mark)}, expected a time such as 2026-05-01T10:20:30Z"
            problems.append(Problem(message, key="mark"))
    if problems:
        raise InputError(problems)
    return sorted(times)


def separations_by_sinking(depth: Series) -> list[float]:
    """Find the first moment of each steady sinking that ends below the least depth.

    The rate is the slope over `STEADY_TIME`, so that a wave is no dive; the next dive begins after the vehicle has
    been above half of the least depth again. Depths count from the shallowest, which the gauge reads at the surface.
    """
    depth = _counted_from(depth, shallowest(depth))
    later = depth.at(depth.t + STEADY_TIME)
    sinking = (later - depth.values) / STEADY_TIME >= STEADY
    separations, k, n = [], 0, len(depth)
    while k < n:
        if not sinking[k] or depth.values[k] > LEAST_DEPTH:
            k += 1
            continue
        up = np.flatnonzero(depth.values[k + 1 :] < 0.5 * LEAST_DEPTH)
        deep = np.flatnonzero(depth.values[k + 1 :] >= LEAST_DEPTH)
        still = np.flatnonzero(~sinking[k:])
        stops = k + int(still[0]) if len(still) else n - 1
        if len(deep) and float(depth.at(np.array([depth.t[stops] + STEADY_TIME]))[0]) >= LEAST_DEPTH:
            separations.append(float(depth.t[_first_step(depth, k)]))
            after = up[up > deep[0]]
            k = k + 1 + int(after[0]) if len(after) else n
        else:
            k = stops + 1
    return separations


def _counted_from(depth: Series, zero: float) -> Series:
    return Series(depth.t, depth.values - zero)


def _first_step(depth: Series, k: int) -> int:
    """Reading from which on every next one is deeper, down to the least depth of a dive: waves end before it."""
    j = k + int(np.argmax(depth.values[k:] >= LEAST_DEPTH))
    while j > k and depth.values[j] - depth.values[j - 1] >= STEADY * (depth.t[j] - depth.t[j - 1]):
        j -= 1
    return j


def _dive(depth: Series, start: float, end: float) -> Series:
    """Readings from the separation down to the deepest, with time counted from the separation."""
    during = depth.within(start, end)
    if not len(during):
        return Series()
    last = int(np.argmax(during.values >= during.values.max() - 0.02 * np.ptp(during.values)))
    stop = np.searchsorted(during.t, during.t[last] + 5.0, side="right")
    return Series(during.t[:stop] - start, during.values[:stop])


def _judged(parts: Sequence[Series], starts: Sequence[float]) -> pd.DataFrame:
    rows = []
    for k, (part, start) in enumerate(zip(parts, starts, strict=True)):
        gap = float(np.diff(part.t, prepend=0.0).max()) if len(part) > 1 else np.inf
        deepest = float(part.values.max()) if len(part) else np.nan
        reasons = [
            f"fewer than {FEWEST} readings ({len(part)})" if len(part) < FEWEST else "",
            f"a gap in the log ({gap:.0f} s)" if LONGEST_GAP < gap < np.inf else "",
            f"not as deep as {LEAST_DEPTH:g} m ({deepest:.1f} m)" if not deepest >= LEAST_DEPTH else "",
        ]
        reason = "; ".join(filter(None, reasons))
        stamp = pd.Timestamp(start, unit="s", tz="UTC").isoformat(timespec="milliseconds")
        end = start + float(part.t[-1]) if len(part) else start
        rows.append((f"dive-{k + 1}", stamp, start, end, deepest, int(not reason), reason))
    return pd.DataFrame(rows, columns=["run", "t_start", "t_start_s", "t_end_s", "max_depth_m", "ok", "reason"])


def _table(reading: Reading, parts: Sequence[Series], dives: pd.DataFrame) -> pd.DataFrame:
    """Rows of all dives; those that do not count have `ok` = 0."""
    pitch = reading.track.pitch
    tables = []
    for part, name, start, ok in zip(parts, dives["run"], dives["t_start_s"], dives["ok"], strict=True):
        rows = pd.DataFrame({"run": name, "t_s": part.t, "depth_m": part.values})
        if len(pitch):
            rows["pitch_deg"] = pitch.at(part.t + start)
        tables.append(rows.assign(ok=ok).round(3))
    return pd.concat(tables, ignore_index=True)


def _dataset(reading: Reading, table: pd.DataFrame) -> dict[str, object]:
    counted = table.loc[table["ok"] == 1, "run"].unique()
    return {
        "kind": "descent",
        "name": reading.name,
        "file": "dives.csv",
        "runs": {str(name): {} for name in counted},
        "source": reading.source,
    }


def _prospects(how: str, dives: pd.DataFrame, parts: Sequence[Series]) -> tuple[tuple[str, str], ...]:
    count = int(dives["ok"].sum())
    intervals = [float(np.median(np.diff(part.t))) for part in parts if len(part) > 1]
    by_sinking = how == _BY_SINKING
    return (
        ("drag, mass and flooding of the descent", f"yes: {counted(count, 'dive')}" if count else "no: no dive counts"),
        (
            "late payout of the line, a clock's offset",
            "no: the separation is known by the sinking alone; marks of it would show both" if by_sinking else "yes",
        ),
        ("what depends on the run (line, anchor)", "say in runs: what differed; alike dives separate nothing"),
        ("interval of the readings", f"{min(intervals):.2g} s" if intervals else "none"),
    )


def _mission(name: str, parts: Sequence[Series]) -> str:
    """Write the starter mission with the depth of the site that the deepest dive suggests."""
    deepest = max(float(part.values.max()) for part in parts if len(part))
    site = deepest + 5.0
    title = name.replace("'", "''")
    return f"""\
# Written by missionplan import from a log of depths. The log holds neither vehicle, anchor nor line: what is marked
# [assumed] is the starter's. Correct it, then
#   missionplan diagnose mission.yaml .        what do the dives show that this mission lacks?
name: '{title}'
vehicle: vehicle.yaml              # [assumed]
site:
  depth: {site:.1f} m                  # the deepest reading and the line
  water: {{temperature: 10 degC, salinity: 35}}     # [assumed]
navigation: {{velocity_error: {{sigma: 0.03 m/s}}, surfacing_time: 90 s, fix_error: 5 m}}     # [assumed]
phases:
  - transit: {{name: ingress, from: [0 m, 0 m], to: [200 m, 0 m], speed: 1 m/s, d_max: 200 m, arrival_radius: 20 m}}
  - moor:
      radius: 20 m
      anchor_wet_weight: 18 N      # [assumed]; in runs: of dataset.yaml where dives differ
      line_length: 5 m             # [assumed]
      release_time: 1 s
      hold: 30 min
      galvanic_release: 10 min
monte_carlo: {{trials: 5000, seed: 1}}
"""


def _lines(depth: Series) -> TrackLines:
    none: Array = np.empty((2, 0))
    step = max(len(depth) // 4000, 1)
    return TrackLines(none, none, (), none, np.empty((2, 2, 0)), depth.t[::step], depth.values[::step])
