"""Standard normals of many trials by name and leg, drawn when first asked for: the states of Markov chains."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

Key = tuple[str, int]
"""Name of a quantity, and the leg for which it is drawn (0 for one that is drawn once)."""


class NormalPopulation:
    """Standard normals of n trials.

    How many normals a trial needs is not known before it has been run (a transit has as many legs as it takes). What no
    trial has asked for is independent of all margins so far, and may be drawn later.
    """

    def __init__(self, trials: int, generator: np.random.Generator, cells: dict[Key, Array] | None = None) -> None:
        self.trials = trials
        self._generator = generator
        self._cells: dict[Key, Array] = {} if cells is None else cells

    def cell(self, name: str, leg: int = 0, rows: int = 1) -> Array:
        """Return the normals of a quantity on a leg, shape (rows, n)."""
        key = (name, leg)
        if key not in self._cells:
            self._cells[key] = self._draw(key, rows)
        return self._cells[key]

    def _draw(self, key: Key, rows: int) -> Array:
        return self._generator.standard_normal((rows, self.trials))

    def rows(self) -> dict[Key, int]:
        """Return what has been drawn, with the number of rows of each."""
        return {key: len(cell) for key, cell in self._cells.items()}

    def where(self, accepted: NDArray[np.bool_], other: "NormalPopulation") -> "NormalPopulation":
        """Take the accepted trials from another population, and the rest from this one."""
        cells = {
            (name, leg): np.where(accepted, other.cell(name, leg, rows), self.cell(name, leg, rows))
            for (name, leg), rows in {**self.rows(), **other.rows()}.items()
        }
        return NormalPopulation(self.trials, self._generator, cells)


class MovedPopulation(NormalPopulation):
    """Each trial moved at random so that standard normals stay standard normals (Papaioannou et al. 2015).

    u' = √(1 − s²) u + s ξ with ξ a new standard normal. The spread s, one or one a trial, is 1 for a trial drawn anew,
    0 for one that stays.
    """

    def __init__(self, parent: NormalPopulation, spread: float | Array, generator: np.random.Generator) -> None:
        super().__init__(parent.trials, generator)
        self._parent, self._spread = parent, np.asarray(spread)

    def _draw(self, key: Key, rows: int) -> Array:
        name, leg = key
        kept = np.sqrt(1.0 - self._spread**2) * self._parent.cell(name, leg, rows)
        return np.asarray(kept + self._spread * super()._draw(key, rows))


def gathered(
    populations: Sequence[NormalPopulation], chosen: NDArray[np.intp], generator: np.random.Generator
) -> NormalPopulation:
    """Collect trials of several populations, counted from the first trial of the first to the last of the last."""
    rows: dict[Key, int] = {}
    for population in populations:
        rows |= population.rows()
    cells = {
        (name, leg): np.concatenate([population.cell(name, leg, count) for population in populations], axis=1)[
            :, chosen
        ]
        for (name, leg), count in rows.items()
    }
    return NormalPopulation(chosen.size, generator, cells)
