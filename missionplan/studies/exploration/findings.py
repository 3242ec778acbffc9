"""What cells show: their numbers, the best and what is as good, and a race to it with few trials."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.mission import Mission
from missionplan.montecarlo.paired import compare_with_best, pareto_front
from missionplan.montecarlo.statistics import Count, Probability, Statistic
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results.decision import Aim
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration.cells import LEFT_RECORD, SUCCESS, CellItem, CellTrials
from missionplan.studies.exploration.result import Cell
from missionplan.studies.simulation.block_statistics import bound_of, requirement_key
from missionplan.studies.simulation.checks import TOLERATED

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
    if LEFT_RECORD in trials and (left := _probability(trials[LEFT_RECORD]).value) > TOLERATED:
        return Cell(place, f"{100.0 * left:.3g} % of the trials leave the record of the current")
    own = {name: values for name, values in trials.items() if name not in (SUCCESS, LEFT_RECORD)}
    own = {name: values for name, values in own.items() if not name.startswith("requirement ")}
    return Cell(
        place=place,
        success=_probability(trials[SUCCESS]),
        requirements=tuple(_requirement(mission, index, trials) for index in range(len(mission.requirements))),
        quantities={name: statistic_of(values) for name, values in own.items() if values.dtype != bool},
        events={name: _probability(values) for name, values in own.items() if values.dtype == bool},
        trials=trials[SUCCESS].size,
    )


def _probability(happened: NDArray[np.generic]) -> Probability:
    return Count(int(happened.sum()), happened.size).probability()


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


def _requirement(mission: Mission, index: int, trials: Trials) -> RequirementOutcome:
    requirement = mission.requirements[index]
    met = trials[f"requirement {index}"]
    probability, required = _probability(met), requirement.probability
    side, limit = bound_of(requirement) or (None, None)
    return RequirementOutcome(
        quantity=requirement.quantity,
        bound=side,
        limit=limit,
        unit=requirement_key(mission, requirement.quantity)[1] or "",
        required=required,
        probability=probability,
        met=probability.value >= required,
        undecided=probability.low <= required <= probability.high,
        trials=met.size,
    )


def find_best(cells: Sequence[Cell], trials: Sequence[Trials], aim: Aim) -> Best:
    """Find the best cell and those that the trials cannot tell from it.

    The cells that meet all requirements are compared; where none does, all, and the best is the one that succeeds most
    often. Of cells that succeed equally often the one that takes less energy is the best.

    Parameters
    ----------
    cells : sequence of Cell
    trials : sequence of mapping
        Columns of each cell, empty for one that could not be run.
    aim : 'success', 'energy' or 'duration'
    """
    valid = [index for index, cell in enumerate(cells) if not cell.reason and not cell.dropped]
    good = [index for index in valid if cells[index].requirements and cells[index].meets_all]
    constrained = bool(good)
    unmet = not good and any(cells[index].requirements for index in valid)
    column = AIM_COLUMNS["success" if unmet else aim]
    compared = [index for index in (good if constrained else valid) if _is_known(cells[index], column)]
    if not compared:
        return Best(_with_front(cells), None, constrained)
    best = min(compared, key=lambda index: rank(cells[index], column))
    found = compare_with_best(
        [trials[index][column] for index in compared], compared.index(best), most=column == SUCCESS
    )
    judged = {
        index: replace(
            cells[index],
            worse=float(found.worse[number]),
            worse_error=float(found.error[number]),
            as_good=bool(found.as_good[number]),
        )
        for number, index in enumerate(compared)
    }
    return Best(_with_front([judged.get(i, cell) for i, cell in enumerate(cells)]), best, constrained)


def _is_known(cell: Cell, column: str) -> bool:
    return column == SUCCESS or cell.quantities[column].count > 0


def rank(cell: Cell, column: str) -> tuple[float, float]:
    """Order of cells, the best first."""
    energy = cell.quantities[ENERGY].mean
    tie = energy if np.isfinite(energy) else np.inf
    return (-cell.success.value, tie) if column == SUCCESS else (cell.quantities[column].mean, -cell.success.value)


def _with_front(cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """Mark the front of P(success), mean energy and mean duration; without energy, of the other two."""
    names = [name for name in (ENERGY, DURATION) if any(_mean(cell, name) < np.inf for cell in cells)]
    costs = np.array([[-cell.success.value, *(_mean(cell, name) for name in names)] for cell in cells])
    front = pareto_front(np.where(np.isfinite(costs), costs, np.nan))
    return tuple(replace(cell, on_front=bool(on)) for cell, on in zip(cells, front, strict=True))


def _mean(cell: Cell, name: str) -> float:
    mean = cell.quantities[name].mean if name in cell.quantities else np.inf
    return mean if np.isfinite(mean) else np.inf


FIRST, FACTOR = 128, 4
"""Trials of the first heat, and by how much more the next has."""


@dataclass(frozen=True)
class Race:
    """What a race leaves."""

    trials: list[CellTrials]
    """Of each cell, as many as it was run with."""
    dropped: frozenset[int]
    """Cells that cannot be the best."""
    spent: int
    """Trials run."""


def race(
    mission: Mission, cells: int, trials: int, aim: Aim, run: Callable[[Sequence[CellItem]], list[CellTrials]]
) -> Race:
    """Run all cells with few trials, and those that may be the best with more, until all that are left have all.

    Heats begin with the same trials, so that what is left has the numbers of a full exploration. A cell is dropped when
    a requirement is certainly missed while another cell may meet all, or when one that meets all beats it by more than
    chance. Where none that is left meets all in the end, those that may and were dropped for it are run after all.

    Parameters
    ----------
    mission : Mission
        With the requirements.
    cells, trials : int
        Number of cells, and trials of those that last.
    aim : 'success', 'energy' or 'duration'
    run : callable
        Runs blocks of cells and returns the trials of every cell.
    """
    left = list(range(cells))
    known: list[CellTrials] = [CellTrials({})] * cells
    spent, size = 0, min(FIRST, trials)
    while True:
        items = [(cell, block, block_size(size, block)) for cell in left for block in range(block_count(size))]
        found = run(items)
        spent += size * len(left)
        for cell in left:
            known[cell] = found[cell]
        dropped = frozenset(range(cells)) - set(left)
        judged = [cell_of((), mission, each.columns, each.reason) for each in known]
        if size == trials and (again := _to_run_after_all(judged, left)):
            left = again
        elif size == trials:
            whole = {cell for cell in dropped if _size(known[cell]) == trials}
            return Race(known, dropped - whole, spent)
        else:
            left = _last(judged, known, left, aim)
            size = min(size * FACTOR, trials)


def _size(found: CellTrials) -> int:
    return next((values.size for values in found.columns.values()), 0)


def _to_run_after_all(cells: Sequence[Cell], left: Sequence[int]) -> list[int]:
    """Return cells that were dropped for the sake of one that does not meet all in the end, while they may."""
    if any(cells[index].meets_all for index in left):
        return []
    return [
        i
        for i, cell in enumerate(cells)
        if not cell.reason and cell.trials < cells[left[0]].trials and not _misses(cell)
    ]


def _last(cells: Sequence[Cell], known: Sequence[CellTrials], left: Sequence[int], aim: Aim) -> list[int]:
    """Return the cells that may still be the best."""
    valid = [index for index in left if not cells[index].reason]
    may = [index for index in valid if not _misses(cells[index])] or valid
    column = AIM_COLUMNS[aim]
    good = [index for index in may if cells[index].meets_all and rank(cells[index], column)[0] < math.inf]
    if not good:
        return may
    best = min(good, key=lambda index: rank(cells[index], column))
    values = [known[index].columns[column] for index in may]
    as_good = compare_with_best(values, may.index(best), most=column == SUCCESS).as_good
    pairs = zip(may, as_good, strict=True)
    return [index for index, stays in pairs if stays or _is_better(cells, index, best, column)]


def _is_better(cells: Sequence[Cell], index: int, best: int, column: str) -> bool:
    """Whether a cell that may not meet all looks better than the best of those that do."""
    return rank(cells[index], column) < rank(cells[best], column)


def _misses(cell: Cell) -> bool:
    return any(not item.met and not item.undecided for item in cell.requirements)
