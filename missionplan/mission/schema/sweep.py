"""Values that `sweep-dmax` tries: greatest lengths of legs and velocity errors."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator, model_validator

from missionplan.arrays import Array
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, invalid
from missionplan.montecarlo.distributions import Quantity


class SweepGrid(FileSection):
    """Grid of d_max: `points` values from `start` to `stop`, of the distance or as lengths."""

    of: Literal["distance"] | None = None
    start: Annotated[float, Field(alias="from")]
    stop: Annotated[float, Field(alias="to")]
    points: Annotated[int, Field(ge=2, le=10_000)]

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

    d_max: SweepDMax = SweepGrid.model_validate({"from": 0.02, "to": 1.0, "points": 99, "of": "distance"})
    sigma: tuple[q.FixedSpeed, ...] | None = None
    phase: str | None = None

    def d_max_values(self, distance: float) -> Array:
        """Return the lengths of the grid for a transit of `distance`, shape (k,) [m]."""
        if isinstance(self.d_max, SweepGrid):
            values = np.linspace(self.d_max.start, self.d_max.stop, self.d_max.points)
            return values * distance if self.d_max.of else values
        return np.sort(np.array(self.d_max))
