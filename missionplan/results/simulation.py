"""Result of `simulate`: each phase over all trials, what makes missions fail, and which uncertain inputs matter."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.sensitivity import Influence
from missionplan.montecarlo.statistics import Probability, Statistic, trials_to_decide
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.explained import ExplainedOutcome
from missionplan.results.mooring.held_vehicle import HeldVehicle
from missionplan.results.mooring.sized_anchor import MooringAnchor
from missionplan.results.overdue import Overdue
from missionplan.results.plan import Plan
from missionplan.store.trials_table import read_trials


@dataclass(frozen=True)
class Histogram:
    """Counts of a quantity in bins of equal width, over all trials.

    Attributes
    ----------
    edges : array, shape (bins + 1,)
        In the quantity's unit.
    counts : array, shape (bins,)
        The first and last bin also hold what lies beyond them.
    """

    edges: Array
    counts: Array


@dataclass(frozen=True)
class PhaseOutcome:
    """One phase over all trials.

    Attributes
    ----------
    name, kind : str
        As in key paths; the whole mission is ``total``.
    quantities : mapping of str to Statistic
        By the keys of `summary.json`, which end with the unit.
    events : mapping of str to Probability
        Such as ``arrived``; of all trials, so that a trial that never reached the phase counts as no.
    histograms : mapping of str to Histogram
        Of the quantities.
    start, end : Statistic
        Mission time at which the phase began and ended, of the trials that reached it [s].
    label : str
        Name as the mission's file has it, for people to read.
    """

    name: str
    kind: str
    quantities: Mapping[str, Statistic]
    events: Mapping[str, Probability]
    histograms: Mapping[str, Histogram]
    start: Statistic
    end: Statistic
    label: str

    def quantities_and_events(self) -> dict[str, object]:
        """Return the part of `summary.json` that phases and the whole mission have in common."""
        return {
            "quantities": {name: statistic.summary() for name, statistic in self.quantities.items()},
            "events": {name: probability.summary() for name, probability in self.events.items()},
        }


@dataclass(frozen=True)
class Attrition:
    """One step on the way to P(success): the trials that fail at it, and those that have not failed by then.

    Attributes
    ----------
    step : str
        Such as ``ingress: not arrived`` or ``moor: struck the seafloor``.
    lost, surviving : Probability
        Of all trials.
    """

    step: str
    lost: Probability
    surviving: Probability


@dataclass(frozen=True)
class RequirementOutcome:
    """A requirement of the mission and whether it is met.

    Attributes
    ----------
    quantity : str
        Such as ``moor.offset``.
    bound : 'at_most', 'at_least' or None
        None for an event.
    limit : float or None
        In SI.
    unit : str
        SI unit of the limit.
    required : float
        Probability required.
    probability : Probability
        Probability reached, with its interval.
    met, undecided : bool
        Whether value ≥ required; whether the required probability lies inside the interval.
    trials : int
        From which the probability is taken.
    written : str
        The quantity as the mission's file has it, where a phase in it has a name that cannot serve in key paths.
    """

    quantity: str
    bound: Literal["at_most", "at_least"] | None
    limit: float | None
    unit: str
    required: float
    probability: Probability
    met: bool
    undecided: bool
    trials: int = 0
    written: str = ""

    @property
    def trials_to_decide(self) -> int | None:
        """Trials that would decide an undecided requirement if the probability stays as it is, where any would."""
        return trials_to_decide(self.probability.value, self.required) if self.undecided else None

    @property
    def margin(self) -> int:
        """Trials more than required that do as the requirement asks; negative where they are too few."""
        return round(self.probability.value * self.trials) - math.ceil(self.required * self.trials - 1e-9)

    def summary(self) -> dict[str, object]:
        """Return the entry of `summary.json`."""
        bound = {str(self.bound): self.limit} if self.bound else {}
        return {
            "quantity": self.written or self.quantity,
            **bound,
            "required": self.required,
            "probability": self.probability.summary(),
            "met": self.met,
            "undecided": self.undecided,
            **({"trials_to_decide": self.trials_to_decide} if self.undecided else {}),
        }


Sensitivity = Influence
"""Influence of one uncertain input on one key figure, such as of ``moor.release_time`` on ``moor.offset_m``."""


@dataclass(frozen=True)
class Tracks:
    """Horizontal tracks of the first trials of the run, for maps.

    Attributes
    ----------
    position : array, shape (points, 2, trials)
        East and north of the origin at the start and at each fix, anchor drop, touchdown and surfacing;
        nan after a trial has ended [m].
    time : array, shape (points, trials)
        Since the mission's start, at these points [s].
    phase : array of int, shape (points,)
        Index of the phase that each point belongs to.
    targets : mapping of str to ((east, north), radius)
        Goal and arrival circle of each phase [m].
    anchors : array, shape (2, trials)
        Anchors on the seafloor, of one mooring after another; nan where there is none [m].
    origin : (latitude, longitude) or None
        Of the local plane [rad].
    """

    position: Array
    time: Array
    phase: NDArray[np.int64]
    targets: Mapping[str, tuple[tuple[float, float], float]]
    anchors: Array
    origin: tuple[float, float] | None


@dataclass(frozen=True)
class Outcome(Result):
    """Result of `simulate`.

    Attributes
    ----------
    phases : tuple of PhaseOutcome
        In the mission's order.
    total : PhaseOutcome
        The whole mission, with the event ``success``.
    requirements : tuple of RequirementOutcome
    attrition : tuple of Attrition
        Ways to fail, in the mission's order; the last `surviving` is P(success).
    sensitivities : tuple of Sensitivity
        By key figure, the most important first.
    tracks : Tracks
    arrivals : mapping of str to array, shape (2, m)
        True end position of each phase relative to its goal, of the first trials, for CEP circles [m].
    limits : mapping of str to Probability
        Trials that met a limit of the world, failed or not: ``current_faster`` than the vehicle, ``left_record``
        of the current; without those that cannot be.
    anchors : tuple of MooringAnchor
        Of the moorings whose anchor is sized, or cannot be built.
    held : tuple of HeldVehicle
        How the vehicle of each mooring stands on its line, distributions at their means.
    failed_blocks : tuple of str
        Blocks of trials that failed numerically, with seed and block; left out of everything above.
    trials_table : bytes or None
        Parquet, one row per trial, on request.
    plan : Plan or None
        As vehicles take it; None where the mission has no transit, or more legs than it allows.
    overdue : Overdue or None
        What to know if the vehicle does not come back; None where too few trials come back.
    explanations : tuple of ExplainedOutcome
        The same trials by the explanation that holds in each; empty for a mission without doubts.
    members : tuple of ExplainedOutcome
        The same trials by the member of the current's ensemble that each sails in; empty without an ensemble.
    """

    report: ClassVar[str] = "missionplan.report.simulation.page"

    provenance: Provenance
    phases: tuple[PhaseOutcome, ...]
    total: PhaseOutcome
    requirements: tuple[RequirementOutcome, ...]
    attrition: tuple[Attrition, ...]
    sensitivities: tuple[Sensitivity, ...]
    tracks: Tracks
    arrivals: Mapping[str, Array]
    limits: Mapping[str, Probability] = field(default_factory=dict)
    anchors: tuple[MooringAnchor, ...] = ()
    held: tuple[HeldVehicle, ...] = ()
    failed_blocks: tuple[str, ...] = ()
    trials_table: bytes | None = None
    plan: Plan | None = None
    overdue: Overdue | None = None
    explanations: tuple[ExplainedOutcome, ...] = ()
    members: tuple[ExplainedOutcome, ...] = ()

    @property
    def trials(self) -> pd.DataFrame:
        """One row per trial: what was drawn, quantities and events; InputError where they were not kept."""
        return read_trials(self.trials_table)

    @property
    def requirements_met(self) -> bool:
        """Whether every requirement of the mission is met."""
        return all(requirement.met for requirement in self.requirements)

    @property
    def can_be_built(self) -> bool:
        """Whether no anchor is known to be impossible with its parts."""
        return not any(anchor.failures for anchor in self.anchors)

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`."""
        return {
            **self.provenance.summary(),
            "phases": [
                {
                    "name": phase.label,
                    **({"key": phase.name} if phase.name != phase.label else {}),
                    "kind": phase.kind,
                    **phase.quantities_and_events(),
                }
                for phase in self.phases
            ],
            "total": self.total.quantities_and_events(),
            "requirements": [requirement.summary() for requirement in self.requirements],
            "attrition": [
                {"step": step.step, "lost": step.lost.summary(), "surviving": step.surviving.summary()}
                for step in self.attrition
            ],
            "limits": {name: share.summary() for name, share in self.limits.items()},
            "anchors": [anchor.summary() for anchor in self.anchors],
            "holds": [held.summary() for held in self.held],
            "sensitivities": [vars(sensitivity) for sensitivity in self.sensitivities],
            "failed_blocks": list(self.failed_blocks),
            "overdue": self.overdue.summary() if self.overdue else None,
            "explanations": [each.summary() for each in self.explanations],
            "members": [
                {("member" if key == "causes" else key): value for key, value in each.summary().items()}
                | {"member": each.causes[0]}
                for each in self.members
            ],
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per quantity of each phase and of the whole mission."""
        rows = [
            {"phase": phase.label, "quantity": name, **statistic.summary(), "trials": statistic.count}
            for phase in (*self.phases, self.total)
            for name, statistic in phase.quantities.items()
        ]
        return pd.DataFrame(rows)

    def files(self) -> dict[str, str | bytes]:
        """Return `quantities.csv`, `search-areas.csv`, and `trials.parquet` where requested."""
        table = {"trials.parquet": self.trials_table} if self.trials_table is not None else {}
        areas = {"search-areas.csv": to_csv(self.overdue.to_frame())} if self.overdue else {}
        return {"quantities.csv": to_csv(self.to_frame()), **areas, **table}
