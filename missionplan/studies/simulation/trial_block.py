"""A block of trials of a whole mission, phase by phase.

Equipment that fails: when, in which phase, and what is left of the vehicle then.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.schema.vehicle import DistanceHazard, Hazard, HourlyHazard, Leaves, Per
from missionplan.montecarlo.reliability import Exposure, age_at_chance, age_at_rate, age_weibull, rate_of_counts
from missionplan.montecarlo.streams import BlockStreams, NormalSource
from missionplan.phases.hooks import TrialState
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import Failure
from missionplan.scenario.phases import deployed
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.phase_trials import (
    Flags,
    PhaseTrials,
    TrialBlock,
    transit_trials,
    transition_trials,
    where_reached,
)

_LEAVES: dict[Per, Leaves] = {"release": "adrift", "wake-up": "moored"}
_HOUR, _KM = 3600.0, 1000.0
_TINY = 1e-300
"""Age and exposure in the place of none, whose logarithm is finite."""


@dataclass(frozen=True)
class Part:
    """A hazard with the age at which it strikes in each trial."""

    per: Per
    leaves: Leaves
    age: Array
    """Of the exposure: seconds, metres or events, of which it strikes at the first after it; shape (n,)."""
    shape: Scalars = 1.0
    """Of the Weibull law; 1 where it strikes as likely at any age; float or shape (n,)."""

    def margin(self, exposure: Array) -> Array:
        """Logarithm of the cumulative hazard at which it strikes over that of an exposure, shape (n,)."""
        shape = np.asarray(self.shape)
        return np.asarray(shape * np.log(np.maximum(self.age, _TINY) / np.maximum(exposure, _TINY)))


def _drawn(block: TrialBlock, number: int, hazard: "Hazard[Scalars]", trials: int) -> Part:
    stream = f"vehicle.reliability[{number}]"
    normals = block.source.once(f"{stream}.age")[:trials]
    leaves = hazard.leaves or _LEAVES.get(hazard.per, "adrift")
    unit = _HOUR if isinstance(hazard, HourlyHazard) else _KM if isinstance(hazard, DistanceHazard) else 1.0
    if hazard.shape is not None and hazard.scale is not None:
        return Part(hazard.per, leaves, age_weibull(hazard.shape, hazard.scale, normals), hazard.shape)
    if hazard.failures is not None and hazard.exposure is not None:
        rate: Scalars = rate_of_counts(hazard.failures, hazard.exposure, block.source.once(f"{stream}.rate")[:trials])
        if unit == 1.0:
            return Part(hazard.per, leaves, age_at_chance(-np.expm1(-rate), normals))
        return Part(hazard.per, leaves, age_at_rate(rate / unit, normals))
    constant: Scalars = 0.0 if hazard.rate is None else hazard.rate
    return Part(hazard.per, leaves, age_at_rate(constant, normals) if unit != 1.0 else age_at_chance(constant, normals))


def failing(
    parts: Sequence[Part], before: Exposure, begun: TrialState, after: TrialState, trials: PhaseTrials
) -> tuple[TrialState, PhaseTrials, Exposure]:
    """End the trials whose equipment fails in a phase.

    `before`: until the phase began. `begun`, `after`: at the phase's beginning and end. `trials`: of the phase without
    failures of equipment. Returns: until the phase's end. A trial that fails has no quantities and events of the phase.
    """
    exposure = before.plus(trials.exposure)
    first, left = np.full(begun.trials, np.inf), np.full(begun.trials, -1)
    margin = np.min([part.margin(np.asarray(exposure.of(part.per))) for part in parts], axis=0)
    for number, part in enumerate(parts):
        low, high = before.of(part.per), exposure.of(part.per)
        strikes = begun.alive & (low < part.age) & (part.age <= high)
        span = np.where(high > low, high - low, 1.0)
        age = part.age if part.per in ("hour", "km") else np.ceil(part.age)
        share = np.where(strikes, (age - low) / span, np.inf)
        sooner = share < first
        first[sooner], left[sooner] = share[sooner], number
    failed = left >= 0
    lost: dict[str, Flags] = {
        leaves: failed & np.isin(left, [k for k, p in enumerate(parts) if p.leaves == leaves])
        for leaves in list(dict.fromkeys(part.leaves for part in parts))
    }
    if failed.any():
        after = replace(after, alive=after.alive & ~failed)
        trials = replace(
            trials,
            quantities={name: np.where(failed, np.nan, values) for name, values in trials.quantities.items()},
            events={name: flags & ~failed for name, flags in trials.events.items()},
            end=np.where(failed, np.nan, trials.end),
            miss=np.where(failed, np.nan, trials.miss),
        )
    failures, margins = {Failure.EQUIPMENT: failed, **trials.failures}, {Failure.EQUIPMENT: margin, **trials.margins}
    return after, replace(trials, failures=failures, left=lost, margins=margins), exposure


@dataclass(frozen=True)
class MissionTrials:
    """A block of missions."""

    phases: tuple[PhaseTrials, ...]
    total: Mapping[str, Array]
    """``duration_s`` and ``energy_wh``; nan for a trial that did not reach the mission's end; shape (n,)."""
    success: Flags
    """Every transit arrived, every mooring within its radius and not struck, energy within the capacity, shape (n,)."""
    draws: Mapping[str, Array]
    """The uncertain quantities of the mission, by key path, shape (n,)."""

    def inputs(self) -> dict[str, Array]:
        """What was drawn, by the names of the table; what is drawn each leg as its sum over the legs."""
        inputs = dict(self.draws)
        for phase in self.phases:
            inputs |= {f"{phase.name}.{name}": values for name, values in phase.inputs.items()}
        return inputs

    def columns(self) -> dict[str, Array | Flags]:
        """One array a column of the table of trials, shape (n,) each."""
        table: dict[str, Array | Flags] = dict(self.draws)
        for phase in self.phases:
            for values in (phase.inputs, phase.quantities, phase.events):
                table |= {f"{phase.name}.{name}": value for name, value in values.items()}
        return table | {f"total.{name}": value for name, value in self.total.items()} | {"total.success": self.success}


