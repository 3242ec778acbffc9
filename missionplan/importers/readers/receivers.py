"""Fixes of GPS receivers: points of GPX files, and NMEA 0183 sentences."""

import io
import math
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from missionplan.importers.importer import Samples, head_of, needed_module, unpacked
from missionplan.moments import moment_of, utc

FIX_COLUMNS = ("t", "lat", "lon", "hdop", "satellites", "valid")


def is_gpx(path: Path, head: bytes) -> bool:
    """Whether a file is a GPX track."""
    return path.suffix.lower() == ".gpx" or b"<gpx" in head[:2000]


_SENTENCE = re.compile(rb"^[^$\r\n]{0,48}\$[A-Z]{2}(RMC|GGA|GNS|GLL|ZDA|GSV|GSA|VTG),", re.MULTILINE)
"""Of a receiver, on a line that a logger may begin with a time or a tag of its own."""
_SUMMED = re.compile(rb"\*[0-9A-Fa-f]{2}\s*$", re.MULTILINE)
_PLACED = ("RMC", "GGA", "GNS", "GLL")
_NO_FIX = ("N", "E", "M", "S")
"""Modes of RMC, GLL and GNS: none, and estimated (dead-reckoned), manual and simulated ones; of GGA see `_GUESSED`."""
_HALF_A_DAY = timedelta(hours=12.0)
_GUESSED = (0.0, 6.0, 7.0, 8.0)


def is_nmea(path: Path, head: bytes) -> bool:
    """Whether a file holds NMEA sentences."""
    return path.suffix.lower() in (".nmea", ".nme") or _SENTENCE.search(head) is not None


def add_gpx(path: Path, samples: Samples) -> None:
    """Add the points of a GPX file that have times: of its tracks, else of its routes and its waypoints."""
    with unpacked(path) as stream:
        root = ElementTree.parse(stream).getroot()
    kinds: dict[str, list[ElementTree.Element]] = defaultdict(list)
    for element in root.iter():
        kinds[str(element.tag).rpartition("}")[2]].append(element)
    for point in kinds["trkpt"] or (*kinds["wpt"], *kinds["rtept"]):
        said = {str(child.tag).rpartition("}")[2]: (child.text or "").strip() for child in point}
        if said.get("time"):
            valid = float(said["fix"].lower() != "none") if said.get("fix") else math.nan
            place = float(point.get("lat", "nan")), float(point.get("lon", "nan"))
            quality = _number(said.get("hdop")), _number(said.get("sat"))
            samples.add(moment_of(said["time"]).timestamp(), *place, *quality, valid)


def add_nmea(path: Path, samples: Samples) -> None:
    """Add the fixes of NMEA sentences: RMC has the date and GGA the quality, or ZDA the date and GGA the rest.

    Sentences may go without their sums in a file that has none; elsewhere such a one is cut off.
    """
    library = needed_module("pynmea2", "track", "track (NMEA)")
    epoch, last, early, count = _Epoch(), None, list[_Epoch](), len(samples)
    is_summed = _SUMMED.search(head_of(path)) is not None
    with io.TextIOWrapper(unpacked(path), encoding="ascii", errors="replace") as stream:
        for line in stream:
            start = line.find("$")
            try:
                sentence = library.parse(line[start:].strip(), check=is_summed) if start >= 0 else None
            except library.ParseError:
                continue
            clock = getattr(sentence, "timestamp", None)
            if not isinstance(clock, time):
                continue
            if clock != epoch.clock:
                last = epoch.add_to(samples, last, early)
                epoch = _Epoch(clock)
            epoch.take(sentence)
    last = epoch.add_to(samples, last, early)
    if any(one.place is not None for one in early):
        raise ValueError("its fixes have no date: sentences RMC or ZDA have it, beside GGA")
    if len(samples) == count:
        raise ValueError(f"no fixes: no whole sentence {', '.join(_PLACED)} with a position")


@dataclass
class _Epoch:
    """What the sentences of one time say; a receiver sends them in any order."""

    clock: time | None = None
    day: date | None = None
    place: tuple[float, float] | None = None
    valid: float = math.nan
    quality: tuple[float, float] = (math.nan, math.nan)

    def take(self, sentence: Any) -> None:
        """Take in a sentence; a fix is none where one of them says so."""
        kind = getattr(sentence, "sentence_type", "")
        if kind in ("RMC", "ZDA"):
            self.day = sentence.datestamp or self.day
        if kind not in _PLACED:
            return
        if sentence.lat and sentence.lon:
            self.place = sentence.latitude, sentence.longitude
        if kind == "GGA":
            self.quality = _number(sentence.horizontal_dil), _number(sentence.num_sats)
            quality = _number(sentence.gps_qual)
            said = math.nan if math.isnan(quality) else float(quality not in _GUESSED)
        else:
            mode = str(getattr(sentence, "faa_mode" if kind == "GLL" else "mode_indicator", "") or "")
            said = float(
                getattr(sentence, "status", "A") == "A" and not (mode and all(letter in _NO_FIX for letter in mode))
            )
        self.valid = float(np.fmin(self.valid, said))

    def add_to(self, samples: Samples, last: datetime | None, early: "list[_Epoch]") -> datetime | None:
        """Add the fix, on the date it says or that follows from the time before; returns its moment.

        `early`: fixes of before the first date, which are added, and left out of the list, when it comes.
        """
        day = self.day or (last.date() if last else None)
        if self.clock is None or day is None:
            early += [] if self.clock is None else [self]
            return last
        moment = utc(datetime.combine(day, self.clock))
        if self.day is None and last and moment < last - _HALF_A_DAY:
            moment += timedelta(days=1)
        for epoch, then in [*_dated(early, moment), (self, moment)]:
            if epoch.place is not None:
                samples.add(then.timestamp(), *epoch.place, *epoch.quality, epoch.valid)
        early.clear()
        return moment


def _dated(early: list[_Epoch], after: datetime) -> Iterator[tuple[_Epoch, datetime]]:
    """Date times from the last on, each on the day of what comes after it, or on the day before."""
    for epoch in reversed(early):
        then = utc(datetime.combine(after.date(), epoch.clock or time()))
        after = then - timedelta(days=then > after + _HALF_A_DAY)
        yield epoch, after


def _number(value: object) -> float:
    try:
        return float(str(value))
    except ValueError:
        return math.nan
