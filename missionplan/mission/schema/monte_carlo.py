"""Trials of the Monte Carlo, correlations of the quantities drawn, and requirements."""

from typing import Annotated

from pydantic import Field, field_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection


class MonteCarlo(FileSection):
    """Number of trials, and seed of their draws."""

    trials: Annotated[int, Field(ge=1, le=1_000_000_000)] = 10_000
    seed: Annotated[int, Field(ge=0, lt=2**64)] = 1


class Requirement(FileSection):
    """A probability that the mission must have.

    The unit of `at_most` and `at_least` follows from the quantity's phase: the section keeps them as written, and
    `checks.requirements` reads them [SI].
    """

    quantity: str
    probability: q.Probability
    at_most: float | None = None
    at_least: float | None = None

    @field_validator("at_most", "at_least", mode="plain")
    @classmethod
    def _as_written(cls, value: object) -> object:
        return value


class CorrelationSection(FileSection):
    """Correlation of two quantities (of the normals that they are drawn from)."""

    between: tuple[str, str]
    rho: Annotated[float, Field(ge=-1.0, le=1.0)]
