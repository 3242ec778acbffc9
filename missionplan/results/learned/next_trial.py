"""The trial worth making next: what each design costs and tells, what that saves, and what its outcomes would mean."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Literal

import pandas as pd

from missionplan.results import to_csv, to_yaml
from missionplan.results.learned.evidence import Causes

LossUnit = Literal["W h", "min"]
MORE_RIGHT, NEARLY_RIGHT = 0.05, 0.03
"""Gain in the probability of doing right from which a trial is told to settle it, and what counts as equal."""


@dataclass(frozen=True)
class ValuedDesign:
    """A trial that could be made."""

    name: str
    """In words."""
    minutes: float
    """Time that it takes by the planner's model, without the way there and back [min]."""
    energy_wh: float | None
    """Energy that it takes [W h]; None where the mission has no energy budget, or the vehicle stays out of the water.
    """
    information: float
    """Expected gain in information about the causes and their sizes [nats]."""
    saving: float
    saving_error: float
    """Expected reduction of a mission's loss by the choice made after it, and its standard error [the loss's unit]."""
    right: float
    """Probability that what the crew then does about the vehicle is right: swing, calibrate, clean, or nothing."""


@dataclass(frozen=True)
class TrialOutcome:
    """One way in which the trial may come out."""

    probability: float
    causes: Causes
    """Likeliest then."""
    choice: float
    """What would then be chosen [m or N]."""
    saving: float
    """Expected reduction of a mission's loss then [the loss's unit]."""


@dataclass(frozen=True)
class OutcomeRule:
    """The simplest rule that tells from the trial's diagnosis whether another choice is right."""

    effect: str
    name: str
    unit: str
    """Parameter whose estimate decides."""
    threshold: float
    """Threshold [unit]."""
    above: bool
    """Whether the choice changes above the threshold or below it."""
    causes: Causes
    """Likeliest then."""
    choice: float
    """Commonest choice then [m or N]."""
    agreement: float
    """Share of the simulated outcomes in which the rule and the full calculation agree on whether the choice changes.
    """


