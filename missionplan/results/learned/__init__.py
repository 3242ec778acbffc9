"""The answer of a diagnosis: what the simulation gets wrong, why, and what is gained; its parts are in `evidence`."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, ClassVar

import pandas as pd

from missionplan.results import Provenance, Result, mission_files, to_csv, to_json
from missionplan.results.entries import Entry, Record, summary_of
from missionplan.results.learned.evidence import (
    SURE,
    Causes,
    Discrepancy,
    ExplanationOdds,
    GroupScore,
    Judgement,
    KnownParameter,
    NextMeasurement,
    OutlyingGroup,
    ParameterEstimate,
    RankedSet,
    Readings,
    TakenAsExact,
    joined,
)
from missionplan.results.learned.levels import ParameterLevels
from missionplan.results.learned.next_trial import NextTrial
from missionplan.results.score import DatasetScore

Plan = Mapping[str, float | None]
"""What is chosen, and how it fares; keys end with their units."""


@dataclass(frozen=True)
class PlanGain(Record):
    """What the planner would choose before and after a diagnosis."""

    before: Annotated[Plan, Entry("plan with the base mission; empty where there is none")] = field(
        default_factory=dict
    )
    after: Annotated[Plan, Entry("plan with the extended mission; empty where there is none")] = field(
        default_factory=dict
    )
    base_choice_under_extended: Annotated[
        Plan | None, Entry("how the base mission's choice fares when the extended mission is true", optional=True)
    ] = None
    reason: Annotated[str | None, Entry("why there is no plan to compare", optional=True)] = None
    as_written_under_extended: Annotated[
        Plan | None,
        Entry("how what stands in the mission file, if one value, fares when the extended is true", optional=True),
    ] = None


@dataclass(frozen=True)
class Diagnosis(Judgement, Result):
    """What the simulation gets wrong, why, the extended model, the gain."""

    report: ClassVar[str] = "missionplan.report.diagnosis.page"

    provenance: Provenance
    kind: Annotated[str, Entry("of the data set")]
    data: Annotated[str, Entry("name of the data set", key="dataset")]
    source: str
    """Of the data set."""
    causes: Annotated[Causes, Entry("the claimed set; empty if none")]
    known: tuple[ParameterEstimate, ...]
    """What the mission knew of its own effects."""
    confirmed: tuple[ParameterEstimate, ...]
    """The same after these data, of the effects that have not changed."""
    misfit: Annotated[str, Entry("size of the base model's misfit in the planner's terms")]
    ranking: Annotated[tuple[RankedSet, ...], Entry("sets of causes, best first")]
    discrepancy: Annotated[Discrepancy, Entry("what the claimed model leaves", key="remainder")]
    base_discrepancy: Annotated[Discrepancy, Entry("what the base model leaves", key="base_remainder")]
    scores: tuple[GroupScore, ...]
    """Held-out scores of the best set, group by group; empty where there are none."""
    outlying_groups: Annotated[tuple[OutlyingGroup, ...], Entry("what the rest of the record does not predict")]
    indistinguishable: tuple[tuple[Causes, Causes], ...]
    """Pairs of sets that these data cannot tell apart."""
    next_measurements: Annotated[tuple[NextMeasurement, ...], Entry("what would separate the likeliest sets")]
    decision: Annotated[PlanGain, Entry("what the planner would choose before and after")]
    calibration: Annotated[Mapping[str, float], Entry("nuisance parameters of the base model as fitted")]
    untestable: Annotated[Mapping[str, str], Entry("effects that the data could not show, and why")]
    failures: Annotated[Mapping[str, str], Entry("sets that could not be fitted, and why")]
    residuals: pd.DataFrame
    """Row by row: data, base model, extended model, residuals."""
    extended: Mapping[str, object]
    """The mission's data with the causes as effects."""
    next_trial: Annotated[
        NextTrial | None, Entry("the trial worth making next, where it was asked for", optional=True)
    ] = None
    explanations: Annotated[
        tuple[ExplanationOdds, ...], Entry("what is in doubt, as the extended mission carries it; empty: nothing")
    ] = ()
    last_part: DatasetScore | None = None
    """The extended mission's score on the part of the record that was held out of everything, where one was."""
    learned_from: Annotated[tuple[str, ...], Entry("hash of each leg, dive or run that was new to the mission")] = ()
    exact: Annotated[
        tuple[TakenAsExact, ...], Entry("what is taken as exact, what matters most first", key="taken_as_exact")
    ] = ()
    readings: Annotated[Readings, Entry(inline=True)] = field(default_factory=Readings)
    """What else the posterior says."""
    levels: Annotated[
        tuple[ParameterLevels, ...],
        Entry("how what the vehicle has went from mission to mission, as the extended mission has learned it"),
    ] = ()

    @property
    def best(self) -> RankedSet | None:
        """The claimed set's entry; the first of the ranking where nothing is claimed; None without any."""
        return self.ranking[0] if self.ranking else None

    @property
    def changed(self) -> Annotated[Causes, Entry(key="changed_effects")]:
        """Effects of the mission that are not as it knew them."""
        return tuple(cause for cause in self.causes if any(cause == estimate.effect for estimate in self.known))

    def probability_of(self, effect: str) -> float:
        """Probability of one of the mission's own effects after these data; 1 where it has no doubt of it."""
        holding = [effect in odds.causes for odds in self.explanations]
        if not any(holding):
            return 1.0
        return sum(odds.probability for odds, holds in zip(self.explanations, holding, strict=True) if holds)

    @property
    def borne_out(self) -> Causes:
        """The mission's own effects that these data confirm, and that are in no doubt."""
        effects = dict.fromkeys(estimate.effect for estimate in self.confirmed)
        return tuple(effect for effect in effects if self.probability_of(effect) >= SURE)

    @property
    def before_and_after(self) -> Annotated[tuple[KnownParameter, ...], Entry(key="confirmed")]:
        """Parameters that these data confirm, before and after."""
        before = {(estimate.effect, estimate.name): estimate for estimate in self.known}
        return tuple(
            KnownParameter(
                after.effect, after.name, before[after.effect, after.name], after, self.probability_of(after.effect)
            )
            for after in self.confirmed
        )

    @property
    def has_changed(self) -> Annotated[bool, Entry(key="changed")]:
        """Whether an effect of the mission is not as it knew it."""
        return bool(self.changed)

    @property
    def not_told_apart(self) -> Annotated[tuple[tuple[str, ...], ...], Entry(key="indistinguishable")]:
        """Pairs of sets that these data cannot tell apart, each with plus signs between its causes."""
        return tuple(tuple(map(joined, pair)) for pair in self.indistinguishable)

    @property
    def coverage_scale(self) -> Annotated[float, Entry()]:
        """Factor on the random errors with which 90 % of the held-out values would have been inside."""
        return self.coverage.scale if self.coverage is not None else 1.0

    @property
    def extended_mission(self) -> Annotated[str, Entry()]:
        """File of the extended mission, beside this one."""
        return "mission.yaml"

    def diagnosis(self) -> dict[str, object]:
        """Return the dictionary of ``diagnosis.json``."""
        return summary_of(self)

    @property
    def certainty(self) -> Mapping[str, object] | None:
        """Probability of the claimed set of causes, and that none of these is behind the data."""
        best = self.best
        if best is None or best.posterior is None:
            return None
        return {"posterior": best.posterior if self.causes else None, "none_of_these": self.none_of_these}

    def to_frame(self) -> pd.DataFrame:
        """One row a set of the ranking."""
        rows = [
            {
                "causes": joined(entry.causes),
                "log_bayes_factor": entry.log_bayes_factor,
                "score": entry.score,
                "posterior": entry.posterior,
                "log_score_gain": entry.held_out.log_score_gain if entry.held_out else None,
                "share_explained": entry.share_explained,
            }
            for entry in self.ranking
        ]
        columns = ["causes", "log_bayes_factor", "score", "posterior", "log_score_gain", "share_explained"]
        return pd.DataFrame(rows, columns=columns)

    def files(self) -> dict[str, str | bytes]:
        """Return ``diagnosis.json``, ``residuals.csv``, ``ranking.csv``, the extended mission as ``mission.yaml``.

        Where a part was held out, ``score.json`` and ``score-residuals.csv`` of it too.
        """
        last_part: dict[str, str | bytes] = {}
        if self.last_part is not None:
            named = {"command": "score", "mission": self.provenance.mission, "datasets": [self.last_part.summary()]}
            last_part = {"score.json": to_json(named), "score-residuals.csv": to_csv(self.last_part.residuals())}
        return {
            "diagnosis.json": to_json(self.diagnosis()),
            "residuals.csv": to_csv(self.residuals),
            "ranking.csv": to_csv(self.to_frame()),
            **mission_files(self.extended),
            **(self.next_trial.files() if self.next_trial is not None else {}),
            **last_part,
        }


