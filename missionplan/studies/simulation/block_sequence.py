"""The blocks of a run in their order, from the checkpoint or from the workers, merged as they come."""

import contextlib
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import RunError
from missionplan.montecarlo.parallel.blocks import Progress
from missionplan.montecarlo.streams import BLOCK
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.simulation.block_statistics import BlockStatistics, with_prefix
from missionplan.studies.simulation.mission_trials import MapTracks
from missionplan.studies.simulation.precision import Precision

if TYPE_CHECKING:  # workers import this module: pandas takes half a second
    from missionplan.store.trials_table import TrialsTable

BlockItem = tuple[int, int]
"""A block and how many of its trials are used."""


@dataclass(frozen=True)
class BlockResult:
    """A finished block.

    Attributes
    ----------
    totals : BlockStatistics
    rows : mapping of str to array, shape (n,)
        Columns of the table of trials, where asked for.
    tracks : MapTracks or None
    """

    totals: BlockStatistics
    rows: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    tracks: MapTracks | None = None

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Flatten into named arrays, for a file."""
        rows = {f"row/{name}": values for name, values in self.rows.items()}
        tracks = {f"shown/{name}": values for name, values in vars(self.tracks).items()} if self.tracks else {}
        return {**self.totals.to_arrays(), **rows, **tracks}

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "BlockResult":
        """Read what `to_arrays` wrote."""
        rows, tracks = with_prefix(flat, "row/"), with_prefix(flat, "shown/")
        return cls(BlockStatistics.from_arrays(flat), rows, MapTracks.from_arrays(tracks) if "time" in tracks else None)


@dataclass(frozen=True)
class FailedBlock:
    """A block that failed, and why."""

    reason: str


BlockOutcome = BlockResult | FailedBlock
RunBlocks = Callable[[Sequence[BlockItem]], Generator[BlockOutcome, None, None]]
"""Runs blocks and yields their outcomes in the order given."""


@dataclass(frozen=True)
class MergedBlocks:
    """All blocks of a run.

    Attributes
    ----------
    totals : BlockStatistics
        Of the blocks that did not fail.
    failures : tuple of str
        Why the others did.
    first : BlockItem
        First block that did not fail.
    tracks : MapTracks or None
        Its tracks, where it has any.
    """

    totals: BlockStatistics
    failures: tuple[str, ...]
    first: BlockItem
    tracks: MapTracks | None


@dataclass(frozen=True)
class BlockSequence:
    """A run.

    Attributes
    ----------
    items : sequence of BlockItem
        All blocks, ascending.
    store : Checkpoints or None
        Where finished blocks are kept.
    goal : Precision or None
        Ends the run early.
    table : TrialsTable or None
        Takes the rows.
    """

    items: Sequence[BlockItem]
    store: Checkpoints | None = None
    goal: Precision | None = None
    table: "TrialsTable | None" = None

    def run(self, run_blocks: RunBlocks, progress: Progress | None = None) -> MergedBlocks:
        """Run until all blocks are done or the result is precise enough.

        Raises
        ------
        RunError
            When every block failed, or the checkpoint cannot be written.
        """
        merged: MergedBlocks | None = None
        failures: list[str] = []
        with contextlib.closing(self._blocks(run_blocks)) as blocks:
            for item, block in self._counted(blocks, progress):
                if isinstance(block, FailedBlock):
                    failures.append(block.reason)
                    continue
                totals = block.totals if merged is None else merged.totals.merge(block.totals)
                first, tracks = (item, block.tracks) if merged is None else (merged.first, merged.tracks)
                merged = MergedBlocks(totals, tuple(failures), first, tracks)
                if self.table is not None:
                    self.table.add(item[0] * BLOCK, block.rows)
                if self.goal is not None and self.goal.is_reached(totals):
                    break
        if merged is None:
            raise RunError("\n".join(["every block of trials failed:", *failures[:10]]))
        return replace(merged, failures=tuple(failures))

    def _counted(
        self, blocks: Iterable[tuple[BlockItem, BlockOutcome]], progress: Progress | None
    ) -> Iterator[tuple[BlockItem, BlockOutcome]]:
        """Report the trials that are done."""
        done, trials = 0, sum(size for _, size in self.items)
        if progress is not None:
            progress(0, trials)
        for item, block in blocks:
            done += item[1]
            if progress is not None:
                progress(done, trials)
            yield item, block

    def _blocks(self, run_blocks: RunBlocks) -> Generator[tuple[BlockItem, BlockOutcome], None, None]:
        kept = self.store.intact(self.items) if self.store is not None else set()
        todo = [item for item in self.items if item not in kept]
        with contextlib.closing(run_blocks(todo)) as fresh:
            for item in self.items:
                block: BlockOutcome | None = self._stored(item) if item in kept else None
                if block is None and item in kept:  # it has been damaged or taken away meanwhile
                    block = next(run_blocks([item]))
                    self._keep(item, block)
                elif block is None:
                    block = next(fresh)
                    self._keep(item, block)
                yield item, block

    def _stored(self, item: BlockItem) -> BlockResult | None:
        arrays = self.store.read(*item) if self.store is not None else None
        return None if arrays is None else BlockResult.from_arrays(arrays)

    def _keep(self, item: BlockItem, block: BlockOutcome) -> None:
        if self.store is not None and isinstance(block, BlockResult):
            self.store.write(*item, block.to_arrays())
