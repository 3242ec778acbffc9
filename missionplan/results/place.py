"""What missions meet of ground and coast."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class PlaceContact(Record):
    """Trials that a phase loses to one cause."""

    phase: Annotated[str, Entry("as the mission's file has it")]
    cause: Annotated[str, Entry("``aground``, ``on-land``, ``keep-out`` or ``left the grid of depths``")]
    lost: Annotated[Probability, Entry("of all trials")]
    legs: Annotated[Mapping[str, int], Entry("trials by the leg on which it happened, from 1; 0 at a mooring")]
    east: Annotated[float, Entry("mean of the places, east of the origin", "m")]
    north: Annotated[float, Entry("mean of the places, north of the origin", "m")]


@dataclass(frozen=True)
class SeaChart:
    """Depths, land and zones kept out of about the tracks, for maps.

    Attributes
    ----------
    east, north : array, shape (columns,) and (rows,)
        [m]
    depth : array, shape (rows, columns), or None
        Of the water at the mission's start, nan where unknown; None without a grid of depths [m].
    shapes : tuple of (str, tuple of array, shape (k, 2))
        ``land`` or ``keep-out``, with the outline of each polygon and its holes, east and north [m].
    """

    east: Array
    north: Array
    depth: Array | None
    shapes: tuple[tuple[str, tuple[Array, ...]], ...] = ()


@dataclass(frozen=True)
class Coverage(Record):
    """Something that a mission may fail of, and whether its probability of success holds it."""

    what: Annotated[str, Entry("``ground``, ``coast``, ``wind``, ``waves``, ``traffic``, ``equipment``, …")]
    held: Annotated[bool, Entry("whether the probability holds it")]
    why: Annotated[str, Entry("what is held of it, or why it matters here")]
