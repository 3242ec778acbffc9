"""One anchor of `size-anchor`: whether it can be built, its nominal dive, and how often its dives succeed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.physics.anchor import AnchorDesign
from missionplan.physics.anchor_remedies import MAX_WET_WEIGHT, Remedy
from missionplan.physics.drag import DragBuildUp
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import RequirementOutcome


@dataclass(frozen=True)
class DiveProbabilities(Record):
    """Outcomes of many dives with one anchor."""

    good: Annotated[
        Probability,
        Entry(
            "of the mooring failing in no way: within the radius, not struck, and what else the files let be known",
            key="within_radius_and_not_struck",
        ),
    ]
    within: Annotated[Probability, Entry("of the anchor coming down within the radius", key="within_radius")]
    holds: Annotated[
        Probability | None,
        Entry(
            "of the anchor holding, where the vehicle file says how it does: else every anchor counts as holding",
            key="anchor_holds",
            optional=True,
        ),
    ]
    struck: Annotated[Probability, Entry("of the vehicle striking the seafloor", key="struck_seafloor")]
    offset: Annotated[Statistic, Entry("of the anchor from the last fix", "m")]
    lowest_altitude: Annotated[Statistic, Entry("of the vehicle above the seafloor", "m")]
    requirements: Annotated[
        tuple[RequirementOutcome, ...], Entry("what the mission requires of the mooring", optional=True)
    ] = ()


@dataclass(frozen=True)
class SizedAnchor:
    """One anchor: its construction, its nominal dive, and the probabilities of its dives."""

    wet_weight: float
    """Wet weight [N]."""
    terminal_velocity: float
    """Speed through the water at which the drag balances the wet weight; the vehicle's own buoyancy is left out, as in
    Eq. 15, unless the mission carries it [m/s]."""
    drag: DragBuildUp
    """At that speed, effects included [N]."""
    design: AnchorDesign | None
    """None where the vehicle file has no `construction`."""
    remedies: tuple[Remedy, ...]
    """Single changes of the construction that would make an impossible anchor possible."""
    buildable: tuple[float, float] | None
    """Range of wet weights that the construction can make, where this one is impossible [N]."""
    dive: Dive
    """The nominal dive, distributions at their means."""
    profile: DescentProfile
    """That dive against time."""
    probabilities: DiveProbabilities

    @property
    def problems(self) -> list[str]:
        """Why the anchor cannot be built, and what would allow it; empty when it can be built."""
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
    def touched_down(self) -> bool:
        """Whether the nominal dive takes the anchor to the seafloor."""
        return bool(self.profile.record.touched_down[0])

    @property
    def offset(self) -> float:
        """Distance of the nominal dive's anchor from the last fix; nan where it never came down [m]."""
        return float(self.profile.record.offset_distance[0]) if self.touched_down else math.nan

    @property
    def descent_time(self) -> float:
        """Time of the nominal dive from separation to touchdown; nan where it never came down [s]."""
        return float(self.profile.record.descent_time[0])

    @property
    def payout_time(self) -> float:
        """Time of the nominal dive from separation until the line is taut [s]."""
        return float(self.profile.record.payout_time[0])

    @property
    def dive_terminal_velocity(self) -> float:
        """Terminal velocity of the nominal dive, the vehicle's own buoyancy included [m/s]."""
        return float(self.profile.record.terminal_velocity[0])

    @property
    def touchdown_speed(self) -> float:
        """Speed of the nominal dive at touchdown; nan where it never came down [m/s]."""
        return float(self.profile.record.touchdown_speed[0])

    @property
    def lowest_altitude(self) -> float:
        """Lowest altitude of the vehicle in the nominal dive [m]."""
        return float(self.profile.record.lowest_altitude[0])

    def drag_summary(self) -> dict[str, float]:
        """Return the drag of each part and of all together [N]."""
        return {name: float(getattr(self.drag, name)) for name in ("body", "sail", "vehicle", "anchor", "total")}

    def summary(self) -> dict[str, object]:
        """Return the section `anchor` of ``summary.json``."""
        design = self.design
        built: Mapping[str, object] = dict.fromkeys(_BUILT)
        if design is not None:
            built = {key: getattr(design, name) for key, name in _BUILT.items()}
        return {
            "terminal_velocity_m_s": self.terminal_velocity,
            "drag_n": self.drag_summary(),
            "wet_weight_n": self.wet_weight,
            **built,
            "feasible": None if design is None else design.feasible,
            "problems": self.problems,
        }

    @property
    def snatch(self) -> dict[str, float]:
        """Peak tension of the snatch [N], time to nose down [s] and depth lost [m], as far as they can be known."""
        record = self.profile.record
        found = {
            "snatch_tension_n": float(record.snatch_tension[0]),
            "nose_down_time_s": float(record.nose_down_time[0]),
            "depth_lost_m": float(record.depth_lost[0]),
        }
        return {key: value for key, value in found.items() if math.isfinite(value)}

    def descent_summary(self) -> dict[str, float]:
        """Return the section `descent` of ``summary.json``."""
        record = self.profile.record
        return {
            "time_s": self.descent_time,
            "terminal_velocity_m_s": self.dive_terminal_velocity,
            "touchdown_speed_m_s": self.touchdown_speed,
            "offset_m": self.offset,
            "lowest_altitude_m": self.lowest_altitude,
            "release_time_s": float(record.release_time[0]),
            "payout_time_s": self.payout_time,
            "struck_seafloor": bool(record.struck[0]),
            **self.snatch,
        }

    def numbers(self) -> dict[str, float]:
        """Return every number of the anchor by its key, for a table."""
        plain = {key: value for key, value in self.summary().items() if isinstance(value, float)}
        drag = {f"drag_{name}_n": value for name, value in self.drag_summary().items()}
        descent = {f"descent_{key}": value for key, value in self.descent_summary().items() if key != "struck_seafloor"}
        return {**plain, **drag, **descent, "probability_good": self.probabilities.good.value}


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
"""Keys of ``summary.json`` and the properties of the design that they hold."""
