"""Result of `simulate`: each phase over all trials, what makes missions fail, and which uncertain inputs matter."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.sensitivity import Influence
from missionplan.montecarlo.statistics import Probability, Statistic, trials_to_decide
from missionplan.results import Provenance, Result, to_csv
from missionplan.results.decision import Assumption, ExplainedOutcome, MemberOutcome, PlaceContact, SeaChart
from missionplan.results.entries import Entry, Record
from missionplan.results.plan import Plan
from missionplan.results.whereabouts import HeldVehicle, Overdue
from missionplan.store.checkpoints import read_trials

if TYPE_CHECKING:  # workers import this module: pandas takes half a second
    import pandas as pd


@dataclass(frozen=True)
class Histogram:
    """Counts of a quantity in bins of equal width, over all trials."""

    edges: Array
    """In the quantity's unit, shape (bins + 1,)."""
    counts: Array
    """The first and last bin also hold what lies beyond them, shape (bins,)."""


@dataclass(frozen=True)
class PhaseOutcome(Record):
    """One phase over all trials, or the whole mission, ``total``."""

    name: str
    """As in key paths."""
    kind: Annotated[str, Entry("such as ``transit``")]
    quantities: Annotated[Mapping[str, Statistic], Entry("by names that end with the unit")]
    events: Annotated[
        Mapping[str, Probability],
        Entry("such as ``arrived``; of all trials, so that a trial that never reached the phase counts as no"),
    ]
    histograms: Mapping[str, Histogram]
    """Of the quantities."""
    start: Statistic
    end: Statistic
    """Mission time at which the phase began and ended, of the trials that reached it [s]."""
    label: Annotated[str, Entry("as the mission's file has it", key="name")]

    @property
    def key(self) -> Annotated[str | None, Entry(optional=True)]:
        """Name in key paths, where the name of the file cannot serve."""
        return self.name if self.name != self.label else None


@dataclass(frozen=True)
class Attrition(Record):
    """One step on the way to P(success): the trials that fail at it, and those that have not failed by then."""

    step: Annotated[str, Entry("such as ``ingress: not arrived`` or ``moor: struck the seafloor``")]
    lost: Annotated[Probability, Entry("of all trials")]
    surviving: Annotated[Probability, Entry("of all trials")]


@dataclass(frozen=True)
class RequirementOutcome(Record):
    """A requirement of the mission and whether it is met."""

    quantity: str
    """Such as ``moor.offset``."""
    bound: Literal["at_most", "at_least"] | None
    """None for an event."""
    limit: float | None
    """In SI."""
    unit: str
    """SI unit of the limit."""
    required: Annotated[float, Entry("probability required")]
    probability: Annotated[Probability, Entry("probability reached, with its interval")]
    met: Annotated[bool, Entry("whether it is as high as required")]
    undecided: Annotated[bool, Entry("whether the required probability lies inside the interval")]
    trials: int = 0
    """From which the probability is taken."""
    written: str = ""
    """The quantity as the mission's file has it, where a phase in it has a name that cannot serve in key paths."""
    reached: Annotated[
        float | None, Entry("value that the required share of the trials stays within, SI", optional=True)
    ] = None

    @property
    def phase(self) -> str:
        """Phase of the quantity, ``total`` of the whole mission."""
        return self.quantity.rpartition(".")[0]

    @property
    def label(self) -> Annotated[str, Entry(key="quantity")]:
        """The quantity or event, such as ``moor.offset``, as the mission's file has it."""
        return self.written or self.quantity

    @property
    def at_most(self) -> Annotated[float | None, Entry(optional=True)]:
        """Upper bound [SI]."""
        return self.limit if self.bound == "at_most" else None

    @property
    def at_least(self) -> Annotated[float | None, Entry(optional=True)]:
        """Lower bound [SI]."""
        return self.limit if self.bound == "at_least" else None

    @property
    def trials_to_decide(self) -> Annotated[int | None, Entry(when=attrgetter("undecided"))]:
        """Trials that would decide an undecided requirement if the probability stays as it is, where any would."""
        return trials_to_decide(self.probability.value, self.required) if self.undecided else None

    @property
    def bound_in_words(self) -> str:
        """``at most`` or ``at least``; empty for an event."""
        return (self.bound or "").replace("_", " ")

    @property
    def slack(self) -> float:
        """How far from being missed: of a limit, the share of it that is left; of an event, of what it may fail by."""
        if self.limit is None:
            return (self.probability.value - self.required) / max(1.0 - self.required, 1e-9)
        if self.reached is None:
            return 0.0
        room = self.limit - self.reached if self.bound == "at_most" else self.reached - self.limit
        return room / max(abs(self.limit), abs(self.reached), 1e-12)


