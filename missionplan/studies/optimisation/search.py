"""The constrained search: kriging of cost and margins on common random numbers, with few trials and then with more.

Bayesian optimisation under constraints (Schonlau 1997; Gardner et al. 2014): surfaces through the cost and through each
demand's margin say where a choice may be better than the best so far and meet the demands, and that is tried next. All
choices have the same random numbers, so that the surfaces are smooth and differences between choices precise.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from missionplan.arrays import Array
from missionplan.montecarlo.alternatives import Kriging, expected_improvement, paired_difference
from missionplan.results.decision import Aim
from missionplan.studies.exploration.result import AIM_COLUMNS
from missionplan.studies.optimisation import Point
from missionplan.studies.optimisation.evaluations import Demand, Evaluation, Evaluations, is_feasible, violations

COARSE, FINE = 128, 1024
"""Trials of a choice in the wide search, and about its best."""
_FIRST, _MOST = 12, 40
"""Choices from which the surfaces start, and most that they add in the wide search, a key."""
_LOOKED_AT, _MOST_LOOKED_AT = 1.0 / 20.0, 100
"""Share of all choices that is looked at besides, lest a narrow optimum be missed, and most of them, a key."""
_TOGETHER = 4
"""Choices that are tried before the surfaces are drawn again: as many as can be run at once."""
_ENOUGH = 1e-3
"""Hoped-for improvement at which a search ends, of the cost."""
_STARTS = 3
"""Choices apart from each other from which steps are taken, at most."""
_MOST_FINE = 16
"""Choices with many trials that one close search may add."""
_CANDIDATES = 3000
"""Of a large lattice, choices drawn at random of which the next is taken, besides neighbours of the best."""
_DOUBT = 2.0
"""Standard errors by which few trials may fall short and a choice still be looked at with more."""
_NEIGHBOURED = 5
_AT_ONCE = 8
"""Choices that are run with many trials before the winner is looked at again."""
_DOUBTFUL = 4
"""Choices that cost less and may meet the demands, but did not with many trials, that are put before one that did."""


@dataclass
class Search:
    """A search for the choice of least cost that meets all demands."""

    evaluations: Evaluations
    demands: tuple[Demand, ...]
    aim: Aim
    seed: int
    """Of the first choices and of the candidates."""
    fits: dict[int, Kriging] = field(default_factory=dict)
    """The last surface of each margin, and under −1 that of the cost: the next fit starts from it."""

    def widely(self) -> None:
        """Search the whole lattice with few trials."""
        lattice = self.evaluations.lattice
        keys = sum(count > 1 for count in lattice.shape)
        rng = np.random.default_rng(self.seed)
        first = max(_FIRST * keys, 1) + min(round(_LOOKED_AT * len(lattice)), _MOST_LOOKED_AT * keys)
        columns = [rng.permutation((np.arange(first) + rng.random(first)) / first) for _ in lattice.shape]
        points = [
            np.minimum((column * size).astype(int), size - 1)
            for column, size in zip(columns, lattice.shape, strict=True)
        ]
        self.evaluations.of([tuple(int(i) for i in point) for point in np.stack(points, axis=1)], COARSE)
        most = min(first + _MOST * keys, len(lattice))
        self._while_hopeful(rng, most)
        starts: list[Point] = []
        better: set[Point] = set()
        for choice in sorted(self.evaluations.best_known(), key=self._by_rank):
            if better.isdisjoint(self.evaluations.lattice.neighbours(choice.point)):
                starts.append(choice.point)
            better.add(choice.point)
        for point in starts[:_STARTS]:
            self._descend(point)
        self._while_hopeful(rng, most)

    def closely(self, demands: Sequence[Demand] | None = None) -> list[Evaluation]:
        """Run what may be the best with more trials, until nothing is likely to be better.

        Returns those run with many trials, the best first.
        """
        demands = self.demands if demands is None else demands
        rng = np.random.default_rng(self.seed)
        choices = sorted(self.evaluations.best_known(), key=lambda choice: self._rank(choice, demands, _DOUBT))
        self.evaluations.of([choice.point for choice in choices[:2]], FINE)
        for _ in range(_MOST_FINE // 2):
            fine = {point for point, trials in self.evaluations.kept if trials == FINE}
            todo = self._most_hopeful(demands, rng, 2, fine)
            if not todo:
                break
            self.evaluations.of(todo, FINE)
        fine_choices = [choice for (_, trials), choice in self.evaluations.kept.items() if trials == FINE]
        return sorted(fine_choices, key=lambda choice: self._rank(choice, demands, 0.0))

    def until_it_stands(self, refused: Collection[Point] = ()) -> list[Evaluation]:
        """Run the winner's neighbours, and every choice that may be better, until none is left that may.

        A choice may be better that has had few trials, may meet the demands, and on the same trials does not cost more
        than the winner by two standard errors of the difference.

        `refused`: that more trials have shown not to meet the demands. Returns those run with many trials that meet the
        demands or may, and were not refused: by their cost, but of those that only may at most a few before the first
        that does.
        """
        while True:
            fine = {point for point, trials in self.evaluations.kept if trials == FINE}
            ranked = self._contenders(fine.difference(refused))
            winner = next((choice for choice in ranked if is_feasible(self.demands, choice)), None)
            if winner is not None:
                self.evaluations.of(list(self.evaluations.lattice.neighbours(winner.point)), COARSE)
            rest = [choice for choice in self.evaluations.best_known() if choice.point not in fine.union(refused)]
            todo = [choice for choice in rest if self._may_beat(choice, winner)]
            if not todo:
                return ranked
            self.evaluations.of([choice.point for choice in sorted(todo, key=self._by_rank)[:_AT_ONCE]], FINE)

    def _contenders(self, fine: Collection[Point]) -> list[Evaluation]:
        choices = sorted(
            (self.evaluations.kept[point, FINE] for point in fine), key=lambda choice: choice.cost(self.aim)
        )
        sure = [choice for choice in choices if is_feasible(self.demands, choice)]
        least = sure[0].cost(self.aim) if sure else np.inf
        cheaper = [
            choice
            for choice in choices
            if not is_feasible(self.demands, choice)
            and is_feasible(self.demands, choice, doubt=_DOUBT)
            and choice.cost(self.aim) < least
        ]
        return [*cheaper[:_DOUBTFUL], *sure, *cheaper[_DOUBTFUL:]]

    def _may_beat(self, choice: Evaluation, winner: Evaluation | None) -> bool:
        """Whether a choice with few trials may cost less than the winner, and meet the demands."""
        may = is_feasible(self.demands, choice, doubt=_DOUBT)
        if winner is None or not may:
            return may
        column = AIM_COLUMNS[self.aim]
        worse, error, _ = paired_difference(winner.columns[column], choice.columns[column], most=False)
        return worse <= _DOUBT * error

    def _while_hopeful(self, rng: np.random.Generator, most: int) -> None:
        """Run with few trials what the surfaces hope most of, until that is little or so many choices are known."""
        while len(self.evaluations.best_known()) < most:
            todo = self._most_hopeful(self.demands, rng, _TOGETHER, set())
            if not todo:
                break
            self.evaluations.of(todo, COARSE)

    def _descend(self, point: Point) -> None:
        """Step to a better choice beside one while there is any, with few trials.

        Of a hole in flat ground a surface through its rim does not tell the depth.
        """
        while True:
            neighbours = list(self.evaluations.lattice.neighbours(point))
            around = [other for other in neighbours if np.count_nonzero(np.subtract(other, point)) == 1]
            best = min(self.evaluations.of([point, *around], COARSE), key=self._by_rank)
            if best.point == point:
                return
            point = best.point

    def _by_rank(self, choice: Evaluation) -> tuple[float, float]:
        return self._rank(choice, self.demands, _DOUBT)

    def _most_hopeful(
        self, demands: Sequence[Demand], rng: np.random.Generator, count: int, fine: set[Point]
    ) -> list[Point]:
        """Return the choices to be tried next, none where little can be hoped for.

        Those of `fine`, and without them those tried at all, are not tried again.
        """
        choices = self.evaluations.best_known()
        tried = fine or {choice.point for choice in choices}
        candidates = [point for point in self._candidates(choices, demands, rng) if point not in tried]
        if not candidates:
            return []
        judged = [choice for choice in choices if choice.point in fine] if fine else choices
        costs = [choice.cost(self.aim) for choice in judged if is_feasible(demands, choice)]
        low = min(costs, default=np.inf)
        places, hope, least = self.evaluations.lattice.places(candidates)[0], np.ones(len(candidates)), 0.0
        if np.isfinite(low):
            values, least = self._with_common_noise(choices), _ENOUGH * abs(low)
            costly = np.isfinite(values)
            surface = self._surface(
                -1, [choice for choice, has in zip(choices, costly, strict=True) if has], values[costly]
            )
            hope = expected_improvement(low, *surface.at(places))
            hopeful = hope > least  # a chance makes it less
            candidates = [point for point, is_it in zip(candidates, hopeful, strict=True) if is_it]
            places, hope = places[hopeful], hope[hopeful]
        chance = np.zeros(len(candidates))
        for number, demand in enumerate(demands if candidates else ()):
            margins = np.array([demand.margin(choice) for choice in choices])
            mean, spread = self._surface(number, choices, margins).at(places)
            chance += scipy.special.log_ndtr(mean / np.maximum(spread, 1e-3))
        if not np.isfinite(low):
            chance -= chance.max()
        return self._apart(candidates, places, hope * np.exp(chance), count, least=least)

    def _with_common_noise(self, choices: Sequence[Evaluation]) -> Array:
        """Costs of choices, those with few trials moved by what more trials changed of the others, on average."""
        costs = np.array([choice.cost(self.aim) for choice in choices])
        kept = self.evaluations.kept
        moved = [
            choice.cost(self.aim) - kept[choice.point, COARSE].cost(self.aim)
            for choice in choices
            if choice.trials == FINE and (choice.point, COARSE) in kept
        ]
        moved = [move for move in moved if np.isfinite(move)]
        few = np.array([choice.trials < FINE for choice in choices])
        return costs + np.where(few, float(np.mean(moved)) if moved else 0.0, 0.0)

    def _apart(
        self, candidates: Sequence[Point], places: Array, hope: Array, count: int, *, least: float
    ) -> list[Point]:
        chosen: list[Point] = []
        surface = self.fits.get(-1) or next(iter(self.fits.values()), None)
        for _ in range(min(count, len(candidates))):
            index = int(np.argmax(hope))
            if hope[index] <= least:
                break
            chosen.append(candidates[index])
            alike = surface.alike(places[index], places) if surface is not None else 0.0
            hope = hope * np.maximum(1.0 - alike, 0.0)
            hope[index] = -1.0
        return chosen

    def _surface(self, number: int, choices: Sequence[Evaluation], values: Array) -> Kriging:
        """Draw a surface through a value of some choices, from where the last fit of the same value ended."""
        places, axis = self.evaluations.lattice.places([choice.point for choice in choices])
        self.fits[number] = Kriging.fitted(places, axis, values, self.fits.get(number))
        return self.fits[number]

    def _candidates(
        self, choices: Sequence[Evaluation], demands: Sequence[Demand], rng: np.random.Generator
    ) -> list[Point]:
        """All choices, or of many some at random and the neighbours of the best known."""
        lattice = self.evaluations.lattice
        if len(lattice) <= _CANDIDATES:
            return [tuple(int(i) for i in np.unravel_index(number, lattice.shape)) for number in range(len(lattice))]
        drawn = rng.integers(0, lattice.shape, (_CANDIDATES, len(lattice.shape)))
        best = sorted(choices, key=lambda choice: self._rank(choice, demands, _DOUBT))[:_NEIGHBOURED]
        near = [point for choice in best for point in (choice.point, *lattice.neighbours(choice.point))]
        return list(dict.fromkeys([*near, *(tuple(int(i) for i in point) for point in drawn)]))

    def _rank(self, choice: Evaluation, demands: Sequence[Demand], doubt: float) -> tuple[float, float]:
        """Order: feasible choices by their cost, then the others by how far they are from the demands."""
        if is_feasible(demands, choice, doubt=doubt):
            return 0.0, choice.cost(self.aim)
        return sum(violations(demands, choice)) + 1e-12, choice.cost(self.aim)
