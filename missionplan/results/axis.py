"""One of the keys that are varied or chosen, with its values; and what is best."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Literal

from missionplan.results.entries import Entry, Record

Aim = Literal["success", "energy", "duration"]


@dataclass(frozen=True)
class Axis(Record):
    """What is varied along one axis.

    Attributes
    ----------
    values : tuple
        As the mission file takes them.
    labels : tuple of str
        As people read them, without the unit.
    numbers : tuple of float or None
        In `unit`, or for `start` seconds since 1970; None where the values are no numbers.
    """

    keys: Annotated[tuple[str, ...], Entry("key paths that take the same value")]
    values: tuple[object, ...]
    labels: tuple[str, ...]
    numbers: tuple[float, ...] | None = None
    unit: Annotated[str, Entry("as given; ``UTC`` for `start`; empty for bare numbers and for what has no number")] = ""

    @property
    def exact_values(self) -> Annotated[list[str], Entry(key="values")]:
        """Values as a script reads them."""
        return [self.exact(index) for index in range(len(self.values))]

    @property
    def name(self) -> str:
        """The keys in one word."""
        return "+".join(self.keys)

    @property
    def is_time(self) -> bool:
        """Whether the values are moments."""
        return self.keys == ("start",)

    def shown(self, index: int) -> str:
        """Return a value with its unit."""
        return f"{self.labels[index]} {self.unit}".strip()

    def exact(self, index: int) -> str:
        """Return a value as a script reads it: moments by ISO 8601."""
        if self.is_time and self.numbers is not None:
            return datetime.fromtimestamp(self.numbers[index], UTC).isoformat(timespec="seconds")
        return self.shown(index)
