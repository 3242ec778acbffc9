"""A block of trials through a transition to hover, as `simulate` takes it."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.phases.state import TrialState
from missionplan.phases.transition.simulation import simulate_transition
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.transition import manoeuvre, transition_vehicle
from missionplan.studies.simulation.phase_trials import (
    OUT_OF_ENERGY,
    PhaseTrials,
    TrialBlock,
    end_exhausted,
    quantities_reached,
    where_reached,
)


def transition_trials(
    block: TrialBlock, phase: TransitionPhase[Scalars], state: TrialState
) -> tuple[TrialState, PhaseTrials]:
    """Slow every trial of a block down to hover, where it is.

    Energy is that of the tunnel thrusters until the vehicle hovers, and of the hotel load where the mission has one;
    the propeller's own is left out, as in the paper. A vehicle that does not reach hover fails.

    Parameters
    ----------
    block : TrialBlock
    phase : TransitionPhase
    state : TrialState
        Where the phase begins.
    """
    scenario = block.scenario
    record = simulate_transition(transition_vehicle(scenario, phase), manoeuvre(phase))
    hotel = scenario.budget.hotel
    duration = _each(record.hover_time, state)
    spent = _each(record.energy_to_hover, state) + duration * (hotel if np.all(np.isfinite(hotel)) else 0.0)
    hovering = state.alive & np.isfinite(duration)
    after = replace(
        state,
        clock=state.clock + np.where(hovering, duration, 0.0),
        energy=state.energy + np.where(hovering, spent, 0.0),
        alive=hovering,
    )
    continuing, exhausted = end_exhausted(after, scenario.capacity)
    quantities = {
        "depth_excursion_m": (state.alive, _each(record.depth_excursion, state)),
        "pitch_excursion_rad": (state.alive, _each(record.pitch_excursion, state)),
        "hover_time_s": (hovering, duration),
        "duration_s": (hovering, duration),
        "energy_wh": (hovering, spent / JOULES_PER_WATT_HOUR),
    }
    found = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=quantities_reached(quantities),
        limits={},
        events={"hovering": hovering},
        start=where_reached(state.alive, state.clock),
        end=where_reached(hovering, after.clock),
        failures={"did not come to hover": state.alive & ~hovering, OUT_OF_ENERGY: exhausted},
        miss=np.full((2, state.trials), np.nan),
        track=where_reached(hovering, state.position)[None, :, : block.tracked],
        track_time=where_reached(hovering, after.clock)[None, : block.tracked],
        anchor=np.empty((2, 0)),
        goal=state.position,
        radius=0.0,
        inputs={},
    )
    return continuing, found


def _each(values: Scalars, state: TrialState) -> Array:
    """One value a trial, also where no draw made them differ."""
    return np.array(np.broadcast_to(values, (state.trials,)), dtype=float)
