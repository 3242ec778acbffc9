"""`diagnose`: a mission and a data set in; verdict, causes, extended mission and gain out."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from missionplan.datasets import files_outside
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.experiment_design import discriminations
from missionplan.diagnosis.explanations import Weighed, hypotheses, odds, weighed, weighed_with_causes, with_found
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.given import forecast_notice
from missionplan.diagnosis.inference.model import CauseFit, FitRequest, fitted
from missionplan.diagnosis.inference.selection import Candidate
from missionplan.diagnosis.pipeline import PipelineResult, judge, read, run_pipeline
from missionplan.diagnosis.plan_gain import with_urgency
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission, MissionOrPath
from missionplan.results import Provenance
from missionplan.results.learned import Diagnosis, PlanGain
from missionplan.results.learned.evidence import Causes, GroupScore, Judgement, NextMeasurement, RankedSet, TakenAsExact
from missionplan.results.learned.levels import ParameterLevels
from missionplan.results.learned.next_trial import NextTrial
from missionplan.store.folder import as_path
from missionplan.studies.history import parameter_levels
from missionplan.studies.run import Run, check_arguments

Progress = Callable[[int, int], None]
"""Called with stages done, of how many."""

SEPARATED = 2
"""Rivals for which a next measurement is sought."""
STAGES = 6
NO_TRIAL = "no further trial is valued: that needs data which the mission has not learned from"


def diagnose(
    mission: MissionOrPath,
    dataset: str | Path,
    *,
    seed: int | None = None,
    jobs: int = 1,
    plan: bool = True,
    holdout: float | None = None,
    next_trial: bool = False,
    allow_outside: bool = False,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find out what a mission's simulation gets wrong about measured data, and why.

    Parameters
    ----------
    mission : Mission, str or Path
        The base model.
    dataset : str or Path
        Folder of a data set of any kind.
    seed : int, optional
        Of the plans before and after; default the mission's. The diagnosis itself draws nothing.
    jobs : int
        Processes for fits, predictions and plans; the numbers are the same with any.
    plan : bool
        Whether to plan with both models.
    holdout : float, optional
        Last share of the legs or dives that is kept away from everything, and on which the extended mission is scored.
    next_trial : bool
        Whether to value the trials that could be made next.
    allow_outside : bool
        Whether the data set's table may lie outside its folder.
    progress : callable, optional
        Called with stages done, of how many.

    Raises
    ------
    InputError
        When data set or mission lack what a diagnosis needs: all problems at once.
    RunError
        When not even the base model can be fitted.
    """
    mission = check_arguments(mission, seed=seed, jobs=jobs)
    seed = mission.monte_carlo.seed if seed is None else seed
    with (
        threadpool_limits(limits=1),
        files_outside(allowed=allow_outside),
    ):  # matrices of some hundred rows: more threads only wait for each other
        asked = _Asked(plan, next_trial, holdout)
        return _diagnose(mission, as_path(dataset, "dataset"), seed, jobs, asked, partial(_staged, progress, count(1)))


@dataclass(frozen=True)
class _Asked:
    """What is computed beside the diagnosis: plans, the value of further trials, the score on a part held out."""

    plan: bool
    next_trial: bool
    holdout: float | None


def _staged(progress: Progress | None, numbers: Iterator[int]) -> None:
    """Count a stage for a progress bar."""
    if progress is not None:
        progress(min(next(numbers), STAGES), STAGES)


