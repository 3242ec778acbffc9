"""One block of trials through all phases of a mission, each from the state in which the last one left it."""

from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.montecarlo.streams import LegNormals
from missionplan.phases.mooring.mooring import moor
from missionplan.phases.state import TrialState
from missionplan.phases.transit.ground_velocity import random_part
from missionplan.phases.transit.plan import (
    Environment,
    Normals,
    TransitNormals,
    TransitPlan,
    TransitRecord,
    column,
)
from missionplan.phases.transit.transit import transit
from missionplan.scenario.mooring import moor_plan
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.studies.simulation.mission_trials import Flags, MissionTrials, PhaseTrials
from missionplan.studies.simulation.transition_trials import transition_trials

JOULES_PER_WATT_HOUR = 3600.0


@dataclass(frozen=True)
class BlockRun:
    """A block under way.

    Attributes
    ----------
    scenario : Scenario
        With the block's draws.
    seed, block : int
        See `montecarlo.streams`.
    tracked : int
        Trials whose tracks are kept.
    inputs : bool
        Whether to sum up what was drawn each leg.
    """

    scenario: Scenario
    seed: int
    block: int
    tracked: int
    inputs: bool

    def normals(self, name: str, trials: int) -> Array:
        """Standard normals of a fix that is taken once, shape (2, n)."""
        return LegNormals(self.seed, name, self.block).leg(0)[:, :trials]

    def run(self, trials: int) -> MissionTrials:
        """Take `trials` trials through the mission."""
        phases = self.scenario.mission.phases
        state = self._deployed(trials)
        goal = state.position
        done: list[PhaseTrials] = []
        for phase in phases:
            if isinstance(phase, TransitPhase):
                state, record, goal = self._transit(phase, state)
            elif isinstance(phase, MoorPhase):
                state, record = self._moor(phase, state, goal)
            else:
                after, record = transition_trials(self.scenario, phase, state, self.tracked)
                state, out = self._spend(after)
                record = replace(record, failures={**record.failures, "out of energy": out})
            done.append(record)
        good = np.ones(trials, dtype=bool)
        for record in done:
            for failed in record.failures.values():
                good &= ~failed
        total = {
            "duration_s": _where(state.alive, state.clock),
            "energy_wh": _where(state.alive, state.energy / JOULES_PER_WATT_HOUR),
        }
        draws = {path: np.asarray(self.scenario[path]) for path in self.scenario.uncertain}
        return MissionTrials(tuple(done), total, good, draws)

    def _deployed(self, trials: int) -> TrialState:
        """Where the first phase begins, with the fix before the first dive; at the origin where none says."""
        first = self.scenario.mission.phases[0]
        place = np.zeros(2)
        if isinstance(first, TransitPhase) and first.start is not None:
            place = self.scenario.position(first.start, f"{first.name}.from")
        sd = self.scenario.fix_sd
        noise = sd * self.normals(f"{first.name}.fix_at_start", trials) if np.any(sd) else 0.0
        return TrialState.at(place, trials, noise)

    def _transit(self, phase: TransitPhase, state: TrialState) -> tuple[TrialState, PhaseTrials, Array]:
        scenario = self.scenario
        plan, normals = scenario.transit_plan(phase), self._leg_normals(phase)
        around = Environment(scenario.current, scenario.compensation(phase), scenario.effects_under_way(phase))
        after, record = transit(plan, state, normals, around, tracked=min(self.tracked, state.trials))
        kept, out = self._spend(after)
        goal, arrived = column(plan.goal), record.arrived & ~out
        quantities = {
            "duration_s": record.duration,
            "surfacings": record.surfacings,
            "distance_m": record.distance,
            "arrival_error_m": record.arrival_error,
            "energy_wh": record.energy / JOULES_PER_WATT_HOUR,
        }
        found = PhaseTrials(
            name=phase.name,
            kind=phase.kind,
            quantities={name: _where(arrived, values) for name, values in quantities.items()},
            events={"arrived": arrived},
            start=_where(state.alive, state.clock),
            end=_where(arrived, after.clock),
            failures={"not arrived": state.alive & ~record.arrived, "out of energy": out},
            miss=_where(arrived, after.position - goal),
            track=_points(record.track),
            anchor=np.empty((2, 0)),
            goal=goal,
            radius=plan.arrival_radius,
            inputs=_leg_inputs(plan, normals, state, record, goal) if self.inputs else {},
        )
        return kept, found, goal

    def _moor(self, phase: MoorPhase, state: TrialState, goal: Array) -> tuple[TrialState, PhaseTrials]:
        scenario, came = self.scenario, state.alive
        plan = moor_plan(scenario, phase)
        normals = self.normals(f"{phase.name}.fix", state.trials)
        after, record = moor(
            plan,
            state,
            normals,
            scenario.current or STILL_WATER,
            effects=scenario.descent_effects,
            surface_effects=scenario.transit_effects,
        )
        kept, out = self._spend(after)
        descent, down, ended = record.descent, came & record.descent.touched_down, after.alive & ~out
        miss = record.anchor - goal
        reached = {
            "release_time_s": (came, descent.release_time),
            "payout_time_s": (came, descent.payout_time),
            "descent_time_s": (down, descent.descent_time),
            "terminal_velocity_m_s": (came, descent.terminal_velocity),
            "offset_m": (down, record.offset_distance),
            "target_offset_m": (down, np.hypot(miss[0], miss[1])),
            "lowest_altitude_m": (down, descent.lowest_altitude),
            "ascent_time_s": (after.alive, record.ascent_time),
            "duration_s": (ended, record.duration),
            "energy_wh": (ended, record.energy / JOULES_PER_WATT_HOUR),
        }
        within, struck = down & record.within_radius, down & record.struck
        points = (record.anchor, record.surfaced_at, after.position)
        found = PhaseTrials(
            name=phase.name,
            kind=phase.kind,
            quantities={name: _where(mask, values) for name, (mask, values) in reached.items()},
            events={"within_radius": within, "struck_seafloor": struck},
            start=_where(came, state.clock),
            end=_where(ended, after.clock),
            failures={
                "anchor did not reach the seafloor": came & ~down,
                "anchor outside the radius": down & ~within,
                "struck the seafloor": struck,
                "did not surface": down & ~record.surfaced,
                "out of energy": out,
            },
            miss=_where(down, miss),
            track=np.stack([np.where(after.alive, point, np.nan)[:, : self.tracked] for point in points]),
            anchor=_where(down, record.anchor),
            goal=goal,
            radius=plan.radius,
            inputs={},
        )
        return kept, found

    def _leg_normals(self, phase: TransitPhase) -> TransitNormals:
        """Open the streams of a transit."""

        def legs(name: str) -> LegNormals:
            return LegNormals(self.seed, f"{phase.name}.{name}", self.block)

        entries = self.scenario.transit_effect_ids
        return TransitNormals(
            velocity=legs("velocity_error"),
            fix_on_surfacing=legs("fix_on_surfacing"),
            fix_on_diving=legs("fix_on_diving"),
            effects=[legs(f"effects.{effect}") for effect in entries],
        )

    def _spend(self, state: TrialState) -> tuple[TrialState, Flags]:
        """End the trials that have used more than the battery holds; also give which."""
        for known in (state.position, state.fix, state.clock):
            if not np.isfinite(known).all() and not np.isfinite(known[..., state.alive]).all():
                raise FloatingPointError("a trial under way has lost its place or its time")
        out = state.alive & (state.energy > self.scenario.capacity)
        return replace(state, alive=state.alive & ~out), out


