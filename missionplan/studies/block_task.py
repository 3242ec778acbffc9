"""What a worker does with one block; the module that worker processes import, and so kept light."""

from dataclasses import dataclass

from missionplan.errors import MissionplanError
from missionplan.montecarlo.streams import BLOCK
from missionplan.studies.block_sequence import DoneBlock, Item
from missionplan.studies.mission_trials import MissionTrials
from missionplan.studies.setting import Setting
from missionplan.studies.tally import SAMPLED_BLOCKS, tally
from missionplan.studies.trial_block import run_block


@dataclass(frozen=True, eq=False)  # hashed by identity: Dask hashes what it runs, and arrays have no hash
class BlockTask:
    """Runs a block, in this process or another; everything that it needs is in it.

    Attributes
    ----------
    means : Setting
        The mission at its means, with the site's current where it is read from a file, which workers need not reach.
    seed : int
    keep_trials : bool
        Whether a row a trial comes back too.
    """

    means: Setting
    seed: int
    keep_trials: bool = False

    def trials(self, block: int, size: int, tracked: int = 0) -> MissionTrials:
        """Run one block."""
        setting = self.means.sampled(seed=self.seed, block=block, size=size)
        return run_block(setting, self.seed, block, size, tracked)

    def __call__(self, item: Item) -> DoneBlock:
        """Run one block and reduce it; a failure of its numbers is told, not raised, so that others go on."""
        block, size = item
        try:
            trials = self.trials(block, size)
            reduced = tally(self.means.mission, trials, sampled=block < SAMPLED_BLOCKS)
        except MissionplanError:
            raise
        except Exception as error:
            first = block * BLOCK
            place = f"block {block} (trials {first} to {first + size - 1}, seed {self.seed})"
            return DoneBlock(None, failure=f"{place}: {type(error).__name__}: {error}")
        return DoneBlock(reduced, dict(trials.columns()) if self.keep_trials else {})
