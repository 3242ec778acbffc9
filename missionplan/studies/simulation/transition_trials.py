"""A block of trials through a transition phase, as `simulate` takes it."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.phases.state import TrialState
from missionplan.phases.transition.simulation import simulate_transition
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transition import manoeuvre, transition_vehicle
from missionplan.studies.simulation.mission_trials import PhaseTrials

JOULES_PER_WATT_HOUR = 3600.0


def transition_trials(
    scenario: Scenario, phase: TransitionPhase, state: TrialState, tracked: int
) -> tuple[TrialState, PhaseTrials]:
    """Slow every trial of a block down to hover, where it is.

    Energy is that of the tunnel thrusters until the vehicle hovers, and of the hotel load where the mission has one;
    the propeller's own is left out, as in the paper. A vehicle that does not come to hover fails.

    Parameters
    ----------
    scenario : Scenario
        With the block's draws.
    phase : TransitionPhase
    state : TrialState
        Where the phase begins.
    tracked : int
        Trials whose place is kept.
    """
    record = simulate_transition(transition_vehicle(scenario, phase), manoeuvre(scenario, phase))
    hotel = scenario.energy("hotel")
    duration = _each(record.hover_time, state)
    spent = _each(record.energy_to_hover, state) + duration * (hotel if np.all(np.isfinite(hotel)) else 0.0)
    hovering = state.alive & np.isfinite(duration)
    after = replace(
        state,
        clock=state.clock + np.where(hovering, duration, 0.0),
        energy=state.energy + np.where(hovering, spent, 0.0),
        alive=hovering,
    )
    reached = {
        "depth_excursion_m": (state.alive, record.depth_excursion),
        "pitch_excursion_rad": (state.alive, record.pitch_excursion),
        "hover_time_s": (hovering, duration),
        "duration_s": (hovering, duration),
        "energy_wh": (hovering, spent / JOULES_PER_WATT_HOUR),
    }
    found = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities={name: np.where(mask, _each(values, state), np.nan) for name, (mask, values) in reached.items()},
        events={"hovering": hovering},
        start=np.where(state.alive, state.clock, np.nan),
        end=np.where(hovering, after.clock, np.nan),
        failures={"did not come to hover": state.alive & ~hovering},
        miss=np.full((2, state.trials), np.nan),
        track=np.where(hovering, state.position, np.nan)[None, :, :tracked],
        anchor=np.empty((2, 0)),
        goal=state.position,
        radius=0.0,
        inputs={},
    )
    return after, found


def _each(values: Scalars, state: TrialState) -> Array:
    """One value a trial, where no draw made them differ too."""
    return np.array(np.broadcast_to(values, (state.trials,)), dtype=float)
