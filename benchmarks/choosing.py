"""Trials until the best cell of a grid is found: a race, successive halving, and kriging of paired differences.

All take their trials from one full exploration, which is also the truth: what is compared is how many of them each
looks at, and whether it ends with the same best cell: that of least energy among those that meet all requirements.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import ndtr

from benchmarks.common import MISSIONS, Options, Row, Section
from missionplan.mission import Mission, load
from missionplan.studies.exploration.cell_run import CellRun, CellTrials
from missionplan.studies.exploration.explore import CellPlan
from missionplan.studies.exploration.findings import DURATION, ENERGY, cell_of, rank
from missionplan.studies.exploration.racing import race
from missionplan.studies.exploration.variation import read_axes

CASES = {
    "chesapeake": ("ingress.speed+egress.speed=0.6:2:0.1 m/s", "ingress.d_max+egress.d_max=200:1600:100 m"),
    "estuary": ("start=04:00:14:00:20 min", "ingress.speed+egress.speed=0.9:1.9:0.1 m/s"),
}
TRIALS = 1024
FEW = 128
"""Trials of the first round of halving, and of a point of the kriging."""
START = 12
"""Points from which kriging starts."""


@dataclass
class Grid:
    """A full exploration, and how many of its trials have been looked at."""

    mission: Mission
    shape: tuple[int, ...]
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


def by_kriging(grid: Grid) -> int:
    """Model paired differences of the cost and the requirements' margins by Gaussian processes; look where they hope.

    Expected improvement times the probability that all requirements are met (Schonlau 1997), until none is left; then
    the five best predicted are looked at in full.
    """
    places = np.stack(np.unravel_index(np.arange(grid.cells), grid.shape), axis=1) / np.maximum(
        np.array(grid.shape) - 1, 1
    )
    order = np.random.default_rng(1).permutation(grid.cells)
    points = [int(cell) for cell in order[:START]]
    while True:
        judged = [grid.judged(cell, FEW) for cell in points]
        cost = np.array([rank(each, ENERGY)[0] if not each.reason else np.nan for each in judged])
        margin = np.array(
            [min((i.probability.value - i.required for i in each.requirements), default=-1.0) for each in judged]
        )
        known = np.isfinite(cost)
        feasible = known & (margin >= 0.0)
        low = cost[feasible].min() if feasible.any() else np.inf
        mean, sd = (
            _kriged(places[np.array(points)[known]], cost[known], places)
            if known.sum() > 2
            else (np.zeros(grid.cells),) * 2
        )
        may, may_sd = _kriged(places[points], np.maximum(margin, -0.2), places)
        chance = ndtr((may + 1e-3) / np.maximum(may_sd, 1e-6))
        gain = _improvement(low, mean, sd) * chance if np.isfinite(low) else chance
        gain[points] = 0.0
        if len(points) >= grid.cells or (np.isfinite(low) and gain.max() < 1e-3 * low):
            break
        points.append(int(np.argmax(gain)))
    hopeful = sorted(range(grid.cells), key=lambda cell: mean[cell] if chance[cell] > 0.2 else np.inf)[:5]
    seen = [cell for cell, ok in zip(points, feasible, strict=True) if ok]
    seen = sorted(seen, key=lambda cell: mean[cell])[:5]
    return grid.best(list(dict.fromkeys([*hopeful, *seen])), grid.trials)


def _improvement(low: float, mean: NDArray, sd: NDArray) -> NDArray:
    z = (low - mean) / np.maximum(sd, 1e-9)
    return (low - mean) * ndtr(z) + sd * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)


def _kriged(known: NDArray, values: NDArray, places: NDArray) -> tuple[NDArray, NDArray]:
    """Predict by a Gaussian process (Matérn 5/2) whose length scales are the likeliest of a few."""
    centre, scale = values.mean(), max(values.std(), 1e-9)
    y = (values - centre) / scale
    best = None
    for one in (0.1, 0.2, 0.4, 0.8):
        for two in (0.1, 0.2, 0.4, 0.8) if known.shape[1] > 1 else (one,):
            lengths = np.array([one, two])[: known.shape[1]]
            factor = cho_factor(_matern(known, known, lengths) + 1e-4 * np.eye(len(y)), lower=True)
            weights = cho_solve(factor, y)
            likelihood = -0.5 * y @ weights - np.log(np.diag(factor[0])).sum()
            if best is None or likelihood > best[0]:
                best = likelihood, lengths, factor, weights
    _, lengths, factor, weights = best
    across = _matern(places, known, lengths)
    variance = 1.0 - np.einsum("ij,ji->i", across, cho_solve(factor, across.T))
    return centre + scale * (across @ weights), scale * np.sqrt(np.maximum(variance, 0.0))


def _matern(a: NDArray, b: NDArray, lengths: NDArray) -> NDArray:
    r = np.sqrt(5.0) * np.sqrt((((a[:, None] - b[None]) / lengths) ** 2).sum(axis=-1))
    return (1.0 + r + r * r / 3.0) * np.exp(-r)


METHODS = {"race": by_race, "successive halving": by_halving, "kriging": by_kriging}


def full(name: str, trials: int) -> Grid:
    """Run a full exploration."""
    mission = load(MISSIONS / f"{name}.yaml")
    axes = read_axes(mission, CASES[name])
    plan = CellPlan.of(mission, axes, 1, (DURATION, ENERGY))
    found = CellRun(plan.task, [(cell, 0, trials) for cell in plan.cells]).run(plan.cells)
    return Grid(mission, tuple(len(axis.values) for axis in axes), found, trials)


def rows_of(name: str, grid: Grid) -> list[Row]:
    """Compare the methods on one grid."""
    truth = grid.best(range(grid.cells), grid.trials)
    total, rows = grid.cells * grid.trials, []
    for method, find in METHODS.items():
        own = Grid(grid.mission, grid.shape, grid.found, grid.trials)
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