def _diagnose(
    mission: Mission, dataset: Path, seed: int, jobs: int, asked: _Asked, stage: Callable[[], None]
) -> Diagnosis:
    started = time.perf_counter()
    part = None if asked.holdout is None else partial(_first_part, share=asked.holdout, seed=seed)
    explanations, selection = weighed_with_causes(weighed(mission, dataset, seed, jobs, part), jobs)
    bound = explanations[0].bound
    stage()
    is_new = not bound.is_known
    is_planned = asked.plan and is_new
    pipeline_result = run_pipeline(bound.model, stage, jobs, search=is_new, selection=selection)
    if not is_new:  # the mission's own effects are as they were known before
        base = replace(pipeline_result.selection.base, given=bound.known)
        pipeline_result = replace(pipeline_result, selection=replace(pipeline_result.selection, base=base), best=base)
    judgement = judge(bound, pipeline_result)
    scale = judgement.coverage.scale if judgement.coverage is not None else 1.0
    explanations = with_found(explanations, pipeline_result, jobs)
    believed = hypotheses(explanations, pipeline_result, scale) if is_new else ()
    extended = extended_mission(believed, bound.data.identities) if is_new else dict(mission.raw)
    stage()
    separated = _separated(bound, pipeline_result, judgement, jobs)
    stage()
    decision = bound.plan_gain(mission, extended, seed=seed, jobs=jobs) if is_planned else PlanGain()
    trial = _next_trial(explanations, pipeline_result, scale, seed, extended) if asked.next_trial and is_new else None
    untold = (NO_TRIAL,) if asked.next_trial and not is_new else ()
    provenance = Run("diagnose", mission, 0, seed, started=started).provenance(
        {"dataset": str(dataset), "jobs": jobs, **asdict(asked)},
        datasets=[dataset],
        notices=(
            *mission.notices(),
            *bound.data.notices,
            *forecast_notice(mission, pipeline_result.best.causes),
            *untold,
        ),
    )
    result = _result(provenance, bound, pipeline_result, judgement, separated, decision, extended)
    last = None
    if asked.holdout is not None:
        from missionplan.diagnosis.scoring.holdout import score_last_part  # models of legs and dives, for it alone

        last = score_last_part(dataset, asked.holdout, mission, extended, seed)
    levels = _levels(Mission.from_data(extended, file=mission.file), seed, urgency=is_planned)
    in_doubt = odds(explanations, believed)
    exact = taken_as_exact(bound, pipeline_result, jobs) if is_planned else ()
    return replace(result, exact=exact, next_trial=trial, explanations=in_doubt, last_part=last, levels=levels)


NEAREST = 2
"""Sets of the ranking beside the claimed one and none, of which one may be likelier when something is put off."""


def taken_as_exact(bound: DataKind, pipeline_result: PipelineResult, jobs: int = 1) -> tuple[TakenAsExact, ...]:
    """Fit the likeliest sets again with each thing that is taken as exact put off; what matters most comes first.

    The score of a set then is that of now and what its evidence gains. Nothing is said where what is claimed has no
    name, and of what cannot be fitted.
    """
    claimed = pipeline_result.best.causes
    scores: dict[Causes, float] = {(): 0.0}
    scores |= {one.causes: one.score for one in pipeline_result.selection.ranking if _is_named(one.causes)}
    if claimed not in scores:
        return ()
    sets = list(dict.fromkeys([(), claimed, *list(scores)[1 : NEAREST + 1]]))
    wanted: list[FitRequest] = [(causes, ()) for causes in sets]
    models = (("", "", bound.model), *bound.put_off())
    (_, _, now), *others = [(what, instead, fitted(model, wanted, jobs)) for what, instead, model in models]
    known, rows = np.array([scores[causes] for causes in sets]), []
    for what, instead, then in others:
        pairs = [
            (was, is_now)
            for was, is_now in zip(now, then, strict=True)
            if isinstance(was, CauseFit) and isinstance(is_now, CauseFit)
        ]
        if len(pairs) < len(sets):
            continue
        gains = np.array([is_now.log_evidence - was.log_evidence for was, is_now in pairs])
        first, likeliest = (sets[int(np.argmax(masses))] for masses in (known, known + gains))
        before, after = pairs[sets.index(claimed)]
        moved = [
            replace(was, value=is_now.value - was.value, low=is_now.low - was.low, high=is_now.high - was.high)
            for was, is_now in zip(before.estimates, after.estimates, strict=True)
            if CATALOGUE[was.effect].tier == "physical"
        ]
        most = max(moved, key=lambda move: abs(move.value) / max(move.sd, 1e-30), default=None)
        rows.append(TakenAsExact(what, instead, most, likeliest, likeliest != first))
    return tuple(sorted(rows, key=lambda row: (not row.turns, -row.in_sd)))


def _is_named(causes: Causes) -> bool:
    return all(CATALOGUE[name].tier != "neutral" for name in causes)


