"""A case as plain data, written in two folders: the tool's input and the truth."""

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml


@dataclass(frozen=True)
class Case:
    """One hidden-effect case.

    Attributes
    ----------
    seed, kind, scenario
        Arguments of ``draw_case`` that reproduce it.
    truth : tuple of str
        Effects of the catalogue that are in the data, sorted; empty for a control and for an outside effect.
    ties : tuple of tuple of str
        Sets of causes that are indistinguishable from the truth in these data.
    outside : str
        Name of the effect outside the catalogue, or empty.
    parameters : dict
        ``"effect.parameter"`` → true value (SI), where the contract has the same parameter.
    strength : float
        Strength of the effect in standard errors under the nuisances' covariance.
    mission, vehicle, dataset : dict
        Contents of the YAML files; the vehicle is None if inline or not needed.
    header, rows
        Contents of the CSV file.
    notes : dict
        Sizes and nuisances, for readers of ``truth.json``.
    """

    seed: int
    kind: str
    scenario: str
    truth: tuple[str, ...]
    ties: tuple[tuple[str, ...], ...]
    outside: str
    parameters: dict[str, float]
    strength: float
    mission: dict[str, Any]
    vehicle: dict[str, Any] | None
    dataset: dict[str, Any]
    header: list[str]
    rows: list[list[str]]
    notes: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name for folders and messages."""
        return f"{self.kind}-{self.scenario}-{self.seed}"

    def accepts(self, causes: list[str]) -> bool:
        """Whether these causes are the truth or exactly tied with it."""
        return tuple(sorted(causes)) in {self.truth, *self.ties}

    def write(self, folder: Path, truth_folder: Path) -> tuple[Path, Path]:
        """Write the tool's input and, elsewhere, the truth; return the paths of mission and data set."""
        data = folder / "data"
        data.mkdir(parents=True)
        truth_folder.mkdir(parents=True, exist_ok=True)
        mission = folder / "mission.yaml"
        mission.write_text(yaml.safe_dump(self.mission, sort_keys=False, allow_unicode=True), encoding="utf-8")
        if self.vehicle is not None:
            text = yaml.safe_dump(self.vehicle, sort_keys=False, allow_unicode=True)
            (folder / "vehicle.yaml").write_text(text, encoding="utf-8")
        text = yaml.safe_dump(self.dataset, sort_keys=False, allow_unicode=True)
        (data / "dataset.yaml").write_text(text, encoding="utf-8")
        with (data / self.dataset["file"]).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self.header)
            writer.writerows(self.rows)
        truth = {
            "seed": self.seed,
            "kind": self.kind,
            "scenario": self.scenario,
            "truth": self.truth,
            "ties": self.ties,
            "outside": self.outside,
            "parameters": self.parameters,
            "strength": self.strength,
            "notes": self.notes,
        }
        (truth_folder / f"{self.name}.json").write_text(json.dumps(truth, indent=1), encoding="utf-8")
        return mission, data