Sensitivity = Influence
"""Influence of one uncertain input on one key figure, such as of ``moor.release_time`` on ``moor.offset_m``."""


@dataclass(frozen=True)
class MooringAnchor(Record):
    """The anchor of a mooring that the mission leaves to be sized, or whose parts it gives."""

    phase: Annotated[str, Entry("name of the mooring")]
    wet_weight: Annotated[float, Entry("of the anchor", "N")]
    is_sized: Annotated[bool, Entry("whether it is the worst case's (Briggs et al., Eqs. 1 and 15)", key="sized")]
    failures: Annotated[
        tuple[str, ...], Entry("why its parts cannot make it; empty where they can, or are not given", key="problems")
    ] = ()

    @property
    def feasible(self) -> Annotated[bool, Entry()]:
        """Whether no part is known to make it impossible."""
        return not self.failures


@dataclass(frozen=True)
class Tracks:
    """Horizontal tracks of the first trials of the run, for maps."""

    position: Array
    """East and north of the origin at the start and at each fix, anchor drop, touchdown and surfacing; nan after a
    trial has ended; shape (points, 2, trials) [m]."""
    time: Array
    """Since the mission's start, at these points, shape (points, trials) [s]."""
    phase: NDArray[np.int64]
    """Index of the phase that each point belongs to, shape (points,)."""
    targets: Mapping[str, tuple[tuple[float, float], float]]
    """Goal and arrival circle of each phase [m]."""
    anchors: Array
    """Anchors on the seafloor, of one mooring after another; nan where there is none; shape (2, trials) [m]."""
    origin: tuple[float, float] | None
    """Of the local plane [rad]."""
    profile: Array
    """When, since the mission's start, and how deep the vehicle is, straight between; nan after a trial has failed;
    shape (2, corners, trials) [s, m]."""
    success: NDArray[np.bool_]
    """Whether the mission succeeds, shape (trials,)."""


