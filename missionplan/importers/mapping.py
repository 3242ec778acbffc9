"""What the user says of a source's names, `lat=Latitude[deg]`, and degrees, times and units as logs write them."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import pandas as pd

from missionplan.arrays import Array, without_nines
from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.mission.documents import load_document
from missionplan.mission.units import FACTORS
from missionplan.scenario.currents.attributes import COARSEST, FINEST, factor

QUANTITIES = {
    "time": "iso",
    "lat": "deg",
    "lon": "deg",
    "x": "m",
    "y": "m",
    "dr_lat": "deg",
    "dr_lon": "deg",
    "dr_x": "m",
    "dr_y": "m",
    "depth": "m",
    "heading": "deg",
    "heading_true": "deg",
    "pitch": "deg",
    "speed": "m/s",
    "declination": "deg",
    "hdop": "",
    "hacc": "m",
    "satellites": "",
    "valid": "",
    "gps": "",
    "odometry": "",
    "mark": "",
    "origin": "",
}
"""Quantities that a name can be given for, and the unit where none is."""
ASSIGNMENT = re.compile(rf"({'|'.join(QUANTITIES)})=(.+)", re.DOTALL)
_UNIT = re.compile(r"(.*?)\s*\[([^\[\]]*)\]")
_BEHIND = re.compile(r"\s*[(\[]\s*([^()\[\]]*?)\s*[)\]]\s*$")
_WORD = re.compile(r"[^\W\d]\D*(-?\d)?|°")


@dataclass(frozen=True)
class MappedName:
    """A column, variable or topic, and the unit its values are in (``iso``, ``epoch``, ``ddmm`` and the like too)."""

    name: str
    unit: str


def read_mapping(entries: Sequence[str]) -> dict[str, MappedName]:
    """Read the entries of `--map`: `quantity=name[unit]`, several in one, or YAML files of them.

    Raises InputError: all entries that are none.
    """
    mapping: dict[str, MappedName] = {}
    problems: list[Problem] = []
    for entry in entries:
        if entry.endswith((".yaml", ".yml")) and "=" not in entry:
            data = load_document(Path(entry)).data
            pairs = list(data.items()) if isinstance(data, Mapping) else [(entry, None)]
        else:
            parts = (assignment.partition("=") for assignment in _split(entry))
            pairs = [(quantity.strip(), name if name.strip() else None) for quantity, _, name in parts]
        for quantity, name in pairs:
            problem = _problem(str(quantity), name)
            if problem is not None:
                problems.append(problem)
            else:
                mapping[str(quantity)] = mapped(str(quantity), str(name))
    if problems:
        raise InputError(problems)
    return mapping


def mapped(quantity: str, name: str) -> MappedName:
    """Split a name from its unit."""
    matched = _UNIT.fullmatch(name.strip())
    if matched is None:
        return MappedName(name.strip(), QUANTITIES[quantity])
    return MappedName(matched[1].strip(), matched[2].strip())


def own_unit(asked: MappedName, quantity: str, heading: str, below: str) -> str:
    """Return the unit of a column: the user's, else one that its heading ends with or the cell below it holds."""
    wanted = "rad" if QUANTITIES[quantity] == "deg" else QUANTITIES[quantity]
    if asked.unit != QUANTITIES[quantity] or wanted in ("", "iso"):
        return asked.unit
    behind, ending = _BEHIND.search(heading), heading.rpartition("_")[2]
    stated = [behind[1] if behind else "", ending if ending in FACTORS[wanted] else "", below.strip()]
    for word in (text for text in stated if _WORD.fullmatch(text)):
        if (wanted == "rad" and word.lower() in DDMM) or factor(word, wanted) or (wanted == "m" and factor(word, "Pa")):
            return word
    return asked.unit


def without_unit(heading: str) -> str:
    """Return the name of a column without a unit in brackets behind it."""
    return _BEHIND.sub("", heading).strip()


def _split(entry: str) -> list[str]:
    """Split `lat=Latitude[deg] time=UTC[iso]` before each quantity."""
    starts = [match.start() for match in re.finditer(rf"(?:^|(?<=\s))(?:{'|'.join(QUANTITIES)})=", entry)]
    if not starts or starts[0] != 0:
        return [entry]
    return [entry[start:end].strip() for start, end in zip(starts, [*starts[1:], len(entry)], strict=True)]


