"""Blocks of a run, run anywhere, merged in their order and kept; ended where the result is as precise as required."""

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, MissionplanError, Problem, RunError
from missionplan.mission import Mission
from missionplan.mission.checks.sections import quantity_unit
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.montecarlo.blocks import Progress
from missionplan.montecarlo.streams import BLOCK
from missionplan.results.failures import Counted
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import members_of
from missionplan.store.checkpoints import Checkpoints, kept_or_run
from missionplan.studies.simulation.block_statistics import (
    SAMPLED_BLOCKS,
    SCALES,
    BlockStatistics,
    requirement_key,
    statistics_of_block,
    with_prefix,
)
from missionplan.studies.simulation.trial_block import TRACKED_TRIALS, MapTracks, MissionTrials, run_block

if TYPE_CHECKING:
    from missionplan.store.checkpoints import TrialsTable


_Z95 = 1.959963984540054
SUCCESS = "success"
_OPTION = "precision"


@dataclass(frozen=True)
class Precision:
    """A standard error to be reached."""

    key: str
    """Column of the statistics, such as ``moor.offset_m`` or ``total.success``."""
    error: float
    """In the results' unit, or a share of the mean."""
    relative: bool
    is_event: bool
    """Whether `error` is a share of the mean; whether it is that of a probability."""
    text: str = field(default="", compare=False)
    """As written."""

    @classmethod
    def parse(cls, text: str, mission: Mission) -> "Precision":
        """Read ``0.5%`` (of P(success)), ``success=0.002``, ``total.duration=0.5%`` or ``moor.offset=0.1 m``.

        Raises InputError when the mission has no such quantity, or the number cannot be read.
        """
        name, _, wanted = text.rpartition("=")
        name, wanted = name.strip() or SUCCESS, wanted.strip()
        quantity = f"total.{SUCCESS}" if name == SUCCESS else name
        try:
            unit = quantity_unit(quantity, mission.phases)  # none of an event
        except QuantityError as problem:
            raise InputError([Problem(str(problem), key=_OPTION)]) from None
        share = wanted.endswith("%")
        try:
            if share or unit is None:
                error = float(wanted.removesuffix("%")) / (100.0 if share else 1.0)
            else:
                error = parse_number_with_unit(float(wanted) if unit == "" else wanted, unit) * SCALES.get(unit, 1.0)
        except (ValueError, QuantityError) as problem:
            hint = "such as 0.5%, success=0.002 or moor.offset=0.1 m"
            raise InputError([Problem(f"given {text!r}: {problem}", key=_OPTION, hint=hint)]) from None
        if not 0.0 < error < math.inf:
            raise InputError([Problem(f"given {text!r}, expected more than 0", key=_OPTION)])
        key, _ = requirement_key(mission, quantity)
        return cls(key, error, relative=share and unit is not None, is_event=unit is None, text=text)

    def is_reached(self, totals: BlockStatistics) -> bool:
        """Whether the standard error is below the required one.

        Of a probability, a quarter of Wilson's 95 % interval (Wilson 1927, J. Am. Stat. Assoc. 22, 209–212) takes the
        place of √(p(1 − p)/n), which is 0 as long as p is 0 or 1.
        """
        if self.is_event:
            probability = totals.counts[Counted.event(self.key)].probability()
            return (probability.high - probability.low) / (2.0 * _Z95) < self.error
        statistic = totals.statistics[self.key].moments
        limit = self.error * (abs(float(statistic.mean)) if self.relative else 1.0)
        return bool(float(statistic.standard_error) < limit)


BlockItem = tuple[int, int]
"""A block and how many of its trials are used."""


@dataclass(frozen=True)
class BlockResult:
    """A finished block."""

    totals: BlockStatistics
    rows: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    """Columns of the table of trials, where asked for, shape (n,)."""
    tracks: MapTracks | None = None
    trials: MissionTrials | None = None
    """Of the run's first block, with the tracks of all; a file does not hold them."""

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


