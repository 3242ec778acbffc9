"""The answer of `size-anchor`: an anchor one can build, the dive it gives, and how often that dive is good enough."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.physics.anchor import AnchorDesign
from missionplan.physics.anchor_remedies import MAX_WET_WEIGHT, Remedy
from missionplan.physics.vehicle_drag import DragBuildUp
from missionplan.results.base import Provenance, Result, to_csv


@dataclass(frozen=True)
class DiveProbabilities:
    """What became of many dives with one anchor.

    Attributes
    ----------
    good : Probability
        Of coming down within the radius without the vehicle striking the seafloor.
    within, struck : Probability
        Of the anchor coming down within the radius, and of the vehicle striking.
    offset, lowest_altitude : Statistic
        Of the anchor from the last fix, and of the vehicle above the seafloor [m].
    """

    good: Probability
    within: Probability
    struck: Probability
    offset: Statistic
    lowest_altitude: Statistic


@dataclass(frozen=True)
class SizedAnchor:
    """One anchor, its construction, its nominal dive and its probabilities.

    Attributes
    ----------
    wet_weight : float
        [N]
    terminal_velocity : float
        Speed through the water at which the drag balances the wet weight, the vehicle's own buoyancy left out as in
        Eq. 15 unless the mission carries it [m/s].
    drag : DragBuildUp
        At that speed, the effects' factor included [N].
    design : AnchorDesign or None
        None where the vehicle file has no `construction`.
    remedies : tuple of Remedy
        Single changes of the construction that would make an impossible anchor possible.
    buildable : (float, float) or None
        Wet weights that the construction can make, asked for where this one is impossible [N].
    dive : Dive
        Of the nominal dive, distributions at their means.
    profile : DescentProfile
        That dive against time.
    probabilities : DiveProbabilities
    """

    wet_weight: float
    terminal_velocity: float
    drag: DragBuildUp
    design: AnchorDesign | None
    remedies: tuple[Remedy, ...]
    buildable: tuple[float, float] | None
    dive: Dive
    profile: DescentProfile
    probabilities: DiveProbabilities

    @property
    def problems(self) -> list[str]:
        """Why the anchor cannot be built, and what would mend it; empty when it can."""
        if self.design is None or self.design.feasible:
            return []
        words = [failure.words for failure in self.design.failures]
        words += [f"it could be built with a {remedy.words}" for remedy in self.remedies]
        if not self.remedies:
            words.append("no single change of a part mends it")
        if self.buildable is not None:
            low, high = self.buildable
            upwards = "upwards" if high >= MAX_WET_WEIGHT else f"to {high:.3g} N"
            words.append(f"the parts as given make anchors of {low:.2f} N wet {upwards}")
        return words

    @property
    def offset(self) -> float:
        """Of the nominal dive's anchor from the last fix; nan where it never came down [m]."""
        record = self.profile.record
        return float(record.offset_distance[0]) if record.touched_down[0] else math.nan

    @property
    def descent_time(self) -> float:
        """Of the nominal dive, from separation to touchdown; nan where it never came down [s]."""
        return float(self.profile.record.descent_time[0])

    @property
    def lowest_altitude(self) -> float:
        """Of the nominal dive's vehicle [m]."""
        return float(self.profile.record.lowest_altitude[0])

    def summary(self) -> dict[str, Any]:
        """Give the section `anchor` of ``summary.json``."""
        design = self.design
        drag = {name: float(getattr(self.drag, name)) for name in ("body", "sail", "vehicle", "anchor", "total")}
        built: dict[str, Any] = dict.fromkeys(_BUILT)
        if design is not None:
            built = {key: getattr(design, name) for key, name in _BUILT.items()}
        return {
            "terminal_velocity_m_s": self.terminal_velocity,
            "drag_n": drag,
            "wet_weight_n": self.wet_weight,
            **built,
            "feasible": None if design is None else design.feasible,
            "problems": self.problems,
        }

    def descent_summary(self) -> dict[str, Any]:
        """Give the section `descent` of ``summary.json``."""
        record = self.profile.record
        return {
            "time_s": self.descent_time,
            "terminal_velocity_m_s": float(record.terminal_velocity[0]),
            "offset_m": self.offset,
            "lowest_altitude_m": self.lowest_altitude,
            "release_time_s": float(record.release_time[0]),
            "payout_time_s": float(record.payout_time[0]),
            "struck_seafloor": bool(record.struck[0]),
        }

    def probabilities_summary(self) -> dict[str, Any]:
        """Give the probabilities for ``summary.json``."""
        probabilities = self.probabilities
        return {
            "within_radius_and_not_struck": probabilities.good.summary(),
            "within_radius": probabilities.within.summary(),
            "struck_seafloor": probabilities.struck.summary(),
            "offset_m": probabilities.offset.summary(),
            "lowest_altitude_m": probabilities.lowest_altitude.summary(),
        }


