"""From the reduced blocks of a simulation to its `Outcome`."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.schema.sweep import Requirement
from missionplan.montecarlo.sensitivity import sensitivities
from missionplan.montecarlo.statistics import Count, Integers, Probability, RunningStatistic, Statistic
from missionplan.phases.place import Cause
from missionplan.results import Provenance
from missionplan.results.decision import Causes, ExplainedOutcome, PlaceContact
from missionplan.results.failures import LIMITS, MET, Counted, CountedKind
from missionplan.results.simulation import (
    Attrition,
    Histogram,
    Outcome,
    PhaseOutcome,
    RequirementOutcome,
    Sensitivity,
    Tracks,
)
from missionplan.scenario.site_current import MEMBER
from missionplan.studies.simulation.block_statistics import (
    SCALES,
    BlockStatistics,
    Sampled,
    Side,
    bound_of,
    explained_name,
    explanation,
    requirement_key,
    with_prefix,
)
from missionplan.studies.simulation.trial_block import MapTracks

INTEGER_QUANTITIES = ("surfacings",)
"""Quantities that are whole numbers."""
BINS = 40
"""Bins of a histogram, between the 0.1 % and 99.9 % quantiles."""


@dataclass(frozen=True)
class OutcomeBuilder:
    """The merged blocks of a simulation."""

    mission: Mission
    totals: BlockStatistics
    """Of all blocks that succeeded."""
    tracks: MapTracks
    """Of the first trials."""
    members: tuple[tuple[str, float], ...] = ()
    """Of the current's ensemble: names and probabilities."""

    def outcome(self, provenance: Provenance) -> Outcome:
        """Return the result, as far as the blocks tell it."""
        clocks = tuple(self._clocks())
        phases, spans = self.mission.phases, itertools.pairwise(clocks)
        steps, left, trials = [], self.totals.trials, self.totals.trials
        for step, count in self.totals.counts.items():
            if step.kind is CountedKind.FAILURE and (count.successes or step.name not in LIMITS):
                left -= count.successes
                steps.append(Attrition(str(step), count.probability(), Count(left, trials).probability()))
        return Outcome(
            provenance=provenance,
            phases=tuple(
                replace(self._phase(phase.name, phase.kind, *span), label=phase.label)
                for phase, span in zip(phases, spans, strict=True)
            ),
            total=self._phase("total", "total", clocks[0], clocks[-1]),
            requirements=tuple(self._requirement(*numbered) for numbered in enumerate(self.mission.requirements)),
            attrition=tuple(steps),
            limits=self._counted(CountedKind.LIMIT, ""),
            sensitivities=self._sensitivities(),
            tracks=simulation_tracks(self.mission, self.tracks),
            arrivals=self._sampled(Sampled.MISS),
            explanations=tuple(
                self._explained(doubt.place, number, doubt.causes[number], doubt.probabilities[number])
                for doubt in self.mission.doubts
                for number in doubt.told_apart
            ),
            contacts=tuple(self._contacts()),
            members=tuple(
                self._explained(MEMBER, number, (name,), weight) for number, (name, weight) in enumerate(self.members)
            ),
        )

    def _contacts(self) -> Iterator[PlaceContact]:
        rows = self.totals.contacts
        for number, cause in dict.fromkeys((int(row[0]), Cause(int(row[1]))) for row in rows):
            contacts = rows[(rows[:, 0] == number) & (rows[:, 1] == cause)]
            count, east, north = contacts[:, 3:].sum(axis=0)
            yield PlaceContact(
                phase=self.mission.phases[number].label,
                cause=MET[cause],
                lost=Count(int(count), self.totals.trials).probability(),
                legs={str(int(row[2])): int(row[3]) for row in contacts},
                east=float(east / count),
                north=float(north / count),
            )

    def _explained(self, place: str, number: int, causes: Causes, share: float) -> ExplainedOutcome:
        counted = explanation(place, number)
        count, statistics = self.totals.counts[counted], self.totals.statistics
        names = (explained_name(counted, quantity) for quantity in ("duration_s", "energy_wh"))
        duration, energy = (statistics[name].statistic() for name in names)
        return ExplainedOutcome(place, number, causes, share, count.probability(), duration, energy, count.trials)

    def _clocks(self) -> Iterator[Statistic]:
        """Mission time at the start, and at the end of each phase of the trials that completed it."""
        yield Statistic.of_constant(0.0, self.totals.trials)
        for phase in self.mission.phases[:-1]:
            yield self.totals.statistics[f"{phase.name}.end"].statistic()
        yield self.totals.statistics["total.duration_s"].statistic()

    def _phase(self, name: str, kind: str, start: Statistic, end: Statistic) -> PhaseOutcome:
        statistics = with_prefix(self.totals.statistics, f"{name}.")
        statistics.pop("end", None)
        return PhaseOutcome(
            name=name,
            kind=kind,
            quantities={quantity: _statistic(quantity, running) for quantity, running in statistics.items()},
            events=self._counted(CountedKind.EVENT, name),
            histograms={quantity: histogram_from_sketch(running) for quantity, running in statistics.items()},
            start=start,
            end=end,
            label=name,
        )

    def _counted(self, kind: CountedKind, of: str) -> dict[str, Probability]:
        """Probabilities by name of what is counted of one kind."""
        counts = self.totals.counts.items()
        return {key.name: count.probability() for key, count in counts if (key.kind, key.of) == (kind, of)}

    def _requirement(self, index: int, requirement: Requirement) -> RequirementOutcome:
        outcome = requirement_outcome(self.mission, requirement, self.totals.counts[Counted.requirement(index)])
        key, unit = requirement_key(self.mission, requirement.quantity)
        reached = self._reached(key, unit or "", outcome.bound, outcome.required, outcome.trials)
        return replace(outcome, reached=reached)

    def _reached(self, key: str, unit: str, side: Side | None, required: float, trials: int) -> float | None:
        """Value within which the required share of all trials stays, SI; None where too few have one."""
        if side is None or key not in self.totals.statistics:
            return None
        running = self.totals.statistics[key]
        share = required * trials / running.moments.count if running.moments.count else math.inf
        if share > 1.0:
            return None
        return running.quantile(float(share if side == "at_most" else 1.0 - share)) / SCALES.get(unit, 1.0)

    def _sensitivities(self) -> tuple[Sensitivity, ...]:
        """Sensitivity of each phase's key figures to what was drawn until its end, of the mission's to everything."""
        inputs, outputs = self._sampled(Sampled.INPUT), self._sampled(Sampled.OUTPUT)
        names = [phase.name for phase in self.mission.phases]
        influences: list[Sensitivity] = []
        for index, name in enumerate([*names, "total"]):
            later = tuple(f"{other}." for other in names[index + 1 :])
            drawn = {source: values for source, values in inputs.items() if not source.startswith(later)}
            figures = {output: values for output, values in outputs.items() if output.startswith(f"{name}.")}
            influences += sensitivities(drawn, figures)
        return tuple(influences)

    def _sampled(self, kind: Sampled) -> dict[str, Array]:
        return {name: values for (sampled, name), values in self.totals.sample.items() if sampled is kind}


