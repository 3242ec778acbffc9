"""What an exploration finds: numbers of its cells, the best and what is as good, where the requirements are met."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.mission import Mission
from missionplan.montecarlo.alternatives import PairedDifferences, compare_with_best, pareto_front
from missionplan.montecarlo.statistics import Count, Probability, Statistic
from missionplan.results import Provenance, Result, to_csv, to_grid
from missionplan.results.decision import Aim, Assumption, Axis, MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.failures import Counted
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration.cells import LEFT_RECORD, SUCCESS
from missionplan.studies.simulation import TOLERATED
from missionplan.studies.simulation.outcome_builder import requirement_outcome

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
    assumed: tuple[Assumption, ...] = ()
    """What the best takes for granted, each with its worth, where it meets all that is required."""

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
        is_complete = not any(cell.dropped for cell in self.cells)
        return self.ranges([is_complete and self.has_requirements and cell.meets_all for cell in self.cells])

    @property
    def ranges_as_good(self) -> tuple[Window, ...]:
        """Ranges of the only axis that cannot be told from the best."""
        return self.ranges([cell.as_good for cell in self.cells])

    def ranges(self, has: Sequence[bool]) -> tuple[Window, ...]:
        """Return the ranges of the only axis whose cells have something; none where there are two, or no numbers."""
        if len(self.axes) != 1 or self.axes[0].numbers is None:
            return ()
        starts = [i for i, flag in enumerate(has) if flag and (i == 0 or not has[i - 1])]
        ends = [i for i, flag in enumerate(has) if flag and (i + 1 == len(has) or not has[i + 1])]
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
        summary = {"status": cell.status, "reason": cell.reason} if cell.reason else cell.summary()
        return {"values": self.values_of(cell), **summary}

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


ENERGY, DURATION = "total.energy_wh", "total.duration_s"
AIM_COLUMNS: dict[Aim, str] = {"success": SUCCESS, "energy": ENERGY, "duration": DURATION}
Trials = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Best:
    """All cells with their places among the others."""

    cells: tuple[Cell, ...]
    best: int | None
    constrained: bool
    """Whether the best is among cells that meet all requirements."""


def cell_of(place: tuple[int, ...], mission: Mission, trials: Trials, reason: str) -> Cell:
    """Sum up the trials of one cell; `mission` has the requirements, which are the same for all."""
    if reason:
        return Cell(place, reason)
    if LEFT_RECORD in trials and (left := Count.of(trials[LEFT_RECORD]).probability().value) > TOLERATED:
        return Cell(place, f"{100.0 * left:.3g} % of the trials leave the record of the current")
    met = [str(Counted.requirement(number)) for number in range(len(mission.requirements))]
    columns = {name: values for name, values in trials.items() if name not in (SUCCESS, LEFT_RECORD, *met)}
    return Cell(
        place=place,
        success=Count.of(trials[SUCCESS]).probability(),
        requirements=tuple(
            requirement_outcome(mission, requirement, Count.of(trials[name]))
            for name, requirement in zip(met, mission.requirements, strict=True)
        ),
        quantities={name: statistic_of(values) for name, values in columns.items() if values.dtype != bool},
        events={name: Count.of(values).probability() for name, values in columns.items() if values.dtype == bool},
        trials=trials[SUCCESS].size,
    )


def statistic_of(values: NDArray[np.generic]) -> Statistic:
    """Sum up a quantity, shape (n,); nan where no trial reached it."""
    numbers = values.astype(float)
    reached = numbers[np.isfinite(numbers)]
    if not reached.size:
        return Statistic(*(float("nan"),) * 6, count=0, missing=numbers.size)
    sd = float(reached.std(ddof=1)) if reached.size > 1 else float("nan")
    low, middle, high = (float(value) for value in np.quantile(reached, (0.05, 0.5, 0.95)))
    error = sd / np.sqrt(reached.size)
    return Statistic(
        float(reached.mean()), sd, low, middle, high, float(error), reached.size, numbers.size - reached.size
    )


def find_best(cells: Sequence[Cell], trials: Sequence[Trials], aim: Aim) -> Best:
    """Find the best cell and those that the trials cannot tell from it.

    The cells that meet all requirements are compared; where none does, all, and the best is the one that succeeds most
    often. Of cells that succeed equally often the one that takes less energy is the best.

    `trials`: columns of each cell, empty for one that could not be run.
    """
    valid = [index for index, cell in enumerate(cells) if not cell.reason and not cell.dropped]
    good = [index for index in valid if cells[index].requirements and cells[index].meets_all]
    constrained = bool(good)
    unmet = not good and any(cells[index].requirements for index in valid)
    column = AIM_COLUMNS["success" if unmet else aim]
    compared = [
        index
        for index in (good if constrained else valid)
        if column == SUCCESS or cells[index].quantities[column].count > 0
    ]
    if not any(cells[index].success.value for index in compared):
        return Best(_with_front(cells), None, constrained)
    best = min(compared, key=lambda index: rank(cells[index], column))
    comparison = compare_with_best(
        [trials[index][column] for index in compared], compared.index(best), most=column == SUCCESS
    )
    judged = _beside_best(cells, compared, comparison)
    return Best(_with_front([judged.get(i, cell) for i, cell in enumerate(cells)]), best, constrained)


def _beside_best(cells: Sequence[Cell], compared: Sequence[int], comparison: PairedDifferences) -> dict[int, Cell]:
    """Cells that were compared, by their number, with how far they are from the best."""
    rows = zip(compared, comparison.worse.tolist(), comparison.error.tolist(), comparison.as_good.tolist(), strict=True)
    return {
        index: replace(cells[index], worse=worse, worse_error=error, as_good=good) for index, worse, error, good in rows
    }


def rank(cell: Cell, column: str) -> tuple[float, float]:
    """Order of cells, the best first."""
    energy = cell.quantities[ENERGY].mean
    tie = energy if np.isfinite(energy) else np.inf
    return (-cell.success.value, tie) if column == SUCCESS else (cell.quantities[column].mean, -cell.success.value)


def _with_front(cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """Mark the front of P(success), mean energy and mean duration; without energy, of the other two."""

    def mean(cell: Cell, name: str) -> float:
        return cell.quantities[name].mean if name in cell.quantities else np.nan

    names = [name for name in (ENERGY, DURATION) if any(mean(cell, name) < np.inf for cell in cells)]
    costs = np.array([[-cell.success.value, *(mean(cell, name) for name in names)] for cell in cells])
    front = pareto_front(np.where(np.isfinite(costs), costs, np.nan))
    return tuple(replace(cell, on_front=bool(on)) for cell, on in zip(cells, front, strict=True))