_BUILT: Mapping[str, str] = {
    "dry_mass_kg": "dry_mass",
    "displaced_mass_kg": "displaced_mass",
    "cylinder_length_m": "cylinder_length",
    "trim_mass_kg": "trim_mass",
    "trim_position_m": "trim_position",
    "centre_of_gravity_m": "centre_of_gravity",
    "centre_of_buoyancy_m": "centre_of_buoyancy",
    "length_m": "length",
    "flooded_mass_kg": "flooded_mass",
}


@dataclass(frozen=True)
class ProbableAnchor:
    """The lightest anchor that reaches a probability, or the reason why there is none.

    Attributes
    ----------
    required : float
        Probability asked for.
    anchor : SizedAnchor or None
        None when no anchor reaches it.
    reason : str
        Why none does; empty otherwise.
    best : float
        Highest probability found among the weights tried.
    line_length : float or None
        Shortest line [m] with which some anchor would reach it, where the line is what fails.
    line_anchor_weight : float or None
        Wet weight of that anchor [N].
    """

    required: float
    anchor: SizedAnchor | None
    reason: str
    best: float
    line_length: float | None = None
    line_anchor_weight: float | None = None

    def summary(self) -> dict[str, Any]:
        """Give the section `probable` of ``summary.json``."""
        found = self.anchor
        return {
            "required": self.required,
            "found": found is not None,
            "reason": self.reason,
            "best": self.best,
            "anchor": found.summary() if found else None,
            "descent": found.descent_summary() if found else None,
            "odds": found.probabilities_summary() if found else None,
            "line_length_m": self.line_length,
            "line_anchor_wet_weight_n": self.line_anchor_weight,
        }


@dataclass(frozen=True)
class DesignLayer:
    """A layer of the current as the worst case takes it: thickness [m] and speed [m/s]."""

    thickness: float
    speed: float


@dataclass(frozen=True)
class AnchorSizing(Result):
    """The anchor of a mooring, for the worst case and, where asked for, for a probability.

    Attributes
    ----------
    provenance : Provenance
    phase : str
        Name of the mooring.
    radius, depth, line_length : float
        Distributions at their means [m].
    layers : tuple of DesignLayer
        The worst case of Eq. 1.
    required_velocity : float
        Over the ground, all layers aligned [m/s].
    vector_velocity : float or None
        The same with the layers' own directions; None where they have none [m/s].
    anchor : SizedAnchor
        For the worst case.
    probable : ProbableAnchor or None
        Where a probability was asked for.
    notes : tuple of str
        Where formulae leave their range.
    """

    report: ClassVar[str] = "anchor.page"

    provenance: Provenance
    phase: str
    radius: float
    depth: float
    line_length: float
    layers: tuple[DesignLayer, ...]
    required_velocity: float
    vector_velocity: float | None
    anchor: SizedAnchor
    probable: ProbableAnchor | None
    notes: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """Give the dictionary of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "phase": self.phase,
            "radius_m": self.radius,
            "line_length_m": self.line_length,
            "required_velocity_m_s": self.required_velocity,
            "required_velocity_vector_m_s": self.vector_velocity,
            "anchor": self.anchor.summary(),
            "descent": self.anchor.descent_summary(),
            "odds": self.anchor.probabilities_summary(),
            "probable": self.probable.summary() if self.probable else None,
            "notes": list(self.notes),
        }

    def to_frame(self) -> pd.DataFrame:
        """One row a number of the anchors: quantity, value for the worst case, value for the probable anchor."""
        columns = {"worst_case": self.anchor}
        if self.probable and self.probable.anchor:
            columns["probable"] = self.probable.anchor
        rows: dict[str, dict[str, float]] = {}
        for name, anchor in columns.items():
            for quantity, value in _numbers(anchor).items():
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
        """Give ``anchor.csv`` and ``descent.csv``."""
        return {"anchor.csv": to_csv(self.to_frame()), "descent.csv": to_csv(self.descent_frame().round(6))}


def _numbers(anchor: SizedAnchor) -> dict[str, float]:
    summary = anchor.summary()
    drag = {f"drag_{name}_n": value for name, value in summary.pop("drag_n").items()}
    plain = {key: value for key, value in summary.items() if isinstance(value, float)}
    descent = {f"descent_{key}": value for key, value in anchor.descent_summary().items() if key != "struck_seafloor"}
    return {**plain, **drag, **descent, "probability_good": anchor.probabilities.good.value}


def _stage_names(profile: DescentProfile) -> list[str]:
    starts = np.array(list(profile.stages.values()))
    names = ["release", "pay-out wait", "free fall", "pull-down", "coasting", "rise to the line's length"]
    return [names[index] for index in np.searchsorted(starts, profile.time, side="right")]
