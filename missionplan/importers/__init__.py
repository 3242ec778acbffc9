"""`import`: a vehicle's own logs to a data set, with a report of what was made of them and a starter mission.

A reader (`readers`, one a make; they share `importer`, `mapping` and `readers.netcdf`) makes a `track` of files.
`dives` says where legs may be, `cutting` makes legs of them, `judging` says which fixes and legs count, and
`reckoning` serves vehicles that freeze their position under water, or carry it with a current of their own.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path, PurePath
from typing import Literal

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, counted, did_you_mean, shown
from missionplan.importers.cutting import LEG_COLUMNS, CutTrack, cut, leg_picture, of_the_clock
from missionplan.importers.descents import descent_data, read_marks
from missionplan.importers.dives import LegRules
from missionplan.importers.geodesy import shifted, with_declination
from missionplan.importers.importer import ReadOptions, SourceLog, known_importers
from missionplan.importers.judging import JUMPED
from missionplan.importers.mapping import read_mapping
from missionplan.importers.sources import Reading, Sources, find_sources, of_one
from missionplan.importers.starter import LegNumbers, mission_text, numbers_of, prospects
from missionplan.importers.track import Fixes, Positions, Track, possible
from missionplan.mission.schema.place import Geographic, to_plane
from missionplan.results.imported import Ability, ImportedData, LogFigures, SourceEntry, TrackLines
from missionplan.store.folder import as_path

KINDS = ("transit", "descent")
_JUMPS = 0.2
"""Share of fixes that jump from which on they are of no one track."""
_RETURNS = 5
"""Times that they do at least."""


def import_logs(
    sources: str | Path | Sequence[str | Path],
    *,
    format: str | None = None,
    kind: Literal["transit", "descent"] = "transit",
    names: Sequence[str] = (),
    cache: str | Path | None = None,
    name: str | None = None,
    shift_origin: tuple[float, float] | None = None,
    rules: LegRules | None = None,
    marks: Sequence[str] = (),
    vehicle: str | None = None,
    deployment: str | None = None,
    is_strict: bool = False,
    explain: Sequence[int] = (),
    progress: Callable[[int, int], None] | None = None,
) -> ImportedData:
    """Make a data set of a vehicle's logs.

    Parameters
    ----------
    sources : str, Path or sequence of them
        Files and folders.
    format : str, optional
        Of the logs; default: as recognised.
    kind : str
        ``transit`` (legs between fixes) or ``descent`` (dives).
    names : sequence of str
        What the source calls things, `lat=Latitude[deg]`, or YAML files of it.
    cache : str or Path, optional
        Folder of the sensor lists of Slocum gliders; default: beside the files.
    name : str, optional
        Of the data set; default: the vehicle's.
    shift_origin : tuple of float, optional
        Latitude and longitude [deg] of a made-up place that the first fix is moved to, and all else with it.
    rules : LegRules, optional
        For legs.
    marks : sequence of str
        Times at which an anchor separated, ISO 8601 or seconds since 1970, for dives.
    vehicle, deployment : str, optional
        Which to read, where the files are of several; a deployment may be the date it began, 2026-05-01.
    is_strict : bool
        Whether a damaged file ends the import; else it is named and passed over.
    explain : sequence of int
        Numbers of legs of which is told, and drawn, what they rest on.
    progress : callable, optional
        Called with the number of files done and of all.

    Raises
    ------
    InputError
        When a source is missing, of no known format or of several vehicles, or holds no dives between fixes.
    """
    began, rules = time.perf_counter(), rules or LegRules()
    if kind not in KINDS:
        message = f"given {shown(kind)}, expected {' or '.join(KINDS)}"
        raise InputError([Problem(message, key="kind", hint=did_you_mean(str(kind), KINDS))])
    mapping = read_mapping(names)
    several = [sources] if isinstance(sources, str | PurePath) else sources
    paths = [as_path(source, "sources") for source in several]
    importers, left_out = known_importers()
    if left_out and format not in (None, *importers):
        raise InputError([Problem(f"no format of the name {shown(format)}", key="format"), *left_out])
    batch = find_sources(paths, importers, format, otherwise="track" if mapping else None)
    batch, identity = of_one(batch, vehicle, deployment)
    log = SourceLog(progress=progress, is_strict=is_strict)
    options = ReadOptions(mapping, None if cache is None else as_path(cache, "cache"), vehicle)
    track = _of_one_deployment(_read(batch, options, log), None if identity.deployment else deployment)
    track = with_declination(possible(track))
    track = replace(track, notices=(*track.notices, *of_the_clock(track), *map(str, left_out)))
    if shift_origin is not None:
        track = shifted(track, *shift_origin)
    read = set(log.read)
    reading = Reading(
        track=track,
        name=name or ", ".join(filter(None, (f"{track.name} {identity.vehicle}".strip(), identity.deployment))),
        sources=tuple(SourceEntry(file.path.name, file.checksum) for file in batch.files if file.path in read),
        passed_over=tuple(str(problem) for problem in (*log.passed_over, *batch.passed_over)),
        options=dict(format=track.format, kind=kind, map=list(names), shift_origin=shift_origin, **asdict(rules)),
        began=began,
    )
    with _naming_passed_over(log):
        return transit_data(reading, rules, explain) if kind == "transit" else descent_data(reading, read_marks(marks))


@contextmanager
def _naming_passed_over(log: SourceLog) -> Iterator[None]:
    """Beside what the files read lack, name those that were passed over: it may be in them."""
    try:
        yield
    except InputError as error:
        raise InputError([*error.problems, *log.passed_over]) from None


def _read(batch: Sources, options: ReadOptions, log: SourceLog) -> Track:
    """Read the files; where none can be read, say what is wrong with each."""
    track = batch.importer.read([file.path for file in batch.files], options, log)
    if not log.read:
        raise InputError([*log.passed_over, *batch.passed_over])
    return track


def _of_one_deployment(track: Track, begun: str | None) -> Track:
    """Keep one deployment of a track: they are told apart by a long silence.

    Raises InputError with the list, when there are several and none, or none of them, is chosen.
    """
    spans = track.deployments()
    if len(spans) < 2 and begun is None:
        return track.within(*spans[0]) if spans else track  # without single readings of another year
    parts = {
        f"{datetime.fromtimestamp(part.fixes.t[0], UTC):%Y-%m-%d}": part
        for part in (track.within(*span) for span in spans)
    }
    if begun is not None and begun in parts:
        return parts[begun]
    listed = ", ".join(f"{date} ({len(part.fixes)} fixes)" for date, part in parts.items()) or "none"
    message = f"deployments, by the date of their first fix: {listed}"
    if begun is not None:
        message = f"no deployment {shown(begun)}; {message}"
    hint = f"choose one with --deployment {next(iter(parts), 'DATE')}"
    raise InputError([Problem(message, key="deployment", hint=hint)])


_DRAWN = 4000
"""Readings of depth that the report draws."""


def transit_data(reading: Reading, rules: LegRules, explain: Sequence[int] = ()) -> ImportedData:
    """Make a data set of legs, and pictures of those to be explained.

    Raises InputError when the track has no dive between fixes, none with a dead-reckoned end, or a leg to explain is
    none.
    """
    parts = cut(reading.track, rules)
    _check_found(reading.track, parts)
    wrong = [number for number in explain if not 1 <= number <= len(parts.dives)]
    if wrong:
        expected = f"expected the number of a leg, 1 to {len(parts.dives)}"
        raise InputError([Problem(f"given {shown(number)}, {expected}", key="explain") for number in wrong])
    numbers, by_glide = numbers_of(parts.legs), parts.is_made and not len(reading.track.speed)
    text = mission_text(reading.name, numbers)
    mission_file = "mission.yaml"
    return ImportedData(
        provenance=reading.provenance(text, (*_of_current(parts, rules), *parts.notices)),
        kind="transit",
        name=reading.name,
        format=reading.track.format,
        dataset={
            "kind": "transit",
            "name": reading.name,
            "file": "legs.csv",
            "noise": {
                "fix": f"{numbers.fix_sd:.3g} m",
                **({"reckoned_speed": min(numbers.glide_doubt, 1.0)} if numbers.glide_doubt > 0.0 and by_glide else {}),
            },
            "source": reading.source,
        },
        table=_rounded(parts.legs[list(LEG_COLUMNS)]),
        dives=_rounded(parts.dives),
        sources=reading.sources,
        passed_over=reading.passed_over,
        reckoning=parts.reckoning,
        rejected_fixes=_rejected(parts),
        mission_text=text,
        can_show=tuple(map(Ability._make, prospects(parts.legs, numbers))),
        next_commands=(f"missionplan diagnose {mission_file} .", f"missionplan simulate {mission_file}"),
        figures=_figures(parts, numbers),
        lines=_lines(parts, numbers),
        basis=parts.basis,
        pictures=tuple(leg_picture(parts, number - 1) for number in dict.fromkeys(explain)),
    )


def _check_found(track: Track, parts: CutTrack) -> None:
    good, rejected = len(parts.fixes.good), len(parts.fixes.rejected)
    jumped = parts.fixes.rejected.t[np.array(parts.fixes.reasons, dtype=object) == JUMPED]
    jumps, returns = len(jumped), len(np.unique(np.searchsorted(parts.fixes.good.t, jumped)))
    if jumps > _JUMPS * (good + jumps) and returns > _RETURNS:  # not the boat that carried the vehicle, there and back
        message = f"{jumps} of {good + jumps} fixes jump from their neighbours and back: are they of two vehicles?"
        hint = "name the files of one, or choose it with --vehicle"
        raise InputError([Problem(message, key="sources", hint=hint)])
    if good < 2:
        message = f"{good} fixes that count ({rejected} do not): a leg needs one before and one after a dive"
        hint = parts.fixes.reasons[0] if parts.fixes.reasons else "are there fixes in these files?"
        raise InputError([Problem(message, hint=hint)])
    if not len(parts.dives):
        depth = f"greatest depth is {track.depth.values.max():.1f} m" if len(track.depth) else "logs hold no depth"
        message = f"no dive between {good} fixes; the {depth}"
        hint = "; ".join([*parts.notices, "--dive-depth says how deep a dive goes"])
        raise InputError([Problem(message, hint=hint)])
    if not len(parts.legs):
        reason = str(parts.dives["reason"].iloc[0])
        message = f"{counted(len(parts.dives), 'dive')}, but none has a dead-reckoned end: {track.reckoning} ({reason})"
        hint = "dead reckoning can be made from heading with speed, or with pitch and depth"
        raise InputError([Problem(message, hint=hint)])


def _of_current(parts: CutTrack, rules: LegRules) -> tuple[str, ...]:
    """Say whether the vehicle's dead reckoning is carried with a current of its own, and what was done about it."""
    current = parts.current
    if current is None:
        return ()
    if not np.isfinite(current.share):
        return ("the vehicle logs an estimate of the current; the legs do not show whether its dead reckoning has it",)
    measured = f"{current.share:.2f} ± {current.sd:.2f} of the current that the vehicle estimates"
    if not current.is_in:
        return (f"the dead reckoning holds {measured}: it is taken to hold none of it",)
    done = (
        "it was taken out"
        if rules.take_out_current
        else "it was left in: a leg's error is what that estimate did not foresee (--take-out-current removes it)"
    )
    return (f"the vehicle's dead reckoning holds {measured}: {done}",)


