"""Seagliders: netCDF files of the basestation, one a dive, and OceanGliders OG1 netCDF, a deployment in one file.

Dead reckoning is that of the basestation's hydrodynamic model: displacements from reading to reading, which are summed
from each fix on. They lie along the dimension of the CTD, or of the vehicle's own readings, by the version of the
basestation. In OG1 a file's own flag `DEAD_RECKONING` goes before them. Descriptions: the basestation3 of the
University of Washington (BaseNetCDF) and the OG1 format of OceanGliders (oceangliderscommunity/OG-format-user-manual).
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.geodesy import moved
from missionplan.importers.importer import Identity, Importer, ReadOptions, SourceLog
from missionplan.importers.judging import judge_fixes
from missionplan.importers.readers.netcdf import MAGIC, Variables, opened, variable_names
from missionplan.importers.track import Fixes, Positions, Series, Track, columns_of, fixes, positions, series

_SEAGLIDER = {"log_gps_lat", "log_gps_lon"}
_OG1 = {"latitude_gps", "longitude_gps"}
_BY_MODEL = "the hydrodynamic model (displacements from the last fix)"
_BY_SLOPE = "the glide slope model (displacements from the last fix)"
_NONE = "the files hold no dead reckoning"
_DEPTH = ("depth", "sea_water_pressure")


@dataclass(frozen=True)
class _Part:
    """What one file holds."""

    fixes: Fixes
    ways: tuple[Array, Array, Array]
    """Times since 1970 [s] and displacements east and north since the reading before [m], shape (n,) each."""
    reckoned: Positions
    """That the file itself calls dead-reckoned."""
    reckoning: str
    """Where ways or positions come from; nothing where there are none."""
    depth: Series
    pitch: Series
    heading: Series
    speed: Series
    declination: Series
    at_surface: Series = field(default_factory=Series)


def _recognises(marks: set[str], name: str, path: Path, head: bytes) -> bool:
    return head.startswith(MAGIC) and variable_names(path, name) >= marks


def _identity(path: Path) -> Identity:
    """Vehicle and deployment that a file names."""
    with opened(path, "seaglider") as data:
        file = Variables(data)
        trajectory = file.text("trajectory", "id")
        vehicle = file.text("platform_serial_number", "platform_id", "glider", "wmo_identifier", "wmo_id")
        during = re.search(r"during (.+?)(?: deployed on|$)", file.text("title"))
        title = file.text("sg_cal_mission_title") or (during[1] if during else "")
        in_og1 = file.find("latitude_gps") is not None
    deployment = re.sub(r"_(delayed|R|D|realtime|rt|adjusted)$", "", trajectory) if in_og1 else title
    digits = re.fullmatch(r"(?:sg)?\s*0*(\d{2,4})", vehicle, re.IGNORECASE)  # 561, SG561 and sg561 alike
    return Identity(f"SG{int(digits[1]):03d}" if digits else vehicle or re.split(r"_", trajectory)[0], deployment)


def _read(
    format_name: str,
    part_of: Callable[[Variables], _Part],
    files: Sequence[Path],
    options: ReadOptions,
    log: SourceLog,
) -> Track:
    """Read the files of all dives as one track."""
    parts: list[_Part] = []
    dives: dict[str, Path] = {}
    for path in log.each(sorted(files)):
        with log.reading(path), opened(path, format_name) as data:
            file = Variables(data)
            dive = file.text("dive_number") if format_name == "seaglider" else file.text("id")
            if dive and dive in dives:
                raise ValueError(f"holds dive {dive} again, which {dives[dive].name} holds")
            parts.append(part_of(file))
            dives[dive] = path
    return _joined(parts, "Seaglider" if format_name == "seaglider" else "OG1 glider", format_name)


def _joined(parts: Sequence[_Part], name: str, format_name: str) -> Track:
    """Make one track of all files, with displacements summed from the fixes that count."""

    def all_of(quantity: str) -> Series:
        return series(**columns_of(Series, [getattr(part, quantity) for part in parts]))

    every = fixes(**columns_of(Fixes, [part.fixes for part in parts]))
    ways = [np.concatenate([part.ways[k] for part in parts] or [np.empty(0)]) for k in range(3)]
    reckoned = [summed(judge_fixes(every).good, *ways), *(part.reckoned for part in parts)]
    return Track(
        name=name,
        format=format_name,
        fixes=every,
        reckoned=positions(**columns_of(Positions, reckoned)),
        reckoning="; ".join(dict.fromkeys(part.reckoning for part in parts if part.reckoning)) or _NONE,
        depth=all_of("depth"),
        pitch=all_of("pitch"),
        heading=all_of("heading"),
        heading_from="magnetic",
        speed=all_of("speed"),
        declination=all_of("declination"),
        at_surface=all_of("at_surface"),
    )


def summed(good: Fixes, t: Array, east: Array, north: Array) -> Positions:
    """Sum displacements from each fix to the next.

    `good`: that count. `t`, `east`, `north`, shape (n,): times since 1970 [s], in any order, and displacements since
    the reading before [m].
    """
    timed = np.flatnonzero(np.isfinite(t) & np.isfinite(east) & np.isfinite(north))
    t, first = np.unique(t[timed], return_index=True)
    east, north = (step[timed][first] for step in (east, north))
    if not len(good) or not len(t):
        return Positions()
    since = np.searchsorted(good.t, t, side="right") - 1
    at_fix = np.searchsorted(t, good.t, side="right") - 1
    way = []
    for step in (east, north):
        total = np.append(0.0, np.cumsum(step))
        way.append((total[1:] - total[at_fix + 1][np.maximum(since, 0)])[since >= 0])
    since, t = since[since >= 0], t[since >= 0]
    return positions(t, *moved(good.latitude[since], good.longitude[since], *way))


def _dive(file: Variables) -> _Part:
    latitude = file.find("log_gps_lat")
    longitude = file.find("log_gps_lon")
    if latitude is None or longitude is None or np.count_nonzero(np.isfinite(file.numbers(latitude))) < 2:
        raise ValueError("fewer than two fixes: the dive was not completed")
    quality = {  # the basestation writes −1 where there is none
        name: np.where((read := file.like(file.find(f"log_gps_{logged}"), latitude)) > 0.0, read, np.nan)
        for name, logged in (("accuracy", "hpe"), ("hdop", "hdop"), ("satellites", "n_satellites"))
    }
    variation = file.find("log_gps_magvar")
    ways, how = _ways(file)
    return _Part(
        fixes=fixes(
            file.clock(latitude),
            file.in_unit(latitude, "deg"),
            file.in_unit(longitude, "deg"),
            valid=file.validity(latitude),
            **quality,
        ),
        ways=ways,
        reckoned=Positions(),
        reckoning=how,
        depth=file.series(file.find("depth", "eng_depth", "ctd_depth", "ctd_pressure", standard=_DEPTH), "m"),
        pitch=file.series(file.find("eng_pitchAng", "pitch"), "deg"),
        heading=file.series(file.find("eng_head", "heading"), "deg"),
        speed=Series() if how else file.series(file.find("horz_speed", "horz_speed_gsm"), "m/s"),
        declination=file.series(variation, "deg"),
    )


def _ways(file: Variables) -> tuple[tuple[Array, Array, Array], str]:
    """Displacements on the clock of their own dimension, of the better of two models, and which it is."""
    for ending, how in (("", _BY_MODEL), ("_gsm", _BY_SLOPE)):
        east, north = (file.find(f"{axis}_displacement{ending}") for axis in ("east", "north"))
        if east is not None and north is not None and np.isfinite(file.numbers(east)).any():
            return (file.clock(east), file.in_unit(east, "m"), file.like(north, east, "m")), how
    return (np.empty(0), np.empty(0), np.empty(0)), ""


def _deployment(file: Variables) -> _Part:
    latitude, longitude = file.find("latitude_gps"), file.find("longitude_gps")
    if latitude is None or longitude is None:
        raise ValueError("no fixes (LATITUDE_GPS, LONGITUDE_GPS)")
    t = file.clock(latitude)
    ways, how = _ways(file)
    line = _flagged(file)
    if len(line):
        ways, how = (np.empty(0), np.empty(0), np.empty(0)), "the file's own, where DEAD_RECKONING is 1"
    phase = file.find("phase")
    return _Part(
        fixes=fixes(t, file.in_unit(latitude, "deg"), file.in_unit(longitude, "deg"), valid=file.validity(latitude)),
        ways=ways,
        reckoned=line,
        reckoning=how,
        depth=file.series(file.find("depth", "depth_z", "glider_depth", "pres", standard=_DEPTH), "m"),
        pitch=file.series(
            file.find("pitch", "glider_pitch", standard=("platform_pitch", "platform_pitch_fore_up")), "deg"
        ),
        heading=file.series(file.find("heading", "glider_heading", standard=("platform_orientation",)), "deg"),
        speed=Series() if how else file.series(file.find("glider_horz_velo_model"), "m/s"),
        declination=file.series(file.find("magnetic_declination"), "deg"),
        at_surface=_drifting(file, phase),
    )


def _flagged(file: Variables) -> Positions:
    """Positions that the file calls dead-reckoned."""
    flag = file.find("dead_reckoning")
    latitude, longitude = (file.find(name, standard=(name,)) for name in ("latitude", "longitude"))
    if flag is None or latitude is None or longitude is None:
        return Positions()
    is_reckoned = file.like(flag, latitude) == 1.0
    t = np.where(is_reckoned, file.clock(latitude), np.nan)
    return positions(t, file.in_unit(latitude, "deg"), file.like(longitude, latitude, "deg"))


def _drifting(file: Variables, phase: str | None) -> Series:
    """Whether the phase is that of surface drift, by the values that the variable explains."""
    if phase is None:
        return Series()
    meanings, values = file.attribute(phase, "flag_meanings"), file.attribute(phase, "flag_values")
    words = re.split(r"[\s,]+", meanings.lower())
    codes = [float(code) for code in re.findall(r"-?\d+", values)]
    at_surface = [code for code, word in zip(codes, words, strict=False) if "surface" in word]
    phases = file.series(phase, "")
    return Series(phases.t, np.isin(phases.values, at_surface).astype(float)) if at_surface else Series()


IMPORTERS = (
    Importer(
        "seaglider",
        "Seaglider basestation netCDF, one file a dive",
        partial(_recognises, _SEAGLIDER, "seaglider"),
        partial(_read, "seaglider", _dive),
        identify=_identity,
    ),
    Importer(
        "og1",
        "OceanGliders OG1 netCDF",
        partial(_recognises, _OG1, "og1"),
        partial(_read, "og1", _deployment),
        identify=_identity,
    ),
)
