"""One cell of an exploration: the mission with its values, and a block of its trials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, MissionplanError, Problem
from missionplan.identity import Identity
from missionplan.mission import Mission
from missionplan.montecarlo.common_streams import CommonStreams
from missionplan.results.choosing.axis import Axis
from missionplan.scenario.scenario import Scenario
from missionplan.studies.exploration.key_paths import with_values
from missionplan.studies.exploration.shared_current import SharedCurrent
from missionplan.studies.nominal_dive import check_dives
from missionplan.studies.run import identified
from missionplan.studies.simulation.block_statistics import requirement_flags
from missionplan.studies.simulation.checks import check_complete
from missionplan.studies.simulation.trial_block import run_trials

CellItem = tuple[int, int, int]
"""A cell, a block of its trials, and how many of the block's trials are used."""
LEFT_RECORD = "left_record"
SUCCESS = "total.success"
Columns = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True)
class InvalidCell:
    """A cell whose mission cannot be run, and why."""

    reason: str


@dataclass(frozen=True)
class CellBlock:
    """A block of a cell's trials: by name `total.success`, each requirement, what left the record, quantities."""

    columns: Columns


@dataclass(frozen=True, eq=False)  # hashed by identity, as Dask asks for
class CellTask:
    """Runs a block of a cell, in this process or another.

    Attributes
    ----------
    data : mapping
        The base mission's, with included files in their places.
    cells : sequence of mapping
        Values by key path that each cell puts in their places.
    current : SharedCurrent
    seed : int
        The same for all cells: common random numbers.
    quantities : tuple of str
        Columns to return besides success and requirements, such as ``total.energy_wh``.
    file : str
        How messages name the mission.
    """

    COMMAND: ClassVar[str] = "explore"
    data: Mapping[str, object]
    cells: Sequence[Mapping[str, object]]
    current: SharedCurrent
    seed: int
    quantities: tuple[str, ...]
    file: str

    def identity(self, mission: Mission, axes: Sequence[Axis]) -> Identity:
        """Everything that a finished block depends on; not how many trials there are."""
        values = [{"keys": axis.name, "values": list(axis.values)} for axis in axes]
        options = {"command": self.COMMAND, "columns": list(self.quantities), "vary": values}
        return Identity.of(identified(mission), options, self.seed)

    def mission(self, cell: int) -> Mission:
        """Return the mission of a cell; raises InputError where it is not valid."""
        return Mission.from_data(with_values(self.data, self.cells[cell]), file=self.file)

    def scenario(self, cell: int) -> Scenario:
        """Return the mission of a cell at its means, checked."""
        return checked_means(self.mission(cell), self.current)

    @cached_property
    def _streams(self) -> CommonStreams:
        return CommonStreams(self.seed)

    def __call__(self, item: CellItem) -> CellBlock | InvalidCell:
        """Run one block of a cell; what is wrong with its mission is returned, not raised, so that others go on."""
        return run_checked(self.scenario, self._streams, item, self.quantities)


def checked_means(mission: Mission, current: SharedCurrent) -> Scenario:
    """Return a mission at its means; raises InputError where it cannot be run."""
    check_complete(mission)
    means = Scenario.at_means(mission, current.for_mission(mission))
    check_dives(means)
    return means


def run_checked(
    means_of: Callable[[int], Scenario], streams: CommonStreams, item: CellItem, quantities: Sequence[str]
) -> CellBlock | InvalidCell:
    """Run one block of a mission; what is wrong with it is returned, not raised."""
    cell, block, size = item
    try:
        means, source = means_of(cell), streams.of_block(block)
        trials = run_trials(means.sampled_from(source, size), source, size, inputs=False)
    except InputError as error:
        return InvalidCell("; ".join(_in_short(problem) for problem in error.problems))
    except MissionplanError:
        raise
    except Exception as error:
        return InvalidCell(f"block {block}: {type(error).__name__}: {error}")
    columns = trials.columns()
    flags = {SUCCESS: trials.success, **requirement_flags(means.mission, columns)}
    left = [phase.limits[LEFT_RECORD] for phase in trials.phases if LEFT_RECORD in phase.limits]
    if left and means.current is not None and means.current.is_binding:
        flags[LEFT_RECORD] = np.any(left, axis=0)
    return CellBlock(flags | {name: columns[name] for name in quantities})


def _in_short(problem: Problem) -> str:
    """Return a problem without the file, which is that of every cell."""
    return f"{problem.key}: {problem.message}" if problem.key else problem.message
