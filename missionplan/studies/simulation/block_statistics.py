"""Statistics and counts of a block of missions, which merge block by block, and the first trials in full."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.checks.sections import EVENTS, QUANTITIES
from missionplan.mission.schema.sweep import Requirement
from missionplan.montecarlo.quantile_sketch import QuantileSketch
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistics
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import MET, SUCCESS, Counted, CountedKind
from missionplan.scenario.site_current import MEMBER
from missionplan.studies.simulation.phase_trials import Flags
from missionplan.studies.simulation.trial_block import MissionTrials

Value = TypeVar("Value")
Side = Literal["at_most", "at_least"]

SAMPLED_BLOCKS = 4
"""Blocks whose inputs and key figures are kept trial by trial, for sensitivities and circles of error."""
SUFFIXES = {"s": "_s", "m": "_m", "m/s": "_m_s", "J": "_wh", "N": "_n", "rad": "_rad", "": ""}
"""How the name of a quantity ends in results, by the SI unit in which the mission file bounds it."""
SCALES = {"J": 1.0 / JOULES_PER_WATT_HOUR}
"""From that SI unit to the results' where they differ."""
KEY_FIGURES = {
    "transit": ("duration_s", "arrival_error_m", "energy_wh", "arrived"),
    "moor": (
        *("offset_m", "target_offset_m", "lowest_altitude_m", "terminal_velocity_m_s", "within_radius"),
        *("nose_altitude_m", "holding_margin"),
    ),
    "transition": ("depth_excursion_m", "energy_wh", "hovering"),
    "total": ("duration_s", "energy_wh", "success"),
}
"""Quantities and events whose sensitivities are computed, by kind of phase."""


class Sampled(StrEnum):
    """What is kept of the first trials, one by one."""

    INPUT = "input"
    OUTPUT = "output"
    MISS = "miss"


