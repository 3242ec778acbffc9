"""Transit by dead reckoning in legs, with fixes at the surface between them: Briggs et al., section IV, Eqs. 18–24.

A leg of at most d_max aims at the target (Eqs. 18–20), or off it by the drift that the vehicle expects
(Eqs. 21–23, see `compensation`). Its velocity error is drawn once (Eq. 24). At its end the vehicle surfaces, takes a
fix, drifts with the surface layer for the surfacing time, and takes a fix on diving, on which arrival is judged and
from which the next leg starts. Checked against an integral equation (`expectation`) for σ/U from 0.005 to 0.4.
"""

import numpy as np

from missionplan.phases.state import TrialState
from missionplan.phases.transit.execution import ExecutedLegLoop, Execution
from missionplan.phases.transit.leg_loop import LegLoop
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, TransitRecord, column


def transit(
    plan: TransitPlan,
    state: TrialState,
    normals: TransitNormals,
    environment: Environment | None = None,
    *,
    tracked: int = 0,
    execution: Execution | None = None,
) -> tuple[TrialState, TransitRecord]:
    """Take a block of trials through a transit.

    Trials that have failed before stay where they are and do not arrive; trials that start within the arrival radius
    have arrived without a leg. A trial that meets ground, land or a zone stops there.

    Parameters
    ----------
    plan : TransitPlan
    state : TrialState
        At the fix before the first dive.
    normals : TransitNormals
    environment : Environment, optional
        Default: still water, no compensation, no effects.
    tracked : int
        Number of trials, the first ones, whose tracks are kept.
    execution : Execution, optional
        Of a vehicle that goes by other rules than the plan's; with its time at the surface in the plan.

    Returns
    -------
    state, record : TrialState, TransitRecord
    """
    run = plan, state, normals, environment or Environment(), tracked
    legs = LegLoop(*run) if execution is None else ExecutedLegLoop(execution, *run)
    for number in range(plan.max_legs):
        if legs.all_arrived:
            break
        legs.run(number)
    end = legs.final_state()
    under_way, at_surface = plan.time_under_way(end.distance, end.surfacings), end.surfacings * plan.surfacing_time
    energy = under_way * plan.power_under_way + at_surface * plan.power_at_surface
    energy += end.surfacings * plan.surfacing_energy
    lost = end.left_record & ~(end.under_way & end.outrun)  # what cannot stem the current drifts off any record
    current = environment.current if environment is not None else None
    arrived = state.alive & ~end.under_way & ~end.contact.met
    if isinstance(legs, ExecutedLegLoop):
        arrived &= legs.arrived(under_way + at_surface)
    if current is not None and current.is_binding:
        arrived &= ~lost
    record = TransitRecord(
        duration=under_way + at_surface,
        surfacings=end.surfacings,
        distance=end.distance,
        arrival_error=np.sqrt(end.position[0] ** 2 + end.position[1] ** 2),
        energy=energy,
        arrived=arrived,
        outrun=end.outrun,
        left_record=lost,
        contact=end.contact,
        track=legs.track(),
        track_time=legs.track_time(),
    )
    goal = column(plan.goal)
    clock, used = state.clock + record.duration, state.energy + energy
    return TrialState(end.position + goal, end.fix + goal, clock, used, arrived), record
