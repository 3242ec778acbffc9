"""Result of `size-anchor`: the anchor for the worst case and for what is asked of dives, and the nominal dive."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.physics.trim import TrimState
from missionplan.results.base import Provenance, Result, to_csv
from missionplan.results.decision import Assumption, MemberOutcome
from missionplan.results.held_vehicle import HeldVehicle
from missionplan.results.simulation import Outcome, judgement_summary
from missionplan.results.sized_anchor import DiveProbabilities, SizedAnchor


@dataclass(frozen=True)
class Deviation:
    """An anchor of another weight, as one that was built heavier: its wet weight [N], and how its dives end."""

    weight: float
    probabilities: DiveProbabilities
    misses: tuple[str, ...]

    def summary(self) -> dict[str, object]:
        """Return an entry of ``summary.json``."""
        return {
            "wet_weight_n": self.weight,
            "misses": list(self.misses),
            "odds": self.probabilities.summary(),
        }


@dataclass(frozen=True)
class ProbableAnchor:
    """The lightest anchor that does all that is asked of its dives, or which demands stand against which."""

    required: float | None
    """Probability asked of dives that succeed; None where only the mission's requirements are asked."""
    anchor: SizedAnchor | None
    """The lightest that can be built; that of any parts where none can; None where no anchor does."""
    reason: str
    """Why none does, with the numbers of the best compromise; empty otherwise."""
    compromise: float
    """Wet weight that comes nearest [N]."""
    best: float
    """Share of its dives that succeed."""
    margins: tuple[Deviation, ...] = ()
    """Anchors a tenth lighter and heavier than the one found."""
    line_length: float | None = None
    """Shortest line [m] with which some anchor would do, where the line is what fails."""
    line_anchor_weight: float | None = None
    """Wet weight of that anchor [N]."""
    lighter: float | None = None
    """Wet weight [N] of a lighter anchor that reaches it, where the parts cannot make that one."""

    def summary(self) -> dict[str, object]:
        """Return the section `probable` of ``summary.json``."""
        found = self.anchor
        return {
            "required": self.required,
            "found": found is not None,
            "reason": self.reason,
            "best": self.best,
            "best_wet_weight_n": self.compromise,
            "margins": [each.summary() for each in self.margins],
            "anchor": found.summary() if found else None,
            "descent": found.descent_summary() if found else None,
            "odds": found.probabilities.summary() if found else None,
            "line_length_m": self.line_length,
            "line_anchor_wet_weight_n": self.line_anchor_weight,
            "lightest_of_any_parts_n": self.lighter,
        }


@dataclass(frozen=True)
class DesignLayer:
    """A layer of the current in the worst case: thickness [m] and speed [m/s]."""

    thickness: float
    speed: float


@dataclass(frozen=True)
class ExplainedAnchor:
    """An anchor when one explanation holds."""

    causes: tuple[str, ...]
    """Its effects; empty for none."""
    probability: float
    good: Probability
    """Of the anchor to build: within the radius, not struck, and holding where that counts."""
    needed: float | None
    """Wet weight of the lightest anchor that reaches the probability asked for, were it known that this holds [N]; None
    where none does, or none was asked for."""

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        return {
            "causes": list(self.causes),
            "probability": self.probability,
            "good": self.good.summary(),
            "needed_wet_weight_n": self.needed,
        }


@dataclass(frozen=True)
class AnchorSizing(Result):
    """The anchor of a mooring: for the worst case and, where one was given, for a probability.

    Attributes
    ----------
    radius, depth, line_length : float
        Distributions at their means [m].
    """

    report: ClassVar[str] = "missionplan.report.anchor.page"

    provenance: Provenance
    phase: str
    """Name of the mooring."""
    radius: float
    depth: float
    line_length: float
    layers: tuple[DesignLayer, ...]
    """The worst case of Eq. 1."""
    required_velocity: float
    """Downward, over the ground, all layers aligned [m/s]."""
    vector_velocity: float | None
    """The same with the layers' own directions; None where they have none [m/s]."""
    anchor: SizedAnchor
    """For the worst case."""
    probable: ProbableAnchor | None
    """Where a probability was given."""
    notes: tuple[str, ...]
    """Formulae that are used outside their range."""
    judged: Outcome | None = None
    """The mission with the anchor to build, simulated with fresh draws; None where it requires nothing."""
    held: HeldVehicle | None = None
    """How the vehicle stands on its line above the anchor to build."""
    trim: tuple[TrimState, ...] = ()
    """How the vehicle lies with that anchor, with it flooded, and without it."""
    explanations: tuple[ExplainedAnchor, ...] = ()
    """The anchor to build under each explanation of the mission; empty for a mission without doubts."""
    members: tuple[MemberOutcome, ...] = ()
    """Dives that succeed with the anchor to build in each member of the current's ensemble; empty without one."""

    @property
    def to_build(self) -> SizedAnchor:
        """The anchor for the probability, where one was given and can be reached; else that of the worst case."""
        return self.probable.anchor if self.probable and self.probable.anchor else self.anchor

    @property
    def meets_requirements(self) -> bool:
        """Whether the mission with the anchor to build meets all requirements on fresh draws, if it has any."""
        return self.judged is None or self.judged.requirements_met

    @property
    def succeeds(self) -> bool:
        """Whether the anchor to build can be built, is ever good, does all that is asked, and so does the mission."""
        reached = self.probable is None or self.probable.anchor is not None
        some_succeed = self.to_build.probabilities.good.value > 0.0
        return reached and some_succeed and not self.to_build.problems and self.meets_requirements

    def summary(self) -> dict[str, object]:
        """Return the contents of ``summary.json``."""
        entries = {
            **self.provenance.summary(),
            "phase": self.phase,
            "radius_m": self.radius,
            "line_length_m": self.line_length,
            "required_velocity_m_s": self.required_velocity,
            "required_velocity_vector_m_s": self.vector_velocity,
            "anchor": self.anchor.summary(),
            "descent": self.anchor.descent_summary(),
            "odds": self.anchor.probabilities.summary(),
            "probable": self.probable.summary() if self.probable else None,
            "to_build": "worst-case" if self.to_build is self.anchor else "probable",
            "meets_requirements": self.meets_requirements,
            "judged": judgement_summary(self.judged),
            "succeeds": self.succeeds,
            "hold": self.held.summary() if self.held else None,
            "trim": [state.summary() for state in self.trim],
            "notes": list(self.notes),
            **({"members": [each.summary() for each in self.members]} if self.members else {}),
            **({"explanations": [each.summary() for each in self.explanations]} if self.explanations else {}),
        }
        return self.with_decision(entries)

    @property
    def certainty(self) -> Mapping[str, object]:
        """Probability that a dive with the anchor to build does all that is asked."""
        return self.to_build.probabilities.good.summary()

    @property
    def assumed(self) -> tuple[Assumption, ...]:
        """What the mission with it takes for granted, each with its worth; nothing where it was not judged."""
        return () if self.judged is None else self.judged.assumed

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
                "stage": _stage_names(profile),
            }
        )

    def files(self) -> dict[str, str | bytes]:
        """Return ``anchor.csv`` and ``descent.csv``."""
        return {"anchor.csv": to_csv(self.to_frame()), "descent.csv": to_csv(self.descent_frame().round(6))}


def _stage_names(profile: DescentProfile) -> list[str]:
    starts = np.array(list(profile.stages.values()))
    names = ["release", "pay-out wait", "free fall", "pull-down", "coasting", "rise to the line's length"]
    return [names[index] for index in np.searchsorted(starts, profile.time, side="right")]
