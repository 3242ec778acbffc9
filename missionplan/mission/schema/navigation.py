"""Navigation by dead reckoning: velocity error, surfacings for fixes, drift compensation."""

from typing import Annotated, Generic, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from missionplan.arrays import Array
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection, V, invalid
from missionplan.montecarlo.distributions import mean_of

CompensationName = Literal["none", "last-leg", "mean", "forecast", "filter", "as-printed"]


class VelocityErrorSection(FileSection, Generic[V]):
    """Velocity error of a leg, N(mean, Σ): east and north [m/s]."""

    mean: tuple[q.SignedSpeed[V], q.SignedSpeed[V]] = q.default((0.0, 0.0))
    sigma: q.Speed[V] | None = None
    covariance_rows: tuple[tuple[q.FixedVariance, q.FixedVariance], tuple[q.FixedVariance, q.FixedVariance]] | None = (
        Field(default=None, alias="covariance")
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

    velocity_error: VelocityErrorSection[V]
    surfacing_time: q.Duration[V]
    fix_error: q.Distance[V] = q.default(0.0)
    drift_compensation: CompensationName = "none"
    max_legs: Annotated[int, Field(ge=1, le=100_000)] = 400
