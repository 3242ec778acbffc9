"""Cells of an exploration: the mission with other values, blocks of its trials, and the run of all of them."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property, partial
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, MissionplanError
from missionplan.identity import Identity
from missionplan.mission import Mission
from missionplan.montecarlo.blocks import Workers
from missionplan.montecarlo.streams import CommonStreams
from missionplan.phases.currents import Current
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.results.decision import Axis
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import current_source, is_netcdf, recorded_current
from missionplan.store.checkpoints import Checkpoints, kept_or_run
from missionplan.studies.exploration import first_start
from missionplan.studies.held_vehicle import check_dives
from missionplan.studies.run import identified
from missionplan.studies.simulation import check_complete
from missionplan.studies.simulation.block_statistics import requirement_flags
from missionplan.studies.simulation.trial_block import run_trials


@dataclass(frozen=True)
class SharedCurrent:
    """A record of the current, read for one mission."""

    current: Current | None
    """None where missions have none, or each reads its own."""
    place: Mapping[str, object]
    """What the record depends on besides the start; a mission with anything else reads its own."""
    start: datetime | None
    """Of the mission that it was read for."""
    moves: bool
    """Whether a later start meets a later part of it."""

    @classmethod
    def of(cls, mission: Mission, first: datetime | None = None) -> "SharedCurrent":
        """Read a mission's record. A field has dates; others show by a second start whether they are tied to the clock.

        `first`: earliest start of all: what is read begins there, and may hold nothing from before.
        """
        if mission.start is None or first is None:
            return cls(recorded_current(mission), _place(mission), mission.start, moves=False)
        hour = timedelta(hours=1)
        starts = ({"start": moment.isoformat()} for moment in (first, first + hour))
        early, later = map(mission.with_written, starts)
        current = recorded_current(early)
        written = current_source(mission)
        if written is not None and all(is_netcdf(name) for name in written.members):  # a field
            return cls(current, _place(mission), early.start, moves=True)
        shifted = recorded_current(later)
        if not isinstance(current, RecordedCurrent) or not isinstance(shifted, RecordedCurrent):
            return cls(None, {}, None, moves=False)  # each start reads its own
        by = float(current.time[-1] - shifted.time[-1])
        if not math.isclose(by, hour.total_seconds()) and by != 0.0:
            return cls(None, {}, None, moves=False)  # cut to the mission's time: each start reads its own part
        return cls(current, _place(mission), early.start, moves=by != 0.0)

    def for_mission(self, mission: Mission) -> Current | None:
        """Return the record as a mission with another start meets it; read anew for a mission at another place."""
        if _place(mission) != self.place:
            return recorded_current(mission)
        current = self.current
        if not self.moves or not isinstance(current, RecordedCurrent) or mission.start is None or self.start is None:
            return current
        later = (mission.start - self.start).total_seconds()
        return current.later(later) if later else current


def _place(mission: Mission) -> dict[str, object]:
    """What is read about: the record itself, and where the mission goes."""
    site, goes = mission.raw.get("site"), [(phase.start, phase.to) for phase in mission.transits]
    keys = ("current", "origin", "depth")
    return {"goes": goes} | ({key: site.get(key) for key in keys} if isinstance(site, Mapping) else {})


CellItem = tuple[int, int, int]
"""A cell, a block of its trials, and how many of the block's trials are used."""
LEFT_RECORD = "left_record"
SUCCESS = "total.success"
Columns = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True)
class CellTrials:
    """Trials of a cell, or a block of them: `total.success`, each requirement, what left the record, quantities."""

    columns: Columns
    reason: str = ""
    """Why its mission cannot be run, where it cannot: there are no trials then."""