@dataclass(frozen=True)
class BlockStatistics:
    """Reduced blocks."""

    statistics: RunningStatistics
    """Of ``phase.quantity``, and of ``phase.end`` but for the last phase, which ends with the mission."""
    counts: Mapping[Counted, Count]
    """Of a failure those still good until then."""
    sample: Mapping[tuple[Sampled, str], Array]
    """Of the first trials: inputs and outputs by their names, and where each phase misses by the phase's; shape
    (..., m)."""
    contacts: Array = field(default_factory=lambda: np.empty((0, 6)))
    """Trials lost to ground, coast and zones: number of the phase, `Cause`, leg, how many, sums of east and north;
    shape (m, 6) [m]."""

    @property
    def trials(self) -> int:
        """Trials in it."""
        return self.counts[SUCCESS].trials

    def merge(self, other: "BlockStatistics") -> "BlockStatistics":
        """Add the next block."""
        sample = dict(self.sample)
        for name, values in other.sample.items():
            sample[name] = np.concatenate((sample[name], values), axis=-1) if name in sample else values
        counts = {name: count.merge(other.counts[name]) for name, count in self.counts.items()}
        contacts = _summed(np.concatenate((self.contacts, other.contacts)))
        return BlockStatistics(self.statistics.merge(other.statistics), counts, sample, contacts)

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Flatten into named arrays, for a file."""
        flat: dict[str, NDArray[np.generic]] = {
            f"sample/{kind}/{name}": values for (kind, name), values in self.sample.items()
        }
        flat["contacts"] = self.contacts
        flat["count/names"] = np.array([[str(part) for part in counted] for counted in self.counts])
        flat["count/numbers"] = np.array([(count.successes, count.trials) for count in self.counts.values()])
        statistics = self.statistics
        flat["statistic/names"] = np.array(statistics.names)
        for part in fields(Moments):
            flat[f"moments/{part.name}"] = getattr(statistics.moments, part.name)
        used = [sketch.bins_in_use() for sketch in statistics.sketches]
        flat["sketch/sizes"] = np.array([len(counts) for _, counts in used])
        flat["sketch/bins"] = np.concatenate([bins for bins, _ in used])
        flat["sketch/counts"] = np.concatenate([counts for _, counts in used])
        return flat

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "BlockStatistics":
        """Read what `to_arrays` wrote."""
        numbers = zip(flat["count/names"].tolist(), flat["count/numbers"].tolist(), strict=True)
        counts = {Counted(CountedKind(kind), of, name): Count(*number) for (kind, of, name), number in numbers}
        ends = np.cumsum(flat["sketch/sizes"])[:-1]
        bins, bin_counts = (np.split(flat[f"sketch/{name}"], ends) for name in ("bins", "counts"))
        sketches = tuple(map(QuantileSketch.from_bins, bins, bin_counts))
        moments = Moments(**with_prefix(flat, "moments/"))  # type: ignore[arg-type]
        statistics = RunningStatistics(tuple(flat["statistic/names"].tolist()), moments, sketches)
        sample = {
            (kind, name): np.asarray(values, dtype=float)
            for kind in Sampled
            for name, values in with_prefix(flat, f"sample/{kind}/").items()
        }
        return cls(statistics, counts, sample, np.asarray(flat["contacts"], dtype=float))


def with_prefix(named: Mapping[str, Value], prefix: str) -> dict[str, Value]:
    """Entries whose names begin with a prefix, without it."""
    return {name.removeprefix(prefix): named[name] for name in named if name.startswith(prefix)}


def statistics_of_block(mission: Mission, trials: MissionTrials, *, sampled: bool, members: int = 0) -> BlockStatistics:
    """Reduce one block.

    `sampled`: whether to keep inputs and key figures trial by trial. `members`: of the current's ensemble.
    """
    counts = {name: Count.of(trial) for name, trial in happened(mission, trials).items()}
    holding = {
        explanation(doubt.place, number): trials.draws[doubt.place] == number
        for doubt in mission.doubts
        for number in doubt.told_apart
    }
    holding |= {explanation(MEMBER, number): trials.draws[MEMBER] == number for number in range(members)}
    counts |= {name: Count(int((trials.success & where).sum()), int(where.sum())) for name, where in holding.items()}
    sample = _sample(trials) if sampled else {}
    explained = {
        explained_name(counted, quantity): np.where(where, values, np.nan)
        for counted, where in holding.items()
        for quantity, values in trials.total.items()
    }
    total = {f"total.{name}": values for name, values in trials.total.items()}
    phases = {f"{phase.name}.{name}": values for phase in trials.phases for name, values in phase.quantities.items()}
    statistics = RunningStatistics.of(
        {**total, **phases, **{f"{phase.name}.end": phase.end for phase in trials.phases[:-1]}} | explained
    )
    return BlockStatistics(statistics, counts, sample, _summed(_contacts(trials)))


def happened(mission: Mission, trials: MissionTrials) -> dict[Counted, Flags]:
    """Trials that succeed, in which each event happens, and that meet each limit, failure and requirement."""
    events = {
        Counted(CountedKind.EVENT, phase.name, name): trial
        for phase in trials.phases
        for name, trial in phase.events.items()
    }
    met = requirement_flags(mission, trials.columns())
    limits = {}
    for limit in sorted({limit for phase in trials.phases for limit in phase.limits}):
        flags = [phase.limits[limit] for phase in trials.phases if limit in phase.limits]
        limits[Counted(CountedKind.LIMIT, "", limit)] = np.any(flags, axis=0)
    return {SUCCESS: trials.success, **events, **limits, **failures_by_step(trials), **met}


def _contacts(trials: MissionTrials) -> Array:
    """One row for each trial that is lost to ground, coast or a zone, as in `BlockStatistics.contacts`."""
    steps, rows = failures_by_step(trials), [np.empty((0, 6))]
    for number, phase in enumerate(trials.phases):
        if phase.contact is None:
            continue
        for cause, reason in MET.items():
            lost = np.flatnonzero(steps[Counted(CountedKind.FAILURE, phase.name, reason)] & phase.contact.of(cause))
            one = np.ones(lost.size)
            columns = (phase.contact.leg[lost], one, *phase.contact.where[:, lost])
            rows.append(np.stack((number * one, cause * one, *columns), axis=1))
    return np.concatenate(rows)


def _summed(rows: Array) -> Array:
    """Sum rows of the same phase, cause and leg."""
    kinds, which = np.unique(rows[:, :3], axis=0, return_inverse=True)
    sums = np.zeros((len(kinds), 3))
    np.add.at(sums, which.ravel(), rows[:, 3:])
    return np.concatenate((kinds, sums), axis=1)


def explanation(place: str, number: int) -> Counted:
    """Return the explanation of a number at a key path, or of none: the trials in which it holds."""
    return Counted(CountedKind.EXPLANATION, place, str(number))


def explained_name(explanation: Counted, quantity: str) -> str:
    """Name of the statistics of the mission's quantity in an explanation's trials."""
    return f"{explanation.kind}:{explanation.of} {explanation.name}.{quantity}"


def requirement_flags(mission: Mission, columns: Mapping[str, Array | Flags]) -> dict[Counted, Flags]:
    """Trials that meet each requirement."""
    flags = {}
    for index, requirement in enumerate(mission.requirements):
        column, side, limit = bounded_column(mission, requirement)
        flags[Counted.requirement(index)] = is_within(columns[column], side, limit)
    return flags


def is_within(values: NDArray[np.generic], side: Side | None, limit: float) -> Flags:
    """Trials in which a quantity keeps a bound, or, without one, an event happens; what was never reached does not."""
    if side is None:
        return np.asarray(values, dtype=bool)
    numbers = values.astype(float, copy=False)
    return np.asarray(numbers <= limit if side == "at_most" else numbers >= limit)


def bounded_column(mission: Mission, requirement: Requirement) -> tuple[str, Side | None, float]:
    """Column of the trials that a requirement bounds, and its bound in the column's unit; None and nan for an event."""
    column, unit = requirement_key(mission, requirement.quantity)
    side, limit = bound_of(requirement) or (None, math.nan)
    return column, side, limit * SCALES.get(unit or "", 1.0)


