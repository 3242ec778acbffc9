"""One block of trials through all phases of a mission, each from the state in which the last one left it."""

import numpy as np

from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.montecarlo.streams import BlockStreams, NormalSource
from missionplan.phases.state import TrialState
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transit_streams import deployed
from missionplan.studies.simulation.mission_trials import MissionTrials
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.phase_trials import PhaseTrials, TrialBlock, where_reached
from missionplan.studies.simulation.transit_trials import transit_trials
from missionplan.studies.simulation.transition_trials import transition_trials


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
    for phase in scenario.drawn.phases:
        if isinstance(phase, TransitPhase):
            state, found = transit_trials(block, phase, state)
            goal = found.goal
        elif isinstance(phase, MoorPhase):
            state, found = mooring_trials(block, phase, state, goal)
        else:
            state, found = transition_trials(block, phase, state)
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
