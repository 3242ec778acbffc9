"""The probability of a rare failure of a mission, and how it comes about."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import MissionOrPath
from missionplan.montecarlo.parallel.blocks import Backend, Progress, run_blocks
from missionplan.montecarlo.rare_events.estimate import LEAST_REPETITIONS, Estimate
from missionplan.montecarlo.rare_events.population import NormalPopulation
from missionplan.montecarlo.rare_events.subset_simulation import Pilot, run_pilot
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.montecarlo.streams import stream
from missionplan.results.base import Provenance
from missionplan.results.rare_failure import RareFailure
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.arguments import check_arguments, made_by
from missionplan.studies.nominal_dive import check_dives
from missionplan.studies.rare_failure.driven_trials import (
    BATCH,
    STREAM,
    DrivenMission,
    FailingTrials,
    RareTask,
    drawn_inputs,
)
from missionplan.studies.rare_failure.event import FAILS, RareEvent
from missionplan.studies.rare_failure.margins import margins, scales
from missionplan.studies.rare_failure.modes import failure_modes
from missionplan.studies.simulation.checks import check_complete, input_notices
from missionplan.studies.simulation.record_cover import check_cover

MAX_TRIALS = 1_000_000
"""Trials after which the search ends, unless their number is given."""
VARIATION = 0.1
"""Coefficient of variation at which it ends, unless one is given."""
PLAIN_TRIALS = 2048
"""Plain trials from which the scales of the margins and the usual values of the inputs are taken."""
FEWEST_BATCHES = 3
"""Batches before an end because the result is precise enough: the scatter of twelve repetitions at least."""
_KEPT = 2000
"""Failing trials in the table, drawn by their weights."""


@dataclass(frozen=True)
class _Usual:
    """Plain trials: how many failed, and what was drawn in them."""

    failed: int
    inputs: Mapping[str, Array]


def find_rare_failure(
    mission: MissionOrPath,
    *,
    event: str = FAILS,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    precision: str | None = None,
    progress: Progress | None = None,
) -> RareFailure:
    """Estimate the probability of a rare failure by subset simulation, and sample the missions that fail.

    Parameters
    ----------
    mission : Mission, str or Path
    event : str
        ``not total.success``, ``moor.struck_seafloor``, ``moor.offset > 30 m``; see `RareEvent.parse`.
    trials, seed : int, optional
        Most trials that are run (default `MAX_TRIALS`; two batches of repetitions at least); default seed: the
        mission's.
    jobs, backend, scheduler
        See `run_blocks`. The result does not depend on them, to the last bit.
    precision : str, optional
        Coefficient of variation at which the search ends, such as ``5%``; default `VARIATION`.
    progress : callable, optional
        Called with the trials done and the most that are run.

    Raises
    ------
    InputError
        When the mission lacks what its phases need, or an option is wrong.
    RunError
        When a trial cannot be computed, or a worker dies.
    """
    started = time.perf_counter()
    mission = check_arguments(
        mission, trials=trials, seed=seed, jobs=jobs, text={"precision": precision, "event": event}
    )
    check_complete(mission)
    wanted, aim = RareEvent.parse(event, mission), _variation(precision)
    seed = mission.monte_carlo.seed if seed is None else seed
    means = Scenario.at_means(mission, recorded_current(mission))
    check_cover(mission, means)
    check_dives(means)
    driven, usual = _with_scales(means, wanted, seed)
    pilot = run_pilot(driven, stream(seed, STREAM, 0))
    batches: list[FailingTrials] = []
    if pilot.reached:
        task, spent = RareTask(driven, pilot.levels, seed), PLAIN_TRIALS + pilot.trials
        count = max(LEAST_REPETITIONS // BATCH, ((trials or MAX_TRIALS) - spent) // task.trials)
        results = run_blocks(task, range(1, count + 1), jobs=jobs, backend=backend, scheduler=scheduler)
        for batch in results:  # in the order of their numbers: an early end does not depend on `jobs`
            batches.append(batch)
            if progress is not None:
                progress(spent + len(batches) * task.trials, spent + count * task.trials)
            if len(batches) >= FEWEST_BATCHES and _estimate(batches).variation <= aim:
                break
    provenance = made_by(
        "simulate",
        mission,
        seed=seed,
        trials=PLAIN_TRIALS + pilot.trials + sum(batch.trials for batch in batches),
        options={"rare": event, "trials": trials, "jobs": jobs, "backend": backend, "precision": precision},
        started=started,
        notices=(*input_notices(mission, means), *_notices(pilot, batches, aim)),
    )
    return _result(provenance, wanted, pilot, batches, usual)


def _variation(precision: str | None) -> float:
    """Read the coefficient of variation: ``5%`` or ``0.05``."""
    if precision is None:
        return VARIATION
    try:
        value = float(precision.strip().removesuffix("%")) / (100.0 if precision.strip().endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        message = f"given {precision!r}, expected a coefficient of variation of the probability"
        raise InputError([Problem(message, key="precision", hint="such as 5%")])
    return value


def _with_scales(means: Scenario, event: RareEvent, seed: int) -> tuple[DrivenMission, _Usual]:
    """Run plain trials for the scales of the margins."""
    plain = DrivenMission(means, event, {})
    scenario, trials = plain.run(NormalPopulation(PLAIN_TRIALS, stream(seed, "rare failure, plain", 0)), inputs=True)
    failed = int(np.count_nonzero(event.happens(trials.columns())))
    sizes = scales(margins(event, trials, scenario))
    return DrivenMission(means, event, sizes), _Usual(failed, drawn_inputs(trials))


def _estimate(batches: Sequence[FailingTrials]) -> Estimate:
    return Estimate.of(np.concatenate([batch.estimates for batch in batches]))


def _notices(pilot: Pilot, batches: Sequence[FailingTrials], aim: float) -> list[str]:
    if not pilot.reached:
        return [
            "No failure was found: what leads to it may be a thing whose margin is not known (docs/rare-failures.md)."
        ]
    if _estimate(batches).variation <= aim:
        return []
    return [f"The coefficient of variation asked for, {100.0 * aim:g} %, was not reached: it takes more trials."]


def _result(
    provenance: Provenance, event: RareEvent, pilot: Pilot, batches: Sequence[FailingTrials], usual: _Usual
) -> RareFailure:
    if not batches:
        found, probability = None, wilson(usual.failed, PLAIN_TRIALS)
    else:
        found = _estimate(batches)
        probability = Probability(found.value, found.low, found.high)
    weights = np.concatenate([batch.weights for batch in batches]) if batches else np.empty(0)
    steps = np.concatenate([batch.steps for batch in batches]) if batches else np.empty(0, dtype=str)
    columns = {name: np.concatenate([batch.columns[name] for batch in batches]) for name in _names(batches)}
    inputs = {name: np.asarray(columns[name], dtype=float) for name in (batches[0].inputs if batches else ())}
    return RareFailure(
        provenance=provenance,
        event=event.text,
        probability=probability,
        variation=math.inf if found is None else found.variation,
        repetitions=0 if found is None else found.repetitions,
        levels=len(pilot.levels),
        reached=pilot.reached and weights.size > 0,
        nearest=pilot.probability,
        modes=failure_modes(weights, steps, inputs, usual.inputs),
        sample=_sample(weights, steps, columns, provenance.seed),
    )


def _names(batches: Sequence[FailingTrials]) -> Sequence[str]:
    return tuple(batches[0].columns) if batches else ()


def _sample(weights: Array, steps: Array, columns: Mapping[str, Array], seed: int) -> pd.DataFrame:
    """Tabulate failing trials, drawn by their weights so that each row counts the same."""
    table = pd.DataFrame({"step": steps, **columns})
    if not weights.size:
        return table
    places = (np.arange(min(_KEPT, weights.size)) + stream(seed, "rare failure, table", 0).random()) * (
        weights.sum() / min(_KEPT, weights.size)
    )
    chosen = np.minimum(np.searchsorted(np.cumsum(weights), places), weights.size - 1)
    drawn: pd.DataFrame = table.iloc[chosen].reset_index(drop=True)
    return drawn
