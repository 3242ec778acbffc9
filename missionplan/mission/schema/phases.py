"""Phases of a mission as they are written in its file.

Navigation by dead reckoning: velocity error, surfacings for fixes, drift compensation.
"""

import itertools
import math
from typing import Annotated, Generic, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.mission.schema import FileSection, PhaseSection, V, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.manoeuvring import TransitionPhase
from missionplan.mission.schema.place import Position
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser
from missionplan.montecarlo.distributions import mean_of

_FORCE = QuantityParser("N", low=0.0, open_low=True)


class LegTableSection(FileSection):
    """Leg length against distance left, piecewise linear."""

    table: Annotated[
        tuple[tuple[q.FixedDistance, q.FixedLength], ...],
        Doc("distance left and longest leg there, linear between"),
        Field(examples=[[["0 m", "50 m"], ["2 km", "800 m"]]]),
    ]

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
    name: Annotated[str, Doc("name of the phase, for reports")] = "transit"
    start: Annotated[Position[V] | None, Doc("where it begins; without it, where the transit before went")] = Field(
        default=None, alias="from"
    )
    to: Annotated[Position[V], Doc("goal, east and north of the origin, or by latitude and longitude")]
    via: Annotated[
        tuple[Position[V], ...] | Literal["auto"],
        Doc("points on the way to the goal, each reached as the goal is; auto: the shortest way clear of land"),
    ] = ()
    depth: Annotated[q.Distance[V], Doc("depth of the transit"), q.DEPTH] = q.default(0.0)
    speed: Annotated[q.PositiveSpeed[V], Doc("speed through the water"), q.SPEED] = q.default(math.nan)
    shaft_rate: Annotated[
        q.ShaftRate[V] | None,
        Doc("turns of the propeller, in place of a speed"),
        Limit((0.0, 1050.0), (1.0, 320.0), "AUV propellers turn at 60 to 3000 rpm"),
    ] = None
    d_max: Annotated[
        DMax[V],
        Doc("longest leg, or leg lengths against distance left"),
        Limit((1.0, 1e6), (5.0, 2e5), "a leg is longer than a vehicle, and than what it drifts"),
    ]
    arrival_radius: Annotated[
        q.PositiveLength[V],
        Doc("distance from the goal at which the transit has arrived"),
        Limit((0.01, 50_000.0), (1.0, 2000.0), "a fix is good to 3 to 10 m"),
    ]

    @property
    def ways(self) -> "tuple[Position[V], ...]":
        """Points on the way that the file gives."""
        return () if isinstance(self.via, str) else self.via

    @model_validator(mode="after")
    def _one_of_speed_and_shaft_rate(self) -> Self:
        keys = self.model_fields_set & {"speed", "shaft_rate"}
        if len(keys) != 1:
            raise invalid("expected exactly one of speed and shaft_rate" if keys else "missing", ("speed",))
        return self


DesignCurrent = Annotated[
    Annotated[tuple[q.FixedSpeed, ...], Tag("<layers>")] | Annotated[q.FixedSpeed, Tag("<one>")],
    Discriminator(lambda value: "<layers>" if isinstance(value, list | tuple) else "<one>"),
]


class LineFloat(FileSection, Generic[V]):
    """A float on the line."""

    distance: Annotated[q.Distance[V], Doc("from the vehicle along the line")]
    buoyancy: Annotated[
        q.Force[V],
        Doc("buoyancy less weight"),
        Limit((1e-3, 1e5), (0.05, 2000.0), "a trawl float of 100 mm lifts 3 N, one of 200 mm 28 N"),
    ]


class MoorPhase(PhaseSection, Generic[V]):
    """Anchor release, descent, hold, galvanic release and ascent."""

    kind: Literal["moor"] = Field(default="moor", exclude=True)
    name: Annotated[str, Doc("name of the phase, for reports")] = "moor"
    radius: Annotated[
        q.PositiveLength[V],
        Doc("distance from the fix on arrival within which the anchor is to lie"),
        Limit((0.1, 50_000.0), (1.0, 1000.0), "Briggs et al.: 75 ft"),
    ]
    design_current: Annotated[
        DesignCurrent | None,
        Doc("worst current, of the water or of each layer, for which the anchor is sized"),
        q.CURRENT,
    ] = None
    anchor_wet_weight: Annotated[
        V | Literal["sized"],
        q.or_word(_FORCE, "sized"),
        Doc("weight of the flooded anchor in water; `sized`: for the worst current"),
        Limit((1e-3, 100_000.0), (0.5, 5000.0), "Briggs et al.: 11.8 N for a 10 kg vehicle"),
    ] = "sized"
    line_length: Annotated[
        q.PositiveLength[V],
        Doc("length of the line between anchor and vehicle"),
        Limit((0.01, 11_000.0), (0.3, 1000.0), "Briggs et al.: 5 m"),
    ]
    line_diameter: Annotated[
        q.Distance[V],
        Doc("diameter of the line; 0 without drag"),
        Limit((0.0, 0.5), (5e-4, 0.05), "fishing line has 0.5 mm, a ship's mooring 50 mm"),
    ] = q.default(0.0)
    line_material: Annotated[
        Literal["polyester", "nylon", "aramid", "polyethylene", "steel-wire"] | None,
        Doc("what the line is made of, from which weight, stiffness and strength follow"),
    ] = None
    line_wet_weight: Annotated[
        q.WeightPerLength[V] | None,
        Doc("weight in water of a metre of line, negative where it floats; over the material's"),
        Limit((-100.0, 1000.0), (-1.0, 20.0), "4 mm of polyester 0.05 N/m, of wire rope 0.55 N/m"),
    ] = None
    line_floats: Annotated[tuple[LineFloat[V], ...], Doc("floats on the line, from the vehicle down")] = ()
    line_stiffness: Annotated[
        q.Stiffness[V] | None,
        Doc("force for a metre of stretch of the whole line; over the material's"),
        Limit((0.1, 1e9), (50.0, 1e6), "5 m of 4 mm cord: 5 kN/m in nylon, 200 kN/m in Dyneema; of shock cord 50 N/m"),
    ] = None
    line_strength: Annotated[
        q.Force[V] | None,
        Doc("force at which the line parts; over the material's"),
        Limit((0.1, 1e8), (20.0, 1e6), "2 mm cord bears 0.5 to 4 kN, a galvanic link 0.1 to 3 kN"),
    ] = None
    release_time: Annotated[
        q.Duration[V],
        Doc("time from the last fix until the anchor separates"),
        Limit((0.0, q.DAY), (0.0, 1800.0), "Briggs et al.: seconds"),
    ] = q.default(0.0)
    hold: Annotated[
        q.Duration[V],
        Doc("time on the bottom until the release is commanded"),
        Limit((0.0, 730.0 * q.DAY), (0.0, 90.0 * q.DAY), "moorings are kept for days to months"),
    ] = q.default(0.0)
    galvanic_release: Annotated[
        q.Duration[V],
        Doc("time from that command until the link has corroded"),
        Limit((0.0, 365.0 * q.DAY), (0.0, 45.0 * q.DAY), "galvanic links are made for hours to weeks"),
    ] = q.default(0.0)
    carry_net_buoyancy: Annotated[bool, Doc("whether the anchor is sized to carry the vehicle's net buoyancy too")] = (
        False
    )
    lateral: Annotated[
        Literal["coupled", "uncoupled"], Doc("whether the line ties the drift of anchor and vehicle together")
    ] = "coupled"

    @property
    def times_moored(self) -> tuple[V, ...]:
        """Times one after the other from touchdown, the last from the command to release until the line parts [s]."""
        return self.hold, self.galvanic_release