@dataclass(frozen=True)
class Outcome(Result):
    """Result of `simulate`."""

    report: ClassVar[str] = "missionplan.report.simulation.page"

    provenance: Provenance
    phases: Annotated[tuple[PhaseOutcome, ...], Entry("in the mission's order")]
    total: Annotated[
        PhaseOutcome, Entry("the whole mission, with the event ``success``", parts=("quantities", "events"))
    ]
    requirements: Annotated[tuple[RequirementOutcome, ...], Entry("in the mission's order")]
    attrition: Annotated[
        tuple[Attrition, ...], Entry("ways to fail, in the mission's order; the last `surviving` is P(success)")
    ]
    sensitivities: Annotated[
        tuple[Sensitivity, ...], Entry("uncertain inputs that matter, by key figure, the most important first")
    ]
    tracks: Tracks
    arrivals: Mapping[str, Array]
    """True end position of each phase relative to its goal, of the first trials, for CEP circles, shape (2, m) [m]."""
    limits: Annotated[
        Mapping[str, Probability],
        Entry(
            "trials that met a limit of the world, failed or not: ``current_faster`` than the vehicle, "
            "``left_record`` of the current; without those that cannot be"
        ),
    ] = field(default_factory=dict)
    anchors: Annotated[
        tuple[MooringAnchor, ...], Entry("of the moorings whose anchor is sized, or cannot be built")
    ] = ()
    held: Annotated[
        tuple[HeldVehicle, ...],
        Entry("how the vehicle of each mooring stands on its line, distributions at their means", key="holds"),
    ] = ()
    failed_blocks: Annotated[
        tuple[str, ...],
        Entry("blocks of trials that failed numerically, with seed and block; left out of everything else"),
    ] = ()
    trials_table: bytes | None = None
    """Parquet, one row per trial, on request."""
    plan: Plan | None = None
    """As vehicles take it; None where the mission has no transit, or more legs than it allows."""
    overdue: Annotated[
        Overdue | None, Entry("what to know if the vehicle does not come back; null where too few trials come back")
    ] = None
    explanations: Annotated[
        tuple[ExplainedOutcome, ...],
        Entry("the same trials by the explanation that holds in each; empty for a mission without doubts"),
    ] = ()
    members: tuple[ExplainedOutcome, ...] = ()
    """The same trials by the member of the current's ensemble that each sails in; empty without an ensemble."""
    chart: SeaChart | None = None
    """Depths, land and zones about the tracks; None where the mission says nothing of them."""
    assumed: tuple[Assumption, ...] = ()
    """What the mission takes for granted, each with its worth."""
    contacts: Annotated[
        tuple[PlaceContact, ...],
        Entry("what missions meet of ground, coast and zones kept out of; empty where they meet nothing"),
    ] = ()

    @property
    def trials(self) -> "pd.DataFrame":
        """One row per trial: what was drawn, quantities and events; InputError where they were not kept."""
        return read_trials(self.trials_table)

    @property
    def certainty(self) -> Mapping[str, object]:
        """Probability of success, with its interval."""
        return self.total.events["success"].summary()

    @property
    def sailed(self) -> tuple[MemberOutcome, ...]:
        """How often the mission succeeds in each member of the current's ensemble in which a trial sails."""
        tried = (member for member in self.members if member.trials)
        return tuple(MemberOutcome(member.causes[0], member.probability, member.success) for member in tried)

    @property
    def holds_equipment(self) -> bool:
        """Whether failures of equipment are among those of the trials."""
        return any(coverage.held for coverage in self.provenance.holds if coverage.what == "equipment")

    @property
    def requirements_met(self) -> bool:
        """Whether every requirement of the mission is met."""
        return all(requirement.met for requirement in self.requirements)

    @property
    def can_be_built(self) -> bool:
        """Whether no anchor is known to be impossible with its parts."""
        return not any(anchor.failures for anchor in self.anchors)

    @property
    def of_members(self) -> Annotated[list[dict[str, object]], Entry(key="members")]:
        """The same trials by the member of the current's ensemble that each sails in."""
        entries = [(member.causes[0], member.summary()) for member in self.members]
        return [
            {"member": name, **{key: value for key, value in entry.items() if key != "causes"}}
            for name, entry in entries
        ]

    def to_frame(self) -> "pd.DataFrame":
        """One row per quantity of each phase and of the whole mission."""
        from pandas import DataFrame

        return DataFrame(self._rows())

    def _rows(self) -> list[dict[str, object]]:
        return [
            {"phase": phase.label, "quantity": name, **statistic.summary(), "trials": statistic.count}
            for phase in (*self.phases, self.total)
            for name, statistic in phase.quantities.items()
        ]

    def files(self) -> dict[str, str | bytes]:
        """Return `quantities.csv`, `search-areas.csv`, and `trials.parquet` where requested."""
        table = {"trials.parquet": self.trials_table} if self.trials_table is not None else {}
        areas = {"search-areas.csv": to_csv([area.row() for area in self.overdue.areas])} if self.overdue else {}
        return {"quantities.csv": to_csv(self._rows()), **areas, **table}


JUDGED = Entry(
    "the mission with what is recommended, simulated with fresh draws; null where it requires nothing",
    parts=("seed", "trials", "total", "requirements"),
)
"""Of a recommendation."""


def judgement_summary(judged: Outcome | None) -> dict[str, object] | None:
    """Return what ``summary.json`` says of a mission that was simulated with a recommendation, on fresh draws."""
    if judged is None:
        return None
    stated = judged.summary()
    return {"requirements_met": judged.requirements_met, **{key: stated[key] for key in JUDGED.parts}}