def _rounded(table: pd.DataFrame) -> pd.DataFrame:
    """Round to what logs hold: centimetres, milliseconds, and 1 cm of latitude."""
    tenths = ("heading_deg", "dr_sd_m", "surface_s", "lag_dr_end_s", "rpm")
    digits = {**dict.fromkeys(tenths, 1), "depth_m": 2, "max_depth_m": 2}
    return table.round(
        {name: 7 if name.startswith(("lat_", "lon_")) else digits.get(name, 3) for name in table.columns}
    )


def _rejected(parts: CutTrack) -> pd.DataFrame:
    fixes = parts.fixes.rejected
    columns = {"t_s": fixes.t, "lat": fixes.latitude, "lon": fixes.longitude, "hdop": fixes.hdop}
    return pd.DataFrame({**columns, "satellites": fixes.satellites, "reason": list(parts.fixes.reasons)})


def _figures(parts: CutTrack, numbers: LegNumbers) -> LogFigures:
    east, north = numbers.mean_error
    return LogFigures(
        max_depth=numbers.depth,
        fixes=len(parts.fixes.good),
        velocity_error_sigma=numbers.sigma,
        velocity_error_mean_east=east,
        velocity_error_mean_north=north,
        leg_length=numbers.length,
        leg_duration=numbers.duration,
        speed=numbers.speed,
        surfacing_time=numbers.surfacing,
        fix_sd=numbers.fix_sd,
        record=numbers.record,
        made_reckoning_sd=float(parts.legs["dr_sd_m"].median()) if parts.is_made else math.nan,
        current_in_reckoning=parts.current.share if parts.current else math.nan,
    )


