"""The trial worth making next: what each design costs and tells, what that saves, and what its outcomes would mean."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import pandas as pd

from missionplan.results import to_csv, to_yaml
from missionplan.results.entries import Entry, Record
from missionplan.results.learned.evidence import Causes

LossUnit = Literal["W h", "min"]
MORE_RIGHT, NEARLY_RIGHT = 0.05, 0.03
"""Gain in the probability of doing right from which a trial is told to settle it, and what counts as equal."""


def _is_computed(told: Any) -> bool:
    """Whether a trial was looked for."""
    return getattr(told, "reason", None) is None


def _in_energy(told: Any) -> bool:
    return _is_computed(told) and told.unit == "W h"


def _in_time(told: Any) -> bool:
    return _is_computed(told) and told.unit == "min"


@dataclass(frozen=True)
class ValuedDesign(Record):
    """A trial that could be made."""

    name: Annotated[str, Entry("in words", key="design")]
    minutes: Annotated[float, Entry("that it takes by the planner's model, without the way there and back")]
    energy_wh: Annotated[
        float | None,
        Entry("that it takes; null: no energy budget, or the vehicle stays out of the water", "W h", ending=False),
    ]
    information: Annotated[float, Entry("expected gain about the causes and their sizes", "nats")]
    saving: Annotated[
        float,
        Entry("expected reduction of a mission's loss by the choice made after it", "W h", when=_in_energy),
        Entry("expected reduction of a mission's loss by the choice made after it", "min", when=_in_time),
    ]
    saving_error: Annotated[
        float,
        Entry("standard error of the saving", "W h", when=_in_energy),
        Entry("standard error of the saving", "min", when=_in_time),
    ]
    right: Annotated[
        float,
        Entry(
            "probability that the crew then does what is right about the vehicle: swing, calibrate, clean or nothing"
        ),
    ]
    unit: LossUnit = "W h"
    """Of the loss."""


@dataclass(frozen=True)
class TrialOutcome(Record):
    """One way in which the trial may come out."""

    probability: Annotated[float, Entry("of it")]
    causes: Annotated[Causes, Entry("likeliest then")]
    choice: Annotated[float, Entry("what would then be chosen [m or N]")]
    saving: Annotated[float, Entry("expected reduction of a mission's loss then, in the loss's unit")]


@dataclass(frozen=True)
class OutcomeRule(Record):
    """The simplest rule that tells from the trial's diagnosis whether another choice is right."""

    effect: Annotated[str, Entry("whose parameter's estimate decides")]
    name: Annotated[str, Entry("of the parameter")]
    unit: Annotated[str, Entry("of the parameter")]
    threshold: Annotated[float, Entry("in that unit")]
    above: Annotated[bool, Entry("whether the choice changes above the threshold or below it")]
    causes: Annotated[Causes, Entry("likeliest then")]
    choice: Annotated[float, Entry("commonest choice then [m or N]")]
    agreement: Annotated[
        float, Entry("share of the simulated outcomes in which the rule and the full calculation agree")
    ]


class PossibleSet(NamedTuple):
    """A set of causes that may hold."""

    causes: Annotated[Causes, Entry("effects of the set")]
    probability: Annotated[float, Entry("of it")]


