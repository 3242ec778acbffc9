"""Moments: every time of day that a file, an option or a caller gives becomes an aware `datetime` in UTC here alone."""

import math
import re
from collections.abc import Mapping
from datetime import UTC, date, datetime, timedelta, timezone
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

EXAMPLE = "2026-06-01T04:00Z"
"""A moment as messages write one."""
EPOCH_SCALE = 1e8
"""Times above this are seconds since 1970, not since some start [s]."""
YET_TO_COME = 100.0 * 31_556_952.0
"""Later than this is nothing that was measured: days of spreadsheets counted from 1970 are [s since 1970]."""
_ISO = re.compile(
    r"(?P<year>[+-]?\d{1,4})-(?P<month>\d{1,2})-(?P<day>\d{1,2})"
    r"(?:(?:[Tt]|\s+)(?P<hour>\d{1,2})(?::(?P<minute>\d{1,2})(?::(?P<second>\d{1,2})(?:[.,](?P<part>\d*))?)?)?)?"
    r"\s*(?P<zone>.*)"
)
_OFFSET = re.compile(r"(?P<sign>[+-])(?P<hours>\d{1,2})(?::?(?P<minutes>\d{2}))?")
_UNIT = re.compile(r"\s*(?P<unit>[^\W\d]+)\s+(?:since|from|after|ref|@)\s+(?P<since>\S.*?)\s*", re.IGNORECASE)
_SECONDS = {
    "s": ("s", "sec", "second"),
    "ms": ("ms", "msec", "millisec", "millisecond"),
    "us": ("us", "µs", "microsec", "microsecond"),
    "ns": ("ns", "nanosec", "nanosecond"),
    "min": ("min", "minute"),
    "h": ("h", "hr", "hour"),
    "d": ("d", "day"),
}
_TEXTS = ("long_name", "comment", "description")
"""Attributes of times that people read."""
_OTHER_ZONE = re.compile(
    r"(?i:\b(?:UTC|GMT)\s*[+-]\s*0?[1-9]\d*|\blocal(?:[\s_-]+\w+){0,2}[\s_-]+time\b|^\W*local\W*$|\btime[\W_]+local\b)"
    r"|\b(?:[ACEMP][DS]T|AK[DS]T|HA?ST|[CE]ES?T|MES?Z|BST|JST|AE[DS]T|NZ[DS]T)\b"
)
_PLAIN_UTC = re.compile(r"\b(?:UTC|GMT)\b(?!\s*[+-]\s*0?[1-9])", re.IGNORECASE)
_LENGTHS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}
_CALENDARS = ("", "standard", "gregorian", "proleptic_gregorian")
_REFORM = datetime(1582, 10, 15, tzinfo=UTC)
"""First day of the Gregorian calendar, before which CF's standard calendar is the Julian one."""


def utc(moment: datetime) -> datetime:
    """Return a moment in UTC; one without a zone is UTC, whatever the zone of the computer."""
    return moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)


def moment_of(value: object) -> datetime:
    """Read a moment as a file or a caller gives it.

    Raises ValueError when it is anything else, such as a bare number, or of a zone that has only a name.

    Parameters
    ----------
    value : object
        A text by ISO 8601, a date (its midnight) or a `datetime`.

    Returns
    -------
    datetime
        In UTC, which is the zone of what names none.
    """
    if isinstance(value, datetime):
        return utc(value)
    if isinstance(value, date):
        return datetime(value.year, value.month, value.day, tzinfo=UTC)
    words = value.strip() if isinstance(value, str) else ""
    matched = _ISO.fullmatch(words)
    if matched is not None:
        return _of_parts(matched)
    if re.match(r"\d{8}T", words.upper()):  # the basic form, 20260601T0400Z
        return utc(datetime.fromisoformat(words.upper()))
    raise ValueError(f"expected a date and time such as {EXAMPLE}")


def moment_or_none(value: object) -> datetime | None:
    """Read a moment where a value is one."""
    try:
        return moment_of(value)
    except (ValueError, OverflowError):
        return None


def _of_parts(matched: re.Match[str]) -> datetime:
    year, month, day, hour, minute, second = (
        int(matched[name] or 0) for name in ("year", "month", "day", "hour", "minute", "second")
    )
    micro = int((matched["part"] or "0").ljust(6, "0")[:6])
    midnight = timedelta(days=hour == 24 and not (minute or second or micro))  # ISO 8601's end of a day
    moment = datetime(year, month, day, 0 if midnight else hour, minute, second, micro, tzinfo=zone_of(matched["zone"]))
    return (moment + midnight).astimezone(UTC)