@dataclass(frozen=True)
class NextTrial:
    """Which trial, if any, is worth making next."""

    decides: str = ""
    """Key of what is chosen: ``d_max_m`` or ``anchor_wet_weight_n``."""
    unit: LossUnit = "W h"
    """Of the loss."""
    choice: float = 0.0
    loss: float = 0.0
    """Best choice with what is known now [m or N], and its expected loss [unit]."""
    tried: tuple[float, float] = (0.0, 0.0)
    """Least and greatest choice of those tried [m or N]."""
    success: float = 0.0
    """Probability of success with it."""
    failure_loss: float = 0.0
    """Loss counted for a mission that fails [unit]."""
    perfect: float = 0.0
    """Expected saving if cause and sizes were known exactly [unit]."""
    explanations: tuple[tuple[Causes, float], ...] = ()
    """Sets of causes that may hold, with their probabilities."""
    designs: tuple[ValuedDesign, ...] = ()
    """Greatest saving first, then greatest information."""
    right: float = 0.0
    """Probability that what the crew does about the vehicle by what is known now is right."""
    best: ValuedDesign | None = None
    """The cheapest of those that save nearly the most; None where no trial is worth it."""
    outcomes: tuple[TrialOutcome, ...] = ()
    """Of the best, likeliest first."""
    rule: OutcomeRule | None = None
    """Of the best, where one parameter decides."""
    trial: Mapping[str, object] | None = None
    """Mission file's data of the one recommended; None for an instrument, or where none is."""
    reason: str | None = None
    """Why nothing was computed, where nothing was."""

    @property
    def settling(self) -> ValuedDesign | None:
        """The cheapest of those that nearly best tell what to do about the vehicle; None where none tells more."""
        most = max((each.right for each in self.designs), default=0.0)
        enough = [each for each in self.designs if each.right >= most - NEARLY_RIGHT]
        return min(enough, key=lambda each: each.minutes) if most > self.right + MORE_RIGHT else None

    @property
    def recommended(self) -> ValuedDesign | None:
        """The best for the plan, else what settles what to do about the vehicle."""
        return self.best or self.settling

    def summary(self) -> dict[str, object]:
        """Return the entry ``next_trial`` of ``diagnosis.json``."""
        if self.reason is not None:
            return {"reason": self.reason}
        unit = self.unit.replace(" ", "").lower()
        return {
            "decides": self.decides,
            "choice": self.choice,
            "tried": list(self.tried),
            f"loss_{unit}": self.loss,
            "success": self.success,
            "right": self.right,
            f"failure_loss_{unit}": self.failure_loss,
            f"perfect_saving_{unit}": self.perfect,
            "explanations": [{"causes": list(causes), "probability": p} for causes, p in self.explanations],
            "best": self.best.name if self.best is not None else None,
            "settling": self.settling.name if self.settling is not None else None,
            "designs": self.to_frame().to_dict(orient="records"),
            "outcomes": [asdict(outcome) for outcome in self.outcomes],
            "rule": asdict(self.rule) if self.rule is not None else None,
        }

    def to_frame(self) -> pd.DataFrame:
        """One row a design."""
        unit = self.unit.replace(" ", "").lower()
        rows = [
            {
                "design": each.name,
                "minutes": each.minutes,
                "energy_wh": each.energy_wh,
                "information_nats": each.information,
                f"saving_{unit}": each.saving,
                f"saving_error_{unit}": each.saving_error,
                "right": each.right,
            }
            for each in self.designs
        ]
        return pd.DataFrame(rows)

    def files(self) -> dict[str, str | bytes]:
        """``next-trials.csv``, and the recommended trial as ``next-trial.yaml``, with what its outcomes would mean."""
        found: dict[str, str | bytes] = {"next-trials.csv": to_csv(self.to_frame())} if self.designs else {}
        if self.trial is not None:
            told = "".join(f"# {line}\n" for line in self._notes())  # for who sails it
            found["next-trial.yaml"] = told + to_yaml(self.trial)
        return found

    def _notes(self) -> list[str]:
        made, unit = self.recommended, "m" if self.decides == "d_max_m" else "N"
        chosen = "d_max" if self.decides == "d_max_m" else "anchor's wet weight"
        lines = ["The trial that diagnose --next-trial found worth making; give its data to diagnose afterwards."]
        if made is not None:
            takes = f"{made.minutes:.0f} min" + (f" and {made.energy_wh:.3g} W h" if made.energy_wh else "")
            saves = f", and saves {made.saving:.2g} {self.unit} a mission on average" if self.best is made else ""
            right = f"{min(100.0 * made.right, 99.0):.0f} %, not {100.0 * self.right:.0f} %"
            lines.append(f"It takes {takes}, without the way there and back{saves}.")
            lines.append(
                f"What is done about the vehicle (swing, calibrate, clean, nothing) is then right with {right}."
            )
        if self.best is None:
            return lines
        lines.append(f"Now the {chosen} is best at {self.choice:.4g} {unit}. What the outcomes would mean:")
        for each in self.outcomes:
            same = f"keep {self.choice:.4g} {unit}"
            new = f"choose {each.choice:.4g} {unit}, which saves {max(each.saving, 0.0):.2g} {self.unit} a mission"
            looks = " and ".join(cause.replace("-", " ") for cause in each.causes) or "nothing new"
            percent = min(100.0 * each.probability, 99.0)  # the models are approximate: nothing is certain
            lines.append(f"- {looks} ({percent:.0f} %): {same if each.choice == self.choice else new}")
        if self.rule is not None:
            side = "above" if self.rule.above else "below"
            limit = f"{self.rule.effect}.{self.rule.name} {side} {self.rule.threshold:.2g} {self.rule.unit}".strip()
            lines.append(f"In short: choose {self.rule.choice:.4g} {unit} where the diagnosis has {limit}, else keep.")
        return lines
