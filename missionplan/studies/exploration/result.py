"""Result of `explore`: one or two keys varied, cell by cell, the best cells, and where the requirements are met."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import pandas as pd

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.results.base import Provenance, Result, to_csv, to_grid
from missionplan.results.decision import Aim, Axis, MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import RequirementOutcome

if TYPE_CHECKING:
    import xarray

NOT_RUN = Probability(float("nan"), float("nan"), float("nan"))
"""Of a cell that cannot be run."""
Status = Literal["met", "undecided", "missed", "none", "invalid"]


@dataclass(frozen=True)
class Cell(Record):
    """The mission with one value of each key."""

    place: tuple[int, ...]
    """Index along each axis."""
    reason: str = ""
    """Why it cannot be run; empty where it can. The other attributes then say nothing."""
    success: Annotated[Probability, Entry("of the whole mission")] = NOT_RUN
    requirements: Annotated[tuple[RequirementOutcome, ...], Entry("in the mission's order")] = ()
    quantities: Annotated[
        Mapping[str, Statistic], Entry("such as ``total.energy_wh``, of the trials that reach them")
    ] = field(default_factory=dict)
    events: Annotated[Mapping[str, Probability], Entry("such as ``ingress.arrived``")] = field(default_factory=dict)
    worse: Annotated[
        float,
        Entry(
            "mean of what the aim asks for, less that of the best cell, trial by trial on common random numbers, "
            "positive where this cell is worse [share, W h or s]; null where it is not compared",
            key="worse_than_best",
        ),
    ] = float("nan")
    worse_error: Annotated[float, Entry("of that difference", key="standard_error_of_worse")] = float("nan")
    as_good: Annotated[bool, Entry("whether the trials cannot tell the cell from the best")] = False
    on_front: Annotated[
        bool,
        Entry(
            "whether no other cell is at least as good in P(success), mean energy and mean duration, and better in one"
        ),
    ] = False
    trials: Annotated[int, Entry("of the cell")] = 0
    dropped: Annotated[
        bool, Entry("whether a race ended before the cell had all trials, because it cannot be the best")
    ] = False

    @property
    def status(self) -> Annotated[Status, Entry()]:
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
    """One or two keys of a mission varied on common random numbers."""

    report: ClassVar[str] = "missionplan.studies.exploration.page"

    provenance: Provenance
    axes: Annotated[tuple[Axis, ...], Entry("the keys that are varied", key="vary")]
    """One or two."""
    cells: tuple[Cell, ...]
    """The last axis runs fastest."""
    aim: Annotated[Aim, Entry("what is best")]
    best: int | None
    """Number of the best cell; None where no cell can be compared."""
    constrained: bool
    """Whether the best is among the cells that meet all requirements."""
    members: Annotated[
        tuple[MemberOutcome, ...],
        Entry("how often the best succeeds in each member of the current's ensemble", optional=True),
    ] = ()

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

    @property
    def best_entry(self) -> Annotated[dict[str, object] | None, Entry(key="best")]:
        """The best cell."""
        return None if self.best is None else self._entry(self.cells[self.best])

    @property
    def values_as_good(self) -> Annotated[list[dict[str, str]], Entry(key="as_good")]:
        """Values of the cells that cannot be told from the best."""
        return [self.values_of(cell) for cell in self.cells if cell.as_good]

    @property
    def exact_windows(self) -> Annotated[list[dict[str, str]], Entry(key="windows")]:
        """Ranges of the only key in which all requirements are met, ``from`` and ``to``."""
        exact = self.axes[0].exact
        return [{"from": exact(window.first), "to": exact(window.last)} for window in self.windows]

    @property
    def values_on_front(self) -> Annotated[list[dict[str, str]], Entry(key="front")]:
        """Values of the cells on the front."""
        return [self.values_of(cell) for cell in self.cells if cell.on_front]

    @property
    def entries(self) -> Annotated[list[dict[str, object]], Entry(key="cells")]:
        """The cells with their values; of those that cannot be run the reason alone."""
        return [self._entry(cell) for cell in self.cells]

    def _entry(self, cell: Cell) -> dict[str, object]:
        told = {"status": cell.status, "reason": cell.reason} if cell.reason else cell.summary()
        return {"values": self.values_of(cell), **told}

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