def requirement_key(mission: Mission, quantity: str) -> tuple[str, str | None]:
    """Column of a requirement's quantity, such as ``moor.offset_m``, and the unit of its bound; None for an event."""
    kinds = {phase.name: phase.kind for phase in mission.phases} | {"total": "total"}
    phase, _, name = quantity.rpartition(".")
    if name in EVENTS[kinds[phase]]:
        return quantity, None
    unit = QUANTITIES[kinds[phase]][name]
    return f"{quantity}{SUFFIXES[unit]}", unit


def bound_of(requirement: Requirement) -> tuple[Side, float] | None:
    """Side and limit of a requirement's bound, in SI; None for an event."""
    if requirement.at_most is not None:
        return "at_most", requirement.at_most
    return None if requirement.at_least is None else ("at_least", requirement.at_least)


def failures_by_step(trials: MissionTrials) -> dict[Counted, Flags]:
    """Trials that fail at each step of the mission and at none before it."""
    good = np.ones(trials.success.size, dtype=bool)
    steps = {}
    for phase in trials.phases:
        for failure, failed in phase.failures.items():
            steps[Counted(CountedKind.FAILURE, phase.name, failure)] = good & failed
            good = good & ~failed
    return steps


def _sample(trials: MissionTrials) -> dict[tuple[Sampled, str], Array]:
    kinds = [(phase.name, phase.kind) for phase in trials.phases] + [("total", "total")]
    figures = [f"{phase}.{name}" for phase, kind in kinds for name in KEY_FIGURES[kind]]
    columns = trials.columns()
    return (
        {(Sampled.INPUT, name): values for name, values in trials.inputs().items()}
        | {(Sampled.OUTPUT, name): np.asarray(columns[name], dtype=float) for name in figures}
        | {(Sampled.MISS, phase.name): phase.miss for phase in trials.phases}
    )