TRACKED_TRIALS = 300
"""Trials whose tracks are on maps, the first of the run."""


@dataclass(frozen=True)
class MapTracks:
    """Some trials for maps: plain arrays, the phases one after another."""

    position: Array
    """Tracks, shape (points, 2, k) [m]."""
    time: Array
    """Since the mission's start, at the points of the tracks, shape (points, k) [s]."""
    points: NDArray[np.int64]
    """Points of the tracks that are each phase's, shape (phases,)."""
    anchors: Array
    """On the seafloor, shape (2, m) [m]."""
    goals: Array
    """Goal, east and north, and arrival radius or mooring radius, at the trials' mean, shape (phases, 3) [m]."""
    profile: Array
    """When, since the mission's start, and how deep, straight between, shape (2, corners, k) [s, m]."""
    success: Flags
    """Whether the mission succeeds, shape (k,)."""

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "MapTracks":
        """Read the fields from arrays of their names."""
        return cls(**{field.name: flat[field.name] for field in fields(cls)})  # type: ignore[arg-type]

    @classmethod
    def of(cls, trials: MissionTrials) -> "MapTracks":
        """Collect those of the first `TRACKED_TRIALS` from a block."""
        phases, shown = trials.phases, slice(TRACKED_TRIALS)
        position = np.concatenate([phase.track[..., shown] for phase in phases])
        return cls(
            position=position,
            time=np.concatenate([phase.track_time[:, shown] for phase in phases]),
            points=np.array([len(phase.track) for phase in phases]),
            anchors=np.concatenate([phase.anchor for phase in phases], axis=1),
            goals=np.array([(*phase.goal.mean(axis=1), np.mean(phase.radius)) for phase in phases], dtype=float),
            profile=np.concatenate([phase.profile[..., shown] for phase in phases], axis=1),
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

    `scenario`: with the draws of these trials. `source`: of what is drawn each leg or fix; the scenario's draws come
    from it too. `tracked`: trials whose tracks are kept. `inputs`: whether to sum up what was drawn each leg. Raises
    FloatingPointError when a phase divides by zero, overflows or computes nan, or the position or the time of a trial
    under way is not finite.
    """
    parts: list[Part] = []
    done: list[PhaseTrials] = []
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        block, first, position = TrialBlock(scenario, source, tracked, inputs), scenario.drawn.phases[0], np.zeros(2)
        if isinstance(first, TransitPhase) and first.start is not None:
            position = scenario.position(first.start)  # else the origin
        state = deployed(scenario, first, position, source, trials)
        goal, exposure = state.position, Exposure()
        if scenario.drawn.vehicle is not None:
            hazards = enumerate(scenario.drawn.vehicle.reliability)
            parts = [_drawn(block, number, hazard, trials) for number, hazard in hazards]
        for phase in scenario.drawn.phases:
            begun = state
            if isinstance(phase, TransitPhase):
                state, phase_trials = transit_trials(block, phase, state)
                goal = phase_trials.goal
            elif isinstance(phase, MoorPhase):
                state, phase_trials = mooring_trials(block, phase, state, goal)
            else:
                state, phase_trials = transition_trials(block, phase, state)
            if parts:
                state, phase_trials, exposure = failing(parts, exposure, begun, state, phase_trials)
            done.append(phase_trials)
        total = {
            "duration_s": where_reached(state.alive, state.clock),
            "energy_wh": where_reached(state.alive, state.energy / JOULES_PER_WATT_HOUR),
        }
    success = np.ones(trials, dtype=bool)
    for phase_trials in done:
        for failed in phase_trials.failures.values():
            success &= ~failed
    return MissionTrials(tuple(done), total, success, scenario.draws)
