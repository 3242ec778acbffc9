"""The mission: what a mission file says, validated and in SI, with distributions kept as distributions."""

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.effects import EffectEntry, read_effects
from missionplan.mission.schema.phases import MoorPhase, Phase, PhaseEntry, TransitPhase
from missionplan.mission.schema.section import FileSection, complain
from missionplan.mission.schema.site import Site
from missionplan.mission.schema.transition import TransitionPhase
from missionplan.mission.schema.vehicle import EnergyBudget, Vehicle
from missionplan.mission.units import QuantityParser
from missionplan.montecarlo.distributions import Distribution, NormalTransform, Quantity, mean_of

CompensationName = Literal["none", "last-leg", "mean", "forecast", "filter", "as-printed"]


class VelocityErrorSection(FileSection):
    """Velocity error of a leg, N(mean, Σ): east and north [m/s]."""

    mean: tuple[q.SignedSpeed, q.SignedSpeed] = (0.0, 0.0)
    sigma: q.Speed | None = None
    covariance_rows: tuple[tuple[q.FixedVariance, q.FixedVariance], tuple[q.FixedVariance, q.FixedVariance]] | None = (
        Field(default=None, alias="covariance")
    )

    @model_validator(mode="after")
    def _one_spread(self) -> "VelocityErrorSection":
        if (self.sigma is None) == (self.covariance_rows is None):
            raise complain("expected either sigma or covariance")
        if self.covariance_rows is not None:
            matrix = np.array(self.covariance_rows)
            if not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix).min() < 0.0:
                raise complain("expected a symmetric matrix without negative eigenvalues", ("covariance",))
        return self

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Σ_v, shape (2, 2) [m²/s²]; of the mean sigma where sigma is a distribution."""
        if self.covariance_rows is not None:
            return np.array(self.covariance_rows, dtype=float)
        return np.eye(2) * mean_of(cast(Quantity, self.sigma)) ** 2

    @property
    def isotropic_sigma(self) -> float | None:
        """σ_v when Σ_v = σ_v² I, else None [m/s]."""
        matrix = self.covariance
        return float(np.sqrt(matrix[0, 0])) if np.allclose(matrix, matrix[0, 0] * np.eye(2), rtol=1e-12) else None


class Navigation(FileSection):
    """What the vehicle does not know of its motion, and how it surfaces for fixes."""

    velocity_error: VelocityErrorSection
    surfacing_time: q.Duration
    fix_error: q.Distance = 0.0
    drift_compensation: CompensationName = "none"
    max_legs: Annotated[int, Field(ge=1, le=100_000)] = 400


class SweepGrid(FileSection):
    """Grid of d_max: `points` values from `start` to `stop`, of the distance or as lengths."""

    of: Literal["distance"] | None = None
    start: Annotated[float, Field(alias="from")]
    stop: Annotated[float, Field(alias="to")]
    points: Annotated[int, Field(ge=2, le=10_000)]

    @field_validator("start", "stop", mode="plain")
    @classmethod
    def _in_units(cls, value: Any, info: ValidationInfo) -> Quantity:
        unit = "" if info.data.get("of") else "m"
        return QuantityParser(unit, low=0.0, open_low=True, fixed=True)(value)

    @model_validator(mode="after")
    def _in_order(self) -> "SweepGrid":
        if self.start >= self.stop:
            raise complain("expected from below to")
        return self


SweepDMax = Annotated[
    Annotated[SweepGrid, Tag("<grid>")] | Annotated[tuple[q.FixedLength, ...], Tag("<list>")],
    Discriminator(lambda value: "<grid>" if isinstance(value, dict | SweepGrid) else "<list>"),
]


class SweepSection(FileSection):
    """What `sweep-dmax` sweeps."""

    d_max: SweepDMax = SweepGrid.model_validate({"from": 0.02, "to": 1.0, "points": 99, "of": "distance"})
    sigma: tuple[q.FixedSpeed, ...] | None = None
    phase: str | None = None

    def d_max_values(self, distance: float) -> NDArray[np.float64]:
        """Lengths of the grid for a transit of `distance` [m]."""
        if isinstance(self.d_max, SweepGrid):
            values = np.linspace(self.d_max.start, self.d_max.stop, self.d_max.points)
            return values * distance if self.d_max.of else values
        return np.sort(np.array(self.d_max))


class MonteCarlo(FileSection):
    """How many trials, from which seed."""

    trials: Annotated[int, Field(ge=1, le=1_000_000_000)] = 10_000
    seed: Annotated[int, Field(ge=0, lt=2**64)] = 1


class Requirement(FileSection):
    """A probability that the mission must reach."""

    quantity: str
    probability: q.Probability
    at_most: Any = None
    at_least: Any = None


class CorrelationSection(FileSection):
    """Correlation of two quantities (of the normals that they are drawn from)."""

    between: tuple[str, str]
    rho: Annotated[float, Field(ge=-1.0, le=1.0)]


class Mission(FileSection):
    """A mission file, validated. All in SI; quantities are floats or distributions."""

    name: str = ""
    start: datetime | None = None
    vehicle: Vehicle | None = None
    site: Site | None = None
    navigation: Navigation | None = None
    entries: tuple[PhaseEntry, ...] = Field(default=(), alias="phases")
    sweep: SweepSection = SweepSection()
    monte_carlo: MonteCarlo = MonteCarlo()
    energy: EnergyBudget | None = None
    requirements: tuple[Requirement, ...] = ()
    correlations: tuple[CorrelationSection, ...] = ()
    effects: tuple[EffectEntry, ...] = ()

    _raw: dict[str, Any] = PrivateAttr(default_factory=dict)
    _file: str = PrivateAttr(default="")

    @field_validator("effects", mode="plain")
    @classmethod
    def _read_effects(cls, value: Any) -> tuple[EffectEntry, ...]:
        return read_effects(value)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Phases in the order of the file."""
        return tuple(entry.phase for entry in self.entries)

    @property
    def transits(self) -> tuple[TransitPhase, ...]:
        """The transits among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, TransitPhase))

    @property
    def moors(self) -> tuple[MoorPhase, ...]:
        """The moorings among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, MoorPhase))

    @property
    def transitions(self) -> tuple[TransitionPhase, ...]:
        """The transitions among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, TransitionPhase))

    @property
    def budget(self) -> EnergyBudget | None:
        """Energy budget: the mission's own, else the vehicle's."""
        return self.energy or (self.vehicle.energy if self.vehicle else None)

    @property
    def file(self) -> str:
        """Path of the mission file, as given."""
        return self._file

    @property
    def raw(self) -> Mapping[str, Any]:
        """The file's own data with includes in place, as it is written to `mission.yaml` of a report."""
        return self._raw

    def quantities(self) -> dict[str, Quantity]:
        """Every quantity by its key path, phases by name: ``ingress.speed``, ``site.current[0].speed``."""
        found: dict[str, Quantity] = {}
        for name, value in self:
            if name == "entries":
                for phase in self.phases:
                    _collect(phase, phase.name, found)
            elif name != "sweep":
                _collect(value, name, found)
        return found

    def notices(self) -> tuple[str, ...]:
        """What the reader should know: distributions that were cut at the physical range of their quantity."""
        return tuple(
            f"{path}: {value.mass_cut:.2g} of the distribution lies outside the physical range and was cut off"
            for path, value in self.uncertain().items()
            if value.mass_cut > 1e-12
        )

    def uncertain(self) -> dict[str, Distribution]:
        """The quantities that are distributions, by key path."""
        return {path: value for path, value in self.quantities().items() if isinstance(value, Distribution)}


_QUANTITY = (float, NormalTransform)
"""What every distribution is, rather than their union: it is asked of every value of a mission."""


def _collect(value: Any, path: str, found: dict[str, Quantity]) -> None:
    if value is None or isinstance(value, bool | str):
        return
    if isinstance(value, _QUANTITY):
        found[path] = cast("Quantity", value)
    elif isinstance(value, EffectEntry):
        for name, parameter in value.parameters.items():
            found[f"{path}.{value.effect}.{name}"] = parameter
    elif isinstance(value, BaseModel):
        given = type(value).model_fields
        for name, inner in value:
            _collect(inner, f"{path}.{given[name].alias or name}", found)
    elif isinstance(value, tuple):
        for index, inner in enumerate(value):
            _collect(inner, path if isinstance(inner, EffectEntry) else f"{path}[{index}]", found)
