"""The answer of a diagnosis: what the simulation gets wrong, why, and what is gained; its parts are in `evidence`."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import ClassVar

import pandas as pd

from missionplan.results import Provenance, Result, mission_files, to_csv, to_json
from missionplan.results.entries import fields_of
from missionplan.results.learned.evidence import (
    SURE,
    Causes,
    Discrepancy,
    ExplanationOdds,
    GroupScore,
    Judgement,
    NextMeasurement,
    ParameterEstimate,
    RankedSet,
    Readings,
)
from missionplan.results.learned.levels import ParameterLevels
from missionplan.results.learned.next_trial import NextTrial
from missionplan.results.score import DatasetScore

_RESPONSE = ("axis", "what", "probability")
Plan = Mapping[str, float | None]
"""What is chosen, and how it fares; keys end with their units."""


@dataclass(frozen=True)
class PlanGain:
    """What the planner would choose before and after a diagnosis."""

    before: Plan = field(default_factory=dict)
    after: Plan = field(default_factory=dict)
    """Plans with the base and with the extended mission; empty where there is none."""
    base_choice_under_extended: Plan | None = None
    """How the base mission's choice fares when the extended mission is true."""
    reason: str | None = None
    """Why there is no plan to compare."""
    as_written_under_extended: Plan | None = None
    """How what stands in the mission file fares when the extended mission is true; None where that is no one value."""

    def summary(self) -> dict[str, object]:
        """Return the entry of ``decision``."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Diagnosis(Judgement, Result):
    """What the simulation gets wrong, why, the extended model, the gain."""

    report: ClassVar[str] = "missionplan.report.diagnosis.page"

    provenance: Provenance
    kind: str
    data: str
    source: str
    """Of the data set."""
    causes: Causes
    """The claimed set; empty if none."""
    known: tuple[ParameterEstimate, ...]
    """What the mission knew of its own effects."""
    confirmed: tuple[ParameterEstimate, ...]
    """The same after these data, of the effects that have not changed."""
    misfit: str
    """Size of the base model's misfit in the planner's terms."""
    ranking: tuple[RankedSet, ...]
    """Best first."""
    discrepancy: Discrepancy
    base_discrepancy: Discrepancy
    """What the claimed model leaves, and the base model."""
    scores: tuple[GroupScore, ...]
    """Held-out scores of the best set, group by group; empty where there are none."""
    outlying_groups: tuple[tuple[str, float], ...]
    """Group and p-value."""
    indistinguishable: tuple[tuple[Causes, Causes], ...]
    """Pairs of sets that these data cannot tell apart."""
    next_measurements: tuple[NextMeasurement, ...]
    decision: PlanGain
    """What the planner would choose before and after."""
    calibration: Mapping[str, float]
    """Nuisance parameters of the base model as fitted."""
    untestable: Mapping[str, str]
    failures: Mapping[str, str]
    """Effects that the data could not show and sets that could not be fitted, and why."""
    residuals: pd.DataFrame
    """Row by row: data, base model, extended model, residuals."""
    extended: Mapping[str, object]
    """The mission's data with the causes as effects."""
    next_trial: NextTrial | None = None
    """The trial worth making next, where it was asked for."""
    explanations: tuple[ExplanationOdds, ...] = ()
    """What is in doubt, as that mission carries it; empty where nothing is."""
    last_part: DatasetScore | None = None
    """The extended mission's score on the part of the record that was held out of everything, where one was."""
    learned_from: tuple[str, ...] = ()
    """Hash of each leg, dive or run that was new to the mission."""
    readings: Readings = field(default_factory=Readings)
    """What else the posterior says."""

    levels: tuple[ParameterLevels, ...] = ()
    """How what the vehicle has went from mission to mission, as the extended mission has learned it."""

    @property
    def best(self) -> RankedSet | None:
        """The claimed set's entry; the first of the ranking where nothing is claimed; None without any."""
        return self.ranking[0] if self.ranking else None

    @property
    def changed(self) -> Causes:
        """Effects of the mission that are not as it knew them."""
        return tuple(cause for cause in self.causes if any(cause == estimate.effect for estimate in self.known))

    def probability_of(self, effect: str) -> float:
        """Probability of one of the mission's own effects after these data; 1 where it has no doubt of it."""
        holding = [effect in each.causes for each in self.explanations]
        if not any(holding):
            return 1.0
        return sum(each.probability for each, holds in zip(self.explanations, holding, strict=True) if holds)

    @property
    def borne_out(self) -> Causes:
        """The mission's own effects that these data confirm, and that are in no doubt."""
        effects = dict.fromkeys(estimate.effect for estimate in self.confirmed)
        return tuple(effect for effect in effects if self.probability_of(effect) >= SURE)

    def _confirmed_summary(self) -> list[dict[str, object]]:
        before = {(estimate.effect, estimate.name): estimate for estimate in self.known}
        return [
            {
                "effect": after.effect,
                "name": after.name,
                "prior": before[after.effect, after.name].quantity_summary(),
                "posterior": after.quantity_summary(),
                "probability": self.probability_of(after.effect),
            }
            for after in self.confirmed
        ]

    def diagnosis(self) -> dict[str, object]:
        """Return the dictionary of ``diagnosis.json``."""
        return {
            "verdict": self.verdict,
            "causes": list(self.causes),
            "misfit": self.misfit,
            "credible_set": [list(causes) for causes in self.credible_set],
            "ranking": [fields_of(entry) for entry in self.ranking],
            "remainder": self.discrepancy.summary(),
            "base_remainder": self.base_discrepancy.summary(),
            "outlying_groups": [{"group": group, "p_value": p_value} for group, p_value in self.outlying_groups],
            "indistinguishable": [["+".join(causes) for causes in pair] for pair in self.indistinguishable],
            "next_measurements": [entry.summary() for entry in self.next_measurements],
            "decision": self.decision.summary(),
            "calibration": dict(self.calibration),
            "learned_from": list(self.learned_from),
            "untestable": dict(self.untestable),
            "failures": dict(self.failures),
            "extended_mission": "mission.yaml",
            "confirmed": self._confirmed_summary(),
            "levels": [each.summary() for each in self.levels],
            "explanations": [each.summary() for each in self.explanations],
            "changed": bool(self.changed),
            "changed_effects": list(self.changed),
            "not_constant": list(self.not_constant),
            "suspect_labels": self.suspect_labels,
            "none_of_these": self.none_of_these,
            **fields_of(self.readings),
            "responses": [dict(zip(_RESPONSE, each, strict=True)) for each in self.readings.responses],
            "coverage_scale": self.coverage.scale if self.coverage is not None else 1.0,
            **({"next_trial": self.next_trial.summary()} if self.next_trial is not None else {}),
        }

    def summary(self) -> dict[str, object]:
        """Return the dictionary of ``summary.json``."""
        entries = {**self.provenance.summary(), "dataset": self.data, "kind": self.kind, **self.diagnosis()}
        return self.with_decision(entries)

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
                "causes": "+".join(entry.causes),
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
        count = Counter(each.data for each in self.diagnoses)
        return tuple(
            each.data
            if count[each.data] == 1
            else f"{each.data} ({Path(str(each.provenance.options['dataset'])).name})"
            for each in self.diagnoses
        )

    @property
    def informed_by(self) -> dict[str, tuple[str, ...]]:
        """By effect that the extended mission has learned of, the data sets that had a say in it."""
        found: dict[str, list[str]] = {}
        for each, name in zip(self.diagnoses, self.names, strict=True):
            had_a_say = (*each.causes, *(p.effect for p in each.confirmed)) if each.learned_from else ()
            for effect in dict.fromkeys(had_a_say):
                found.setdefault(effect, []).append(name)
        return {effect: tuple(names) for effect, names in found.items()}

    @property
    def shared(self) -> tuple[str, ...]:
        """Effects of which more than one data set had a say."""
        return tuple(effect for effect, names in self.informed_by.items() if len(names) > 1)

    def diagnosis(self) -> dict[str, object]:
        """Return the dictionary of ``diagnosis.json``."""
        return {
            "datasets": [{"name": each.data, "kind": each.kind, **each.diagnosis()} for each in self.diagnoses],
            "informed_by": {effect: list(names) for effect, names in self.informed_by.items()},
            "shared": list(self.shared),
            "extended_mission": "mission.yaml",
        }

    def summary(self) -> dict[str, object]:
        """Return the dictionary of ``summary.json``."""
        return self.with_decision({**self.provenance.summary(), **self.diagnosis()})

    def to_frame(self) -> pd.DataFrame:
        """One row a data set."""
        rows = [
            {
                "dataset": each.data,
                "kind": each.kind,
                "verdict": each.verdict,
                "causes": "+".join(each.causes),
                "changed": "+".join(each.changed),
                "confirmed": "+".join(each.borne_out),
            }
            for each in self.diagnoses
        ]
        return pd.DataFrame(rows)

    def files(self) -> dict[str, str | bytes]:
        """``diagnosis.json``, ``campaign.csv``, the extended ``mission.yaml``, and a folder for each data set."""
        found: dict[str, str | bytes] = {
            "diagnosis.json": to_json(self.diagnosis()),
            "campaign.csv": to_csv(self.to_frame()),
            **mission_files(self.extended),
        }
        for index, each in enumerate(self.diagnoses, start=1):
            own = {"summary.json": to_json(each.summary()), **each.files()}
            found |= {f"{index}-{each.kind}/{name}": content for name, content in own.items()}
        return found
