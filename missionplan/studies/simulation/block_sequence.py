"""The blocks of a run in their order, from the checkpoint or from the workers, merged as they come."""

import contextlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import RunError
from missionplan.montecarlo.parallel_blocks import Progress
from missionplan.montecarlo.streams import BLOCK
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.simulation.block_statistics import BlockStatistics
from missionplan.studies.simulation.mission_trials import MapTracks
from missionplan.studies.simulation.precision import Precision
from missionplan.studies.simulation.trials_table import TrialsTable

BlockItem = tuple[int, int]
"""A block and how many of its trials are used."""


@dataclass(frozen=True)
class BlockResult:
    """A block that is done: reduced, with a row a trial and what maps show where asked for; or why it failed."""

    totals: BlockStatistics | None
    rows: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    shown: MapTracks | None = None
    failure: str = ""

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Flatten into named arrays, for a file; of a block that did not fail."""
        assert self.totals is not None
        rows = {f"row/{name}": values for name, values in self.rows.items()}
        shown = {f"shown/{name}": values for name, values in vars(self.shown).items()} if self.shown else {}
        return {**self.totals.to_arrays(), **rows, **shown}

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "BlockResult":
        """Read what `to_arrays` wrote."""
        rows, shown = (_under(flat, group) for group in ("row/", "shown/"))
        return cls(BlockStatistics.from_arrays(flat), rows, MapTracks(**shown) if shown else None)


def _under(flat: Mapping[str, NDArray[np.generic]], group: str) -> dict[str, Any]:
    return {name.removeprefix(group): values for name, values in flat.items() if name.startswith(group)}


RunBlocks = Callable[[Sequence[BlockItem]], Generator[BlockResult, None, None]]
"""Runs blocks and yields them in the order given."""


@dataclass
class BlockSequence:
    """A run.

    Attributes
    ----------
    items : sequence of BlockItem
        All blocks, ascending.
    store : Checkpoints or None
        Where finished blocks are kept.
    goal : Precision or None
        What ends the run early.
    table : TrialsTable or None
        Takes the rows.
    first_good : BlockItem
        First block that did not fail, once the run is over.
    shown : MapTracks or None
        What it shows.
    """

    items: Sequence[BlockItem]
    store: Checkpoints | None = None
    goal: Precision | None = None
    table: TrialsTable | None = None
    first_good: BlockItem = (0, 0)
    shown: MapTracks | None = None

    def run(self, fan_out: RunBlocks, progress: Progress | None = None) -> tuple[BlockStatistics, tuple[str, ...]]:
        """Run until all is done or precise enough; give the total, and why blocks failed.

        Raises
        ------
        RunError
            When every block failed, or the checkpoint cannot be written.
        """
        total: BlockStatistics | None = None
        failures: list[str] = []
        done, trials = 0, sum(size for _, size in self.items)
        if progress is not None:
            progress(0, trials)
        with contextlib.closing(self._blocks(fan_out)) as blocks:
            for item, block in blocks:
                done += item[1]
                if progress is not None:
                    progress(done, trials)
                if block.totals is None:
                    failures.append(block.failure)
                    continue
                if total is None:
                    self.first_good, self.shown = item, block.shown
                total = block.totals if total is None else total.merge(block.totals)
                if self.table is not None:
                    self.table.add(item[0] * BLOCK, block.rows)
                if self.goal is not None and self.goal.is_reached(total):
                    break
        if total is None:
            raise RunError("\n".join(["every block of trials failed:", *failures[:10]]))
        return total, tuple(failures)

    def _blocks(self, fan_out: RunBlocks) -> Generator[tuple[BlockItem, BlockResult], None, None]:
        kept = {item for item in self.items if self.store is not None and self.store.holds(*item)}
        todo = [item for item in self.items if item not in kept]
        with contextlib.closing(fan_out(todo)) as fresh:
            for item in self.items:
                block = self._stored(item) if item in kept else None
                if block is None and item in kept:  # it has been damaged or taken away meanwhile
                    block = next(fan_out([item]))
                elif block is None:
                    block = next(fresh)
                    self._keep(item, block)
                yield item, block

    def _stored(self, item: BlockItem) -> BlockResult | None:
        arrays = self.store.read(*item) if self.store is not None else None
        return None if arrays is None else BlockResult.from_arrays(arrays)

    def _keep(self, item: BlockItem, block: BlockResult) -> None:
        if self.store is not None and block.totals is not None:
            self.store.write(*item, block.to_arrays())
