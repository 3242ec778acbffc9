"""Many dives with one anchor, on random numbers common to all anchors."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.schema.sweep import Requirement
from missionplan.mission.views import MooringMission
from missionplan.montecarlo.parallel.blocks import IN_THIS_PROCESS, Workers
from missionplan.montecarlo.statistics import Count, RunningStatistic
from missionplan.montecarlo.streams import BlockStreams, block_count, block_size, stream
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TrialState
from missionplan.results.sized_anchor import DiveProbabilities
from missionplan.scenario.phases import start_of
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.block_statistics import requirement_flags
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.outcome_builder import requirement_outcome
from missionplan.studies.simulation.phase_trials import Flags, TrialBlock


@dataclass(frozen=True)
class _Totals:
    """Merged dives: counts by name, and statistics of those that landed."""

    counts: Mapping[str, Count]
    offset: RunningStatistic
    lowest: RunningStatistic

    def merge(self, other: "_Totals") -> "_Totals":
        counts = {name: count.merge(other.counts[name]) for name, count in self.counts.items()}
        return _Totals(counts, self.offset.merge(other.offset), self.lowest.merge(other.lowest))


@dataclass(frozen=True)
class AnchorTrials:
    """Dives of a mission's mooring from the planned fix, each trial with the same draws for every anchor.

    Attributes
    ----------
    mission : Mission
    trials, seed : int
    workers : Workers
    """

    mission: Mission
    phase: str
    """The mooring's name."""
    recorded: Current | None
    """The site's current where the mission reads it from a file."""
    trials: int
    seed: int
    workers: Workers = IN_THIS_PROCESS

    @property
    def counts_holding(self) -> bool:
        """Whether an anchor must also hold: where the vehicle file says how it does."""
        return MooringMission.of(self.mission).anchor.holding_factor is not None

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """What the mission requires of this mooring."""
        return tuple(item for item in self.mission.requirements if item.quantity.rpartition(".")[0] == self.phase)

    def probabilities(self, weight: float, line_length: float | None = None) -> DiveProbabilities:
        """Estimate the probabilities of an anchor of a wet weight [N], with another line [m] if one is given."""
        task = partial(_block, replace(self, workers=IN_THIS_PROCESS), weight, line_length)
        totals = reduce(_Totals.merge, self.workers.run(task, range(block_count(self.trials))))
        shares = {name: count.probability() for name, count in totals.counts.items()}
        return DiveProbabilities(
            good=shares["good"],
            within=shares["within_radius"],
            holds=shares["anchor_holds"] if self.counts_holding else None,
            struck=shares["struck_seafloor"],
            offset=totals.offset.statistic(),
            lowest_altitude=totals.lowest.statistic(),
            requirements=tuple(
                requirement_outcome(self.mission, item, totals.counts[f"requirement {index}"])
                for index, item in enumerate(self.requirements)
            ),
        )


def _block(study: AnchorTrials, weight: float, line_length: float | None, block: int) -> _Totals:
    """Dive with one block of trials; a dive is good where the mooring fails in no way."""
    size, source = block_size(study.trials, block), BlockStreams(study.seed, block)
    scenario = Scenario.at_means(study.mission, study.recorded).sampled_from(source, size)
    phase = scenario.moor(study.phase)
    length = phase.line_length if line_length is None else line_length
    phase = phase.model_copy(update={"anchor_wet_weight": weight, "line_length": length})
    place, start = start_of(scenario, phase)
    position = np.broadcast_to(place.reshape(2, -1), (2, size))
    fix_error = scenario.fix_sd * stream(study.seed, f"{study.phase}.fix", block).standard_normal((2, size))
    state = TrialState(
        position=position,
        fix=position + fix_error,
        clock=np.full(size, start),
        energy=np.zeros(size),
        alive=np.ones(size, dtype=bool),
    )
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        _, done = mooring_trials(TrialBlock(scenario, source, 0, inputs=False), phase, state, place.reshape(2, -1))
    columns: dict[str, Array | Flags] = {f"{phase.name}.{name}": values for name, values in done.quantities.items()}
    columns |= {f"{phase.name}.{name}": values for name, values in done.events.items()}
    flags = requirement_flags(study.mission.model_copy(update={"requirements": study.requirements}), columns)
    good = ~np.logical_or.reduce(list(done.failures.values()))
    return _Totals(
        {name: Count.of(trials) for name, trials in {"good": good, **done.events, **flags}.items()},
        RunningStatistic.of(done.quantities["offset_m"]),
        RunningStatistic.of(done.quantities["lowest_altitude_m"]),
    )