def _statistic(quantity: str, running: RunningStatistic) -> Statistic:
    """Statistic of a quantity; the sketch's quantiles of integers are rounded."""
    statistic = running.statistic()
    if quantity not in INTEGER_QUANTITIES or not statistic.count:
        return statistic
    return replace(statistic, p05=round(statistic.p05), p50=round(statistic.p50), p95=round(statistic.p95))


def histogram_from_sketch(running: RunningStatistic) -> Histogram:
    """Bin a quantity from its sketch; integers get a bin each where these are few.

    A bin of the sketch that lies across an edge is divided as if it were evenly filled: counts may be fractions.
    """
    low, high = running.quantiles((0.001, 0.999))
    if not math.isfinite(low):
        return Histogram(np.array([0.0, 1.0]), np.zeros(1))
    if high - low <= BINS and (integers := _integer_counts(running)):
        values, counts = integers
        edges = np.arange(round(low) - 0.5, round(high) + 1.0)
        place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
        return Histogram(edges, np.bincount(place, counts, minlength=len(edges) - 1).astype(float))
    margin = max(high - low, 1e-6 * max(abs(low), 1.0)) * 1e-3
    edges = np.linspace(low - margin, high + margin, BINS + 1)
    return Histogram(edges, np.diff(running.count_below(edges[1:-1]), prepend=0.0, append=running.moments.count))


def _integer_counts(running: RunningStatistic) -> tuple[Array, Integers] | None:
    """Values and counts of a quantity; None where not all are integers."""
    starts, ends = running.sketch.bounds()
    values = 0.5 * (starts + ends)
    rounded = np.round(values)
    are_integers = np.all(np.abs(values - rounded) <= 1e-3 * np.abs(rounded))
    return (rounded, running.sketch.bins_in_use()[1]) if are_integers else None


def simulation_tracks(mission: Mission, tracks: MapTracks) -> Tracks:
    """Tracks with the phases, goals and origin of their mission."""
    origin = mission.site.origin if mission.site else None
    return Tracks(
        position=tracks.position,
        time=tracks.time,
        phase=np.repeat(np.arange(len(tracks.points)), tracks.points),
        targets={
            phase.name: ((float(east), float(north)), float(radius))
            for phase, (east, north, radius) in zip(mission.phases, tracks.goals, strict=True)
        },
        anchors=tracks.anchors,
        profile=tracks.profile,
        success=tracks.success,
        origin=(origin.latitude, origin.longitude) if origin else None,
    )


def requirement_outcome(mission: Mission, requirement: Requirement, count: Count) -> RequirementOutcome:
    """Return a requirement with the trials that do as it asks."""
    probability, required = count.probability(), requirement.probability
    _, unit = requirement_key(mission, requirement.quantity)
    side, limit = bound_of(requirement) or (None, None)
    return RequirementOutcome(
        quantity=requirement.quantity,
        bound=side,
        limit=limit,
        unit=unit or "",
        required=required,
        probability=probability,
        met=probability.value >= required,
        undecided=probability.low <= required <= probability.high,
        trials=count.trials,
        written=requirement.written,
    )
