"""The probability of a rare failure of a mission, and how it comes about; what counts as failure: `driven_trials`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Unpack

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission import Mission, MissionOrPath
from missionplan.montecarlo.rare_events import NormalPopulation
from missionplan.montecarlo.rare_events.failure_search import FailureSearch, Found, find
from missionplan.montecarlo.rare_events.strata import ReliabilityIndices, StrataView, strata
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.montecarlo.streams import stream
from missionplan.results import Provenance, Result, to_csv
from missionplan.results.entries import Entry, Record
from missionplan.results.failures import MET, Failure
from missionplan.scenario.scenario import Scenario
from missionplan.studies.rare_failure.driven_trials import (
    FAILS,
    DrivenMission,
    FailingTrials,
    RareEvent,
    discrete_values,
    margins,
    units_of_inputs,
    variation_asked,
)
from missionplan.studies.run import Run, RunArguments
from missionplan.studies.simulation import check_complete, covered_means, input_notices
from missionplan.studies.simulation.block_statistics import failures_by_step


@dataclass(frozen=True)
class Cause(Record):
    """An input that is not as usual where a mission fails; numbers in SI."""

    source: Annotated[str, Entry("such as ``moor.release_time``")]
    mean: Annotated[float, Entry("of the trials that fail so")]
    usual: Annotated[float, Entry("mean of all trials")]
    usual_sd: Annotated[float, Entry("standard deviation of all trials")]
    unit: Annotated[str, Entry("of these numbers, in SI; empty where they have none")] = ""

    @property
    def shift(self) -> Annotated[float, Entry()]:
        """How far it lies from usual, in standard deviations of all trials."""
        return (self.mean - self.usual) / self.usual_sd


@dataclass(frozen=True)
class FailureMode(Record):
    """A way in which the failure comes about."""

    step: Annotated[str, Entry("where such missions fail first, as ``moor: anchor dragged``; empty where nowhere yet")]
    share: Annotated[float, Entry("of the failures")]
    causes: Annotated[tuple[Cause, ...], Entry("what is not as usual in them, the most unusual first")]


@dataclass(frozen=True)
class WayDriven(Record):
    """A way to fail towards which trials were driven by its own margin."""

    way: Annotated[str, Entry("such as ``moor: anchor outside the radius``; empty for failures that no margin tells")]
    probability: Annotated[float, Entry("of failing so, alone or with others; zero where no failure was found")]
    nearest: Annotated[float, Entry("probability, roughly, of coming as near to it as the nearest trials")]
    bound: Annotated[float, Entry("upper end of the 95 % interval by plain trials")]


@dataclass(frozen=True)
class RareFailure(Result):
    """Result of `simulate --rare`."""

    report: ClassVar[str] = "missionplan.studies.rare_failure.page"

    provenance: Provenance
    event: Annotated[str, Entry("such as ``not total.success``", key="rare.event")]
    probability: Annotated[Probability, Entry("with its 95 % interval", key="rare.probability")]
    variation: Annotated[
        float,
        Entry(
            "of the probability, from the scatter of the repetitions; infinite without failures",
            key="rare.coefficient_of_variation",
        ),
    ]
    repetitions: Annotated[int, Entry("independent repetitions", key="rare.repetitions")]
    levels: Annotated[int, Entry("the most levels of one repetition", key="rare.levels")]
    reached: Annotated[bool, Entry("whether a failure was found", key="rare.found")]
    nearest: float
    """Where no failure was found: probability, roughly, of coming as near to one as the nearest trials."""
    ways: Annotated[tuple[WayDriven, ...], Entry("ways to fail towards which trials were driven", key="rare.ways")]
    modes: Annotated[tuple[FailureMode, ...], Entry("the commonest first", key="rare.modes")]
    sample: pd.DataFrame
    """Trials that fail: their weight, the step at which they fail, what was drawn, and what came of it."""

    @property
    def plain_trials(self) -> Annotated[float, Entry(key="rare.plain_trials")]:
        """Trials after which a plain Monte Carlo knows the probability as well; infinite without failures."""
        value = self.probability.value
        return (1.0 - value) / (value * self.variation**2) if value > 0.0 and self.variation > 0.0 else math.inf

    def to_frame(self) -> pd.DataFrame:
        """One row per way to fail and unusual input."""
        rows = [{"step": mode.step, "share": mode.share, **cause.row()} for mode in self.modes for cause in mode.causes]
        return pd.DataFrame(rows, columns=["step", "share", "source", "mean", "usual", "usual_sd", "shift"])

    def files(self) -> dict[str, str | bytes]:
        """Return `rare.csv`, the ways to fail, and `failures.csv`, trials that fail."""
        return {"rare.csv": to_csv(self.to_frame()), "failures.csv": to_csv(self.sample)}


LEAST_SHARE = 0.02
"""Of the failures, of a way to fail that is described."""
LEAST_SHIFT = 0.5
"""Standard deviations from usual from which an input counts as unusual."""
MOST_CAUSES = 4


def failure_modes(
    weights: Array,
    steps: NDArray[np.str_],
    inputs: Mapping[str, Array],
    usual: Mapping[str, Array],
    units: Mapping[str, str],
) -> tuple[FailureMode, ...]:
    """Group failing trials by where they fail, and find what was drawn unlike usual.

    `weights` has shape (n,). `steps` has shape (n,). `inputs`, shape (n,): what was drawn in them; nan where it was
    never needed. `usual`, shape (m,): the same of plain trials. `units`: of the inputs.
    """
    shares = {str(step): float(weights[steps == step].sum() / weights.sum()) for step in np.unique(steps)}
    modes = [
        FailureMode(step, share, _causes(steps == step, weights, inputs, usual, units))
        for step, share in shares.items()
        if share >= LEAST_SHARE
    ]
    return tuple(sorted(modes, key=lambda mode: -mode.share))


def _causes(
    chosen: NDArray[np.bool_],
    weights: Array,
    inputs: Mapping[str, Array],
    usual: Mapping[str, Array],
    units: Mapping[str, str],
) -> tuple[Cause, ...]:
    causes = []
    for source, values in inputs.items():
        drawn = chosen & np.isfinite(values)
        before = usual[source][np.isfinite(usual[source])]
        if before.size < 2 or weights[drawn].sum() < 0.5 * weights[chosen].sum() or not np.std(before) > 0.0:
            continue
        mean = float(np.average(values[drawn], weights=weights[drawn]))
        causes.append(Cause(source, mean, float(np.mean(before)), float(np.std(before)), units[source]))
    unusual = [cause for cause in causes if abs(cause.shift) >= LEAST_SHIFT]
    return tuple(sorted(unusual, key=lambda cause: -abs(cause.shift))[:MOST_CAUSES])


MAX_TRIALS = 1_000_000
"""Trials after which the search ends, unless their number is given."""
PLAIN_TRIALS = 2048
"""Plain trials, from which the ranks of the margins and the usual values of the inputs are taken."""
_MARGIN_WHERE_POSSIBLE = (Failure.OUT_OF_ENERGY, Failure.EQUIPMENT, *MET.values())
_KEPT = 2000
"""Failing trials in the table, drawn by their weights."""


@dataclass(frozen=True)
class _Usual:
    """Plain trials: how many failed, in all, by their ways and by those without a margin; what was drawn in them."""

    failed: int
    failed_by: Array
    failed_without: Mapping[str, int]
    inputs: Mapping[str, Array]


def find_rare_failure(
    mission: MissionOrPath,
    *,
    event: str = FAILS,
    precision: str | None = None,
    **run_as: Unpack[RunArguments],
) -> RareFailure:
    """Estimate the probability of a rare failure by subset simulation, and sample the missions that fail.

    Parameters
    ----------
    mission : Mission, str or Path
    event : str
        ``not total.success``, ``moor.struck_seafloor``, ``moor.offset > 30 m``; see `RareEvent.parse`.
    precision : str, optional
        Coefficient of variation at which the search ends, such as ``5%``; default `VARIATION`.
    **run_as
        See `studies.run.RunArguments`. The trials are the most that are run (default `MAX_TRIALS`; screening and twelve
        runs of each way that counts are always made), of which `progress` is told.

    Raises
    ------
    InputError
        When the mission lacks what its phases need, or an option is wrong.
    RunError
        When a trial cannot be computed, or a worker dies.
    """
    run = Run.begun("simulate", mission, text={"precision": precision, "event": event}, **run_as)
    mission, seed, trials, progress = run.mission, run.seed, run_as.get("trials"), run.workers.progress
    check_complete(mission)
    wanted, aim = RareEvent.parse(event, mission), variation_asked(precision)
    means = covered_means(mission)
    if means.place is not None and not wanted.is_quantity:
        means = replace(means, place=replace(means.place, is_measured=True))
    driven, indices, usual = _with_ways(means, wanted, seed)
    most = MAX_TRIALS if trials is None else trials
    parts, plain_share = strata(discrete_values(mission, means)), usual.failed / PLAIN_TRIALS
    search = find(
        FailureSearch(driven, parts, indices, seed, driven.describe, known=plain_share),
        run.workers.quiet.run,
        variation=aim,
        most_trials=most - PLAIN_TRIALS,
        progress=lambda done: progress(min(PLAIN_TRIALS + done, most), most) if progress is not None else None,
    )
    options: dict[str, object] = {"rare": event, "trials": trials, "jobs": run.workers.jobs}
    options |= {"backend": run.workers.backend, "precision": precision}
    notices = input_notices(mission, means)
    if not search.batches:
        words = "what leads to it may be a thing whose margin is not known (docs/rare-failures.md)."
        notices = (*notices, f"No failure was found: {words}")
    elif search.cut and search.estimate.variation > aim:
        asked_for = f"The coefficient of variation asked for, {100.0 * aim:g} %, was not reached"
        notices = (*notices, f"{asked_for}: it takes more trials.")
    provenance = run.provenance(options, notices, trials=PLAIN_TRIALS + search.trials)
    return _result(provenance, mission, wanted, driven.ways, search, usual)


def _with_ways(means: Scenario, event: RareEvent, seed: int) -> tuple[DrivenMission, ReliabilityIndices, _Usual]:
    """Run plain trials for the ways to fail and the ranks of their margins."""
    driven = DrivenMission(means, event)
    population = NormalPopulation(PLAIN_TRIALS, stream(seed, "rare failure, plain", 0))
    scenario, trials = driven.run(StrataView(population), inputs=True)
    by_way = margins(event, trials, scenario)
    by_way = {way: values for way, values in by_way.items() if not np.isposinf(values).all()}
    driven = replace(driven, ways=tuple(by_way))
    plain = driven.margins_of(trials, by_way)
    fails_by = plain.fails_by
    without = plain.failed & ~fails_by.any(axis=0)
    # where any failure counts, a way may have no margin; energy, ground, zones and equipment have one where possible
    untold = {
        str(step): int(np.count_nonzero(failed))
        for step, failed in (failures_by_step(trials).items() if event.text == FAILS else ())
        if step.name not in _MARGIN_WHERE_POSSIBLE and str(step) not in driven.ways
    }
    usual = _Usual(
        int(np.count_nonzero(plain.failed)),
        np.append(np.count_nonzero(fails_by, axis=1), np.count_nonzero(without)),
        untold,
        trials.inputs(),
    )
    return driven, ReliabilityIndices.of(plain), usual


def _result(
    provenance: Provenance,
    mission: Mission,
    event: RareEvent,
    ways: Sequence[str],
    search: Found[FailingTrials],
    usual: _Usual,
) -> RareFailure:
    described = [batch.described for batch in search.batches]
    probability = wilson(usual.failed, PLAIN_TRIALS)
    if search.batches:
        probability = Probability(search.estimate.value, search.estimate.low, search.estimate.high)
    weights = np.concatenate([trials.weights for trials in described]) if described else np.empty(0)
    steps = np.concatenate([trials.steps for trials in described]) if described else np.empty(0, dtype=str)
    names = tuple(described[0].columns) if described else ()
    columns = {name: np.concatenate([trials.columns[name] for trials in described]) for name in names}
    inputs = {name: np.asarray(columns[name], dtype=float) for name in (described[0].inputs if described else ())}
    return RareFailure(
        provenance=provenance,
        event=event.text,
        probability=probability,
        variation=search.estimate.variation,
        repetitions=sum(batch.counted.size for batch in search.batches),
        levels=max(screening.levels for screening in search.screened),
        reached=weights.size > 0,
        nearest=max(screening.nearest for screening in search.screened),
        ways=_ways(ways, search, usual),
        modes=failure_modes(weights, steps, inputs, usual.inputs, units_of_inputs(mission, inputs)),
        sample=_sample(weights, steps, columns, provenance.seed),
    )


def _ways(ways: Sequence[str], search: Found[FailingTrials], usual: _Usual) -> tuple[WayDriven, ...]:
    """Put together what is known of each way to fail, over all strata; those without a margin by plain trials."""
    driven = []
    for number, way in enumerate((*ways, "")):
        nearest = max(screening.nearest for screening in search.screened if screening.part.way == number)
        bound = wilson(int(usual.failed_by[number]), PLAIN_TRIALS).high
        driven.append(WayDriven(way, search.probability(number), nearest, bound))
    for way, count in usual.failed_without.items():
        driven.append(WayDriven(way, count / PLAIN_TRIALS, 1.0, wilson(count, PLAIN_TRIALS).high))
    return tuple(driven)


def _sample(weights: Array, steps: Array, columns: Mapping[str, Array], seed: int) -> pd.DataFrame:
    """Tabulate failing trials, drawn by their weights so that each row counts the same."""
    table = pd.DataFrame({"step": steps, **columns})
    if not weights.size:
        return table
    count = min(_KEPT, weights.size)
    places = (np.arange(count) + stream(seed, "rare failure, table", 0).random()) * (weights.sum() / count)
    chosen = np.minimum(np.searchsorted(np.cumsum(weights), places), weights.size - 1)
    drawn: pd.DataFrame = table.iloc[chosen].reset_index(drop=True)
    return drawn