class PhaseEntry(FileSection, Generic[V]):
    """One item of `phases`: a single key, the kind of the phase."""

    transit: Annotated[TransitPhase[V] | None, Doc("legs between fixes")] = None
    moor: Annotated[MoorPhase[V] | None, Doc("dive, hold and ascent")] = None
    transition: Annotated[TransitionPhase[V] | None, Doc("slowing down to hover")] = None

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


CompensationName = Literal["none", "last-leg", "mean", "forecast", "filter", "as-printed"]


class VelocityErrorSection(FileSection, Generic[V]):
    """Velocity error of a leg, N(mean, Σ): east and north [m/s]."""

    mean: Annotated[
        tuple[q.SignedSpeed[V], q.SignedSpeed[V]], Doc("mean of the velocity error, east and north"), q.CURRENT
    ] = q.default((0.0, 0.0))
    sigma: Annotated[q.Speed[V] | None, Doc("standard deviation of the velocity error on each axis, σ_v"), q.SIGMA] = (
        None
    )
    covariance_rows: Annotated[
        tuple[tuple[q.FixedVariance, q.FixedVariance], tuple[q.FixedVariance, q.FixedVariance]] | None,
        Doc("covariance of a leg's velocity error, east and north, in place of sigma"),
    ] = Field(
        default=None,
        alias="covariance",
        examples=[[["0.0012 m^2/s^2", "0.0003 m^2/s^2"], ["0.0003 m^2/s^2", "0.0009 m^2/s^2"]]],
    )

    @model_validator(mode="after")
    def _one_spread(self) -> Self:
        if (self.sigma is None) == (self.covariance_rows is None):
            raise invalid("expected either sigma or covariance")
        if self.covariance_rows is not None:
            matrix = np.array(self.covariance_rows)
            if not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix).min() < 0.0:
                raise invalid("expected a symmetric matrix without negative eigenvalues", ("covariance",))
        return self

    @property
    def covariance(self: "VelocityErrorSection") -> Array:
        """Σ_v, shape (2, 2) [m²/s²]; of the mean sigma where sigma is a distribution."""
        if self.covariance_rows is not None:
            return np.array(self.covariance_rows, dtype=float)
        return np.eye(2) * mean_of(self.sigma or 0.0) ** 2

    @property
    def isotropic_sigma(self: "VelocityErrorSection") -> float | None:
        """σ_v when Σ_v = σ_v² I, else None [m/s]."""
        matrix = self.covariance
        return float(np.sqrt(matrix[0, 0])) if np.allclose(matrix, matrix[0, 0] * np.eye(2), rtol=1e-12) else None


class Navigation(FileSection, Generic[V]):
    """Navigation by dead reckoning, with surfacings for fixes."""

    velocity_error: Annotated[VelocityErrorSection[V], Doc("true less dead-reckoned velocity, one draw a leg")]
    surfacing_time: Annotated[
        q.Duration[V],
        Doc("time at the surface for a fix"),
        Limit((0.0, q.DAY), (1.0, q.HOUR), "a GPS fix takes 1 s warm to 15 min cold"),
    ]
    fix_error: Annotated[
        q.Distance[V],
        Doc("standard deviation of a fix on each axis"),
        Limit((0.0, 10_000.0), (0.0, 100.0), "GPS is good to 3 to 10 m, Argos to 1 km"),
    ] = q.default(0.0)
    drift_compensation: Annotated[CompensationName, Doc("how the course is corrected for the drift")] = "none"
    max_legs: Annotated[int, Field(ge=1, le=100_000), Doc("legs after which a transit has failed")] = 400