def _problem(quantity: str, name: object) -> Problem | None:
    if quantity not in QUANTITIES:
        hint = did_you_mean(quantity, QUANTITIES) or f"one of {', '.join(QUANTITIES)}"
        return Problem(f"given {shown(quantity)}, expected a quantity such as lat=Latitude[deg]", key="map", hint=hint)
    if name is None or str(name).strip() == "":
        return Problem(f"given {shown(quantity)} without a name, expected {quantity}=NAME[unit]", key="map")
    return None


if TYPE_CHECKING:
    Words: TypeAlias = pd.Series[str]
    Moments: TypeAlias = pd.Series[pd.Timestamp]
else:
    Words = Moments = pd.Series

PASCALS_A_METRE = 1.0e4
"""Pressure over depth in the sea, to 1 %."""
_EPOCH = {"epoch": 1.0, "unix": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_DAYS = {"days": 0.0, "matlab": 719529.0, "excel": 25569.0, "mjd": 40587.0, "jd": 2440587.5}
"""Day numbers of 1970-01-01."""
DDMM = ("ddmm", "ddmm.mmm", "dm")
"""What degrees and minutes in one number are called."""


def ddmm_to_degrees(value: Array) -> Array:
    """Degrees from degrees and minutes written as one number: 4839.12 is 48° 39.12′, negative south and west."""
    size = np.abs(value)
    degrees = np.floor(size / 100.0)
    return np.asarray(np.sign(value) * (degrees + (size - 100.0 * degrees) / 60.0))


_WORDED = re.compile(
    r"\s*([NSEW])?\s*([-+]?\d+(?:\.\d+)?)\s*[°ºd: -]?\s*(?:(\d+(?:\.\d+)?)\s*['′m: -]?\s*)?"
    r"(?:(\d+(?:\.\d+)?)\s*[\"″s]?\s*)?([NSEW])?\s*",
    re.IGNORECASE,
)


def degrees_of(word: str) -> float:
    """Read degrees as people write them: ``48.652``, ``48 39.12 N``, ``123°28'28.4"W``; nan where it is none."""
    match = _WORDED.fullmatch(word.replace(",", "."))
    if match is None:
        return math.nan
    degrees, minutes, seconds = (float(number or 0.0) for number in match.group(2, 3, 4))
    is_back = math.copysign(1.0, degrees) < 0.0 or (match[1] or match[5] or "").upper() in ("S", "W")
    return math.copysign(abs(degrees) + minutes / 60.0 + seconds / 3600.0, -1.0 if is_back else 1.0)


def angles(words: Words, unit: str) -> Array:
    """Latitudes or longitudes [deg]: in ``deg`` in any writing, ``ddmm`` (4839.12) or ``rad``.

    Raises InputError where a direction is written O: it is east in German, and west in French and Spanish.
    """
    is_other = words.str.contains(r"\d\W*[Oo]\W*$|^\s*[Oo]\W*\d", regex=True)
    if is_other.any():
        message = f"given {shown(words[is_other].iloc[0].strip())}: is O east (Ost) or west (ouest, oeste)?"
        raise InputError([Problem(message, key="map", hint="write E or W")])
    if unit.lower() in DDMM:
        is_back = words.str.contains(r"[SWsw]", regex=True)
        numbers = ddmm_to_degrees(plain_numbers(words.str.replace(r"[NSEWnsew ]", "", regex=True)))
        return np.asarray(np.where(is_back, -np.abs(numbers), numbers))
    numbers = plain_numbers(words)
    if unit.lower() in ("rad", "radian", "radians"):
        return np.degrees(numbers)
    worded = np.flatnonzero(np.isnan(numbers) & (words.str.strip() != "").to_numpy())
    numbers[worded] = [degrees_of(str(words.iloc[k])) for k in worded]
    return numbers


def plain_numbers(words: Words) -> Array:
    """Numbers, with a decimal point or comma; nan where a cell holds none."""
    numbers = pd.to_numeric(words.str.strip().str.replace(",", "."), errors="coerce")
    return without_nines(np.array(numbers, dtype=float))


_FLAGS = {**dict.fromkeys(("a", "true", "t", "yes", "y", "ok", "valid"), 1.0),
          **dict.fromkeys(("v", "false", "f", "no", "n", "invalid", "void"), 0.0)}  # fmt: skip


def flags(words: Words) -> Array:
    """Whether fixes are valid: numbers, or A and V as receivers write them, True and False, yes and no.

    Raises InputError when a cell holds anything else.
    """
    plain = words.str.strip().str.lower()
    values = np.where(plain.isin(_FLAGS), plain.map(_FLAGS), plain_numbers(words))
    other = plain[np.isnan(values) & ~plain.isin(("", "nan"))]
    if len(other):
        raise InputError([Problem(f"given {shown(other.iloc[0])}, expected numbers, A or V, True or False", key="map")])
    return np.asarray(values, dtype=float)


def quantities(words: Words, unit: str, wanted: str) -> Array:
    """Numbers in a unit that pint knows, in the wanted one.

    Raises InputError when the unit is unknown, or of another kind.
    """
    numbers = plain_numbers(words)
    return numbers if unit == wanted or not wanted else numbers * unit_factor(unit, wanted)


@lru_cache(maxsize=64)
def unit_factor(unit: str, wanted: str) -> float:
    """Return what a number in a unit is multiplied by to be in the wanted one; a pressure becomes a depth.

    Raises InputError when the unit is unknown, or of another kind.
    """
    scale, pressure = factor(unit, wanted), factor(unit, "Pa") if wanted == "m" else None
    scale = scale if wanted != "m" or scale is None or FINEST <= scale <= COARSEST else None
    if scale is None and pressure is None:
        raise InputError([Problem(f"given the unit {shown(unit)}, expected one such as {wanted}", key="map")])
    return scale if scale is not None else (pressure or 0.0) / PASCALS_A_METRE


def times(words: Words, unit: str) -> Array:
    """Times as seconds since 1970; nan where a cell holds none.

    Raises InputError when it is none of these.

    `unit`: ``iso``; ``epoch`` or ``s``, ``ms``, ``us``, ``ns`` since 1970; ``days`` since 1970; ``doy:2026`` (day of
    that year, 1.0 at its first midnight); ``matlab`` (days since year 0), ``excel``, ``mjd``, ``jd``; or a
    pattern such as ``%d.%m.%Y %H:%M:%S``.
    """
    kind = unit.lower()
    if "%" in unit:
        stamps = _stamps(pd.to_datetime(words.str.strip(), format=unit, errors="coerce", utc=True))
        if unit.endswith("%S") and np.isnan(stamps).any():  # seconds may have decimals
            parts = _stamps(pd.to_datetime(words.str.strip(), format=f"{unit}.%f", errors="coerce", utc=True))
            stamps = np.where(np.isnan(stamps), parts, stamps)
        return stamps
    if kind in ("iso", "iso8601", "utc", ""):
        words = words.str.strip().str.replace(",", ".")
        return _stamps(pd.to_datetime(words, format="ISO8601", errors="coerce", utc=True))
    if kind in _EPOCH:
        return plain_numbers(words) * _EPOCH[kind]
    if re.fullmatch(r"doy:\d{4}", kind):
        begun = datetime(int(kind[4:]), 1, 1, tzinfo=UTC).timestamp()
        return begun + (plain_numbers(words) - 1.0) * 86400.0
    if kind in _DAYS:
        return (plain_numbers(words) - _DAYS[kind]) * 86400.0
    expected = "iso, epoch, ms, us, ns, days, doy:2026, matlab, excel or a pattern such as %d.%m.%Y %H:%M:%S"
    raise InputError([Problem(f"time in {shown(unit)}, expected {expected}", key="map")])


def _stamps(moments: Moments) -> Array:
    return np.array((moments - pd.Timestamp(0, tz="UTC")).dt.total_seconds(), dtype=float)


_PLACES = (("lat", "lon"), ("dr_lat", "dr_lon"), ("x", "y"), ("dr_x", "dr_y"))


def check_mapping(names: Mapping[str, MappedName], path: Path) -> None:
    """Raise InputError unless columns of time, and of position or depth, are named."""
    has_place = any(set(pair) <= set(names) for pair in _PLACES)
    if "time" not in names or not (has_place or "depth" in names):
        hint = "--map time=UTC[iso] lat=Latitude[deg] lon=Longitude[deg] depth=z[m]"
        raise InputError([Problem("which columns have time and position, or depth?", str(path), hint=hint)])
