"""What trials are counted for: events, ways to fail, limits, requirements and explanations, as results name them."""

from enum import StrEnum
from typing import NamedTuple

from missionplan.phases.place import Cause


class CountedKind(StrEnum):
    """What trials are counted for."""

    EVENT = "event"
    FAILURE = "failure"
    LIMIT = "limit"
    REQUIREMENT = "requirement"
    EXPLANATION = "explained"


class Counted(NamedTuple):
    """What trials are counted by."""

    kind: CountedKind
    of: str
    """Phase, or ``total``; place of a list of explanations; empty of limits and requirements."""
    name: str
    """Event, `Failure`, limit, or number of a requirement or an explanation."""

    @classmethod
    def event(cls, key: str) -> "Counted":
        """Return the event of a key such as ``moor.within_radius``."""
        phase, _, name = key.rpartition(".")
        return cls(CountedKind.EVENT, phase, name)

    @classmethod
    def requirement(cls, number: int) -> "Counted":
        """Return the requirement of a number, from 0: that it is met."""
        return cls(CountedKind.REQUIREMENT, "", str(number))

    def __str__(self) -> str:
        """Write it as results do: ``moor.within_radius``, ``moor: anchor dragged``, ``requirement 0``."""
        if self.kind is CountedKind.EVENT:
            return f"{self.of}.{self.name}"
        return f"{self.of}: {self.name}" if self.kind is CountedKind.FAILURE else f"{self.kind} {self.name}"


SUCCESS = Counted.event("total.success")


class Failure(StrEnum):
    """Why a phase ends a trial."""

    NOT_ARRIVED = "not arrived"
    OUTRUN = "current faster than the vehicle"
    LEFT_RECORD = "left the record of the current"
    AGROUND = "aground"
    ON_LAND = "on-land"
    KEEP_OUT = "keep-out"
    UNCHARTED = "left the grid of depths"
    EQUIPMENT = "equipment"
    OUT_OF_ENERGY = "out of energy"
    TOO_SHALLOW = "line and vehicle longer than the water is deep"
    FLOODED_EARLY = "anchor flooded before its release"
    TOO_LIGHT = "anchor too light to sink the vehicle"
    LINE_PARTED = "line parted"
    NOT_DOWN = "anchor did not reach the seafloor"
    OUTSIDE = "anchor outside the radius"
    STRUCK = "struck the seafloor"
    DRAGGED = "anchor dragged"
    GROUNDED = "grounded in the hold"
    NOT_SURFACED = "did not surface"
    NOT_HOVERING = "did not come to hover"


MET = {
    Cause.AGROUND: Failure.AGROUND,
    Cause.ON_LAND: Failure.ON_LAND,
    Cause.KEEP_OUT: Failure.KEEP_OUT,
    Cause.UNCHARTED: Failure.UNCHARTED,
}
"""Failures by what a trial has met."""
LIMITS: tuple[Failure, ...] = (
    Failure.EQUIPMENT,
    Failure.LEFT_RECORD,
    Failure.OUTRUN,
    *MET.values(),
    Failure.TOO_SHALLOW,
    Failure.TOO_LIGHT,
)
"""Failures where the world sets a limit: reported where some trial met it."""
