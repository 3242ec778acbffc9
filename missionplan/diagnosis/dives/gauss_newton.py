"""Least squares with priors for many sets of causes and starts at once: damped Gauss–Newton, one phase call a step."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.dives.forward import DescentForward

STEPS = 9
CONVERGED = 0.05
"""Fall of the objective [nats] below which a lane is done."""
DIFFERENCE = 0.01
"""Step of the finite differences, in prior standard deviations."""
SHORTER = 0.25
"""Share of a Gauss–Newton step that is tried when the whole of it led up."""
LARGEST = 3.0
"""Longest step of a coordinate, in prior standard deviations."""
PRUNED_AFTER, PRUNED_BEYOND = 3, 3.0
"""Steps after which a start is given up when another of its family is so much better [nats]."""


@dataclass(frozen=True)
class Lane:
    """One start of one set of causes.

    Attributes
    ----------
    free : array of int
        Coordinates that move.
    start : array, shape (k,)
        All coordinates at the start.
    family : int
        Starts of the same problem share a number: the worse ones are given up on the way.
    rows : array of int, optional
        Readings to fit; default all.
    """

    free: NDArray[np.int_]
    start: Array
    family: int
    rows: NDArray[np.int_] | None = None


@dataclass(frozen=True)
class Ended:
    """Where a lane ended: coordinates, and the objective there [nats]."""

    at: Array
    objective: float


def jacobian_settings(coordinates: Sequence[Coordinate], at: Array, free: NDArray[np.int_]) -> tuple[Array, Array]:
    """Settings for forward differences, shape (k, len(free)), and the steps, shape (len(free),)."""
    steps = np.array([DIFFERENCE * coordinates[index].slab for index in free])
    settings = np.repeat(at[:, None], len(free), axis=1)
    settings[free, np.arange(len(free))] += steps
    return settings, steps


def climb(
    forward: DescentForward,
    coordinates: Sequence[Coordinate],
    y: Array,
    covariance: Array,
    lanes: Sequence[Lane],
    steps: int = STEPS,
) -> list[Ended]:
    """Minimise ½(y − f)ᵀΣ⁻¹(y − f) + ½Σ((θ − μ)/s)² in every lane.

    Parameters
    ----------
    forward : DescentForward
        The phase.
    coordinates : sequence of Coordinate, length k
        With centres μ and slabs s.
    y : array, shape (N,)
        Readings.
    covariance : array, shape (N, N)
        Σ.
    lanes : sequence of Lane
        What to climb from where.
    steps : int
        At most so many.
    """
    problem = _Problem(forward, coordinates, y, covariance, lanes)
    places = problem.evaluate([(i, lane.start) for i, lane in enumerate(lanes)])
    shares = {i: 1.0 for i, place in enumerate(places) if np.isfinite(place.objective)}
    for step in range(steps):
        if not shares:
            break
        tried = problem.evaluate(
            [(i, places[i].at + share * problem.step(i, places[i])) for i, share in shares.items()]
        )
        for (i, share), place in zip(tuple(shares.items()), tried, strict=True):
            gained = places[i].objective - place.objective
            if gained > 0.0:
                places[i] = place
            if gained > CONVERGED:
                shares[i] = 1.0
            elif gained > 0.0 or share < 1.0:
                del shares[i]
            else:
                shares[i] = SHORTER
        if step + 1 >= PRUNED_AFTER:
            shares = {i: shares[i] for i in _worth_going_on(shares, lanes, places)}
    return [Ended(place.at, place.objective) for place in places]


def _worth_going_on(active: Iterable[int], lanes: Sequence[Lane], places: "Sequence[_Place]") -> list[int]:
    best: dict[int, float] = {}
    for lane, place in zip(lanes, places, strict=True):
        best[lane.family] = min(best.get(lane.family, np.inf), place.objective)
    return [i for i in active if places[i].objective < best[lanes[i].family] + PRUNED_BEYOND]


@dataclass(frozen=True)
class _Place:
    """Coordinates with the whitened residual and Jacobian there, and the objective: infinite if one is not finite."""

    at: Array
    residual: Array
    jacobian: Array
    objective: float


class _Problem:
    """Readings, whitened, and priors of the lanes."""

    def __init__(
        self,
        forward: DescentForward,
        coordinates: Sequence[Coordinate],
        y: Array,
        covariance: Array,
        lanes: Sequence[Lane],
    ) -> None:
        self._forward, self._coordinates, self._y, self._lanes = forward, coordinates, y, lanes
        self._centre = np.array([coordinate.centre for coordinate in coordinates])
        self._slab = np.array([coordinate.slab for coordinate in coordinates])
        self._factors: dict[bytes, Array] = {}
        for lane in lanes:
            if self._key(lane) not in self._factors:
                rows = np.arange(len(y)) if lane.rows is None else lane.rows
                self._factors[self._key(lane)] = np.asarray(
                    np.linalg.cholesky(covariance[np.ix_(rows, rows)]), dtype=float
                )

    @staticmethod
    def _key(lane: Lane) -> bytes:
        return b"" if lane.rows is None else lane.rows.tobytes()

    def evaluate(self, wanted: Sequence[tuple[int, Array]]) -> list[_Place]:
        """Evaluate lanes at coordinates, Jacobians by forward differences included: one call of the phase."""
        settings = []
        for i, at in wanted:
            free = self._lanes[i].free
            block = np.repeat(at[:, None], 1 + len(free), axis=1)
            block[free, 1 + np.arange(len(free))] += DIFFERENCE * self._slab[free]
            settings.append(block)
        readings = self._forward.readings(self._coordinates, np.concatenate(settings, axis=1))
        places, column = [], 0
        for i, at in wanted:
            count = len(self._lanes[i].free)
            places.append(self._place(i, at, readings[:, column : column + 1 + count]))
            column += 1 + count
        return places

    def _place(self, index: int, at: Array, readings: Array) -> _Place:
        lane = self._lanes[index]
        rows = slice(None) if lane.rows is None else lane.rows
        columns = (readings[:, 1:] - readings[:, :1]) / DIFFERENCE
        both = np.concatenate([(self._y - readings[:, 0])[:, None], columns], axis=1)[rows]
        white = np.asarray(solve_triangular(self._factors[self._key(lane)], both, lower=True, check_finite=False))
        prior = (at[lane.free] - self._centre[lane.free]) / self._slab[lane.free]
        objective = 0.5 * float(white[:, 0] @ white[:, 0]) + 0.5 * float(prior @ prior)
        return _Place(at, white[:, 0], white[:, 1:], objective if np.all(np.isfinite(white)) else np.inf)

    def step(self, index: int, place: _Place) -> Array:
        """Gauss–Newton step of a lane, shape (k,)."""
        free = self._lanes[index].free
        move = np.zeros(len(self._coordinates))
        prior = (self._centre[free] - place.at[free]) / self._slab[free]
        normal = place.jacobian.T @ place.jacobian + np.eye(len(free))
        scaled = np.linalg.solve(normal, place.jacobian.T @ place.residual + prior)
        move[free] = self._slab[free] * np.clip(scaled, -LARGEST, LARGEST)
        return move
