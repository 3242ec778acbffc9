"""`optimise`: anchor, line, legs, speed and start together: all requirements met at the least energy or time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal, Unpack

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import MissionOrPath
from missionplan.mission.mission import with_values
from missionplan.montecarlo.alternatives import paired_difference, pareto_front
from missionplan.montecarlo.statistics import Count
from missionplan.results.optimisation import Obstacle, Optimised, Relaxation, Tried
from missionplan.results.simulation import Outcome
from missionplan.studies.exploration import first_start
from missionplan.studies.exploration.cells import SUCCESS, SharedCurrent
from missionplan.studies.exploration.result import AIM_COLUMNS
from missionplan.studies.judgement import is_good, judged
from missionplan.studies.optimisation import Lattice, Point, read_lattice
from missionplan.studies.optimisation.evaluations import (
    ChoiceTask,
    Demand,
    Evaluation,
    Evaluations,
    columns_needed,
    demands_of,
    is_feasible,
    violations,
)
from missionplan.studies.optimisation.search import FINE, Search
from missionplan.studies.run import ResumableArguments, Run

MOST_CHECKS = 12
"""Choices that are checked with all trials, the best first."""


def optimise(
    mission: MissionOrPath,
    *,
    choose: Sequence[str] = (),
    aim: Literal["energy", "duration"] | None = None,
    **run_as: Unpack[ResumableArguments],
) -> Optimised:
    """Choose values of some keys so that all requirements hold at the least mean energy or duration.

    Parameters
    ----------
    mission : Mission, str or Path
        With requirements, and a section `optimise` unless `choose` is given.
    choose : sequence of str
        What may be chosen, as ``KEY=FROM:TO:STEP`` or ``KEY=A,B,C``; default: the mission's section `optimise`.
    aim : {'energy', 'duration'}, optional
        Default: the mission's, which is energy unless it says otherwise.
    **run_as
        See `studies.run.ResumableArguments`; the trials are those of the checks, and `progress` is told of steps.

    Raises
    ------
    InputError
        When there is nothing to choose, no requirement, an argument is wrong, no choice can be run, or the checkpoint
        is of another run.
    RunError
        When a worker dies, or the checkpoint cannot be written.
    """
    run = Run.begun("optimise", mission, one_of={"aim": (aim, (None, "energy", "duration"))}, **run_as)
    mission, seed = run.mission, run.seed
    lattice, demands = read_lattice(mission, choose), demands_of(mission)
    if not demands:
        raise InputError([Problem("missing; what every choice must meet", mission.file, key="requirements")])
    # without a vehicle there is no energy, and it is the time
    least = aim or (mission.optimise.aim if mission.vehicle is not None else "duration")
    current = SharedCurrent.of(mission, first_start(lattice.axes))
    task = ChoiceTask([mission], [current], seed, columns_needed(mission), lattice)
    store = run.store(task.identity(mission, lattice.axes))
    problem = _Problem(Evaluations(mission, lattice, task, run.workers.quiet, store), demands, least, run)
    return problem.solved({"aim": least, "choose": list(choose), "jobs": run.workers.jobs})


@dataclass
class _Problem:
    evaluations: Evaluations
    demands: tuple[Demand, ...]
    aim: Literal["energy", "duration"]
    run: Run
    checked_trials: int = 0

    @property
    def lattice(self) -> Lattice:
        return self.evaluations.lattice

    def solved(self, options: Mapping[str, object]) -> Optimised:
        """Search, check, and see what binds or what the obstacle is."""
        search = Search(self.evaluations, self.demands, self.aim, self.run.seed)
        self._report(0)
        search.widely()
        self._report(1)
        search.closely()
        choices = self.evaluations.best_known()
        if all(choice.reason for choice in choices):
            reasons = list(dict.fromkeys(choice.reason for choice in choices))[:3]
            raise InputError([Problem(f"no choice tried can be run: {'; '.join(reasons)}", key="choose")])
        self._report(2)
        choice, checked, fresh = self._check(search)
        spent = self.evaluations.spent
        self._report(3)
        relaxations = () if choice is None else self._relaxations(search, choice)
        self._report(4)
        shown = self._nearest() if choice is None else choice
        settings = {"monte_carlo.trials": self.run.trials, "monte_carlo.seed": self.run.seed}  # as it was checked
        return Optimised(
            provenance=self.run.provenance(options, self.run.mission.notices()),
            aim=self.aim,
            axes=self.lattice.axes,
            combinations=len(self.lattice),
            chosen=self._values(shown.point),
            feasible=choice is not None,
            mission=with_values(self.evaluations.mission.raw, {**self.lattice.values_at(shown.point), **settings}),
            checked=checked,
            fresh=fresh,
            tried=self._tried(),
            relaxations=relaxations,
            obstacles=() if choice is not None else self._obstacles(),
            search_trials=spent,
            check_trials=self.checked_trials,
            relaxation_trials=self.evaluations.spent - spent,
        )

    def _report(self, done: int) -> None:
        if self.run.workers.progress is not None:
            self.run.workers.progress(done, 4)

    def _values(self, point: Point) -> dict[str, str]:
        return {axis.name: axis.exact(index) for axis, index in zip(self.lattice.axes, point, strict=True)}

    def _check(self, search: Search) -> tuple[Evaluation | None, Outcome | None, Outcome | None]:
        """Simulate the best choice with all trials, on the same random numbers and on fresh ones, until one does."""
        refused: set[Point] = set()
        for _ in range(MOST_CHECKS):
            ranked = search.until_it_stands(refused)
            if not ranked:
                break
            checked, fresh = self._simulated(ranked[0].point)
            if checked is not None and fresh is not None:
                return ranked[0], checked, fresh
            refused.add(ranked[0].point)
        return None, None, None

    def _simulated(self, point: Point) -> tuple[Outcome | None, Outcome | None]:
        """Simulate a choice as the command does; None where it refuses to, as where a record does not cover it.

        None too where it misses a requirement, and on fresh draws where it did on the others.
        """
        mission, values = self.evaluations.mission, self.lattice.values_at(point)
        run = self.run
        self.checked_trials += run.trials
        judge = partial(judged, mission, values, trials=run.trials, seed=run.seed, jobs=run.workers.jobs)
        checked = judge(assumptions=False, fresh=False)
        if checked is None or not is_good(checked):
            return None, None
        self.checked_trials += run.trials
        fresh = judge()
        return checked, fresh if is_good(fresh) else None

    def _nearest(self) -> Evaluation:
        choices = [choice for choice in self.evaluations.best_known() if not choice.reason]
        return min(choices, key=lambda choice: (sum(violations(self.demands, choice)), choice.cost(self.aim)))

    def _relaxations(self, search: Search, choice: Evaluation) -> tuple[Relaxation, ...]:
        """Solve the problem again with each requirement relaxed, from what is known of it."""
        relaxations, column = [], AIM_COLUMNS[self.aim]
        base = self._best_of(search.closely(), self.demands) or choice
        for number, demand in enumerate(self.demands):
            relaxed = demand.relaxed()
            demands = (*self.demands[:number], relaxed, *self.demands[number + 1 :])
            best = self._best_of(search.closely(demands), demands) or base
            saved, error, _ = paired_difference(best.columns[column], base.columns[column], most=True)
            gain = max(-saved, 0.0) if best is not base else 0.0
            change = "its bound 1 % wider"
            if demand.side is None:
                change = f"{100.0 * relaxed.required:g} % required instead of {100.0 * demand.required:g} %"
            values = self._values(best.point)
            relaxations.append(Relaxation(demand.quantity, change, gain, error if gain else 0.0, values))
        return tuple(relaxations)

    def _best_of(self, ranked: Sequence[Evaluation], demands: Sequence[Demand]) -> Evaluation | None:
        good = [choice for choice in ranked if is_feasible(demands, choice)]
        return min(good, key=lambda choice: choice.cost(self.aim), default=None)

    def _obstacles(self) -> tuple[Obstacle, ...]:
        """Find the requirements without which a choice would do, and how near one comes to each.

        Where dropping one requirement alone would not do: those that the choice that comes nearest misses.
        """
        choices = [choice for choice in self.evaluations.best_known() if not choice.reason]
        obstacles = []
        for number, demand in enumerate(self.demands):
            others = (*self.demands[:number], *self.demands[number + 1 :])
            rest = [choice for choice in choices if is_feasible(others, choice) and choice.trials >= FINE]
            rest = rest or [choice for choice in choices if is_feasible(others, choice)]
            best = min(rest, key=demand.violation, default=None)
            if best is not None and demand.slack(best) < 0.0:
                obstacles.append(_obstacle(demand, best, alone=True))
        nearest = self._nearest()
        missed = [demand for demand in self.demands if demand.slack(nearest) < 0.0]
        return tuple(obstacles) or tuple(_obstacle(demand, nearest, alone=False) for demand in missed)

    def _tried(self) -> tuple[Tried, ...]:
        choices = [choice for choice in self.evaluations.best_known() if not choice.reason]
        shares = [choice.columns[SUCCESS].astype(float).mean() for choice in choices]
        costs = np.array([[-s, e.cost("energy"), e.cost("duration")] for s, e in zip(shares, choices, strict=True)])
        many = max((choice.trials for choice in choices), default=0)
        costs[[choice.trials < many for choice in choices]] = np.nan  # few trials would put luck on the front
        costs[~np.isfinite(costs)] = np.nan
        front = pareto_front(costs)
        return tuple(
            Tried(
                values=self._values(choice.point),
                success=Count.of(choice.columns[SUCCESS]).probability(),
                energy=choice.cost("energy"),
                duration=choice.cost("duration"),
                slack={f"{of.quantity} {i + 1}": of.slack(choice) for i, of in enumerate(self.demands)},
                feasible=is_feasible(self.demands, choice),
                on_front=bool(on),
                trials=choice.trials,
            )
            for choice, on in zip(choices, front, strict=True)
        )


def _obstacle(demand: Demand, nearest: Evaluation, *, alone: bool) -> Obstacle:
    return Obstacle(
        demand.quantity,
        demand.required,
        demand.probability(nearest),
        column=demand.column,
        limit=demand.limit,
        would_do=demand.would_do(nearest),
        alone=alone,
    )
