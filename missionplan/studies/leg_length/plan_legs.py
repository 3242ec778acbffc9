"""How long should each leg be? The best legs for an aim, run in the mission's own Monte Carlo."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import get_args

from missionplan.arrays import Array
from missionplan.mission import MissionOrPath
from missionplan.montecarlo.parallel.blocks import Backend, Progress, Workers
from missionplan.montecarlo.statistics import Moments
from missionplan.montecarlo.streams import block_count
from missionplan.results.base import Provenance
from missionplan.results.decision import label
from missionplan.studies.judgement import judged
from missionplan.studies.leg_length.analytic_transit import analytic_obstacle
from missionplan.studies.leg_length.optimise_legs import Aim, LegAim, OptimisedLegs, optimise_legs
from missionplan.studies.leg_length.paired_trials import AS_PLANNED
from missionplan.studies.leg_length.plan_comparison import (
    PairedPlansTask,
    compare_plans,
    error_scenarios,
    late_gain,
    leg_case,
)
from missionplan.studies.leg_length.plan_result import CandidatePlan, LegCase, LegPlan
from missionplan.studies.leg_length.sweep_scenario import SweepScenario
from missionplan.studies.run import Run


def plan_legs(
    mission: MissionOrPath,
    *,
    aim: Aim = "mean",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> LegPlan:
    """Find the best legs of a transit, and compare them with the best fixed d_max.

    Parameters
    ----------
    mission : Mission, str or Path
        Its transit is the one that `sweep` names, else the first.
    aim : {'mean', 'p95', 'energy'}
        What to make least: the expected time; the time that 95 % of the trials keep (where the mission requires a
        transit's `duration` to be `at_most` something, greatest: the probability of that); the energy, with the speed
        chosen too.
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler, progress
        See `run_blocks`.

    Raises
    ------
    InputError
        When the mission has no transit, or no legs can be planned for it.
    """
    run = Run.begun(
        "plan-legs",
        mission,
        one_of={"aim": (aim, get_args(Aim))},
        trials=trials,
        seed=seed,
        jobs=jobs,
        backend=backend,
        scheduler=scheduler,
        progress=progress,
    )
    scenario, seed = replace(SweepScenario.of(run.mission), sigmas=(None,)), run.seed
    wanted = LegAim(aim, _deadline(scenario)) if aim == "p95" else LegAim(aim)
    best = optimise_legs(scenario, wanted, seed, progress=progress, workers=run.workers.quiet)
    task = PairedPlansTask(scenario, error_scenarios(scenario), best.fixed, best.adaptive, run.trials, seed)
    tasks = [(task, None), *_explained(task, run)]
    evaluation = _Evaluation(
        cases=tuple(
            case for each, share in tasks for case in _judged(_cases(each, share, run.workers), each, wanted, best)
        ),
        candidates=compare_plans(scenario, wanted, best, run.trials, seed) if aim != "mean" else (),
        tracks=task.tracks(),
        members=tuple(case for each, share in _members(task, run) for case in _cases(each, share, run.workers)),
    )
    options = {"aim": aim, "jobs": jobs, "backend": backend, "scheduler": scheduler}
    provenance = run.provenance(options, (*run.mission.notices(), *_notices(scenario)))
    plan = _leg_plan(provenance, scenario, wanted, best, evaluation)
    recommended = {f"{plan.phase}.{key}": value for key, value in plan.changes.items()}
    return replace(plan, judged=judged(run.mission, recommended, trials=run.trials, seed=seed, jobs=jobs))


@dataclass(frozen=True)
class _Evaluation:
    """What trials show of the legs: cases, candidates, tracks by the fixed d_max and by the table, and members."""

    cases: tuple[LegCase, ...]
    candidates: tuple[CandidatePlan, ...]
    tracks: tuple[Array, Array]
    members: tuple[LegCase, ...]


def _explained(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans under each explanation of the mission, with its probability."""
    for each, _ in run.under_explanations():
        known = replace(SweepScenario.of(each.mission), sigmas=(None,))
        case = replace(AS_PLANNED, name=label(each.causes))
        yield replace(task, scenario=known, cases=(case,)), each.probability


def _members(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans in each member of the current's ensemble, with its probability."""
    means = task.scenario.means
    for name, probability, sailed, alone in run.in_members(means.recorded):
        given = replace(task.scenario, means=replace(means, recorded=sailed))
        case = replace(AS_PLANNED, name=name)
        yield replace(task, scenario=given, cases=(case,), trials=alone.trials), probability


def _cases(task: PairedPlansTask, share: float | None, workers: Workers) -> tuple[LegCase, ...]:
    """Run every block of each case, and merge its blocks."""
    items = [(number, block) for block in range(block_count(task.trials)) for number in range(len(task.cases))]
    totals: dict[int, Moments] = {}
    for (number, _), moments in zip(items, workers.run(task, items), strict=True):
        totals[number] = totals[number].merge(moments) if number in totals else moments
    found = (leg_case(task.scenario, case, totals[number]) for number, case in enumerate(task.cases))
    return tuple(replace(case, probability=share) for case in found)


def _judged(cases: tuple[LegCase, ...], task: PairedPlansTask, aim: LegAim, best: OptimisedLegs) -> tuple[LegCase, ...]:
    """Add what the table gains by the aim ``p95``, where that is the aim."""
    if aim.name != "p95":
        return cases
    gains = [late_gain(task.scenario, aim, best, case, task.trials, task.seed) for case in task.cases]
    return tuple(
        replace(case, late_saving=gain, late_saving_error=error)
        for case, (gain, error) in zip(cases, gains, strict=True)
    )


def _leg_plan(
    provenance: Provenance, scenario: SweepScenario, aim: LegAim, best: OptimisedLegs, evaluation: _Evaluation
) -> LegPlan:
    goal = scenario.means.position(scenario.phase.to)
    return LegPlan(
        provenance=provenance,
        phase=scenario.phase.name,
        phase_index=[phase.name for phase in scenario.mission.phases].index(scenario.phase.name),
        aim=aim.name,
        how_found=best.how_found,
        deadline=aim.deadline,
        distance=scenario.distance,
        speed=scenario.speed * best.speed_factor,
        mission_speed=scenario.speed,
        arrival_radius=scenario.arrival_radius,
        required_arrival=scenario.required_arrival,
        surfacing_time=scenario.surfacing_time,
        sigma=scenario.sigma(0),
        planned_sigma=best.spread.sigma,
        base_spread=best.spread.base,
        goal=(float(goal[0]), float(goal[1])),
        left=best.table.left,
        leg=best.table.leg,
        expected_cost=best.adaptive_cost,
        least_cost=best.least_cost,
        expected_surfacings=best.surfacings,
        fixed_d_max=best.d_max,
        fixed_cost=best.fixed_cost,
        one_leg_cost=best.one_leg_cost,
        cases=evaluation.cases,
        candidates=evaluation.candidates,
        fixed_tracks=evaluation.tracks[0],
        adaptive_tracks=evaluation.tracks[1],
        members=evaluation.members,
    )


def _deadline(scenario: SweepScenario) -> float:
    """Longest duration that the mission's requirements allow the transit; infinite without one [s]."""
    quantity = f"{scenario.phase.name}.duration"
    bounds = [requirement.at_most for requirement in scenario.mission.requirements if requirement.quantity == quantity]
    return min((float(bound) for bound in bounds if bound is not None), default=float("inf"))


def _notices(scenario: SweepScenario) -> tuple[str, ...]:
    obstacle = analytic_obstacle(scenario)
    if not obstacle:
        return ()
    return (
        f"the integral equation does not include {obstacle}: it uses the spread of legs in pilot trials of the "
        "mission, and only the trials show what the legs save",
    )