@dataclass(frozen=True)
class Campaign(Result):
    """Several data sets of one campaign."""

    report: ClassVar[str] = "missionplan.report.diagnosis.campaign"

    provenance: Provenance
    diagnoses: tuple[Diagnosis, ...]
    """In the order in which they were made: each with the mission that the one before had extended."""

    @property
    def extended(self) -> Mapping[str, object]:
        """The mission's data with what all data sets have shown."""
        return self.diagnoses[-1].extended

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the data sets, with the folder where several have the same name."""
        count = Counter(diagnosis.data for diagnosis in self.diagnoses)
        return tuple(
            diagnosis.data
            if count[diagnosis.data] == 1
            else f"{diagnosis.data} ({Path(str(diagnosis.provenance.options['dataset'])).name})"
            for diagnosis in self.diagnoses
        )

    @property
    def informed_by(self) -> Annotated[dict[str, tuple[str, ...]], Entry()]:
        """By effect that the extended mission has learned of, the data sets that had a say in it."""
        datasets: dict[str, list[str]] = {}
        for diagnosis, name in zip(self.diagnoses, self.names, strict=True):
            had_a_say = (*diagnosis.causes, *(p.effect for p in diagnosis.confirmed)) if diagnosis.learned_from else ()
            for effect in dict.fromkeys(had_a_say):
                datasets.setdefault(effect, []).append(name)
        return {effect: tuple(names) for effect, names in datasets.items()}

    @property
    def shared(self) -> Annotated[tuple[str, ...], Entry()]:
        """Effects of which more than one data set had a say."""
        return tuple(effect for effect, names in self.informed_by.items() if len(names) > 1)

    @property
    def datasets(self) -> Annotated[tuple[Mapping[str, object], ...], Entry()]:
        """The diagnosis of each data set."""
        return tuple({"name": diagnosis.data, **diagnosis.diagnosis()} for diagnosis in self.diagnoses)

    @property
    def extended_mission(self) -> Annotated[str, Entry()]:
        """File of the extended mission, beside this one."""
        return "mission.yaml"

    def diagnosis(self) -> dict[str, object]:
        """Return the dictionary of ``diagnosis.json``."""
        return summary_of(self)

    def to_frame(self) -> pd.DataFrame:
        """One row a data set."""
        rows = [
            {
                "dataset": diagnosis.data,
                "kind": diagnosis.kind,
                "verdict": diagnosis.verdict,
                "causes": joined(diagnosis.causes),
                "changed": joined(diagnosis.changed),
                "confirmed": joined(diagnosis.borne_out),
            }
            for diagnosis in self.diagnoses
        ]
        return pd.DataFrame(rows)

    def files(self) -> dict[str, str | bytes]:
        """``diagnosis.json``, ``campaign.csv``, the extended ``mission.yaml``, and a folder for each data set."""
        contents: dict[str, str | bytes] = {
            "diagnosis.json": to_json(self.diagnosis()),
            "campaign.csv": to_csv(self.to_frame()),
            **mission_files(self.extended),
        }
        for index, diagnosis in enumerate(self.diagnoses, start=1):
            files = {"summary.json": to_json(diagnosis.summary()), **diagnosis.files()}
            contents |= {f"{index}-{diagnosis.kind}/{name}": content for name, content in files.items()}
        return contents
