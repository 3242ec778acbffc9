"""Quantities in a text, converted to the units of the crew: ``350 m`` to ``1148 ft``."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial

from missionplan.mission.unit_table import FACTORS

_NO_BREAK_SPACE, _NARROW_SPACE, _MINUS = "\u00a0", "\u202f", "\u2212"
SYSTEMS: Mapping[str, Mapping[str, tuple[tuple[float, str], ...]]] = {
    "metric": {"m": ((1000.0, "m"), (math.inf, "km")), "m/s": ((math.inf, "m/s"),)},
    "nautical": {"m": ((926.0, "m"), (math.inf, "nmi")), "m/s": ((math.inf, "kn"),)},
    "imperial": {
        "m": ((1609.344, "ft"), (math.inf, "mi")),
        "m/s": ((math.inf, "ft/s"),),
        "N": ((math.inf, "lbf"),),
        "kg": ((math.inf, "lb"),),
    },
}
"""Of each system, by the SI unit of a dimension: units, each up to a size in SI; of others, the SI unit itself."""
_READ = {
    "m": ("m", "km", "ft", "nmi", "mi"),
    "m/s": ("m/s", "cm/s", "kn", "ft/s", "km/h"),
    "N": ("N", "lbf"),
    "kg": ("kg", "lb"),
}
"""Units that are converted, by SI unit; a millimetre of a drawing stays one."""
DIMENSIONS = {name: si for si, names in _READ.items() for name in names}
"""SI unit of each unit that is converted."""
_NUMBER = r"[−-]?(?:\d[\d\u202f]*)(?:\.\d+)?"
_SPACE = r"[ \u00a0]"
_SIGN = rf"{_SPACE}?(?:±|to|–){_SPACE}?"
_NAMES = "|".join(sorted(map(re.escape, DIMENSIONS), key=len, reverse=True))
_QUANTITY = re.compile(
    rf"(?<![\w.])({_NUMBER}(?:{_SIGN}{_NUMBER})*){_SPACE}({_NAMES})(?![\w/²³*·])(?![ \u00a0\u202f][ms]\b)"
)
_CELL = re.compile(rf"({_NUMBER}(?:{_SIGN}{_NUMBER})*)|–?")
_OF_THE_ROW = ("sd", "5 %", "50 %", "95 %")
"""Heads of columns whose numbers have the unit of the quantity in their row."""
HEAD = re.compile(rf"(.*\()({_NAMES})(\).*)", re.DOTALL)
"""A heading or the label of an axis with a unit in brackets."""

_chosen: ContextVar[str] = ContextVar("units", default="")
_drawn: ContextVar[str] = ContextVar("drawn", default="")


@contextmanager
def using_units(system: str | None) -> Iterator[None]:
    """Write reports in a system of units, whatever their missions say; None leaves it to the missions."""
    token = _chosen.set(system or "")
    try:
        yield
    finally:
        _chosen.reset(token)


def given_units() -> str:
    """Return the system chosen for the run; empty where the mission's counts."""
    return _chosen.get()


@contextmanager
def drawing_in(system: str) -> Iterator[None]:
    """Draw figures in a system of units; empty: as they are drawn."""
    token = _drawn.set(system)
    try:
        yield
    finally:
        _drawn.reset(token)


def drawn_units() -> str:
    """Return the system in which figures are drawn; empty: as they are drawn."""
    return _drawn.get()


def units_of(data: Mapping[str, object]) -> str:
    """Return the system of units for a mission's report; empty: as the mission file writes them."""
    system = _chosen.get() or data.get("units")
    return system if isinstance(system, str) and system in SYSTEMS else ""


def in_units(text: str, system: str) -> str:
    """Convert the quantities of a text."""
    return _QUANTITY.sub(partial(_converted, system=system), text)


def _converted(found: re.Match[str], *, system: str) -> str:
    numbers, unit = found[1], found[2]
    target = target_unit(unit, [numbers], system)
    return found[0] if target == unit else f"{rescaled(numbers, unit, target)}{_NO_BREAK_SPACE}{target}"


def target_unit(unit: str, numbers: list[str], system: str) -> str:
    """Choose the unit of the crew for numbers of one unit, by the largest of them."""
    found = [abs(_value(each)) for text in numbers for each in re.findall(_NUMBER, text)]
    return unit_for_size(unit, max(found, default=0.0), system)


def unit_for_size(unit: str, largest: float, system: str) -> str:
    """Choose the unit of the crew for numbers of one unit up to a size."""
    si = DIMENSIONS[unit]
    choices = SYSTEMS[system].get(si)
    if choices is None:  # the metric and the nautical system have SI's
        return si
    return next(name for limit, name in choices if largest * FACTORS[si][unit] < limit)


def rescaled(numbers: str, unit: str, target: str) -> str:
    """Write numbers in another unit, with about as fine a last digit as they have."""
    si = DIMENSIONS[unit]
    factor = FACTORS[si][unit] / FACTORS[si][target]
    decimals = max(len(each.partition(".")[2]) for each in re.findall(_NUMBER, numbers))
    kept = max(0, round(decimals - math.log10(factor) + 0.3))
    return re.sub(_NUMBER, lambda found: _written(factor * _value(found[0]), kept), numbers)


def _value(number: str) -> float:
    return float(number.replace(_MINUS, "-").replace(_NARROW_SPACE, ""))


def _written(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    whole, point, rest = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", _NARROW_SPACE)
    return (_MINUS if text.startswith("-") and float(text) else "") + whole + point + rest


def column_in_units(head: str, cells: list[str], system: str) -> tuple[str, list[str]]:
    """Convert a column of numbers whose unit stands in its head; one with other cells stays as it is."""
    found = HEAD.fullmatch(head)
    if found is None or not all(_CELL.fullmatch(cell) for cell in cells):
        return head, cells
    unit = found[2]
    target = target_unit(unit, cells, system)
    if target == unit:
        return head, cells
    return f"{found[1]}{target}{found[3]}", [
        rescaled(cell, unit, target) if cell.strip("–") else cell for cell in cells
    ]


def row_in_units(heads: Sequence[str], row: Sequence[str], system: str) -> list[str]:
    """Convert the spread and the points of a row, bare numbers in the unit of the row's own quantity."""
    found = next(filter(None, map(_QUANTITY.fullmatch, row)), None)
    if found is None or len(heads) != len(row):
        return list(row)
    target = target_unit(found[2], [found[1]], system)
    return [
        rescaled(cell, found[2], target)
        if head.replace(_NO_BREAK_SPACE, " ") in _OF_THE_ROW and _CELL.fullmatch(cell) and cell.strip("–")
        else cell
        for head, cell in zip(heads, row, strict=True)
    ]
