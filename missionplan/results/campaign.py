"""Result of `diagnose` with several data sets: each against what those before had shown, and one extended mission."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from missionplan.results.base import Provenance, Result, mission_files, to_csv, to_json
from missionplan.results.learned.diagnosis import Diagnosis


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
                "confirmed": "+".join(dict.fromkeys(p.effect for p in each.confirmed)),
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
