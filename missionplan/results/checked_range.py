"""In which ranges the models were checked, by which rows of `docs/validation`, and on which rows each answer rests."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class Range:
    """A range of a quantity in which a model was compared with something that shares no code with it.

    Attributes
    ----------
    low, high : float
        [`unit`]
    """

    quantity: str
    low: float
    high: float
    unit: str
    """SI; empty for a ratio."""
    rows: tuple[str, ...]
    """IDs of the rows that compared: ``python -m validation ID``."""


_MOORED = ("peer.scipy-moored-line", "peer.moordyn-moored-line")
RANGES: Mapping[str, Range] = {
    "speed_error": Range(
        "velocity error over speed", 0.004, 0.6, "", ("closed.transit-loop", "paper.briggs-fig-8", "sea.modena")
    ),
    "leg": Range("longest leg over arrival radius", 0.6, 150.0, "", ("closed.transit-loop", "paper.briggs-fig-8")),
    "transit": Range("length of a transit", 800.0, 20_000.0, "m", ("closed.transit-loop", "closed.adaptive-legs")),
    "depth": Range("depth of a mooring", 8.0, 60.0, "m", ("peer.scipy-tied-drift", "paper.briggs-table-1")),
    "line": Range("length of the line", 2.0, 12.0, "m", ("peer.scipy-tied-drift", "peer.scipy-moored-line")),
    "line_diameter": Range("diameter of the line", 0.0, 0.008, "m", _MOORED),
    "dive_current": Range("current during a dive", 0.0, 1.2, "m/s", ("peer.scipy-tied-drift",)),
    "hold_current": Range("current at the seafloor", 0.0, 0.5, "m/s", _MOORED),
}
"""Of each quantity, the range that all its rows together cover."""
_TRANSIT = ("closed.one-leg", "closed.transit-loop", "paper.briggs-fig-8")
_MOORING = ("closed.dive-stages", "peer.scipy-tied-drift", *_MOORED)
_MISSION = (*_TRANSIT, *_MOORING, "closed.sensitivity", "paper.briggs-chesapeake")
_RARE = ("closed.rare-ways", "calibration.rare-mission", "peer.openturns-problems")
ROWS_OF_COMMAND: Mapping[str, tuple[str, ...]] = {
    "compare": _MISSION,
    "diagnose": (
        "calibration.legs", "calibration.hidden-legs", "calibration.hidden-dives", "calibration.tank", "sea.modena",
        "sea.saanich",
    ),
    "explore": _MISSION,
    "history": ("calibration.fleets",),
    "identify": ("paper.avila-drag", "paper.avila-added-mass", "calibration.sizes-tank"),
    "import": ("sea.raw-logs",),
    "optimise": (*_MISSION, "closed.optimise"),
    "plan-legs": (*_TRANSIT, "closed.adaptive-legs", "closed.drift-filter"),
    "score": ("calibration.legs", "sea.modena", "sea.saanich"),
    "simulate": _MISSION,
    "simulate --rare": (*_MISSION, *_RARE),
    "size-anchor": (*_MOORING, "paper.briggs-anchor", "paper.briggs-terminal-velocity"),
    "sweep-dmax": _TRANSIT,
    "sweep-transition": ("paper.palmer-transition", "paper.palmer-least-energy", "paper.palmer-tunnel"),
    "tide": ("calibration.tide-forecast", "peer.utide-forecast"),
}  # fmt: skip
"""Rows on which the answer of each command rests."""


@dataclass(frozen=True)
class CheckedRange(Record):
    """A quantity of a mission beside the range in which the model was checked."""

    quantity: Annotated[str, Entry("what it is")]
    least: Annotated[float, Entry("in this mission, at the means, in `unit`")]
    greatest: Annotated[float, Entry("in this mission, at the means, in `unit`")]
    low: Annotated[float, Entry("lower end of what was checked, in `unit`")]
    high: Annotated[float, Entry("upper end of what was checked, in `unit`")]
    unit: Annotated[str, Entry("of these numbers; empty for a ratio")]
    rows: Annotated[tuple[str, ...], Entry("IDs of the rows of docs/validation that checked it")]

    @property
    def is_inside(self) -> Annotated[bool, Entry(key="inside")]:
        """Whether all of the mission lies in what was checked."""
        return self.low <= self.least and self.greatest <= self.high