def _where(reached: Flags, values: Array) -> Array:
    """Values of the trials that reached something, nan for the others."""
    return values if reached.all() else np.where(reached, values, np.nan)


def _points(track: Array | None) -> Array:
    return np.empty((0, 2, 0)) if track is None else track.transpose(1, 0, 2)


def _leg_inputs(
    plan: TransitPlan, normals: TransitNormals, state: TrialState, record: TransitRecord, goal: Array
) -> dict[str, Array]:
    """Sum up what was drawn each leg: the mean velocity error over the legs, and the error of the arrival fix.

    Along and across (to port) the straight course from where the transit began.
    """
    course = goal - state.position
    length = np.hypot(course[0], course[1])
    along = course / np.where(length > 0.0, length, 1.0)
    legs = record.surfacings
    fewest, most = int(legs.min()), int(legs.max())
    total = np.zeros((2, state.trials))
    for number in range(most):
        normal = _leg(normals.velocity, number, state)
        total += normal if number < fewest else np.where(legs > number, normal, 0.0)
    # the error is linear in its normals
    found = {"velocity_error": random_part(plan.velocity_error, total / np.maximum(legs, 1.0))}
    if normals.fix_on_diving is not None and np.any(plan.fix_error):
        last = np.zeros((2, state.trials))
        for number in range(max(fewest - 1, 0), most):
            last = np.where(legs == number + 1, _leg(normals.fix_on_diving, number, state), last)
        found["fix_error"] = plan.fix_error * last
    return {
        f"{name}.{side}": values
        for name, vector in found.items()
        for side, values in (
            ("along", vector[0] * along[0] + vector[1] * along[1]),
            ("across", vector[1] * along[0] - vector[0] * along[1]),
        )
    }


def _leg(source: Normals, number: int, state: TrialState) -> Array:
    return source.leg(number)[:, : state.trials]


def run_block(
    scenario: Scenario, seed: int, block: int, trials: int, tracked: int = 0, inputs: bool = True
) -> MissionTrials:
    """Take one block of trials through the mission.

    Parameters
    ----------
    scenario : Scenario
        With the draws of that block.
    seed, block, trials : int
        Of the run; trials in use in the block.
    tracked : int
        Trials whose tracks are kept.
    inputs : bool
        Whether to sum up what was drawn each leg.

    Raises
    ------
    FloatingPointError
        When a phase divides by zero, overflows or leaves the real numbers, or a trial under way has lost its place.
    """
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        return BlockRun(scenario, seed, block, tracked, inputs).run(trials)
