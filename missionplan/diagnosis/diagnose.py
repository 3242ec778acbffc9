"""`diagnose`: a mission and a data set in; verdict, causes, extended mission and gain out."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from missionplan.datasets.dives import read_descent
from missionplan.datasets.legs import TransitData, read_transit
from missionplan.datasets.reading import DIAGNOSED, TANK
from missionplan.datasets.summaries import read_summary
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.preparation import prepare_dives
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.inference.cross_validation import HeldOut
from missionplan.diagnosis.inference.discrepancy import Discrepancy
from missionplan.diagnosis.inference.experiment_design import ProposedMeasurement, discriminations
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import Candidate
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.legs.one_step import one_step
from missionplan.diagnosis.model_factory import descent_model, summary_model, transit_model
from missionplan.diagnosis.pipeline import PipelineResult, run_pipeline
from missionplan.diagnosis.plan_gain import decide
from missionplan.diagnosis.summaries.model import SummaryModel
from missionplan.diagnosis.summaries.tables import summary_misfit, summary_residuals
from missionplan.diagnosis.tables import (
    descent_misfit,
    descent_residuals,
    descent_shares,
    transit_misfit,
    transit_residuals,
    transit_share,
)
from missionplan.diagnosis.tank.data import TankSet, read_tank
from missionplan.diagnosis.tank.extended_mission import extended_tank_mission
from missionplan.diagnosis.tank.model import TankModel
from missionplan.diagnosis.tank.model_factory import tank_forward
from missionplan.diagnosis.tank.tables import tank_misfit, tank_residuals, tank_share
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.reading.documents import load_document
from missionplan.results.base import Provenance
from missionplan.results.diagnosis import (
    Diagnosis,
    DiscrepancyFound,
    GroupScore,
    HeldOutGain,
    NextMeasurement,
    ParameterEstimate,
    RankedSet,
    Verdict,
)

Progress = Callable[[int, int], None]

LISTED = 12
"""Sets of the ranking that are reported."""
SEPARATED = 2
"""Rivals for which a next measurement is sought."""
STAGES = 8


def diagnose(
    mission: Mission,
    dataset: str | Path,
    *,
    seed: int | None = None,
    jobs: int = 1,
    plan: bool = True,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find out what a mission's simulation gets wrong about measured data, and why.

    Parameters
    ----------
    mission : Mission
        The base model.
    dataset : str or Path
        Folder of a data set of any kind.
    seed : int, optional
        Of the plans before and after; default the mission's. The diagnosis itself draws nothing.
    jobs : int
        Processes for fits, predictions and plans; the numbers are the same with any.
    plan : bool
        Whether to plan with both models.
    progress : callable, optional
        Told stages done, of how many.

    Raises
    ------
    InputError
        When data set or mission lack what a diagnosis needs: all problems at once.
    RunError
        When not even the base model can be fitted.
    """
    seed = mission.monte_carlo.seed if seed is None else seed
    with threadpool_limits(limits=1):  # matrices of some hundred rows: more threads only wait for each other
        return _diagnosis(mission, Path(dataset), seed, jobs, plan=plan, stage=_Stages(progress))


def _diagnosis(mission: Mission, dataset: Path, seed: int, jobs: int, *, plan: bool, stage: "_Stages") -> Diagnosis:
    started = time.perf_counter()
    model, data, kind = _bind(dataset, mission, seed)
    stage("data read")
    found = run_pipeline(model, lambda what, done, of: stage(what), jobs)
    described = _Described(model, found)
    extended = _extended(mission, found.best, data)
    stage("next measurements")
    first, rivals = found.best, [rival.fit for rival in found.claimed.rivals[:SEPARATED]] if found.claimed else []
    next_to = discriminations(model, first, rivals, jobs)
    stage("plans")
    decision = decide(kind, mission, extended, seed=seed, jobs=jobs) if plan else {"before": {}, "after": {}}
    provenance = Provenance(
        command="diagnose",
        mission=mission.name,
        file=mission.file,
        seed=seed,
        trials=0,
        options={"dataset": str(dataset), "jobs": jobs},
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=(*mission.notices(), *data.notices),
    )
    return Diagnosis(
        provenance=provenance,
        kind=kind,
        data=data.name,
        source=data.source,
        verdict=_tempered(found.verdict, kind),
        causes=found.best.causes,
        misfit=described.misfit(),
        credible_set=found.credible_set,
        ranking=described.ranking(),
        rivals=tuple(rival.causes for rival in found.claimed.rivals) if found.claimed else (),
        discrepancy=_discrepancy(found.discrepancy),
        base_discrepancy=_discrepancy(found.base_discrepancy),
        scores=described.scores(),
        outlying_groups=found.outlying_groups,
        indistinguishable=tuple(
            (rival.discrimination.first, rival.discrimination.second) for rival in next_to if rival.alike
        ),
        next_measurements=tuple(_next(rival.discrimination) for rival in next_to),
        decision=decision,
        calibration=described.calibration(),
        untestable=model.untestable,
        failures={"+".join(failure.causes): failure.reason for failure in found.selection.failed},
        residuals=described.residuals,
        extended=extended,
    )