def _lines(parts: CutTrack, numbers: LegNumbers) -> TrackLines:
    latitude, longitude = float(np.radians(numbers.latitude)), float(np.radians(numbers.longitude))
    origin = Geographic.model_construct(latitude=latitude, longitude=longitude)

    def plane(places: Fixes | Positions) -> Array:
        if not len(places):
            return np.empty((2, 0))
        return np.stack(to_plane(np.radians(places.latitude), np.radians(places.longitude), origin))

    def of_dives(name: str) -> Array:
        latitude, longitude = (
            np.radians(parts.dives[f"{axis}_{name}"].to_numpy(dtype=float)) for axis in ("lat", "lon")
        )
        there = np.isfinite(latitude)
        places = np.full((2, len(latitude)), np.nan)
        places[:, there] = to_plane(latitude[there], longitude[there], origin)
        return places

    step = max(len(parts.depth) // _DRAWN, 1)
    return TrackLines(
        fixes=plane(parts.fixes.good),
        rejected=plane(parts.fixes.rejected),
        reckoned=tuple(plane(line) for line in parts.reckoned),
        leg_starts=of_dives("start"),
        leg_ends=np.stack([of_dives("dr_end"), of_dives("end")]),
        depth_t=parts.depth.t[::step],
        depth=parts.depth.values[::step],
    )
