"""Files of fixes alone: GPX tracks, and NMEA 0183 sentences of a receiver."""

import math
from datetime import datetime, time
from pathlib import Path

from missionplan.importers.importer import needed_module
from missionplan.importers.sourcefiles.channels import Samples
from missionplan.moments import utc

FIX_COLUMNS = ("t", "lat", "lon", "hdop", "satellites", "valid")


def is_gpx(path: Path, head: bytes) -> bool:
    """Whether a file is a GPX track."""
    return path.suffix.lower() == ".gpx" or b"<gpx" in head[:2000]


def is_nmea(path: Path, head: bytes) -> bool:
    """Whether a file holds NMEA sentences."""
    return path.suffix.lower() in (".nmea", ".nme") or (head[:1] == b"$" and b"RMC," in head[:4000])


def add_gpx(path: Path, found: Samples) -> None:
    """Add the points of a GPX track."""
    gpxpy = needed_module("gpxpy", "track", "track (GPX)")
    with path.open(encoding="utf-8-sig") as stream:
        try:
            track = gpxpy.parse(stream)
        except gpxpy.gpx.GPXException as error:
            raise ValueError(str(error)) from None
    for point in track.walk(only_points=True):
        if point.time is not None:
            hdop = point.horizontal_dilution
            found.add(
                utc(point.time).timestamp(),
                point.latitude,
                point.longitude,
                _number(hdop),
                _number(point.satellites),
                1.0,
            )


def add_nmea(path: Path, found: Samples) -> None:
    """Add the fixes of NMEA sentences: RMC has the date, GGA the quality."""
    library = needed_module("pynmea2", "track", "track (NMEA)")
    quality: dict[time, tuple[float, float]] = {}
    with path.open(encoding="ascii", errors="replace") as stream:
        for line in stream:
            start = line.find("$")
            if start < 0:
                continue
            try:
                sentence = library.parse(line[start:].strip(), check=True)
            except library.ParseError:
                continue
            kind = getattr(sentence, "sentence_type", "")
            if kind == "GGA" and sentence.timestamp:
                quality = {sentence.timestamp: (_number(sentence.horizontal_dil), _number(sentence.num_sats))}
            elif kind == "RMC" and sentence.timestamp and sentence.datestamp and sentence.lat and sentence.lon:
                hdop, satellites = quality.get(sentence.timestamp, (math.nan, math.nan))
                t = utc(datetime.combine(sentence.datestamp, sentence.timestamp)).timestamp()
                valid = 1.0 if sentence.status == "A" else 0.0
                found.add(t, sentence.latitude, sentence.longitude, hdop, satellites, valid)


def _number(value: object) -> float:
    try:
        return float(str(value))
    except ValueError:
        return math.nan


def empty_fixes() -> Samples:
    """Return a store for fixes."""
    return Samples(FIX_COLUMNS)
