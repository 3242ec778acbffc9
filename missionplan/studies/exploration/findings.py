"""From the trials of all cells: each cell's numbers, the best cell and those as good, the front."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.mission import Mission
from missionplan.montecarlo.paired import compare_with_best, pareto_front
from missionplan.montecarlo.statistics import Count, Probability, Statistic
from missionplan.results.choosing.axis import Aim
from missionplan.results.choosing.exploration import Cell
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration.cells import LEFT_RECORD, SUCCESS
from missionplan.studies.simulation.block_statistics import bound_of, requirement_key
from missionplan.studies.simulation.record_cover import TOLERATED

ENERGY, DURATION = "total.energy_wh", "total.duration_s"
AIM_COLUMNS: dict[Aim, str] = {"success": SUCCESS, "energy": ENERGY, "duration": DURATION}
Trials = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Best:
    """All cells with their places among the others.

    Attributes
    ----------
    cells : tuple of Cell
    best : int or None
    constrained : bool
        Whether the best is among cells that meet all requirements.
    """

    cells: tuple[Cell, ...]
    best: int | None
    constrained: bool


def cell_of(place: tuple[int, ...], mission: Mission, trials: Trials, reason: str) -> Cell:
    """Sum up the trials of one cell; `mission` has the requirements, which are the same for all."""
    if reason:
        return Cell(place, reason)
    if LEFT_RECORD in trials and (left := _probability(trials[LEFT_RECORD]).value) > TOLERATED:
        return Cell(place, f"{100.0 * left:.3g} % of the trials leave the record of the current")
    own = {name: values for name, values in trials.items() if name not in (SUCCESS, LEFT_RECORD)}
    own = {name: values for name, values in own.items() if not name.startswith("requirement ")}
    return Cell(
        place=place,
        success=_probability(trials[SUCCESS]),
        requirements=tuple(_requirement(mission, index, trials) for index in range(len(mission.requirements))),
        quantities={name: statistic_of(values) for name, values in own.items() if values.dtype != bool},
        events={name: _probability(values) for name, values in own.items() if values.dtype == bool},
        trials=trials[SUCCESS].size,
    )


def _probability(happened: NDArray[np.generic]) -> Probability:
    return Count(int(happened.sum()), happened.size).probability()


def statistic_of(values: NDArray[np.generic]) -> Statistic:
    """Sum up a quantity, shape (n,); nan where no trial reached it."""
    numbers = values.astype(float)
    reached = numbers[np.isfinite(numbers)]
    if not reached.size:
        return Statistic(*(float("nan"),) * 6, count=0, missing=numbers.size)
    sd = float(reached.std(ddof=1)) if reached.size > 1 else float("nan")
    low, middle, high = (float(value) for value in np.quantile(reached, (0.05, 0.5, 0.95)))
    error = sd / np.sqrt(reached.size)
    return Statistic(
        float(reached.mean()), sd, low, middle, high, float(error), reached.size, numbers.size - reached.size
    )


def _requirement(mission: Mission, index: int, trials: Trials) -> RequirementOutcome:
    requirement = mission.requirements[index]
    met = trials[f"requirement {index}"]
    probability, required = _probability(met), requirement.probability
    side, limit = bound_of(requirement) or (None, None)
    return RequirementOutcome(
        quantity=requirement.quantity,
        bound=side,
        limit=limit,
        unit=requirement_key(mission, requirement.quantity)[1] or "",
        required=required,
        probability=probability,
        met=probability.value >= required,
        undecided=probability.low <= required <= probability.high,
        trials=met.size,
    )


def find_best(cells: Sequence[Cell], trials: Sequence[Trials], aim: Aim) -> Best:
    """Find the best cell and those that the trials cannot tell from it.

    The cells that meet all requirements are compared; where none does, all, and the best is the one that succeeds most
    often. Of cells that succeed equally often the one that takes less energy is the best.

    Parameters
    ----------
    cells : sequence of Cell
    trials : sequence of mapping
        Columns of each cell, empty for one that could not be run.
    aim : 'success', 'energy' or 'duration'
    """
    valid = [index for index, cell in enumerate(cells) if not cell.reason and not cell.dropped]
    good = [index for index in valid if cells[index].requirements and cells[index].meets_all]
    constrained = bool(good)
    unmet = not good and any(cells[index].requirements for index in valid)
    column = AIM_COLUMNS["success" if unmet else aim]
    compared = [index for index in (good if constrained else valid) if _is_known(cells[index], column)]
    if not compared:
        return Best(_with_front(cells), None, constrained)
    best = min(compared, key=lambda index: rank(cells[index], column))
    found = compare_with_best(
        [trials[index][column] for index in compared], compared.index(best), most=column == SUCCESS
    )
    judged = {
        index: replace(
            cells[index],
            worse=float(found.worse[number]),
            worse_error=float(found.error[number]),
            as_good=bool(found.as_good[number]),
        )
        for number, index in enumerate(compared)
    }
    return Best(_with_front([judged.get(i, cell) for i, cell in enumerate(cells)]), best, constrained)


def _is_known(cell: Cell, column: str) -> bool:
    return column == SUCCESS or cell.quantities[column].count > 0


def rank(cell: Cell, column: str) -> tuple[float, float]:
    """Order of cells, the best first."""
    energy = cell.quantities[ENERGY].mean
    tie = energy if np.isfinite(energy) else np.inf
    return (-cell.success.value, tie) if column == SUCCESS else (cell.quantities[column].mean, -cell.success.value)


def _with_front(cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """Mark the front of P(success), mean energy and mean duration; without energy, of the other two."""
    names = [name for name in (ENERGY, DURATION) if any(_mean(cell, name) < np.inf for cell in cells)]
    costs = np.array([[-cell.success.value, *(_mean(cell, name) for name in names)] for cell in cells])
    front = pareto_front(np.where(np.isfinite(costs), costs, np.nan))
    return tuple(replace(cell, on_front=bool(on)) for cell, on in zip(cells, front, strict=True))


def _mean(cell: Cell, name: str) -> float:
    mean = cell.quantities[name].mean if name in cell.quantities else np.inf
    return mean if np.isfinite(mean) else np.inf
