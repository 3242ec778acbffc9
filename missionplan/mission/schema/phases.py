"""Phases of a mission as they are written in its file."""

import itertools
import math
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, PhaseSection, invalid
from missionplan.mission.schema.site import Position
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.montecarlo.distributions import Quantity

_FORCE = QuantityParser("N", low=0.0, open_low=True)


class LegTableSection(FileSection):
    """Leg length against distance left, piecewise linear."""

    table: tuple[tuple[q.FixedDistance, q.FixedLength], ...]

    @model_validator(mode="after")
    def _increasing(self) -> "LegTableSection":
        left = [row[0] for row in self.table]
        if not left or any(b <= a for a, b in itertools.pairwise(left)):
            raise invalid("expected rows with increasing distance left", ("table",))
        return self


DMax = Annotated[
    Annotated[q.PositiveLength, Tag("<length>")] | Annotated[LegTableSection, Tag("<table>")],
    Discriminator(lambda value: "<table>" if isinstance(value, LegTableSection) or _has_table(value) else "<length>"),
]


def _has_table(value: object) -> bool:
    return isinstance(value, dict) and "table" in value


class TransitPhase(PhaseSection):
    """A transit by dead reckoning with surfacings; `speed` is nan where `shaft_rate` is given instead."""

    kind: Literal["transit"] = Field(default="transit", exclude=True)
    name: str = "transit"
    start: Position | None = Field(default=None, alias="from")
    to: Position
    depth: q.Distance = 0.0
    speed: q.PositiveSpeed = math.nan
    shaft_rate: q.ShaftRate | None = None
    d_max: DMax
    arrival_radius: q.PositiveLength

    @model_validator(mode="after")
    def _one_of_speed_and_shaft_rate(self) -> "TransitPhase":
        given = self.model_fields_set & {"speed", "shaft_rate"}
        if len(given) != 1:
            raise invalid("expected exactly one of speed and shaft_rate" if given else "missing", ("speed",))
        return self


DesignCurrent = Annotated[
    Annotated[tuple[q.FixedSpeed, ...], Tag("<layers>")] | Annotated[q.FixedSpeed, Tag("<one>")],
    Discriminator(lambda value: "<layers>" if isinstance(value, list | tuple) else "<one>"),
]


class MoorPhase(PhaseSection):
    """Anchor release, descent, hold, galvanic release and ascent."""

    kind: Literal["moor"] = Field(default="moor", exclude=True)
    name: str = "moor"
    radius: q.PositiveLength
    design_current: DesignCurrent | None = None
    anchor_wet_weight: Annotated[Quantity | Literal["sized"], q.or_word(_FORCE, "sized")] = "sized"
    line_length: q.PositiveLength
    line_diameter: q.Distance = 0.0
    line_stiffness: q.Stiffness | None = None
    line_strength: q.Force | None = None
    release_time: q.Duration = 0.0
    hold: q.Duration = 0.0
    galvanic_release: q.Duration = 0.0
    carry_net_buoyancy: bool = False
    lateral: Literal["coupled", "uncoupled"] = "coupled"


class PhaseEntry(FileSection):
    """One item of `phases`: a single key, the kind of the phase."""

    transit: TransitPhase | None = None
    moor: MoorPhase | None = None
    transition: TransitionPhase | None = None

    @model_validator(mode="after")
    def _exactly_one(self) -> "PhaseEntry":
        if len(self.model_fields_set) != 1:
            raise invalid(f"expected one of the phases {', '.join(type(self).model_fields)} in each item")
        (kind,) = self.model_fields_set
        if getattr(self, kind) is None:
            raise invalid("given nothing, expected the keys of this phase", (kind,))
        return self

    def keyed(self, key: str) -> "PhaseEntry":
        """Return the item with another name of its phase in key paths."""
        phase = self.phase
        return self if phase.name == key else self.model_copy(update={phase.kind: phase.keyed(key)})

    @property
    def phase(self) -> "Phase":
        """The phase itself."""
        return next(phase for phase in (self.transit, self.moor, self.transition) if phase is not None)


Phase = TransitPhase | MoorPhase | TransitionPhase
