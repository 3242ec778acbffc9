"""Trials of the Monte Carlo, correlations of the quantities drawn, and requirements."""

from collections.abc import Sequence
from typing import Annotated, Self

from pydantic import Field, PrivateAttr, field_validator

from missionplan.mission.quantity_paths import resolved_path
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection
from missionplan.mission.schema.shared_sections import name_in_force
from missionplan.montecarlo.draws import Correlation


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

    _written: str = PrivateAttr(default="")

    @property
    def written(self) -> str:
        """The quantity as the file has it."""
        return self._written or self.quantity

    def resolved(self, names: Sequence[str]) -> Self:
        """Return the requirement with what stands for its phase in key paths, given the names of all phases."""
        resolved = self.model_copy(update={"quantity": resolved_path(self.quantity, names, with_sections=False)})
        resolved._written = self.written
        return resolved

    @field_validator("at_most", "at_least", mode="plain")
    @classmethod
    def _as_written(cls, value: object) -> object:
        return value


class CorrelationSection(FileSection):
    """Correlation of two quantities (of the normals that they are drawn from)."""

    between: tuple[str, str]
    rho: Annotated[float, Field(ge=-1.0, le=1.0)]

    def resolved(self, names: Sequence[str]) -> Self:
        """Return the correlation with names as quantities have them, given the names of all phases."""
        first, second = (name_in_force(resolved_path(path, names)) for path in self.between)
        return self.model_copy(update={"between": (first, second)})

    @property
    def pair(self) -> Correlation:
        """The correlation as draws take it."""
        return Correlation(self.between, self.rho)
