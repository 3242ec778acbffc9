"""The task of a worker: one block. Worker processes import this module, so that it is kept light."""

from dataclasses import dataclass

from missionplan.errors import MissionplanError
from missionplan.montecarlo.streams import BLOCK
from missionplan.scenario.currents.members import members_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.block_sequence import BlockItem, BlockOutcome, BlockResult, FailedBlock
from missionplan.studies.simulation.block_statistics import SAMPLED_BLOCKS, statistics_of_block
from missionplan.studies.simulation.mission_trials import MapTracks, MissionTrials
from missionplan.studies.simulation.trial_block import run_block

TRACKED_TRIALS = 300
"""Trials whose tracks are on maps, the first of the run."""


@dataclass(frozen=True, eq=False)  # hashed by identity: Dask hashes what it runs, and arrays have no hash
class BlockTask:
    """Runs a block, in this process or another; it holds everything that it needs.

    Attributes
    ----------
    means : Scenario
        The mission at its means, with the site's current where it is read from a file, which workers need not reach.
    seed : int
    keep_trials : bool
        Whether to return one row a trial too.
    """

    means: Scenario
    seed: int
    keep_trials: bool = False

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
        tracked = TRACKED_TRIALS if block == 0 else 0
        try:
            trials = self.trials(block, size, tracked=tracked, inputs=sampled or self.keep_trials)
            reduced = statistics_of_block(self.means.mission, trials, sampled=sampled, members=len(self.members))
        except MissionplanError:
            raise
        except Exception as error:
            first = block * BLOCK
            place = f"block {block} (trials {first} to {first + size - 1}, seed {self.seed})"
            return FailedBlock(f"{place}: {type(error).__name__}: {error}")
        rows = trials.columns() if self.keep_trials else {}
        return BlockResult(reduced, rows, MapTracks.of(trials) if tracked else None)
