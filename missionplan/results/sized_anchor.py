"""One anchor of `size-anchor`: whether it can be built, its nominal dive, and how often its dives succeed."""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.phases.mooring.descent import DescentRecord
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.profile import DescentProfile
from missionplan.physics.anchor import AnchorDesign
from missionplan.physics.anchor_remedies import MAX_WET_WEIGHT, Remedy
from missionplan.physics.drag import DragBuildUp
from missionplan.results.entries import Entry, Record, fields_of
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
class BuiltAnchor(Record):
    """The anchor as it is built: of what is null the vehicle file has no `construction`."""

    dry_mass: Annotated[float | None, Entry("of the anchor", "kg")]
    displaced_mass: Annotated[float | None, Entry("of the water that it displaces", "kg")]
    cylinder_length: Annotated[float | None, Entry("of its cylinder", "m")]
    trim_mass: Annotated[float | None, Entry("of the trim ring", "kg")]
    trim_position: Annotated[float | None, Entry("of the trim ring, from the nose", "m")]
    centre_of_gravity: Annotated[float | None, Entry("from the nose", "m")]
    centre_of_buoyancy: Annotated[float | None, Entry("from the nose", "m")]
    length: Annotated[float | None, Entry("of the anchor", "m")]
    flooded_mass: Annotated[float | None, Entry("with the water inside", "kg")]
    feasible: Annotated[bool | None, Entry("whether it can be built")]

    @classmethod
    def of(cls, design: AnchorDesign | None) -> "BuiltAnchor":
        """Return what is built by a design."""
        return cls(*(None if design is None else getattr(design, field.name) for field in fields(cls)))


@dataclass(frozen=True)
class NominalDive(Record):
    """A dive with all that is distributed at its mean; times from the separation, not finite where never reached."""

    time: Annotated[float, Entry("to touchdown", "s")]
    terminal_velocity: Annotated[float, Entry("with the vehicle's own buoyancy", "m/s")]
    touchdown_speed: Annotated[float, Entry("of the anchor", "m/s")]
    offset: Annotated[float, Entry("of the anchor from the last fix", "m")]
    lowest_altitude: Annotated[float, Entry("of the vehicle above the seafloor", "m")]
    release_time: Annotated[float, Entry("of the separation, after the last fix", "s")]
    payout_time: Annotated[float, Entry("until the line is taut", "s")]
    struck_seafloor: Annotated[bool, Entry("whether the vehicle strikes")]
    snatch_tension: Annotated[float | None, Entry("peak of the snatch, as far as it can be known", "N", optional=True)]
    nose_down_time: Annotated[float | None, Entry("from the taut line to nose down", "s", optional=True)]
    depth_lost: Annotated[float | None, Entry("meanwhile", "m", optional=True)]

    @classmethod
    def of(cls, record: DescentRecord) -> "NominalDive":
        """Return the first of the dives of a record."""

        def first_value(value: Array) -> float | None:
            return float(value[0]) if math.isfinite(value[0]) else None

        return cls(
            float(record.descent_time[0]),
            float(record.terminal_velocity[0]),
            float(record.touchdown_speed[0]),
            float(record.offset_distance[0]) if record.touched_down[0] else math.nan,
            float(record.lowest_altitude[0]),
            float(record.release_time[0]),
            float(record.payout_time[0]),
            bool(record.struck[0]),
            first_value(record.snatch_tension),
            first_value(record.nose_down_time),
            first_value(record.depth_lost),
        )


@dataclass(frozen=True)
class SizedAnchor(Record):
    """One anchor: its construction, its nominal dive, and the probabilities of its dives."""

    wet_weight: Annotated[float, Entry("of the anchor", "N")]
    terminal_velocity: Annotated[
        float,
        Entry("speed through the water at which drag balances wet weight; net buoyancy as the mission asks", "m/s"),
    ]
    """The vehicle's own buoyancy is left out, as in Eq. 15, unless the mission carries it."""
    drag: Annotated[DragBuildUp, Entry("of each part and of all at that speed, effects included", "N")]
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
    def problems(self) -> Annotated[list[str], Entry()]:
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
    def built(self) -> Annotated[BuiltAnchor, Entry(inline=True)]:
        """The anchor as it is built."""
        return BuiltAnchor.of(self.design)

    @cached_property
    def nominal(self) -> NominalDive:
        """The nominal dive."""
        return NominalDive.of(self.profile.record)

    def numbers(self) -> dict[str, float]:
        """Return every number of the anchor by its key, for a table."""
        plain = {key: value for key, value in self.summary().items() if isinstance(value, float)}
        drag = {f"drag_{name}_n": value for name, value in fields_of(self.drag).items()}
        dive = {f"descent_{key}": value for key, value in self.nominal.summary().items() if key != "struck_seafloor"}
        return {**plain, **drag, **dive, "probability_good": self.probabilities.good.value}
