"""Trials until the best cell of a grid is found: a race, successive halving, and the kriging of `optimise`.

All take their trials from one full exploration, which is also the truth: what is compared is how many of them each
looks at, and whether it ends with the same best cell: that of least energy among those that meet all requirements.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.common import MISSIONS, Options, Row, Section
from missionplan.mission import Mission, load
from missionplan.montecarlo.blocks import IN_THIS_PROCESS
from missionplan.results.decision import Axis
from missionplan.studies.exploration import read_axes
from missionplan.studies.exploration.cells import CellTask, CellTrials, cell_trials
from missionplan.studies.exploration.explore import race
from missionplan.studies.exploration.result import ENERGY, cell_of, rank
from missionplan.studies.optimisation import Lattice, Point
from missionplan.studies.optimisation.evaluations import Evaluation, Evaluations, columns_needed, demands_of
from missionplan.studies.optimisation.search import Search

CASES = {
    "chesapeake": ("ingress.speed+egress.speed=0.6:2:0.1 m/s", "ingress.d_max+egress.d_max=200:1600:100 m"),
    "estuary": ("start=04:00:14:00:20 min", "ingress.speed+egress.speed=0.6:1.8:0.1 m/s"),
}
TRIALS = 1024
FEW = 128
"""Trials of the first round of halving."""


@dataclass
class Grid:
    """A full exploration, and how many of its trials have been looked at."""

    mission: Mission
    axes: tuple[Axis, ...]
    found: Sequence[CellTrials]
    trials: int
    spent: int = 0
    seen: dict[tuple[int, int], object] = field(default_factory=dict)

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(self.found)

    def look(self, cell: int, trials: int) -> CellTrials:
        """Return the first trials of a cell."""
        if (cell, trials) not in self.seen:
            self.seen[cell, trials] = None
            self.spent += trials
        own = self.found[cell]
        return CellTrials({name: values[:trials] for name, values in own.columns.items()}, own.reason)

    def judged(self, cell: int, trials: int):
        """Sum the first trials of a cell up."""
        own = self.look(cell, trials)
        return cell_of((), self.mission, own.columns, own.reason)

    def best(self, cells: Sequence[int], trials: int) -> int:
        """Return the best of some cells by their first trials."""
        judged = {cell: self.judged(cell, trials) for cell in cells}
        good = [cell for cell in cells if judged[cell].meets_all] or [cell for cell in cells if not judged[cell].reason]
        return min(good, key=lambda cell: rank(judged[cell], ENERGY))


def by_race(grid: Grid) -> int:
    """Drop what is certainly not the best, as `explore` does."""

    def run(items):
        found = [CellTrials({})] * grid.cells
        for cell, block, size in items:
            found[cell] = grid.look(cell, block * 4096 + size)
        return found

    result = race(grid.mission, grid.cells, grid.trials, "energy", run)
    return grid.best([cell for cell in range(grid.cells) if cell not in result.dropped], grid.trials)


def by_halving(grid: Grid) -> int:
    """Keep the better half in each round, with twice the trials (Karnin, Koren & Somekh 2013)."""
    left, size = list(range(grid.cells)), FEW
    while size < grid.trials and len(left) > 1:
        judged = {cell: grid.judged(cell, size) for cell in left}

        def order(cell: int, judged=judged) -> tuple[float, float]:
            lacking = sum(max(item.required - item.probability.value, 0.0) for item in judged[cell].requirements)
            cost = rank(judged[cell], ENERGY)[0] if not judged[cell].reason else np.inf
            return (np.inf if judged[cell].reason else lacking, cost if np.isfinite(cost) else 1e9)

        left = sorted(left, key=order)[: max(len(left) // 2, 1)]
        size *= 2
    return grid.best(left, grid.trials)


class _Looked(Evaluations):
    """Evaluations whose trials are looked up in a grid."""

    def __init__(self, grid: Grid) -> None:
        super().__init__(grid.mission, Lattice(grid.axes), None, 1)
        self.grid = grid

    def of(self, points: Sequence[Point], trials: int) -> list[Evaluation]:
        """Look the trials of some points up."""
        for point in points:
            own = self.grid.look(self.lattice.number(point), trials)
            self.kept[point, trials] = Evaluation(point, own.columns, own.reason)
        return [self.kept[point, trials] for point in points]


def by_kriging(grid: Grid) -> int:
    """Search by kriging of cost and margins, as `optimise` does."""
    search = Search(_Looked(grid), demands_of(grid.mission), "energy", seed=1)
    search.widely()
    return search.evaluations.lattice.number(search.closely()[0].point)


METHODS = {"race": by_race, "successive halving": by_halving, "kriging": by_kriging}


def full(name: str, trials: int) -> Grid:
    """Run a full exploration."""
    mission = load(MISSIONS / f"{name}.yaml")
    axes = read_axes(mission, CASES[name])
    task = CellTask.of(mission, axes, 1, columns_needed(mission))
    numbers = range(len(task.cells))
    found = cell_trials(task, [(number, 0, trials) for number in numbers], numbers, IN_THIS_PROCESS)
    return Grid(mission, axes, found, trials)


def rows_of(name: str, grid: Grid) -> list[Row]:
    """Compare the methods on one grid."""
    truth = grid.best(range(grid.cells), grid.trials)
    total, rows = grid.cells * grid.trials, []
    for method, find in METHODS.items():
        own = Grid(grid.mission, grid.axes, grid.found, grid.trials)
        best = find(own)
        cost = [rank(grid.judged(cell, grid.trials), ENERGY)[0] for cell in (best, truth)]
        same = "the same best" if best == truth else f"{100.0 * (cost[0] / cost[1] - 1.0):.2g} % from the best"
        rows.append(
            Row(
                f"{name}, {grid.cells} cells: {method}",
                f"{own.spent} trials",
                f"{total}",
                f"{own.spent / total:.1%}",
                same,
            )
        )
    return rows


def compare(options: Options) -> Section:
    """Compare on the shipped missions."""
    started, rows = time.perf_counter(), []
    for name in CASES:
        rows += rows_of(name, full(name, TRIALS // options.shrink))
    return Section(
        tuple(rows), notes=(f"Full explorations and all methods took {time.perf_counter() - started:.0f} s.",)
    )