def zone_of(words: str) -> timezone:
    """Read a zone by its offset; none named is UTC.

    Raises ValueError when it is not UTC and has no offset: names such as EST are of several zones.
    """
    if words.strip().upper() in ("", "Z", "UTC", "GMT", "ZULU", "UT"):
        return UTC
    offset = _OFFSET.fullmatch(words.strip())
    if offset is None:
        raise ValueError(f"the zone {words.strip()!r} has no offset; expected Z, UTC or one such as -05:00")
    away = timedelta(hours=int(offset["hours"]), minutes=int(offset["minutes"] or 0))
    return timezone(-away if offset["sign"] == "-" else away)


def zone_written(value: object) -> timezone:
    """Zone in which a moment is written; UTC where it names none."""
    matched = _ISO.fullmatch(value.strip()) if isinstance(value, str) else None
    return zone_of(matched["zone"]) if matched is not None else UTC


def other_zone(text: str) -> str:
    """Return the words by which a text for people says that times are not of UTC; none where it names UTC too."""
    matched = _OTHER_ZONE.search(text)
    return matched[0].strip() if matched is not None and not _PLAIN_UTC.search(text) else ""


def is_since(units: object) -> bool:
    """Whether units are of times since a moment."""
    return isinstance(units, str) and _UNIT.fullmatch(units) is not None


def clock(attributes: Mapping[Any, object]) -> tuple[float, float]:
    """Read what the attributes of times say (UDUNITS and CF 1.11, section 4.4).

    Raises ValueError when their units are none of times, the calendar is one of climate models, whose days are not the
    sea's, or they are of a zone without an offset.

    Parameters
    ----------
    attributes : mapping
        With `units` (``days since 1950-01-01``), and `calendar`, `time_zone` or a text for people, where there are any.

    Returns
    -------
    zero, length : float
        The moment since which times count, from the start of 1970, and their unit [s].
    """
    said = {str(name).lower(): str(value).strip() for name, value in attributes.items()}
    kind, zone = said.get("calendar", "").lower(), said.get("time_zone", said.get("timezone", ""))
    if kind not in _CALENDARS:
        raise ValueError(f"the calendar {said['calendar']!r} is not the standard one")
    units = said.get("units", "")
    matched = _UNIT.fullmatch(units)
    unit = "" if matched is None else matched["unit"].lower()
    name = next((key for key, names in _SECONDS.items() if unit in names or unit.removesuffix("s") in names), None)
    if matched is None or name is None:
        raise ValueError(f"units {units!r}; expected seconds, minutes, hours or days since a moment such as {EXAMPLE}")
    moment = moment_of(matched["since"])
    away = timedelta() if zone.lower() in ("", "none") else zone_of(zone).utcoffset(None)
    is_utc = not away and zone_written(matched["since"]) == UTC
    words = next(filter(None, (other_zone(said.get(text, "")) for text in _TEXTS)), "") if is_utc else ""
    if words:
        raise ValueError(f"a text beside it says {words!r}, its units UTC; an attribute time_zone such as -05:00 tells")
    zero = moment.timestamp() - away.total_seconds()
    if moment < _REFORM and kind != "proleptic_gregorian":
        zero += 86400.0 * _days_between_calendars(moment.year - (moment.month < 3))
    return zero, _LENGTHS[name]


def _days_between_calendars(year: int) -> int:
    """Days by which a date of a year that begins in March is later in the Julian calendar than in the Gregorian."""
    return year // 100 - year // 400 - 2


def epoch_of(text: str) -> float:
    """Read a time as seconds since 1970; without a zone it is UTC.

    Raises ValueError when it is neither ISO 8601 nor a number.
    """
    words = text.strip()
    try:
        return float(words)
    except ValueError:
        return moment_of(words).timestamp()


def epoch_seconds(words: "pd.Series[str]") -> "pd.Series[float]":
    """Read times by ISO 8601 as seconds since 1970, nan where a cell holds none; without a zone they are UTC."""
    return words.map(_epoch_or_nan).astype(float)


def _epoch_or_nan(text: object) -> float:
    try:
        return epoch_of(text) if isinstance(text, str) else math.nan
    except (ValueError, OverflowError):
        return math.nan
