"""A row of the validation table: a claim, a case, a reference, and a function that returns the numbers."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
MISSIONS = ROOT / "missions"
LEVELS = {
    "closed": "Closed forms and invariants",
    "paper": "Tables and figures of the papers",
    "peer": "Peer programs",
    "calibration": "Calibration",
    "sea": "Logs and records of real vehicles",
    "fault": "Faults survived",
}
"""What a row is compared with, in the order of the table; an ID begins with its level."""
PAGES = {
    "closed": "closed-forms",
    "paper": "papers",
    "peer": "peers",
    "calibration": "calibration",
    "sea": "logs",
    "fault": "faults",
}
"""The page of `docs/validation` of each level, and the file of `validation/measured` with what its rows measured."""
CHEAP = 60.0
"""CPU time up to which a row is measured unless it is asked for [s]."""


class NotMeasurableHereError(Exception):
    """A peer program or a record that a row needs is not on this machine."""


@dataclass(frozen=True)
class Accepted:
    """One number of a row, and where it has to lie; without limits it is only reported."""

    name: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf

    @property
    def is_limited(self) -> bool:
        """Whether the number can fail."""
        return self.low > -math.inf or self.high < math.inf

    def holds(self, value: float) -> bool:
        """Whether a value lies where it has to; nan does only where nothing is asked."""
        return not self.is_limited or self.low <= value <= self.high


def at_most(name: str, high: float, unit: str = "") -> Accepted:
    """Return a number with an upper limit."""
    return Accepted(name, unit, high=high)


def at_least(name: str, low: float, unit: str = "") -> Accepted:
    """Return a number with a lower limit."""
    return Accepted(name, unit, low=low)


def between(name: str, low: float, high: float, unit: str = "") -> Accepted:
    """Return a number with both limits."""
    return Accepted(name, unit, low, high)


def near(name: str, value: float, away: float, unit: str = "") -> Accepted:
    """Return a number that has to lie about a printed one."""
    return Accepted(name, unit, value - away, value + away)


def reported(name: str, unit: str = "") -> Accepted:
    """Return a number that is shown and not judged."""
    return Accepted(name, unit)


@dataclass(frozen=True)
class Options:
    """What a run of the rows is told.

    Attributes
    ----------
    data : Path
        Folder of records of real vehicles.
    work : Path
        Folder in which long rows keep what they have done, and go on from it.
    """

    data: Path
    work: Path


@dataclass(frozen=True)
class Measured:
    """The numbers of a row, in the order of its `accepted`, and a figure where a curve says more."""

    values: Sequence[float]
    figure: "Figure | None" = None


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Attributes
    ----------
    name : str
        ID: level and name, such as ``closed.dive-stages``.
    claim, case, reference : str
        What is said, of which case, and what it is compared with.
    accepted : tuple of Accepted
        The numbers, in order.
    measure : callable
        Computes them.
    seed : int or None
        Of its random numbers.
    packages : tuple of str
        Peer programs that it runs.
    cost : float
        CPU time, about [s].
    differs : str
        Why the reference is not met, where that is known; the numbers are then held to what was found.
    """

    name: str
    claim: str
    case: str
    reference: str
    accepted: tuple[Accepted, ...]
    measure: Callable[[Options], Measured]
    seed: int | None = None
    packages: tuple[str, ...] = ()
    cost: float = 5.0
    differs: str = ""

    @property
    def level(self) -> str:
        """What it is compared with, a key of `LEVELS`."""
        return self.name.partition(".")[0]

    @property
    def command(self) -> str:
        """What measures it again."""
        return f"python -m validation {self.name}"


_ROWS: dict[str, Row] = {}


def row(
    name: str,
    claim: str,
    *,
    case: str,
    reference: str,
    accepted: Sequence[Accepted],
    **more: "int | float | str | tuple[str, ...] | None",
) -> "Callable[[Callable[[Options], Sequence[float] | Measured]], Callable[[Options], Sequence[float] | Measured]]":
    """Put a function that measures into the table; the arguments are those of `Row`."""

    def registered(
        measure: "Callable[[Options], Sequence[float] | Measured]",
    ) -> "Callable[[Options], Sequence[float] | Measured]":
        def measured(options: Options) -> Measured:
            found = measure(options)
            return found if isinstance(found, Measured) else Measured([float(value) for value in found])

        if name in _ROWS or name.partition(".")[0] not in LEVELS:
            raise ValueError(f"{name}: a second row of this name, or no level")
        _ROWS[name] = Row(name, claim, case, reference, tuple(accepted), measured, **more)  # type: ignore[arg-type]
        return measure

    return registered


def all_rows() -> dict[str, Row]:
    """Return every row by its ID, level after level."""
    from validation import calibration, closed_forms, faults, papers, peers, sea_records

    modules = (calibration, closed_forms, faults, papers, peers, sea_records)
    assert all(modules)
    return {name: each for level in LEVELS for name, each in _ROWS.items() if each.level == level}


def rows_of(level: str) -> Iterator[Row]:
    """Yield the rows of a level."""
    yield from (each for each in all_rows().values() if each.level == level)