class _Stages:
    """Counts stages for a progress bar."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress, self._done = progress, 0

    def __call__(self, what: str) -> None:
        self._done = min(self._done + 1, STAGES)
        if self._progress is not None:
            self._progress(self._done, STAGES)


def _extended(mission: Mission, best: CauseFit, data: Any) -> dict[str, Any]:
    if isinstance(data, TankSet):
        return extended_tank_mission(mission, best.estimates, best.calibration, data)
    legs = data if isinstance(data, TransitData) else None
    return extended_mission(mission.raw, best.estimates, best.calibration, legs)


def _bind(folder: Path, mission: Mission, seed: int) -> tuple[TransitModel | DescentModel | TankModel, Any, str]:
    """Read the data set and bind the mission to it."""
    document = load_document(folder / "dataset.yaml")
    kind = document.data.get("kind") if isinstance(document.data, dict) else None
    if kind == "transit":
        legs = read_transit(folder, mission)
        return transit_model(legs, mission, seed), legs, kind
    if kind == "descent":
        dives = prepare_dives(read_descent(folder, mission))
        return descent_model(dives, mission), dives, kind
    if kind == "summary":
        tests = read_summary(folder, mission)
        return summary_model(tests, mission), tests, kind
    if kind in TANK:
        tank = read_tank(folder)
        return TankModel(tank_forward(tank.tank, mission)), tank, kind
    message = f"given {kind!r}, expected one of {', '.join((*DIAGNOSED, *TANK))}"
    raise InputError([document.problem(("kind",), message)])


class _Described:
    """An examination in the words and tables of the result."""

    def __init__(self, model: TransitModel | DescentModel | TankModel, found: PipelineResult) -> None:
        self._model, self._found = model, found
        base, best = found.selection.base, found.best
        self.residuals: pd.DataFrame
        if isinstance(model, TransitModel):
            self.residuals = transit_residuals(model, base, best)
        elif isinstance(model, TankModel):
            self.residuals = tank_residuals(model, best)
        elif isinstance(model, SummaryModel):
            self.residuals = summary_residuals(model, base, best)
        else:
            self.residuals = descent_residuals(model, base, best)

    def misfit(self) -> str:
        """Size of the misfit in the planner's terms."""
        if isinstance(self._model, TransitModel):
            return transit_misfit(self._model)
        if isinstance(self._model, TankModel):
            return tank_misfit(self._model, self.residuals)
        return (summary_misfit if isinstance(self._model, SummaryModel) else descent_misfit)(self.residuals)

    def ranking(self) -> tuple[RankedSet, ...]:
        """Sets, best first."""
        listed = self._found.selection.ranking[:LISTED]
        shares = self._shares([candidate.fit for candidate in listed])
        return tuple(self._ranked(candidate, share) for candidate, share in zip(listed, shares, strict=True))

    def _ranked(self, candidate: Candidate, share: float) -> RankedSet:
        gain = self._found.gains.get(candidate.causes)
        return RankedSet(
            candidate.causes,
            candidate.log_bayes_factor,
            candidate.score,
            self._found.posterior.get(candidate.causes),
            tuple(ParameterEstimate(**asdict(estimate)) for estimate in candidate.fit.estimates),
            _gain(gain) if gain else None,
            share,
            self._found.checks.get(candidate.causes),
        )

    def _shares(self, fits: Sequence[CauseFit]) -> list[float]:
        if isinstance(self._model, TransitModel):
            return [transit_share(self._model, fit) for fit in fits]
        if isinstance(self._model, TankModel):
            return [tank_share(self.residuals, fit) for fit in fits]
        return descent_shares(self._model, self._found.selection.base, fits)

    def scores(self) -> tuple[GroupScore, ...]:
        """Held-out scores of the best set, group by group."""
        ranking = self._found.selection.ranking
        gain = self._found.gains.get(ranking[0].causes) if ranking else None
        if gain is None:
            return ()
        return tuple(
            GroupScore(
                before.group,
                before.log_score,
                after.log_score,
                float(np.sqrt(before.squared_error / before.count)),
                float(np.sqrt(after.squared_error / after.count)),
            )
            for before, after in zip(gain.base, gain.extended, strict=True)
        )

    def calibration(self) -> Mapping[str, float]:
        """Nuisances as fitted, and for navigation logs the prediction of the next leg."""
        values = dict(self._found.best.calibration)
        ahead = one_step(self._model, self._found.best) if isinstance(self._model, TransitModel) else None
        if ahead is not None:
            values |= {
                "next_leg_mean_so_far_rms_m": ahead.mean_so_far,
                "next_leg_last_leg_rms_m": ahead.last_leg,
                "next_leg_model_rms_m": ahead.model,
            }
        return values


def _tempered(verdict: Verdict, kind: str) -> Verdict:
    """A summary of a few numbers, its times shifted by hand, explains nothing by itself."""
    return "ambiguous" if kind == "summary" and verdict == "explained" else verdict


def _gain(gain: HeldOut) -> HeldOutGain:
    names = HeldOutGain.__dataclass_fields__
    return HeldOutGain(**{name: getattr(gain, name) for name in names})


def _next(found: ProposedMeasurement) -> NextMeasurement:
    return NextMeasurement((found.first, found.second), found.measurement, found.expected_log_bayes_factor)


def _discrepancy(found: Discrepancy) -> DiscrepancyFound:
    tests = tuple((test.name, test.p_value) for test in found.tests)
    told = DiscrepancyFound(found.log_bayes_factor, found.axis, found.resembles, found.by_axis, tests)
    if found.shape is None:
        return told
    table = pd.DataFrame({"at": found.shape.at, "mean": found.shape.mean, "sd": found.shape.sd})
    return replace(told, place=found.shape.place, value=found.shape.value, shape=table)
