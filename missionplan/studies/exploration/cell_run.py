"""Blocks of cells from the checkpoint or from the workers, gathered cell by cell."""

import contextlib
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.montecarlo.parallel.blocks import Workers
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.exploration.cells import CellBlock, CellItem, InvalidCell

MAX_BLOCKS = 100_000
"""Blocks of one cell: a checkpoint numbers the blocks of all cells in one sequence."""
_REASON = "reason"
RunCell = Callable[[CellItem], CellBlock | InvalidCell]


@dataclass(frozen=True)
class CellTrials:
    """All trials of a cell, by column; none where it cannot be run, for a reason."""

    columns: Mapping[str, NDArray[np.generic]]
    reason: str = ""


def cell_trials(
    task: RunCell, items: Sequence[CellItem], cells: Sequence[int], workers: Workers, store: Checkpoints | None = None
) -> list[CellTrials]:
    """Run the blocks that are not in the checkpoint, and return the trials of each of some cells.

    Parameters
    ----------
    task : callable
        Runs a block of a cell.
    items : sequence of CellItem
        In any order; the blocks of a cell ascend.
    cells : sequence of int
    workers : Workers
        Told the trials done.
    store : Checkpoints, optional
        Where finished blocks are kept.
    """
    gathered: dict[int, list[CellBlock | InvalidCell]] = {cell: [] for cell in cells}
    total, done = sum(size for _, _, size in items), 0
    tell = workers.progress or (lambda *_: None)
    with contextlib.closing(_Blocks(task, items, store).run(workers.quiet)) as blocks:
        tell(0, total)
        for item, block in blocks:
            gathered[item[0]].append(block)
            done += item[2]
            tell(done, total)
    return [_joined(gathered[cell]) for cell in cells]


@dataclass(frozen=True)
class _Blocks:
    """Blocks of cells, from the checkpoint or from the workers."""

    task: RunCell
    items: Sequence[CellItem]
    store: Checkpoints | None

    def run(self, workers: Workers) -> Generator[tuple[CellItem, CellBlock | InvalidCell], None, None]:
        numbered = {item: (item[0] * MAX_BLOCKS + item[1], item[2]) for item in self.items}
        kept = self.store.intact(numbered.values()) if self.store is not None else set()
        todo = [item for item in self.items if numbered[item] not in kept]
        with contextlib.closing(workers.run(self.task, todo)) as fresh:  # type: ignore[type-var]
            for item in self.items:
                block = self._stored(numbered[item]) if numbered[item] in kept else None
                if block is None:
                    block = self.task(item) if numbered[item] in kept else next(fresh)
                    self._keep(numbered[item], block)
                yield item, block

    def _stored(self, number: tuple[int, int]) -> CellBlock | InvalidCell | None:
        """Return a finished block; None where it has been damaged or taken away."""
        arrays = self.store.read(*number) if self.store is not None else None
        if arrays is None:
            return None
        return InvalidCell(str(arrays[_REASON])) if _REASON in arrays else CellBlock(arrays)

    def _keep(self, number: tuple[int, int], block: CellBlock | InvalidCell) -> None:
        if self.store is not None:
            arrays = block.columns if isinstance(block, CellBlock) else {_REASON: np.array(block.reason)}
            self.store.write(*number, arrays)


def _joined(blocks: Sequence[CellBlock | InvalidCell]) -> CellTrials:
    invalid = [block.reason for block in blocks if isinstance(block, InvalidCell)]
    if invalid:
        return CellTrials({}, invalid[0])
    parts = [block.columns for block in blocks if isinstance(block, CellBlock)]
    return CellTrials({name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {})