@dataclass(frozen=True, eq=False)  # hashed by identity, as Dask asks for
class MissionTask:
    """Runs a block of one of several missions, in this process or another."""

    missions: Sequence[Mission]
    currents: Sequence[SharedCurrent]
    seed: int
    """The same for all: common random numbers."""
    quantities: tuple[str, ...]
    """Columns to return besides success and requirements, such as ``total.energy_wh``."""

    def scenario(self, cell: int) -> Scenario:
        """Return one of the missions at its means, checked; raises InputError where it is not valid."""
        return checked_means(self.missions[cell], self.currents[cell])

    @cached_property
    def _streams(self) -> CommonStreams:
        return CommonStreams(self.seed)

    def __call__(self, item: CellItem) -> CellTrials:
        """Run one block; what is wrong with its mission is returned, not raised, so that others go on."""
        cell, block, size = item
        try:
            means, source = self.scenario(cell), self._streams.of_block(block)
            trials = run_trials(means.sampled_from(source, size), source, size, inputs=False)
        except InputError as error:
            # without the file, which is that of every cell
            reasons = (
                f"{problem.key}: {problem.message}" if problem.key else problem.message for problem in error.problems
            )
            return CellTrials({}, "; ".join(reasons))
        except MissionplanError:
            raise
        except Exception as error:
            return CellTrials({}, f"block {block}: {type(error).__name__}: {error}")
        columns = trials.columns()
        met = requirement_flags(means.mission, columns)
        flags = {SUCCESS: trials.success, **{str(counted): flags for counted, flags in met.items()}}
        left = [phase.limits[LEFT_RECORD] for phase in trials.phases if LEFT_RECORD in phase.limits]
        if left and means.current is not None and means.current.is_binding:
            flags[LEFT_RECORD] = np.any(left, axis=0)
        return CellTrials(flags | {name: columns[name] for name in self.quantities})


@dataclass(frozen=True, eq=False)
class CellTask(MissionTask):
    """Runs a block of a cell: of one mission with other values at some key paths."""

    COMMAND: ClassVar[str] = "explore"

    cells: Sequence[Mapping[str, object]]
    """Values by key path that each cell puts in their places."""

    @classmethod
    def of(cls, mission: Mission, axes: Sequence[Axis], seed: int, columns: tuple[str, ...]) -> Self:
        """Lay out the cells of one or two axes, the last running fastest."""
        pairs = [[(axis.keys, value) for value in axis.values] for axis in axes]
        cells = [{key: value for keys, value in cell for key in keys} for cell in itertools.product(*pairs)]
        return cls([mission], [SharedCurrent.of(mission, first_start(axes))], seed, columns, cells)

    @property
    def current(self) -> SharedCurrent:
        """Record of the current that the cells share."""
        return self.currents[0]

    def identity(self, mission: Mission, axes: Sequence[Axis]) -> Identity:
        """Everything that a finished block depends on; not how many trials there are."""
        values = [{"keys": axis.name, "values": list(axis.values)} for axis in axes]
        options = {"command": self.COMMAND, "columns": list(self.quantities), "vary": values}
        return Identity.of(identified(mission), options, self.seed)

    def mission(self, cell: int) -> Mission:
        """Return the mission of a cell; raises InputError where it is not valid."""
        return self.missions[0].with_written(self.cells[cell])

    def scenario(self, cell: int) -> Scenario:
        """Return the mission of a cell at its means, checked."""
        return checked_means(self.mission(cell), self.current)


def checked_means(mission: Mission, current: SharedCurrent) -> Scenario:
    """Return a mission at its means; raises InputError where it cannot be run."""
    check_complete(mission)
    means = Scenario.at_means(mission, current.for_mission(mission))
    check_dives(means)
    return means


MAX_BLOCKS = 100_000
"""Blocks of one cell: a checkpoint numbers the blocks of all cells in one sequence."""
_REASON = "reason"


def cell_trials(
    task: Callable[[CellItem], CellTrials],
    items: Sequence[CellItem],
    cells: Sequence[int],
    workers: Workers,
    store: Checkpoints | None = None,
) -> list[CellTrials]:
    """Run the blocks that are not in the checkpoint, and return the trials of each of some cells.

    `task`: runs a block of a cell. `items`: in any order; the blocks of a cell ascend. `workers`: told the trials done.
    `store`: where finished blocks are kept.
    """
    gathered: dict[int, list[CellTrials]] = {cell: [] for cell in cells}
    run, form = partial(workers.quiet.run, task), (_arrays_of, _from_arrays)
    with closing(kept_or_run(items, run, store, _numbered, form, workers.progress)) as blocks:
        for item, block in blocks:
            gathered[item[0]].append(block)
    return [_joined(gathered[cell]) for cell in cells]


def _numbered(item: CellItem) -> tuple[int, int]:
    cell, block, size = item
    return cell * MAX_BLOCKS + block, size


def _arrays_of(block: CellTrials) -> Columns:
    return {_REASON: np.array(block.reason)} if block.reason else block.columns


def _from_arrays(arrays: Columns) -> CellTrials:
    return CellTrials({}, str(arrays[_REASON])) if _REASON in arrays else CellTrials(arrays)


def _joined(blocks: Sequence[CellTrials]) -> CellTrials:
    invalid = [block for block in blocks if block.reason]
    if invalid:
        return invalid[0]
    parts = [block.columns for block in blocks]
    return CellTrials({name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {})
