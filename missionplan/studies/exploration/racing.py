"""A race of cells: few trials of all, more of those that may still be the best."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from missionplan.mission import Mission
from missionplan.montecarlo.paired import compare_with_best
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results.choosing.axis import Aim
from missionplan.results.choosing.exploration import Cell
from missionplan.studies.exploration.cell_run import CellTrials
from missionplan.studies.exploration.cells import SUCCESS, CellItem
from missionplan.studies.exploration.findings import AIM_COLUMNS, cell_of, rank

FIRST, FACTOR = 128, 4
"""Trials of the first heat, and by how much more the next has."""


@dataclass(frozen=True)
class Race:
    """What a race leaves.

    Attributes
    ----------
    trials : list of CellTrials
        Of each cell, as many as it was run with.
    dropped : frozenset of int
        Cells that cannot be the best.
    spent : int
        Trials run.
    """

    trials: list[CellTrials]
    dropped: frozenset[int]
    spent: int


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
