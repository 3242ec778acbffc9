"""A block of trials of a whole mission, phase by phase."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.montecarlo.streams import BlockStreams, NormalSource
from missionplan.phases.state import TrialState
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transit_streams import deployed
from missionplan.studies.simulation.equipment import failing, parts_of
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.phase_trials import (
    Exposure,
    Flags,
    PhaseTrials,
    TrialBlock,
    transit_trials,
    transition_trials,
    where_reached,
)


@dataclass(frozen=True)
class MissionTrials:
    """A block of missions.

    Attributes
    ----------
    phases : tuple of PhaseTrials
    total : mapping of str to array, shape (n,)
        ``duration_s`` and ``energy_wh``; nan for a trial that did not reach the mission's end.
    success : array of bool, shape (n,)
        Every transit arrived, every mooring within its radius and not struck, energy within the capacity.
    draws : mapping of str to array, shape (n,)
        The uncertain quantities of the mission, by key path.
    """

    phases: tuple[PhaseTrials, ...]
    total: Mapping[str, Array]
    success: Flags
    draws: Mapping[str, Array]

    def columns(self) -> dict[str, Array | Flags]:
        """One array a column of the table of trials, shape (n,) each."""
        found: dict[str, Array | Flags] = dict(self.draws)
        for phase in self.phases:
            for values in (phase.inputs, phase.quantities, phase.events):
                found |= {f"{phase.name}.{name}": value for name, value in values.items()}
        return found | {f"total.{name}": value for name, value in self.total.items()} | {"total.success": self.success}


@dataclass(frozen=True)
class MapTracks:
    """Some trials for maps: plain arrays, the phases one after another.

    Attributes
    ----------
    position : array, shape (points, 2, k)
        Tracks [m].
    time : array, shape (points, k)
        Since the mission's start, at the points of the tracks [s].
    points : integers, shape (phases,)
        Points of the tracks that are each phase's.
    anchors : array, shape (2, m)
        On the seafloor [m].
    profile : array, shape (2, corners, k)
        When, since the mission's start, and how deep, straight between [s, m].
    success : array of bool, shape (k,)
        Whether the mission succeeds.
    goals : array, shape (phases, 3)
        Goal, east and north, and arrival radius or mooring radius, at the trials' mean [m].
    """

    position: Array
    time: Array
    points: NDArray[np.int64]
    anchors: Array
    goals: Array
    profile: Array
    success: Flags

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "MapTracks":
        """Read the fields from arrays of their names."""
        return cls(
            position=np.asarray(flat["position"], dtype=float),
            time=np.asarray(flat["time"], dtype=float),
            points=np.asarray(flat["points"], dtype=np.int64),
            anchors=np.asarray(flat["anchors"], dtype=float),
            goals=np.asarray(flat["goals"], dtype=float),
            profile=np.asarray(flat["profile"], dtype=float),
            success=np.asarray(flat["success"], dtype=bool),
        )

    @classmethod
    def of(cls, trials: MissionTrials) -> "MapTracks":
        """Collect them from a block."""
        phases = trials.phases
        position = np.concatenate([phase.track for phase in phases])
        return cls(
            position=position,
            time=np.concatenate([phase.track_time for phase in phases]),
            points=np.array([len(phase.track) for phase in phases]),
            anchors=np.concatenate([phase.anchor for phase in phases], axis=1),
            goals=np.array([(*phase.goal.mean(axis=1), np.mean(phase.radius)) for phase in phases], dtype=float),
            profile=np.concatenate([phase.profile for phase in phases], axis=1),
            success=trials.success[: position.shape[2]],
        )


def run_block(
    scenario: Scenario, seed: int, block: int, trials: int, tracked: int = 0, inputs: bool = True
) -> MissionTrials:
    """Run one block of trials of a run through the mission; see `run_trials`."""
    return run_trials(scenario, BlockStreams(seed, block), trials, tracked, inputs)


def run_trials(
    scenario: Scenario, source: NormalSource, trials: int, tracked: int = 0, inputs: bool = True
) -> MissionTrials:
    """Run trials through the mission.

    Parameters
    ----------
    scenario : Scenario
        With the draws of these trials.
    source : NormalSource
        Of what is drawn each leg or fix; the scenario's draws come from it too.
    trials : int
    tracked : int
        Trials whose tracks are kept.
    inputs : bool
        Whether to sum up what was drawn each leg.

    Raises
    ------
    FloatingPointError
        When a phase divides by zero, overflows or computes nan, or the position or the time of a trial under way is
        not finite.
    """
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        return _run(TrialBlock(scenario, source, tracked, inputs), trials)


def _run(block: TrialBlock, trials: int) -> MissionTrials:
    scenario = block.scenario
    state = _deployed(block, trials)
    goal = state.position
    done: list[PhaseTrials] = []
    parts, exposure = parts_of(block, trials), Exposure()
    for phase in scenario.drawn.phases:
        begun = state
        if isinstance(phase, TransitPhase):
            state, found = transit_trials(block, phase, state)
            goal = found.goal
        elif isinstance(phase, MoorPhase):
            state, found = mooring_trials(block, phase, state, goal)
        else:
            state, found = transition_trials(block, phase, state)
        if parts:
            state, found, exposure = failing(parts, exposure, begun, state, found)
        done.append(found)
    success = np.ones(trials, dtype=bool)
    for found in done:
        for failed in found.failures.values():
            success &= ~failed
    total = {
        "duration_s": where_reached(state.alive, state.clock),
        "energy_wh": where_reached(state.alive, state.energy / JOULES_PER_WATT_HOUR),
    }
    return MissionTrials(tuple(done), total, success, scenario.draws)


def _deployed(block: TrialBlock, trials: int) -> TrialState:
    """Trials at the start of the first phase; at the origin where it has none."""
    scenario = block.scenario
    first = scenario.drawn.phases[0]
    position = np.zeros(2)
    if isinstance(first, TransitPhase) and first.start is not None:
        position = scenario.position(first.start)
    return deployed(scenario, first, position, block.source, trials)