BlockOutcome = BlockResult | str
"""A finished block, or why it failed."""
RunBlocks = Callable[[Sequence[BlockItem]], Generator[BlockOutcome, None, None]]
"""Runs blocks and yields their outcomes in the order given."""


@dataclass(frozen=True)
class MergedBlocks:
    """All blocks of a run."""

    totals: BlockStatistics
    """Of the blocks that did not fail."""
    failures: tuple[str, ...]
    """Why the others did."""
    first: BlockItem
    """First block that did not fail."""
    tracks: MapTracks | None
    """Its tracks, where it has any."""
    trials: MissionTrials | None
    """Of the run's first block, where it was run and not read."""


def run_sequence(
    items: Sequence[BlockItem],
    run_blocks: RunBlocks,
    store: Checkpoints | None = None,
    goal: Precision | None = None,
    table: "TrialsTable | None" = None,
    progress: Progress | None = None,
) -> MergedBlocks:
    """Run blocks until all are done or the result is precise enough.

    `items`: ascending. `store`: where finished blocks are kept. `goal`: ends the run early. `table`: takes the rows.
    Raises RunError when every block failed, or the checkpoint cannot be written.
    """
    merged: MergedBlocks | None = None
    failures: list[str] = []
    form = (lambda block: None if isinstance(block, str) else block.to_arrays()), BlockResult.from_arrays
    with closing(kept_or_run(items, run_blocks, store, lambda item: item, form, progress)) as blocks:
        for item, block in blocks:
            if isinstance(block, str):
                failures.append(block)
                continue
            totals = block.totals if merged is None else merged.totals.merge(block.totals)
            if merged is None:
                merged = MergedBlocks(totals, tuple(failures), item, block.tracks, block.trials)
            merged = replace(merged, totals=totals)
            if table is not None:
                table.add(item[0] * BLOCK, block.rows)
            if goal is not None and goal.is_reached(totals):
                break
    if merged is None:
        raise RunError("\n".join(["every block of trials failed:", *failures[:10]]))
    return replace(merged, failures=tuple(failures))


@dataclass(frozen=True, eq=False)  # hashed by identity: Dask hashes what it runs, and arrays have no hash
class BlockTask:
    """Runs a block, in this process or another; it holds everything that it needs."""

    means: Scenario
    """The mission at its means, with the site's current where it is read from a file, which workers need not reach."""
    seed: int
    keep_trials: bool = False
    """Whether to return one row a trial too."""

    @property
    def members(self) -> tuple[tuple[str, float], ...]:
        """Names and probabilities of the members of the current's ensemble; none where it is none."""
        return members_of(self.means.recorded)

    def trials(self, block: int, size: int, *, tracked: int = 0, inputs: bool = True) -> MissionTrials:
        """Run one block."""
        scenario = self.means.sampled(seed=self.seed, block=block, size=size)
        return run_block(scenario, self.seed, block, size, tracked, inputs)

    def tracks(self, block: int, size: int) -> MapTracks:
        """Run one block for its tracks."""
        return MapTracks.of(self.trials(block, size, tracked=TRACKED_TRIALS, inputs=False))

    def __call__(self, item: BlockItem) -> BlockOutcome:
        """Run one block and reduce it; a numerical failure is returned, not raised, so that other blocks go on."""
        (block, size), sampled = item, item[0] < SAMPLED_BLOCKS
        tracked = size if block == 0 else 0
        try:
            trials = self.trials(block, size, tracked=tracked, inputs=sampled or self.keep_trials)
            reduced = statistics_of_block(self.means.mission, trials, sampled=sampled, members=len(self.members))
        except MissionplanError:
            raise
        except Exception as error:
            first = block * BLOCK
            place = f"block {block} (trials {first} to {first + size - 1}, seed {self.seed})"
            return f"{place}: {type(error).__name__}: {error}"
        rows = trials.columns() if self.keep_trials else {}
        return BlockResult(reduced, rows, MapTracks.of(trials), trials) if tracked else BlockResult(reduced, rows)
