"""`explore`: one or two keys of a mission varied on common random numbers, over all cells and blocks."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Unpack, get_args

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission, MissionOrPath
from missionplan.mission.checks.sections import quantity_unit
from missionplan.mission.quantity_paths import resolved_path
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.alternatives import compare_with_best
from missionplan.montecarlo.statistics import Count
from missionplan.montecarlo.streams import sized_blocks
from missionplan.results.decision import Aim, Assumption, Axis, MemberOutcome
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import members_drawn, members_of
from missionplan.studies import judgement
from missionplan.studies.exploration import OPTION, read_axes
from missionplan.studies.exploration.cells import SUCCESS, CellItem, CellTask, CellTrials, cell_trials
from missionplan.studies.exploration.result import (
    AIM_COLUMNS,
    DURATION,
    ENERGY,
    Cell,
    Exploration,
    cell_of,
    find_best,
    rank,
)
from missionplan.studies.run import ResumableArguments, Run
from missionplan.studies.simulation import check_complete, input_notices
from missionplan.studies.simulation.block_statistics import requirement_key

MAX_TRIALS = 25_000_000
"""Trials of all cells together: their results are kept in memory, to be compared pair by pair."""
_SHOWN = 3
"""Reasons that a message names where no cell can be run."""


FIRST, FACTOR = 128, 4
"""Trials of the first heat, and by how much more the next has."""


@dataclass(frozen=True)
class Race:
    """What a race leaves."""

    trials: list[CellTrials]
    """Of each cell, as many as it was run with."""
    dropped: frozenset[int]
    """Cells that cannot be the best."""
    spent: int
    """Trials run."""


def race(
    mission: Mission, cells: int, trials: int, aim: Aim, run: Callable[[Sequence[CellItem]], list[CellTrials]]
) -> Race:
    """Run all cells with few trials, and those that may be the best with more, until all that are left have all.

    Heats begin with the same trials, so that what is left has the numbers of a full exploration. A cell is dropped when
    a requirement is certainly missed while another cell may meet all, or when one that meets all beats it by more than
    chance. Where none that is left meets all in the end, those that may and were dropped for it are run after all.

    `mission`: with the requirements. `cells`, `trials`: number of cells, and trials of those that last. `run`: runs
    blocks of cells and returns the trials of every cell.
    """
    left = list(range(cells))
    samples: list[CellTrials] = [CellTrials({})] * cells
    spent, size = 0, min(FIRST, trials)
    while True:
        heat = run([(cell, *block) for cell in left for block in sized_blocks(size)])
        spent += size * len(left)
        for cell in left:
            samples[cell] = heat[cell]
        dropped = frozenset(range(cells)) - set(left)
        judged = [cell_of((), mission, sample.columns, sample.reason) for sample in samples]
        if size == trials and (again := _to_run_after_all(judged, left)):
            left = again
        elif size == trials:
            whole = {cell for cell in dropped if judged[cell].trials == trials}
            return Race(samples, dropped - whole, spent)
        else:
            left = _last(judged, samples, left, aim)
            size = min(size * FACTOR, trials)


def _to_run_after_all(cells: Sequence[Cell], left: Sequence[int]) -> list[int]:
    """Return cells that were dropped for the sake of one that does not meet all in the end, while they may."""
    if any(cells[index].meets_all for index in left):
        return []
    return [
        i
        for i, cell in enumerate(cells)
        if not cell.reason and cell.trials < cells[left[0]].trials and not _misses(cell)
    ]


def _last(cells: Sequence[Cell], samples: Sequence[CellTrials], left: Sequence[int], aim: Aim) -> list[int]:
    """Return the cells that may still be the best."""
    valid = [index for index in left if not cells[index].reason]
    may = [index for index in valid if not _misses(cells[index])] or valid
    column = AIM_COLUMNS[aim]
    good = [index for index in may if cells[index].meets_all and rank(cells[index], column)[0] < math.inf]
    if not good:
        return may
    best = min(good, key=lambda index: rank(cells[index], column))
    values = [samples[index].columns[column] for index in may]
    as_good = compare_with_best(values, may.index(best), most=column == SUCCESS).as_good
    # a cell that may not meet all may look better than the best of those that do
    order = rank(cells[best], column)
    return [index for index, stays in zip(may, as_good, strict=True) if stays or rank(cells[index], column) < order]


def _misses(cell: Cell) -> bool:
    return any(not item.met and not item.undecided for item in cell.requirements)


def explore(
    mission: MissionOrPath,
    vary: Sequence[str] | str,
    *,
    aim: Aim = "success",
    only_best: bool = False,
    quantities: Sequence[str] = (),
    **run_as: Unpack[ResumableArguments],
) -> Exploration:
    """Vary one or two keys of a mission and find the best cell.

    Every cell has the same random numbers, so that differences between cells are far more precise than the cells.

    Parameters
    ----------
    mission : Mission, str or Path
        Or the path of its file.
    vary : str or sequence of str
        One or two of ``KEY=FROM:TO:STEP`` and ``KEY=A,B,C``; see `read_axes`.
    aim : {'success', 'energy', 'duration'}
        What is best: the greatest P(success); or of the cells that meet all requirements the least mean energy or
        duration.
    only_best : bool
        Run cells that cannot be the best with few trials; there are then no windows.
    quantities : sequence of str
        Reported besides, as requirements name them: ``moor.offset``, ``ingress.arrived``.
    **run_as
        See `studies.run.ResumableArguments`; the trials are those of each cell.

    Raises
    ------
    InputError
        When an argument is wrong, no cell can be run, or the checkpoint is of another run.
    RunError
        When a worker dies, or the checkpoint cannot be written.
    """
    run = Run.begun("explore", mission, one_of={"aim": (aim, get_args(Aim))}, **run_as)
    mission, trials, seed = run.mission, run.trials, run.seed
    axes = read_axes(mission, [vary] if isinstance(vary, str) else list(vary))
    columns = _columns(mission, quantities)
    places = list(itertools.product(*(range(len(axis.values)) for axis in axes)))
    if (whole := len(places) * trials) > MAX_TRIALS:
        message = f"{len(places)} cells of {trials} trials are {whole:.3g}, expected at most {MAX_TRIALS:.3g}"
        raise InputError([Problem(message, key="trials", hint="fewer trials, or fewer cells")])
    task = CellTask.of(mission, axes, seed, columns)
    store = run.store(task.identity(mission, axes))

    def run_cells(items: Sequence[CellItem]) -> list[CellTrials]:
        return cell_trials(task, items, range(len(places)), run.workers, store)

    if only_best:
        raced = race(mission, len(places), trials, aim, run_cells)
    else:
        samples = run_cells([(cell, *block) for cell in range(len(places)) for block in sized_blocks(trials)])
        raced = Race(samples, frozenset(), trials * len(places))
    best = find_best(_cells(mission, places, raced), [sample.columns for sample in raced.trials], aim)
    return Exploration(
        provenance=run.provenance(
            {
                "vary": list(vary) if not isinstance(vary, str) else [vary],
                **{"aim": aim, "jobs": run.workers.jobs, "only_best": only_best},
                **{"quantity": list(quantities), "trials_run": raced.spent},
            },
            _notices(mission, task),
        ),
        axes=axes,
        cells=best.cells,
        aim=aim,
        best=best.best,
        constrained=best.constrained,
        members=_members(task, axes, raced.trials, best.best, trials),
        assumed=_assumed(task, best.cells, best.best) if best.constrained and mission.requirements else (),
    )


def _cells(mission: Mission, places: Sequence[tuple[int, ...]], raced: Race) -> list[Cell]:
    """Return the cells as their trials have them, of which at least one can be run."""
    cells = [
        replace(
            cell_of(place, mission, sample.columns, sample.reason),
            dropped=number in raced.dropped and not sample.reason,
        )
        for number, (place, sample) in enumerate(zip(places, raced.trials, strict=True))
    ]
    if all(cell.reason for cell in cells):
        reasons = list(dict.fromkeys(cell.reason for cell in cells))
        shown = "; ".join(reasons[:_SHOWN]) + ("; …" if len(reasons) > _SHOWN else "")
        raise InputError([Problem(f"no cell can be run: {shown}", key=OPTION)])
    return cells


def _assumed(task: CellTask, cells: Sequence[Cell], best: int | None) -> tuple[Assumption, ...]:
    return () if best is None else judgement.ledger(task.mission(best), task.seed, None, cells[best].requirements)


def _members(
    task: CellTask, axes: Sequence[Axis], samples: Sequence[CellTrials], best: int | None, trials: int
) -> tuple[MemberOutcome, ...]:
    """Return how the best cell does in each member of the current's ensemble, of the trials that sail in it."""
    recorded = task.current.current
    varied = any(key.startswith("site.") for axis in axes for key in axis.keys)  # then each cell reads its own
    chosen = None if best is None or varied else members_drawn(recorded, task.seed, trials)
    if best is None or chosen is None or chosen.size != samples[best].columns[SUCCESS].size:
        return ()
    success = samples[best].columns[SUCCESS]
    counts = [Count.of(success[chosen == number].astype(bool)) for number in range(len(members_of(recorded)))]
    pairs = zip(members_of(recorded), counts, strict=True)
    return tuple(MemberOutcome(name, weight, count.probability()) for (name, weight), count in pairs if count.trials)


def _columns(mission: Mission, quantities: Sequence[str]) -> tuple[str, ...]:
    """Columns of the trials for the quantities asked for, with energy and duration in front."""
    problems, columns = [], [DURATION, ENERGY]
    labels = [phase.label for phase in mission.phases]
    for quantity in (resolved_path(name, labels, with_sections=False) for name in quantities):
        try:
            quantity_unit(quantity, mission.phases)
            columns.append(requirement_key(mission, quantity)[0])
        except QuantityError as error:
            problems.append(Problem(str(error), key="quantity"))
    if problems:
        raise InputError(problems)
    return tuple(dict.fromkeys(columns))


def _notices(mission: Mission, task: CellTask) -> tuple[str, ...]:
    """Notices of the mission as it is written; of cells, how many cannot be run is in the report."""
    try:
        check_complete(mission)
        return input_notices(mission, Scenario.at_means(mission, task.current.for_mission(mission)))
    except InputError:
        return mission.notices()
