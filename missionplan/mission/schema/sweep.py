"""Values that `sweep-dmax` tries, and what `optimise` may choose.

Trials of the Monte Carlo, correlations of the quantities drawn, and requirements.
"""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, PrivateAttr, Tag, ValidationInfo, field_validator, model_validator
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.mission.quantity_paths import name_in_force, resolved_path
from missionplan.mission.schema import FileSection, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.streams import Correlation


class SweepGrid(FileSection):
    """Grid of d_max: `points` values from `start` to `stop`, of the distance or as lengths."""

    of: Annotated[Literal["distance"] | None, Doc("whether the ends are parts of the distance")] = None
    start: Annotated[float, Field(alias="from", examples=["100 m"]), Doc("first value")]
    stop: Annotated[float, Field(alias="to", examples=["2 km"]), Doc("last value")]
    points: Annotated[int, Field(ge=2, le=10_000, examples=[20]), Doc("number of values, both ends counted")]

    @field_validator("start", "stop", mode="plain")
    @classmethod
    def _in_units(cls, value: object, info: ValidationInfo) -> Quantity:
        unit = "" if info.data.get("of") else "m"
        return QuantityParser(unit, low=0.0, open_low=True, fixed=True)(value)

    @model_validator(mode="after")
    def _in_order(self) -> "SweepGrid":
        if self.start >= self.stop:
            raise invalid("expected `from` less than `to`")
        return self


SweepDMax = Annotated[
    Annotated[SweepGrid, Tag("<grid>")] | Annotated[tuple[q.FixedLength, ...], Tag("<list>")],
    Discriminator(lambda value: "<grid>" if isinstance(value, dict | SweepGrid) else "<list>"),
]


class SweepSection(FileSection):
    """Values that `sweep-dmax` tries, and on which transit."""

    d_max: Annotated[
        SweepDMax,
        Doc("leg lengths that are tried"),
        Field(examples=[["200 m", "400 m", "800 m"]]),
        Limit((1.0, 1e6), (1.0, 2e5), "500 km is the greatest distance from the origin"),
    ] = SweepGrid.model_validate({"from": 0.02, "to": 1.0, "points": 99, "of": "distance"})
    sigma: Annotated[
        tuple[q.FixedSpeed, ...] | None,
        Doc("velocity errors, σ_v, of which each is swept"),
        q.SIGMA,
        Field(examples=[["0.02 m/s", "0.05 m/s"]]),
    ] = None
    phase: Annotated[str | None, Doc("transit that is swept; without it the first"), Field(examples=["ingress"])] = None

    def d_max_values(self, distance: float) -> Array:
        """Return the lengths of the grid for a transit of `distance`, shape (k,) [m]."""
        if isinstance(self.d_max, SweepGrid):
            values = np.linspace(self.d_max.start, self.d_max.stop, self.d_max.points)
            return values * distance if self.d_max.of else values
        return np.sort(np.array(self.d_max))


AsWritten = str | float | int | bool | dict[str, object] | list[object]
"""A value of another key, read when it is put there."""


class ChoiceSection(FileSection):
    """One key, or several that take the same value; `from` and `to`, in steps of `step`, or a list of `choices`."""

    key: Annotated[str | None, Doc("key that is chosen"), Field(examples=["ingress.d_max"])] = None
    keys: Annotated[
        tuple[str, ...],
        Doc("keys that are chosen together, with one value"),
        Field(examples=[["ingress.speed", "egress.speed"]]),
    ] = ()
    low: Annotated[str | float | None, Doc("least value"), Field(examples=["200 m"])] = Field(
        default=None, alias="from"
    )
    high: Annotated[str | float | None, Doc("greatest value"), Field(examples=["1 km"])] = Field(
        default=None, alias="to"
    )
    step: Annotated[str | float | None, Doc("distance between values"), Field(examples=["100 m"])] = None
    choices: Annotated[
        tuple[AsWritten, ...], Doc("values, in place of a range"), Field(examples=[["200 m", "400 m"]])
    ] = ()

    @model_validator(mode="after")
    def _complete(self) -> "ChoiceSection":
        if (self.key is None) == (not self.keys):
            raise invalid("expected either key or keys")
        bounded = self.low is not None and self.high is not None
        if bounded == bool(self.choices) or (self.low is None) != (self.high is None):
            raise invalid("expected either from and to, or choices")
        if self.step is not None and not bounded:
            raise invalid("needs from and to", ("step",))
        return self

    @property
    def all_keys(self) -> tuple[str, ...]:
        """The keys that take the value."""
        return self.keys or ((self.key,) if self.key else ())


class OptimiseSection(FileSection):
    """What `optimise` may choose, so that all requirements are met at the least of `aim`."""

    aim: Annotated[Literal["energy", "duration"], Doc("what is to be least")] = "energy"
    choose: Annotated[tuple[ChoiceSection, ...], Field(max_length=8), Doc("keys that may be chosen")] = ()


class MonteCarlo(FileSection):
    """Number of trials, and seed of their draws."""

    trials: Annotated[int, Field(ge=1, le=1_000_000_000), Doc("number of trials")] = 10_000
    seed: Annotated[int, Field(ge=0, lt=2**64), Doc("seed of all random numbers")] = 1


class Requirement(FileSection):
    """A probability that the mission must have.

    The unit of `at_most` and `at_least` follows from the quantity's phase: the section keeps them as written, and
    `checks.sections` reads them [SI].
    """

    quantity: Annotated[str, Doc("quantity or event that has to hold"), Field(examples=["total.success"])]
    probability: Annotated[q.Probability, Doc("probability with which it has to")]
    at_most: Annotated[float | None, Doc("greatest value"), Field(examples=["6 h"])] = None
    at_least: Annotated[float | None, Doc("least value"), Field(examples=["10 W*h"])] = None

    _written: str = PrivateAttr(default="")

    @property
    def written(self) -> str:
        """The quantity as the file has it."""
        return self._written or self.quantity

    @property
    def phase(self) -> str:
        """Phase of the quantity, ``total`` of the whole mission."""
        return self.quantity.rpartition(".")[0]

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

    between: Annotated[tuple[str, str], Doc("the two quantities"), Field(examples=[["ingress.speed", "egress.speed"]])]
    rho: Annotated[float, Field(ge=-1.0, le=1.0, examples=[0.5]), Doc("correlation of their normals")]

    def resolved(self, names: Sequence[str]) -> Self:
        """Return the correlation with names as quantities have them, given the names of all phases."""
        first, second = (name_in_force(resolved_path(path, names)) for path in self.between)
        return self.model_copy(update={"between": (first, second)})

    @property
    def pair(self) -> Correlation:
        """The correlation as draws take it."""
        return Correlation(self.between, self.rho)