@dataclass(frozen=True)
class NextTrial(Record):
    """Which trial, if any, is worth making next."""

    decides: Annotated[
        str, Entry("key of what is chosen: ``d_max_m`` or ``anchor_wet_weight_n``", when=_is_computed)
    ] = ""
    unit: LossUnit = "W h"
    """Of the loss."""
    choice: Annotated[float, Entry("best choice with what is known now [m or N]", when=_is_computed)] = 0.0
    loss: Annotated[
        float,
        Entry("expected loss of that choice", "W h", when=_in_energy),
        Entry("expected loss of that choice", "min", when=_in_time),
    ] = 0.0
    tried: Annotated[
        tuple[float, float], Entry("least and greatest choice of those tried [m or N]", when=_is_computed)
    ] = (0.0, 0.0)
    success: Annotated[float, Entry("probability of success with the choice", when=_is_computed)] = 0.0
    failure_loss: Annotated[
        float,
        Entry("loss counted for a mission that fails", "W h", when=_in_energy),
        Entry("loss counted for a mission that fails", "min", when=_in_time),
    ] = 0.0
    perfect: Annotated[
        float,
        Entry("expected saving if all were known exactly", "W h", key="perfect_saving", when=_in_energy),
        Entry("expected saving if all were known exactly", "min", key="perfect_saving", when=_in_time),
    ] = 0.0
    explanations: Annotated[tuple[PossibleSet, ...], Entry("sets of causes that may hold", when=_is_computed)] = ()
    designs: Annotated[
        tuple[ValuedDesign, ...], Entry("greatest saving first, then greatest information", when=_is_computed)
    ] = ()
    right: Annotated[
        float,
        Entry("probability that what the crew does about the vehicle by what is known now is right", when=_is_computed),
    ] = 0.0
    best: ValuedDesign | None = None
    """The cheapest of those that save nearly the most; None where no trial is worth it."""
    outcomes: Annotated[tuple[TrialOutcome, ...], Entry("of the best design, likeliest first", when=_is_computed)] = ()
    rule: Annotated[OutcomeRule | None, Entry("of the best design, where one parameter decides", when=_is_computed)] = (
        None
    )
    trial: Mapping[str, object] | None = None
    """Mission file's data of the one recommended; None for an instrument, or where none is."""
    reason: Annotated[str | None, Entry("why nothing was computed, where nothing was", optional=True)] = None

    @property
    def best_name(self) -> Annotated[str | None, Entry(key="best", when=_is_computed)]:
        """The cheapest design of those that save nearly the most; null where no trial is worth it."""
        return None if self.best is None else self.best.name

    @property
    def settling_name(self) -> Annotated[str | None, Entry(key="settling", when=_is_computed)]:
        """The cheapest design of those that nearly best tell what to do about the vehicle; null: none tells more."""
        return None if self.settling is None else self.settling.name

    @property
    def settling(self) -> ValuedDesign | None:
        """The cheapest of those that nearly best tell what to do about the vehicle; None where none tells more."""
        most = max((design.right for design in self.designs), default=0.0)
        enough = [design for design in self.designs if design.right >= most - NEARLY_RIGHT]
        return min(enough, key=lambda design: design.minutes) if most > self.right + MORE_RIGHT else None

    @property
    def recommended(self) -> ValuedDesign | None:
        """The best for the plan, else what settles what to do about the vehicle."""
        return self.best or self.settling

    def to_frame(self) -> pd.DataFrame:
        """One row a design."""
        return pd.DataFrame([design.row() for design in self.designs])

    def files(self) -> dict[str, str | bytes]:
        """``next-trials.csv``, and the recommended trial as ``next-trial.yaml``, with what its outcomes would mean."""
        contents: dict[str, str | bytes] = {"next-trials.csv": to_csv(self.to_frame())} if self.designs else {}
        if self.trial is not None:
            comments = "".join(f"# {line}\n" for line in self._notes())  # for who sails it
            contents["next-trial.yaml"] = comments + to_yaml(self.trial)
        return contents

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
        for outcome in self.outcomes:
            same = f"keep {self.choice:.4g} {unit}"
            new = (
                f"choose {outcome.choice:.4g} {unit}, which saves {max(outcome.saving, 0.0):.2g} {self.unit} a mission"
            )
            looks = " and ".join(cause.replace("-", " ") for cause in outcome.causes) or "nothing new"
            percent = min(100.0 * outcome.probability, 99.0)  # the models are approximate: nothing is certain
            lines.append(f"- {looks} ({percent:.0f} %): {same if outcome.choice == self.choice else new}")
        if self.rule is not None:
            side = "above" if self.rule.above else "below"
            limit = f"{self.rule.effect}.{self.rule.name} {side} {self.rule.threshold:.2g} {self.rule.unit}".strip()
            lines.append(f"In short: choose {self.rule.choice:.4g} {unit} where the diagnosis has {limit}, else keep.")
        return lines
