"""Trials of choices on common random numbers: each point of the lattice is run once with each number of trials."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.parallel.blocks import Workers
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results.axis import Aim
from missionplan.scenario.scenario import Scenario
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.exploration.cells import (
    CellTask,
    cell_trials,
    checked_means,
)
from missionplan.studies.exploration.findings import AIM_COLUMNS, DURATION, ENERGY
from missionplan.studies.optimisation.choices import Lattice, Point
from missionplan.studies.simulation.block_statistics import requirement_key
from missionplan.studies.simulation.checks import mooring_anchors

Columns = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True, eq=False)
class ChoiceTask(CellTask):
    """Runs a block of a choice; an anchor that its parts cannot make is no choice."""

    COMMAND = "optimise"

    def scenario(self, cell: int) -> Scenario:
        """Return the mission of a choice at its means, checked."""
        mission = self.mission(cell)
        means = checked_means(mission, self.current)
        unbuilt = [anchor for anchor in mooring_anchors(mission, means) if anchor.failures]
        if unbuilt:
            raise InputError([Problem(f"the anchor cannot be built: {unbuilt[0].failures[0]}", key=unbuilt[0].phase)])
        return means


@dataclass(frozen=True)
class Evaluation:
    """Trials of one choice.

    Attributes
    ----------
    point : Point
    columns : mapping of str to array, shape (n,)
        Empty where the choice cannot be run.
    reason : str
        Why not.
    """

    point: Point
    columns: Columns
    reason: str = ""

    @property
    def trials(self) -> int:
        """Number of trials."""
        return next((values.size for values in self.columns.values()), 0)

    def cost(self, aim: Aim) -> float:
        """Mean of what is to be least, of the trials that reach the mission's end [W h or s]; infinite where none."""
        values = self.columns.get(AIM_COLUMNS[aim])
        if values is None:
            return float("inf")
        reached = values[np.isfinite(values.astype(float))].astype(float)
        return float(reached.mean()) if reached.size else float("inf")


@dataclass
class Evaluations:
    """All trials run so far.

    Attributes
    ----------
    mission : Mission
    lattice : Lattice
    task : ChoiceTask
    workers : Workers
    store : Checkpoints or None
        Where finished blocks are kept.
    spent : int
        Trials run, or found finished.
    kept : dict of (Point, int) to Evaluation
        By point and number of trials.
    """

    mission: Mission
    lattice: Lattice
    task: ChoiceTask
    workers: Workers
    store: Checkpoints | None = None
    spent: int = 0
    kept: dict[tuple[Point, int], Evaluation] = field(default_factory=dict)

    def of(self, points: Sequence[Point], trials: int) -> list[Evaluation]:
        """Return the trials of some points, run where they have not been."""
        todo = [point for point in dict.fromkeys(points) if (point, trials) not in self.kept]
        cells = [self.lattice.number(point) for point in todo]
        items = [(cell, block, block_size(trials, block)) for cell in cells for block in range(block_count(trials))]
        found = cell_trials(self.task, items, cells, self.workers, self.store)
        for point, each in zip(todo, found, strict=True):
            self.kept[point, trials] = Evaluation(point, each.columns, each.reason)
            self.spent += trials
        return [self.kept[point, trials] for point in points]

    def best_known(self) -> list[Evaluation]:
        """Return the evaluation with the most trials of each point."""
        most: dict[Point, Evaluation] = {}
        for (point, trials), evaluation in self.kept.items():
            if point not in most or most[point].trials < trials:
                most[point] = evaluation
        return list(most.values())


def columns_needed(mission: Mission) -> tuple[str, ...]:
    """Columns by which choices are judged: energy, duration, and what requirements bound."""
    bounded = [requirement_key(mission, item.quantity)[0] for item in mission.requirements]
    return tuple(dict.fromkeys((DURATION, ENERGY, *bounded)))
