"""Many dives with one anchor, on random numbers common to all anchors."""

from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from missionplan.mission import Mission
from missionplan.mission.views import MooringMission
from missionplan.montecarlo.parallel.blocks import IN_THIS_PROCESS, Workers
from missionplan.montecarlo.statistics import Count, RunningStatistic
from missionplan.montecarlo.streams import block_count, block_size, stream
from missionplan.phases.currents import Current
from missionplan.phases.hooks import surface_velocity
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.hold import hold_vehicle, lifted
from missionplan.results.mooring.sized_anchor import DiveProbabilities
from missionplan.scenario.anchors import laden
from missionplan.scenario.held_vehicle import hold_of
from missionplan.scenario.mooring import dive_of, is_too_shallow, start_of
from missionplan.scenario.scenario import STILL_WATER, Scenario

STEP = 0.2
"""Of the integration [s]; times are then within a tenth of a millisecond, which is enough for probabilities."""


@dataclass(frozen=True)
class _Totals:
    """Merged dives; the statistics are of those that landed."""

    good: Count
    enough: Count
    within: Count
    holds: Count
    struck: Count
    offset: RunningStatistic
    lowest: RunningStatistic

    def merge(self, other: "_Totals") -> "_Totals":
        return _Totals(
            self.good.merge(other.good),
            self.enough.merge(other.enough),
            self.within.merge(other.within),
            self.holds.merge(other.holds),
            self.struck.merge(other.struck),
            self.offset.merge(other.offset),
            self.lowest.merge(other.lowest),
        )


@dataclass(frozen=True)
class AnchorTrials:
    """Dives of a mission's mooring, each trial with the same draws for every anchor.

    Attributes
    ----------
    mission : Mission
    phase : str
        The mooring's name.
    recorded : Current or None
        The site's current where the mission reads it from a file.
    trials, seed : int
    workers : Workers
    """

    mission: Mission
    phase: str
    recorded: Current | None
    trials: int
    seed: int
    workers: Workers = IN_THIS_PROCESS

    @property
    def counts_holding(self) -> bool:
        """Whether an anchor must also hold: where the vehicle file says how it does."""
        return MooringMission.of(self.mission).anchor.holding_factor is not None

    def probabilities(self, weight: float, line_length: float | None = None) -> DiveProbabilities:
        """Estimate the probabilities of an anchor of a wet weight [N], with another line [m] if one is given."""
        task = partial(_block, replace(self, workers=IN_THIS_PROCESS), weight, line_length)
        totals = reduce(_Totals.merge, self.workers.run(task, range(block_count(self.trials))))
        return DiveProbabilities(
            good=totals.good.probability(),
            enough=totals.enough.probability(),
            within=totals.within.probability(),
            holds=totals.holds.probability() if self.counts_holding else None,
            struck=totals.struck.probability(),
            offset=totals.offset.statistic(),
            lowest_altitude=totals.lowest.statistic(),
        )


def _block(study: AnchorTrials, weight: float, line_length: float | None, block: int) -> _Totals:
    """Dive with one block of trials."""
    size = block_size(study.trials, block)
    scenario = Scenario.at_means(study.mission, study.recorded).sampled(seed=study.seed, block=block, size=size)
    phase = scenario.moor(study.phase)
    dive = dive_of(scenario, phase, weight)
    if line_length is not None:
        dive = replace(dive, line_length=line_length)
    release = np.broadcast_to(np.asarray(phase.release_time, dtype=float), (size,))
    place, t_start = start_of(scenario, phase)
    position = np.broadcast_to(place.reshape(2, -1), (2, size))
    start = np.full(size, t_start)
    record = descend(
        dive,
        effects=scenario.descent_effects,
        release_time=release,
        current=scenario.current or STILL_WATER,
        position=position,
        t_start=start,
        surface_velocity=surface_velocity(scenario.effects_afloat, start, release, position),
        step=STEP,
    )
    fix_error = scenario.fix_error * stream(study.seed, f"{study.phase}.fix", block).standard_normal((2, size))
    landed = record.touched_down & ~is_too_shallow(dive, laden(scenario, phase).mooring.vehicle.hull.length)
    offset = np.where(landed, np.hypot(*(record.offset - fix_error)), np.nan)
    within = offset <= phase.radius
    struck, holds = record.struck & landed, landed
    if study.counts_holding:
        hold = hold_of(scenario, phase, weight)
        hold = lifted(replace(hold, line=replace(hold.line, length=dive.line_length)), scenario.descent_effects)
        touchdown = start + release + np.where(landed, record.descent_time, 0.0)
        lasting = phase.hold + phase.galvanic_release
        current = scenario.current or STILL_WATER
        holds = landed & hold_vehicle(hold, current, position + record.offset, touchdown, lasting).anchor_holds
    return _Totals(
        Count.of(within & holds & ~struck),
        Count.of(within & holds),
        Count.of(within),
        Count.of(holds),
        Count.of(struck),
        RunningStatistic.of(offset),
        RunningStatistic.of(np.where(landed, record.lowest_altitude, np.nan)),
    )
