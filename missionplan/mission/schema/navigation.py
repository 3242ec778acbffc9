"""Navigation by dead reckoning: velocity error, surfacings for fixes, drift compensation."""

from typing import Annotated, Generic, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.mission.schema import limits
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.limits import Limit
from missionplan.mission.schema.section import FileSection, V, invalid
from missionplan.montecarlo.distributions import mean_of

CompensationName = Literal["none", "last-leg", "mean", "forecast", "filter", "as-printed"]


class VelocityErrorSection(FileSection, Generic[V]):
    """Velocity error of a leg, N(mean, Σ): east and north [m/s]."""

    mean: Annotated[
        tuple[q.SignedSpeed[V], q.SignedSpeed[V]], Doc("mean of the velocity error, east and north"), limits.CURRENT
    ] = q.default((0.0, 0.0))
    sigma: Annotated[
        q.Speed[V] | None, Doc("standard deviation of the velocity error on each axis, σ_v"), limits.SIGMA
    ] = None
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
    surfacing_time: Annotated[
        q.Duration[V],
        Doc("time at the surface for a fix"),
        Limit((0.0, limits.DAY), (1.0, limits.HOUR), "a GPS fix takes 1 s warm to 15 min cold"),
    ]
    fix_error: Annotated[
        q.Distance[V],
        Doc("standard deviation of a fix on each axis"),
        Limit((0.0, 10_000.0), (0.0, 100.0), "GPS is good to 3 to 10 m, Argos to 1 km"),
    ] = q.default(0.0)
    drift_compensation: CompensationName = "none"
    max_legs: Annotated[int, Field(ge=1, le=100_000)] = 400
