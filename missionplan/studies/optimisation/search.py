"""The constrained search: differential evolution with few trials, then steps on the lattice with more."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.results.choosing.axis import Aim
from missionplan.studies.optimisation.evaluations import Evaluation, Evaluations
from missionplan.studies.optimisation.judging import Demand, is_feasible, violations

COARSE, FINE = 128, 1024
"""Trials of a choice in the wide search, and in the steps about its best."""
MEMBERS, GENERATIONS = 7, 16
"""Of the differential evolution; members a key."""
_STARTS = 4
"""Best points of the wide search from which steps are taken."""
_DOUBT = 2.0
"""Standard errors by which few trials may fall short and a choice still be looked at with more."""
_NEVER = 1e9
"""Cost of what cannot be had: finite, for the search."""
_MOST_STEPS = 40


@dataclass(frozen=True)
class Search:
    """A search for the choice of least cost that meets all demands.

    Attributes
    ----------
    evaluations : Evaluations
    demands : tuple of Demand
    aim : 'energy' or 'duration'
    seed : int
        Of the differential evolution.
    """

    evaluations: Evaluations
    demands: tuple[Demand, ...]
    aim: Aim
    seed: int

    def widely(self) -> None:
        """Search the whole lattice with few trials, by differential evolution under constraints (Lampinen 2002)."""
        shape = self.evaluations.lattice.shape
        free = [axis for axis, count in enumerate(shape) if count > 1]
        if not free:
            self.evaluations.of([(0,) * len(shape)], COARSE)
            return

        def at(x: NDArray[np.float64]) -> list[Evaluation]:
            rows = np.atleast_2d(x.T)
            points = np.zeros((len(rows), len(shape)), dtype=int)
            points[:, free] = np.rint(rows)
            return self.evaluations.of([tuple(int(i) for i in point) for point in points], COARSE)

        def costs(x: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.array([min(each.cost(self.aim), _NEVER) for each in at(x)])

        def beyond(x: NDArray[np.float64]) -> NDArray[np.float64]:
            found = np.array([violations(self.demands, each) for each in at(x)]).T
            return found if x.ndim > 1 else found[:, 0]

        limits = {"constraints": scipy.optimize.NonlinearConstraint(beyond, -np.inf, 0.0)} if self.demands else {}
        run: Any = scipy.optimize.differential_evolution  # its stubs know no vectorised function
        run(
            costs,
            [(0, shape[axis] - 1) for axis in free],
            integrality=[True] * len(free),
            popsize=MEMBERS,
            maxiter=GENERATIONS,
            tol=1e-3,
            vectorized=True,
            updating="deferred",
            polish=False,
            seed=self.seed,
            **limits,
        )

    def closely(self, demands: Sequence[Demand] | None = None, *, starts: int = _STARTS) -> list[Evaluation]:
        """Step from the best points known to better neighbours, with more trials, until none is better.

        A neighbour is looked at with more trials only where few leave open that it is both feasible and better.

        Returns
        -------
        list of Evaluation
            Those run with many trials, the best first.
        """
        demands = self.demands if demands is None else demands
        known = sorted(self.evaluations.best_known(), key=lambda each: self._rank(each, demands, _DOUBT))
        for start in self.evaluations.of([each.point for each in known[:starts]], FINE):
            best = start
            for _ in range(_MOST_STEPS):
                better = self._better_neighbours(best, demands)
                if not better:
                    break
                best = better[0]
        fine = [each for (_, trials), each in self.evaluations.kept.items() if trials == FINE]
        return sorted(fine, key=lambda each: self._rank(each, demands, 0.0))

    def _better_neighbours(self, best: Evaluation, demands: Sequence[Demand]) -> list[Evaluation]:
        around = list(self.evaluations.lattice.neighbours(best.point))
        (here,) = self.evaluations.of([best.point], COARSE)
        coarse = self.evaluations.of(around, COARSE)
        rank = self._rank(here, demands, _DOUBT)
        promising = sorted(
            (each for each in coarse if self._rank(each, demands, _DOUBT) < rank),
            key=lambda each: self._rank(each, demands, _DOUBT),
        )
        for each in self.evaluations.of([each.point for each in promising[:3]], FINE):
            if self._rank(each, demands, 0.0) < self._rank(best, demands, 0.0):
                return [each]
        return []

    def _rank(self, each: Evaluation, demands: Sequence[Demand], doubt: float) -> tuple[float, float]:
        """Order: feasible choices by their cost, then the others by how far they are from the demands."""
        if is_feasible(demands, each, doubt=doubt):
            return 0.0, each.cost(self.aim)
        return sum(violations(demands, each)) + 1e-12, each.cost(self.aim)
