"""Will the mission work? With what probability, how long, how much energy, and why it fails when it does."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

import numpy as np

from missionplan.exporters import VEHICLES, format_named
from missionplan.identity import Identity, digest_of_files
from missionplan.mission import Mission, MissionOrPath
from missionplan.montecarlo.statistics import Probability
from missionplan.montecarlo.streams import BLOCK, sized_blocks
from missionplan.results.decision import SeaChart
from missionplan.results.failures import SUCCESS, Counted, CountedKind
from missionplan.results.plan import Plan
from missionplan.results.simulation import Outcome
from missionplan.results.whereabouts import Overdue
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.checkpoints import TrialsTable
from missionplan.store.folder import as_path
from missionplan.studies.export import executions, mission_plan, plan_if_any
from missionplan.studies.run import ResumableArguments, Run, identified
from missionplan.studies.simulation import (
    check_complete,
    check_trials,
    covered_means,
    held_vehicles,
    input_notices,
    mooring_anchors,
    run_notices,
)
from missionplan.studies.simulation.block_sequence import BlockTask, MergedBlocks, Precision, run_sequence
from missionplan.studies.simulation.losses import Search, read_searches
from missionplan.studies.simulation.outcome_builder import OutcomeBuilder
from missionplan.studies.simulation.overdue import overdue
from missionplan.studies.simulation.trial_block import MapTracks, MissionTrials, run_block

MAX_TRIALS = 10_000_000
"""Trials after which a run to a given precision ends, unless the number of trials is given."""


_LEFT = Counted(CountedKind.LIMIT, "", "left_record")
CHART_NODES = 150
"""Of the depths on maps, along each side."""


def simulate(
    mission: MissionOrPath,
    *,
    precision: str | None = None,
    keep_trials: bool = False,
    searched: str | Path | None = None,
    as_exported: str | None = None,
    assumptions: bool = False,
    sheet: bool = True,
    **run_as: Unpack[ResumableArguments],
) -> Outcome:
    """Run the whole mission many times.

    Parameters
    ----------
    mission : Mission, str or Path
    precision : str, optional
        Stop after the first block at which a standard error is below it: ``0.5%`` (of P(success)),
        ``success=0.002``, ``total.duration=0.5%``, ``moor.offset=0.1 m``. The run then equals one of that many trials.
    keep_trials : bool
        Keep a table with one row a trial.
    searched : str or Path, optional
        GeoJSON of areas that were searched in vain, which the search areas allow for (`read_searches`).
    as_exported : str, optional
        Format of a vehicle, of `missionplan.exporters.VEHICLES`: run what that vehicle does with its files, by
        its own rules, instead of what the mission means. A notice says what of it is lost.
    assumptions : bool
        Run the mission again without each of its assumptions (`judgement.ledger`), and tell what they are worth.
    sheet : bool
        Compute what to know if the vehicle does not come back (`Outcome.overdue`).
    **run_as
        See `studies.run.ResumableArguments`. With `precision`, `trials` are the most that are run (default
        `MAX_TRIALS`).

    Raises
    ------
    InputError
        When the mission lacks what its phases need, an option is wrong, or the checkpoint is of another run.
    RunError
        When every block fails, a worker dies, or the checkpoint cannot be written.
    """
    from missionplan.studies import judgement  # which runs missions by this module

    formats, text = {"as_exported": (as_exported, (None, *VEHICLES))}, {"precision": precision}
    run = Run.begun("simulate", mission, one_of=formats, text=text, **run_as)
    mission, seed, workers = run.mission, run.seed, run.workers
    check_complete(mission)
    searches = read_searches(as_path(searched, "searched"), mission) if searched is not None else ()
    goal = Precision.parse(precision, mission) if precision else None
    means, exported = _carried_out(mission, as_exported)
    notices = input_notices(mission, means)
    task = BlockTask(means, seed, keep_trials)
    items = sized_blocks(MAX_TRIALS if goal and run_as.get("trials") is None else run.trials)
    store, table = run.store(_identity(task, as_exported)), TrialsTable() if keep_trials else None
    merged = run_sequence(items, lambda todo: workers.quiet.run(task, todo), store, goal, table, workers.progress)
    check_trials(means, merged.totals.counts.get(_LEFT))
    if exported is not None:
        notices = (*notices, *_loss(mission, exported, merged, seed))
    tracks = merged.tracks or task.tracks(*merged.first)  # block 0 has them, unless it failed
    options: dict[str, object] = {"jobs": workers.jobs, "backend": workers.backend, "precision": precision}
    options |= {"keep_trials": keep_trials, **({} if as_exported is None else {"as_exported": as_exported})}
    options |= {} if searched is None else {"searched": digest_of_files([as_path(searched, "searched")])}
    options |= {"assumptions": assumptions, "sheet": sheet}
    provenance = run.provenance(options, (*notices, *run_notices(merged, goal)), trials=merged.totals.trials)
    outcome = OutcomeBuilder(mission, merged.totals, tracks, task.members).outcome(provenance)
    first = merged.trials if exported is None else None
    return replace(
        outcome,
        anchors=mooring_anchors(mission, means),
        held=held_vehicles(means),
        failed_blocks=merged.failures,
        trials_table=table.parquet() if table else None,
        plan=plan_if_any(mission, means, seed),
        overdue=_overdue(task, merged, searches) if sheet else None,
        chart=_chart(means, tracks),
        assumed=judgement.ledger(mission, seed, first, outcome.requirements) if assumptions else (),
    )


def _carried_out(mission: Mission, as_exported: str | None) -> tuple[Scenario, tuple[str, Plan] | None]:
    """The scenario at its means as it is carried out, and the format and plan whose files say so, if any do."""
    means = covered_means(mission)
    if as_exported is None:
        return means, None
    plan = mission_plan(mission, means=means, to=as_exported)
    return replace(means, executions=executions(mission, as_exported, plan)), (as_exported, plan)


def _chart(means: Scenario, tracks: MapTracks) -> SeaChart | None:
    """Depths, land and zones about the tracks; None where the mission says nothing of them."""
    place = means.place
    if place is None:
        return None
    points = np.concatenate((np.moveaxis(tracks.position, 1, 0).reshape(2, -1), tracks.goals[:, :2].T), axis=1)
    places = points[:, np.isfinite(points).all(axis=0)]
    low, high = np.quantile(places, 0.01, axis=1), np.quantile(places, 0.99, axis=1)
    margin = float(np.max(high - low))
    east, north = (np.linspace(a - margin, b + margin, CHART_NODES) for a, b in zip(low, high, strict=True))
    lattice = np.stack([axis.ravel() for axis in np.meshgrid(east, north)])
    depth = place.water_at(lattice, np.zeros(lattice.shape[1])).reshape(CHART_NODES, CHART_NODES)
    shapes = [
        ("land" if zone.is_land else "keep-out", tuple(np.array(ring.coords)[:, :2] for ring in outlines))
        for zone in place.zones
        for part in getattr(zone.geometry, "geoms", (zone.geometry,))
        for outlines in ((part.exterior, *part.interiors),)
    ]
    return SeaChart(east, north, depth if place.ground is not None else None, tuple(shapes))


def event_probabilities(mission: Mission, *, trials: int, seed: int) -> dict[Counted, Probability]:
    """Return the probabilities of success and of each phase's events, as `simulate` does and nothing else.

    Raises InputError and RunError as `simulate` does.
    """
    check_complete(mission)
    means = covered_means(mission)
    task = BlockTask(means, seed)
    merged = run_sequence(sized_blocks(trials), lambda items: (task(item) for item in items))
    check_trials(means, merged.totals.counts.get(_LEFT))
    return {counted: count.probability() for counted, count in merged.totals.counts.items()}


def _overdue(task: BlockTask, merged: MergedBlocks, searches: Sequence[Search]) -> Overdue | None:
    """See where those trials of the first block are that do not end; run it again where it was read from a file."""
    block, size = merged.first
    scenario = task.means.sampled(seed=task.seed, block=block, size=size)
    trials = merged.trials or run_block(scenario, task.seed, block, size, tracked=size, inputs=False)
    return overdue(scenario, trials, task.seed, searches)


def simulate_block(mission: Mission, *, seed: int, block: int, trials: int = BLOCK) -> MissionTrials:
    """Run one block of trials alone, as `simulate` does, and keep every trial.

    `seed`, `block`: as a failed block is reported. `trials`: first trials of the block that are used. Raises InputError
    when the mission lacks what its phases need. Raises what the block fails with.
    """
    check_complete(mission)
    return BlockTask(Scenario.at_means(mission, recorded_current(mission)), seed).trials(block, trials)


def _loss(mission: Mission, exported: tuple[str, Plan], merged: MergedBlocks, seed: int) -> tuple[str, ...]:
    """Say how the mission as exported compares with the mission as it is meant, on one block, and why."""
    as_exported, plan = exported
    trials = min(merged.totals.trials, BLOCK)
    meant = event_probabilities(mission, trials=trials, seed=seed)
    parts = [
        f"{counted.of} {counted.name} {merged.totals.counts[counted].probability().value:.1%} of trials, "
        f"as the mission means it {meant[counted].value:.1%}"
        for counted in meant
        if counted == SUCCESS or counted.name == "arrived"
    ]
    lost = (f"Not in its files: {words}." for words in format_named(as_exported).lost(plan))
    return (f"As the vehicle carries out its {as_exported} files: {'; '.join(parts)}.", *lost)


def _identity(task: BlockTask, as_exported: str | None) -> Identity:
    """Everything that a finished block depends on; not how many blocks there are."""
    options: dict[str, object] = {"command": "simulate", "keep_trials": task.keep_trials}
    options |= {} if as_exported is None else {"as_exported": as_exported}
    return Identity.of(identified(task.means.mission), options, task.seed)
