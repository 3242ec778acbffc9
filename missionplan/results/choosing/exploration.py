"""Result of `explore`: one or two keys varied, cell by cell, the best cells, and where the requirements are met."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal

import pandas as pd

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.results.base import Provenance, Result, to_csv, to_grid
from missionplan.results.choosing.axis import Aim, Axis
from missionplan.results.members import MemberOutcome
from missionplan.results.simulation import RequirementOutcome

if TYPE_CHECKING:
    import xarray

NOT_RUN = Probability(float("nan"), float("nan"), float("nan"))
"""Of a cell that cannot be run."""
Status = Literal["met", "undecided", "missed", "none", "invalid"]


@dataclass(frozen=True)
class Cell:
    """The mission with one value of each key.

    Attributes
    ----------
    place : tuple of int
        Index along each axis.
    reason : str
        Why it cannot be run; empty where it can. The other attributes then say nothing.
    success : Probability
    requirements : tuple of RequirementOutcome
    quantities : mapping of str to Statistic
        Such as ``total.energy_wh``, of the trials that reach them.
    events : mapping of str to Probability
        Such as ``ingress.arrived``.
    worse : float
        Mean of what the aim asks for, less that of the best cell, trial by trial on common random numbers, positive
        where this cell is worse [share, W h or s]; nan where it is not compared.
    worse_error : float
        Standard error of that difference.
    as_good : bool
        Whether the trials cannot tell the cell from the best.
    on_front : bool
        Whether no other cell is at least as good in P(success), mean energy and mean duration, and better in one.
    trials : int
    dropped : bool
        Whether a race ended before the cell had all trials, because it cannot be the best.
    """

    place: tuple[int, ...]
    reason: str = ""
    success: Probability = NOT_RUN
    requirements: tuple[RequirementOutcome, ...] = ()
    quantities: Mapping[str, Statistic] = field(default_factory=dict)
    events: Mapping[str, Probability] = field(default_factory=dict)
    worse: float = float("nan")
    worse_error: float = float("nan")
    as_good: bool = False
    on_front: bool = False
    trials: int = 0
    dropped: bool = False

    @property
    def status(self) -> Status:
        """Whether all requirements are met; undecided where none is certainly missed."""
        if self.reason:
            return "invalid"
        if not self.requirements:
            return "none"
        if any(not item.met and not item.undecided for item in self.requirements):
            return "missed"
        return "undecided" if any(item.undecided for item in self.requirements) else "met"

    @property
    def meets_all(self) -> bool:
        """Whether each requirement is met by the rule of `simulate`, undecided or not."""
        return not self.reason and all(item.met for item in self.requirements)


@dataclass(frozen=True)
class Window:
    """Neighbouring cells along the only axis, from the first to the last, that have something in common."""

    first: int
    last: int


@dataclass(frozen=True, repr=False)
class Exploration(Result):
    """One or two keys of a mission varied on common random numbers.

    Attributes
    ----------
    provenance : Provenance
    axes : tuple of Axis
        One or two.
    cells : tuple of Cell
        The last axis runs fastest.
    aim : 'success', 'energy' or 'duration'
    best : int or None
        Number of the best cell; None where no cell can be compared.
    constrained : bool
        Whether the best is among the cells that meet all requirements.
    members : tuple of MemberOutcome
        How often the best succeeds in each member of the current's ensemble; empty without one.
    """

    report: ClassVar[str] = "missionplan.report.exploration.page"

    provenance: Provenance
    axes: tuple[Axis, ...]
    cells: tuple[Cell, ...]
    aim: Aim
    best: int | None
    constrained: bool
    members: tuple[MemberOutcome, ...] = ()

    @property
    def valid(self) -> tuple[Cell, ...]:
        """Cells that could be run."""
        return tuple(cell for cell in self.cells if not cell.reason)

    @property
    def best_cell(self) -> Cell | None:
        """The best cell."""
        return None if self.best is None else self.cells[self.best]

    @property
    def has_requirements(self) -> bool:
        """Whether the mission requires anything."""
        return any(cell.requirements for cell in self.cells)

    @property
    def any_meets_all(self) -> bool:
        """Whether some cell meets all requirements, where there are any."""
        return not self.has_requirements or any(cell.meets_all for cell in self.valid)

    @property
    def windows(self) -> tuple[Window, ...]:
        """Ranges of the only axis in which all requirements are met; none where there are two, or no numbers."""
        known = not any(cell.dropped for cell in self.cells)
        return self._ranges([known and self.has_requirements and cell.meets_all for cell in self.cells])

    @property
    def ranges_as_good(self) -> tuple[Window, ...]:
        """Ranges of the only axis that cannot be told from the best."""
        return self._ranges([cell.as_good for cell in self.cells])

    def _ranges(self, has: Sequence[bool]) -> tuple[Window, ...]:
        if len(self.axes) != 1 or self.axes[0].numbers is None:
            return ()
        starts = [i for i, each in enumerate(has) if each and (i == 0 or not has[i - 1])]
        ends = [i for i, each in enumerate(has) if each and (i + 1 == len(has) or not has[i + 1])]
        return tuple(Window(*span) for span in zip(starts, ends, strict=True))

    def values_of(self, cell: Cell) -> dict[str, str]:
        """Return a cell's value of each axis, exactly."""
        return {axis.name: axis.exact(index) for axis, index in zip(self.axes, cell.place, strict=True)}

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        best = self.best_cell
        return {
            **self.provenance.summary(),
            "aim": self.aim,
            "vary": [
                {"keys": list(axis.keys), "unit": axis.unit, "values": [axis.exact(i) for i in range(len(axis.values))]}
                for axis in self.axes
            ],
            "best": None if best is None else self._entry(best),
            **({"members": [each.summary() for each in self.members]} if self.members else {}),
            "as_good": [self.values_of(cell) for cell in self.cells if cell.as_good],
            "windows": [
                {"from": self.axes[0].exact(window.first), "to": self.axes[0].exact(window.last)}
                for window in self.windows
            ],
            "front": [self.values_of(cell) for cell in self.cells if cell.on_front],
            "cells": [self._entry(cell) for cell in self.cells],
        }

    def _entry(self, cell: Cell) -> dict[str, object]:
        if cell.reason:
            return {"values": self.values_of(cell), "status": cell.status, "reason": cell.reason}
        return {
            "values": self.values_of(cell),
            "status": cell.status,
            "success": cell.success.summary(),
            "quantities": {name: statistic.summary() for name, statistic in cell.quantities.items()},
            "events": {name: event.summary() for name, event in cell.events.items()},
            "requirements": [item.summary() for item in cell.requirements],
            "worse_than_best": cell.worse,
            "standard_error_of_worse": cell.worse_error,
            "as_good": cell.as_good,
            "on_front": cell.on_front,
            "trials": cell.trials,
            "dropped": cell.dropped,
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per cell."""
        return pd.DataFrame([self._row(cell) for cell in self.cells])

    def to_xarray(self) -> "xarray.Dataset":
        """Return the table as arrays over the keys varied, in their units; needs the extra ``netcdf``."""
        frame = self.to_frame()
        for number, axis in enumerate(self.axes):
            values = axis.labels if axis.numbers is None else axis.numbers
            frame[axis.name] = [values[cell.place[number]] for cell in self.cells]
        return to_grid(frame, [axis.name for axis in self.axes], {axis.name: axis.unit for axis in self.axes})

    def _row(self, cell: Cell) -> dict[str, object]:
        row: dict[str, object] = {**self.values_of(cell), "status": cell.status, "reason": cell.reason}
        if cell.reason:
            return row
        row |= {"success": cell.success.value, "success_low": cell.success.low, "success_high": cell.success.high}
        for name, statistic in cell.quantities.items():
            row |= {name: statistic.mean, f"{name} standard error": statistic.standard_error}
            row |= {f"{name} p05": statistic.p05, f"{name} p95": statistic.p95}
        row |= {name: event.value for name, event in cell.events.items()}
        row |= {f"requirement {i + 1}": item.probability.value for i, item in enumerate(cell.requirements)}
        return row | {
            "worse_than_best": cell.worse,
            "worse_than_best standard error": cell.worse_error,
            "as_good": cell.as_good,
            "on_front": cell.on_front,
            "trials": cell.trials,
        }

    def files(self) -> dict[str, str | bytes]:
        """Return `explore.csv`."""
        return {"explore.csv": to_csv(self.to_frame())}
