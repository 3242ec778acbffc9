"""A block of trials through a mooring, as `simulate` takes it."""

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.mooring import MoorRecord, moor
from missionplan.phases.state import TrialState
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.scenario.mooring import moor_plan
from missionplan.scenario.scenario import STILL_WATER
from missionplan.scenario.transit_streams import fix_normals
from missionplan.studies.simulation.phase_trials import (
    OUT_OF_ENERGY,
    Flags,
    PhaseTrials,
    TrialBlock,
    end_exhausted,
    quantities_reached,
    where_reached,
)


def mooring_trials(
    block: TrialBlock, phase: MoorPhase, state: TrialState, goal: Array
) -> tuple[TrialState, PhaseTrials]:
    """Run the trials of a block through a mooring.

    Parameters
    ----------
    block : TrialBlock
    phase : MoorPhase
    state : TrialState
        Where the phase begins.
    goal : array, shape (2, 1) or (2, n)
        Of the transit before [m].
    """
    scenario, begun = block.scenario, state.alive
    plan = moor_plan(scenario, phase)
    after, record = moor(
        plan,
        state,
        fix_normals(f"{phase.name}.fix", block.seed, block.block, state.trials),
        scenario.current or STILL_WATER,
        effects=scenario.descent_effects,
        surface_effects=scenario.transit_effects,
    )
    continuing, exhausted = end_exhausted(after, scenario.capacity)
    moored, ended = begun & record.descent.touched_down, after.alive & ~exhausted
    within, struck = moored & record.within_radius, moored & record.struck
    points = (record.anchor, record.surfaced_at, after.position)
    found = PhaseTrials(
        name=phase.name,
        kind=phase.kind,
        quantities=_quantities(record, goal, begun, moored, after.alive, ended),
        events={"within_radius": within, "struck_seafloor": struck},
        start=where_reached(begun, state.clock),
        end=where_reached(ended, after.clock),
        failures={
            "anchor did not reach the seafloor": begun & ~moored,
            "anchor outside the radius": moored & ~within,
            "struck the seafloor": struck,
            "did not surface": moored & ~record.surfaced,
            OUT_OF_ENERGY: exhausted,
        },
        miss=where_reached(moored, record.anchor - goal),
        track=np.stack([np.where(after.alive, point, np.nan)[:, : block.tracked] for point in points]),
        anchor=where_reached(moored, record.anchor),
        goal=goal,
        radius=plan.radius,
        inputs={},
    )
    return continuing, found


def _quantities(
    record: MoorRecord, goal: Array, begun: Flags, moored: Flags, surfaced: Flags, ended: Flags
) -> dict[str, Array]:
    descent, miss = record.descent, record.anchor - goal
    return quantities_reached(
        {
            "release_time_s": (begun, descent.release_time),
            "payout_time_s": (begun, descent.payout_time),
            "descent_time_s": (moored, descent.descent_time),
            "terminal_velocity_m_s": (begun, descent.terminal_velocity),
            "offset_m": (moored, record.offset_distance),
            "target_offset_m": (moored, np.hypot(miss[0], miss[1])),
            "lowest_altitude_m": (moored, descent.lowest_altitude),
            "ascent_time_s": (surfaced, record.ascent_time),
            "duration_s": (ended, record.duration),
            "energy_wh": (ended, record.energy / JOULES_PER_WATT_HOUR),
        }
    )