def _next_trial(
    explanations: Sequence[Weighed],
    pipeline_result: PipelineResult,
    scale: float,
    seed: int,
    extended: Mapping[str, object],
) -> NextTrial:
    """Choose the trial that would serve best; its mission names the draws that the extended one does."""
    from missionplan.diagnosis.next_trial import next_trial  # models of legs and dives, for it alone

    trial = next_trial(explanations, pipeline_result, scale, seed)
    common = {key: extended[key] for key in ("posterior", "learned_from") if key in extended}
    return trial if trial.trial is None else replace(trial, trial={**trial.trial, **common})


def _levels(learned: Mission, seed: int, *, urgency: bool) -> tuple[ParameterLevels, ...]:
    """How the vehicle's parameters go from mission to mission, and when that will matter, if it is asked for."""
    if learned.posterior is None:
        return ()
    levels = parameter_levels(learned.posterior.seen)
    return with_urgency(levels, learned, seed) if urgency else levels


def _separated(
    bound: DataKind, pipeline_result: PipelineResult, judgement: Judgement, jobs: int
) -> list[tuple[NextMeasurement, bool]]:
    """Next measurements that separate the first rivals from the claimed set."""
    fits = {candidate.causes: candidate.fit for candidate in pipeline_result.selection.ranking}
    rivals = [fits[causes] for causes in judgement.rivals if causes in fits][:SEPARATED]
    return discriminations(bound.model, pipeline_result.best, rivals, jobs)


def _result(
    provenance: Provenance,
    bound: DataKind,
    pipeline_result: PipelineResult,
    judgement: Judgement,
    separated: Sequence[tuple[NextMeasurement, bool]],
    decision: PlanGain,
    extended: dict[str, object],
) -> Diagnosis:
    residuals = bound.residual_table(pipeline_result.selection.base, pipeline_result.best)
    listed = pipeline_result.selection.ranking[:LISTED]
    shares = bound.shares_explained(pipeline_result.selection.base, [candidate.fit for candidate in listed], residuals)
    return Diagnosis(
        **vars(judgement),
        provenance=provenance,
        kind=bound.kind,
        data=bound.data.name,
        source=bound.data.source,
        causes=pipeline_result.best.causes,
        known=bound.known,
        confirmed=pipeline_result.best.given,
        misfit=bound.misfit(residuals),
        ranking=tuple(
            _ranked(pipeline_result, candidate, share) for candidate, share in zip(listed, shares, strict=True)
        ),
        discrepancy=pipeline_result.discrepancy,
        base_discrepancy=pipeline_result.base_discrepancy,
        scores=group_scores(pipeline_result),
        outlying_groups=pipeline_result.outlying_groups,
        indistinguishable=tuple(measurement.separates for measurement, is_alike in separated if is_alike),
        next_measurements=tuple(measurement for measurement, _ in separated),
        decision=decision,
        calibration=bound.calibration(pipeline_result.best),
        untestable=bound.model.untestable,
        failures={"+".join(failure.causes): failure.reason for failure in pipeline_result.selection.failed},
        residuals=residuals,
        extended=extended,
        learned_from=() if bound.is_known else bound.data.identities,
        readings=read(bound, pipeline_result),
    )


def _first_part(bound: DataKind, *, share: float, seed: int) -> DataKind:
    """Return a record without its last share; the models of legs and dives are imported for it alone."""
    from missionplan.diagnosis.scoring.holdout import first_part

    return first_part(bound, share, seed)


LISTED = 12
"""Sets of the ranking that are reported."""


def _ranked(pipeline_result: PipelineResult, candidate: Candidate, share: float) -> RankedSet:
    held_out = pipeline_result.held_out.get(candidate.causes)
    return RankedSet(
        candidate.causes,
        candidate.log_bayes_factor,
        candidate.score,
        pipeline_result.selection.posterior.get(candidate.causes),
        candidate.fit.estimates,
        held_out.gain if held_out else None,
        share,
    )


def group_scores(pipeline_result: PipelineResult) -> tuple[GroupScore, ...]:
    """Return the held-out scores of the best set, group by group; none where it was not held out."""
    ranking = pipeline_result.selection.ranking
    held_out = pipeline_result.held_out.get(ranking[0].causes) if ranking else None
    if held_out is None:
        return ()
    return tuple(
        GroupScore(
            before.group,
            before.log_score,
            after.log_score,
            float(np.sqrt(before.squared_error / before.count)),
            float(np.sqrt(after.squared_error / after.count)),
        )
        for before, after in zip(held_out.base, held_out.extended, strict=True)
    )
