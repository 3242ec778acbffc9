"""Phases of a mission as they are written in its file."""

import itertools
import math
from typing import Annotated, Generic, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, PhaseSection, V, invalid
from missionplan.mission.schema.site import Position
from missionplan.mission.schema.transition import TransitionPhase

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
    Annotated[q.PositiveLength[V], Tag("<length>")] | Annotated[LegTableSection, Tag("<table>")],
    Discriminator(lambda value: "<table>" if isinstance(value, LegTableSection) or _has_table(value) else "<length>"),
]


def _has_table(value: object) -> bool:
    return isinstance(value, dict) and "table" in value


class TransitPhase(PhaseSection, Generic[V]):
    """A transit by dead reckoning with surfacings; `speed` is nan where `shaft_rate` is given instead."""

    kind: Literal["transit"] = Field(default="transit", exclude=True)
    name: str = "transit"
    start: Position[V] | None = Field(default=None, alias="from")
    to: Position[V]
    depth: q.Distance[V] = q.default(0.0)
    speed: q.PositiveSpeed[V] = q.default(math.nan)
    shaft_rate: q.ShaftRate[V] | None = None
    d_max: DMax[V]
    arrival_radius: q.PositiveLength[V]

    @model_validator(mode="after")
    def _one_of_speed_and_shaft_rate(self) -> Self:
        given = self.model_fields_set & {"speed", "shaft_rate"}
        if len(given) != 1:
            raise invalid("expected exactly one of speed and shaft_rate" if given else "missing", ("speed",))
        return self


DesignCurrent = Annotated[
    Annotated[tuple[q.FixedSpeed, ...], Tag("<layers>")] | Annotated[q.FixedSpeed, Tag("<one>")],
    Discriminator(lambda value: "<layers>" if isinstance(value, list | tuple) else "<one>"),
]


class MoorPhase(PhaseSection, Generic[V]):
    """Anchor release, descent, hold, galvanic release and ascent."""

    kind: Literal["moor"] = Field(default="moor", exclude=True)
    name: str = "moor"
    radius: q.PositiveLength[V]
    design_current: DesignCurrent | None = None
    anchor_wet_weight: Annotated[V | Literal["sized"], q.or_word(_FORCE, "sized")] = "sized"
    line_length: q.PositiveLength[V]
    line_diameter: q.Distance[V] = q.default(0.0)
    line_stiffness: q.Stiffness[V] | None = None
    line_strength: q.Force[V] | None = None
    release_time: q.Duration[V] = q.default(0.0)
    hold: q.Duration[V] = q.default(0.0)
    galvanic_release: q.Duration[V] = q.default(0.0)
    carry_net_buoyancy: bool = False
    lateral: Literal["coupled", "uncoupled"] = "coupled"


class PhaseEntry(FileSection, Generic[V]):
    """One item of `phases`: a single key, the kind of the phase."""

    transit: TransitPhase[V] | None = None
    moor: MoorPhase[V] | None = None
    transition: TransitionPhase[V] | None = None

    @model_validator(mode="after")
    def _exactly_one(self) -> Self:
        if len(self.model_fields_set) != 1:
            raise invalid(f"expected one of the phases {', '.join(type(self).model_fields)} in each item")
        (kind,) = self.model_fields_set
        if getattr(self, kind) is None:
            raise invalid("given nothing, expected the keys of this phase", (kind,))
        return self

    def keyed(self, key: str) -> Self:
        """Return the item with another name of its phase in key paths."""
        phase = self.phase
        return self if phase.name == key else self.model_copy(update={phase.kind: phase.keyed(key)})

    @property
    def kind(self) -> str:
        """The key of the item."""
        return self.phase.kind

    @property
    def phase(self) -> "Phase[V]":
        """The phase itself."""
        return next(phase for phase in (self.transit, self.moor, self.transition) if phase is not None)


Phase = TransitPhase[V] | MoorPhase[V] | TransitionPhase[V]
