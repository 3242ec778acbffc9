"""Trials of choices on common random numbers: each point of the lattice is run once with each number of trials.

How far a choice is from the requirements, as they are or relaxed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.blocks import Workers
from missionplan.montecarlo.statistics import Count, Probability, successes_to_decide
from missionplan.montecarlo.streams import sized_blocks
from missionplan.results.decision import Aim
from missionplan.scenario.scenario import Scenario
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.exploration.cells import CellTask, Columns, cell_trials, checked_means
from missionplan.studies.exploration.result import AIM_COLUMNS, DURATION, ENERGY
from missionplan.studies.optimisation import Lattice, Point
from missionplan.studies.simulation import mooring_anchors
from missionplan.studies.simulation.block_statistics import Side, bounded_column, is_within
from missionplan.studies.simulation.phase_trials import Flags


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
    """Trials of one choice."""

    point: Point
    columns: Columns
    """Empty where the choice cannot be run, shape (n,)."""
    reason: str = ""
    """Why not."""

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
    """All trials run so far."""

    mission: Mission
    lattice: Lattice
    task: ChoiceTask
    workers: Workers
    store: Checkpoints | None = None
    """Where finished blocks are kept."""
    spent: int = 0
    """Trials run, or found finished."""
    kept: dict[tuple[Point, int], Evaluation] = field(default_factory=dict)
    """By point and number of trials."""

    def of(self, points: Sequence[Point], trials: int) -> list[Evaluation]:
        """Return the trials of some points, run where they have not been."""
        todo = [point for point in dict.fromkeys(points) if (point, trials) not in self.kept]
        cells = [self.lattice.number(point) for point in todo]
        items = [(cell, *block) for cell in cells for block in sized_blocks(trials)]
        samples = cell_trials(self.task, items, cells, self.workers, self.store)
        for point, sample in zip(todo, samples, strict=True):
            self.kept[point, trials] = Evaluation(point, sample.columns, sample.reason)
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
    bounded = [bounded_column(mission, item)[0] for item in mission.requirements]
    return tuple(dict.fromkeys((DURATION, ENERGY, *bounded)))


RELAXED = 0.01
"""By which a bound is widened, or a required probability lowered."""
_CANNOT_RUN = 100.0
"""Violation of a choice that cannot be run: more than of any that can."""
_DEEPEST = 4.0
"""Greatest margin, inside or outside, in standard deviations."""
_SUREST = 2.5
"""Greatest normal deviate of a probability: few trials cannot tell more."""
_FARTHEST = 1.0
"""Greatest overshoot of a bound that counts, relative to the bound."""


@dataclass(frozen=True)
class Demand:
    """A requirement as the search sees it."""

    quantity: str
    """As the mission writes it."""
    column: str
    """Of the trials."""
    side: Side | None
    """None for an event."""
    limit: float
    """In the column's unit; nan for an event."""
    required: float
    """Probability."""

    def relaxed(self) -> "Demand":
        """Return the demand with its bound one percent wider, or of an event with a percentage point less."""
        if self.side is None:
            return replace(self, required=max(self.required - RELAXED, 0.0))
        wider = RELAXED * abs(self.limit)
        return replace(self, limit=self.limit + (wider if self.side == "at_most" else -wider))

    def probability(self, evaluation: Evaluation) -> Probability:
        """Probability that a trial does as demanded."""
        return Count.of(self._met(evaluation)).probability()

    def slack(self, evaluation: Evaluation) -> float:
        """Probability reached less that required; that of a choice that cannot be run is −1."""
        return -1.0 if evaluation.reason else float(self._met(evaluation).mean()) - self.required

    def _met(self, evaluation: Evaluation) -> Flags:
        return is_within(evaluation.columns[self.column], self.side, self.limit)

    def margin(self, evaluation: Evaluation) -> float:
        """Return how far a choice is inside the demand, smooth over choices; negative outside.

        Of a bound, the quantile that it concerns in standard deviations of the trials; of an event, or where too few
        trials have the quantity, the probability as a normal deviate less that required.
        """
        if evaluation.reason:
            return -_DEEPEST
        slack, met = self.slack(evaluation), self._met(evaluation)
        share = (float(met.sum()) + 0.5) / (met.size + 1.0)
        deviate = min(max(float(scipy.special.ndtri(share)), -_SUREST), _SUREST)
        inside = deviate - min(float(scipy.special.ndtri(self.required)), _SUREST)
        if self.side is not None:
            values = evaluation.columns[self.column].astype(float)
            beyond, numbers = self._beyond(values), values[np.isfinite(values)]
            if np.isfinite(beyond):
                inside = -beyond / max(float(numbers.std()), 1e-3 * abs(self.limit), 1e-9)
        inside = min(max(inside, -_DEEPEST), _DEEPEST)
        return max(inside, 1e-3) if slack >= 0.0 else min(inside, -1e-3)

    def _beyond(self, values: Array) -> float:
        """Return by how much the quantile that the demand concerns lies beyond its bound; infinite where too few do."""
        reached = self._outwards(values)
        return float(reached[max(math.ceil(self.required * reached.size) - 1, 0)]) - self._sign * self.limit

    def _outwards(self, values: Array) -> Array:
        """Sort values so that each is further beyond the bound than the one before; infinite where there is none."""
        return np.sort(np.where(np.isfinite(values), self._sign * values, np.inf))

    @property
    def _sign(self) -> float:
        return 1.0 if self.side == "at_most" else -1.0

    def would_do(self, evaluation: Evaluation) -> float:
        """Return a limit with which a choice would meet the demand; nan for an event, or where too few reach it.

        The quantile of the trials would be met by half of all fresh trials only. The limit is so far out that the
        interval of the probability lies above that required, or as far out as any trial.
        """
        if self.side is None or evaluation.reason:
            return math.nan
        reached = self._outwards(evaluation.columns[self.column].astype(float))
        count = int(np.isfinite(reached).sum())
        if count < max(self.required * reached.size, 1):
            return math.nan
        return self._sign * float(reached[min(successes_to_decide(self.required, reached.size), count) - 1])

    def violation(self, evaluation: Evaluation) -> float:
        """Return how far a choice is from the demand: the probability that lacks, and the quantile beyond the bound.

        The second leads the search where hardly any trial does as demanded, and the first is the same everywhere.
        """
        lacking = max(-self.slack(evaluation), 0.0)
        if lacking == 0.0 or self.side is None:
            return lacking
        beyond = self._beyond(evaluation.columns[self.column].astype(float))
        return lacking + min(beyond / max(abs(self.limit), 1e-9), _FARTHEST)


def demands_of(mission: Mission) -> tuple[Demand, ...]:
    """Return a mission's requirements as demands."""
    return tuple(
        Demand(item.quantity, *bounded_column(mission, item), item.probability) for item in mission.requirements
    )


def violations(demands: Sequence[Demand], evaluation: Evaluation) -> list[float]:
    """How far a choice is from each demand."""
    if evaluation.reason:
        return [_CANNOT_RUN] * len(demands)
    return [demand.violation(evaluation) for demand in demands]


def is_feasible(demands: Sequence[Demand], evaluation: Evaluation, *, doubt: float = 0.0) -> bool:
    """Whether a choice meets all demands, or may, by so many standard errors of what is required."""
    if evaluation.reason:
        return False
    variances = (demand.required * (1.0 - demand.required) / max(evaluation.trials, 1) for demand in demands)
    pairs = zip(demands, variances, strict=True)
    return all(demand.slack(evaluation) >= -doubt * math.sqrt(variance) for demand, variance in pairs)
