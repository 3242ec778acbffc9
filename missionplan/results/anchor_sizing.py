"""Result of `size-anchor`: the anchor for the worst case and for what is asked of dives, and the nominal dive."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.physics.anchor_remedies import TrimState
from missionplan.results import Provenance, Result, to_csv
from missionplan.results.decision import MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import Outcome, judgement_summary
from missionplan.results.sized_anchor import DiveProbabilities, NominalDive, SizedAnchor
from missionplan.results.whereabouts import HeldVehicle


@dataclass(frozen=True)
class Deviation(Record):
    """An anchor of another weight, as one that was built heavier, and how its dives end."""

    weight: Annotated[float, Entry("of the anchor", "N", "wet_weight")]
    probabilities: Annotated[DiveProbabilities, Entry("how its dives end", key="odds")]
    misses: Annotated[tuple[str, ...], Entry("what is asked and not reached, in words")]


@dataclass(frozen=True)
class ProbableAnchor(Record):
    """The lightest anchor that does all that is asked of its dives, or which demands stand against which."""

    required: Annotated[
        float | None, Entry("of dives that succeed, as asked; null where only the mission's requirements are asked")
    ]
    anchor: Annotated[
        SizedAnchor | None,
        Entry("the lightest that can be built; that of any parts where none can; null where no anchor does"),
    ]
    reason: Annotated[str, Entry("why none does, with the numbers of the best compromise; empty otherwise")]
    compromise: Annotated[float, Entry("wet weight that comes nearest", "N", "best_wet_weight")]
    best: Annotated[float, Entry("share of its dives that succeed")]
    margins: Annotated[tuple[Deviation, ...], Entry("anchors a tenth lighter and heavier than the one found")] = ()
    line_length: Annotated[
        float | None, Entry("shortest with which some anchor would do, where the line is what fails", "m")
    ] = None
    line_anchor_weight: Annotated[float | None, Entry("of that anchor", "N", "line_anchor_wet_weight")] = None
    lighter: Annotated[
        float | None,
        Entry("a lighter anchor that reaches it, where the parts cannot make it", "N", "lightest_of_any_parts"),
    ] = None

    @property
    def found(self) -> Annotated[bool, Entry()]:
        """Whether an anchor does all that is asked."""
        return self.anchor is not None

    @property
    def descent(self) -> Annotated[NominalDive | None, Entry()]:
        """Its nominal dive."""
        return self.anchor.nominal if self.anchor else None

    @property
    def odds(self) -> Annotated[DiveProbabilities | None, Entry()]:
        """How its dives end."""
        return self.anchor.probabilities if self.anchor else None


@dataclass(frozen=True)
class DesignLayer:
    """A layer of the current in the worst case: thickness [m] and speed [m/s]."""

    thickness: float
    speed: float


@dataclass(frozen=True)
class ExplainedAnchor(Record):
    """An anchor when one explanation holds."""

    causes: Annotated[tuple[str, ...], Entry("its effects; empty for none")]
    probability: Annotated[float, Entry("of the explanation")]
    good: Annotated[
        Probability, Entry("of the anchor to build: within the radius, not struck, and holding where that counts")
    ]
    needed: Annotated[
        float | None,
        Entry(
            "of the lightest anchor that reaches the probability asked for, were it known that this holds; null where "
            "none does, or none was asked for",
            "N",
            "needed_wet_weight",
        ),
    ]


@dataclass(frozen=True)
class AnchorSizing(Result):
    """The anchor of a mooring: for the worst case and, where one was given, for a probability."""

    report: ClassVar[str] = "missionplan.report.anchor.page"

    provenance: Provenance
    phase: Annotated[str, Entry("name of the mooring")]
    others: Annotated[tuple[str, ...], Entry("names of the mission's other moorings, for which it is not sized")]
    radius: Annotated[float, Entry("at its mean", "m")]
    depth: float
    """At its mean [m]."""
    line_length: Annotated[float, Entry("at its mean", "m")]
    layers: tuple[DesignLayer, ...]
    """The worst case of Eq. 1."""
    required_velocity: Annotated[float, Entry("downward, over the ground, all layers aligned", "m/s")]
    vector_velocity: Annotated[
        float | None,
        Entry("the same with the layers' own directions; null where none", "m/s", "required_velocity_vector"),
    ]
    anchor: Annotated[SizedAnchor, Entry("for the worst case")]
    probable: Annotated[ProbableAnchor | None, Entry("where a probability was given")]
    notes: Annotated[tuple[str, ...], Entry("formulae that are used outside their range")]
    judged: Outcome | None = None
    """The mission with the anchor to build, simulated with fresh draws; None where it requires nothing."""
    held: Annotated[
        HeldVehicle | None, Entry("how the vehicle stands on its line above the anchor to build", key="hold")
    ] = None
    trim: Annotated[
        tuple[TrimState, ...], Entry("how the vehicle lies with that anchor, with it flooded, and without it")
    ] = ()
    explanations: Annotated[
        tuple[ExplainedAnchor, ...],
        Entry("the anchor to build under each explanation of a mission that has doubts", optional=True),
    ] = ()
    members: Annotated[
        tuple[MemberOutcome, ...],
        Entry("dives that succeed with the anchor to build in each member of the ensemble", optional=True),
    ] = ()

    @property
    def to_build(self) -> SizedAnchor:
        """The anchor for the probability, where one was given and can be reached; else that of the worst case."""
        return self.probable.anchor if self.probable and self.probable.anchor else self.anchor

    @property
    def meets_requirements(self) -> Annotated[bool, Entry()]:
        """Whether the mission with the anchor to build meets all requirements on fresh draws, if it has any."""
        return self.judged is None or self.judged.requirements_met

    @property
    def succeeds(self) -> Annotated[bool, Entry()]:
        """Whether the anchor to build can be built, is ever good, does all that is asked, and so does the mission."""
        reached = self.probable is None or self.probable.anchor is not None
        some_succeed = self.to_build.probabilities.good.value > 0.0
        return reached and some_succeed and not self.to_build.problems and self.meets_requirements

    @property
    def descent(self) -> Annotated[NominalDive, Entry()]:
        """Nominal dive of the anchor for the worst case."""
        return self.anchor.nominal

    @property
    def odds(self) -> Annotated[DiveProbabilities, Entry()]:
        """How the dives of the anchor for the worst case end."""
        return self.anchor.probabilities

    @property
    def which_to_build(self) -> Annotated[str, Entry(key="to_build")]:
        """``worst-case`` or ``probable``."""
        return "worst-case" if self.to_build is self.anchor else "probable"

    @property
    def judgement(self) -> Annotated[dict[str, object] | None, Entry(key="judged")]:
        """The mission with the anchor to build, simulated with fresh draws; null where it requires nothing."""
        return judgement_summary(self.judged)

    @property
    def certainty(self) -> Mapping[str, object]:
        """Probability that a dive with the anchor to build does all that is asked."""
        return self.to_build.probabilities.good.summary()

    @property
    def recommended_values(self) -> Mapping[str, object]:
        """Wet weight of the anchor to build, where it succeeds."""
        return {f"{self.phase}.anchor_wet_weight": f"{self.to_build.wet_weight:.3f} N"} if self.succeeds else {}

    def to_frame(self) -> pd.DataFrame:
        """One row per number: quantity, value for the worst case, value for the probable anchor."""
        columns = {"worst_case": self.anchor}
        if self.probable and self.probable.anchor:
            columns["probable"] = self.probable.anchor
        rows: dict[str, dict[str, float]] = {}
        for name, anchor in columns.items():
            for quantity, value in anchor.numbers().items():
                rows.setdefault(quantity, {})[name] = value
        return pd.DataFrame([{"quantity": quantity, **values} for quantity, values in rows.items()])

    def descent_frame(self) -> pd.DataFrame:
        """The nominal dive against time since the last fix."""
        profile = self.anchor.profile
        stages = np.array(
            ["release", "pay-out wait", "free fall", "pull-down", "coasting", "rise to the line's length"]
        )
        begun = np.searchsorted(np.array(list(profile.stages.values())), profile.time, side="right")
        return pd.DataFrame(
            {
                "t_s": profile.time,
                "vehicle_depth_m": profile.vehicle_depth,
                "vehicle_speed_m_s": profile.vehicle_speed,
                "anchor_depth_m": profile.anchor_depth,
                "anchor_east_m": profile.anchor_track[0],
                "anchor_north_m": profile.anchor_track[1],
                "vehicle_east_m": profile.vehicle_track[0],
                "vehicle_north_m": profile.vehicle_track[1],
                "stage": np.take(stages, begun),
            }
        )

    def files(self) -> dict[str, str | bytes]:
        """Return ``anchor.csv`` and ``descent.csv``."""
        return {"anchor.csv": to_csv(self.to_frame()), "descent.csv": to_csv(self.descent_frame().round(6))}
