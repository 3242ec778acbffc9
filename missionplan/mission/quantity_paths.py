"""Every quantity in a section of a mission, by its key path."""

from typing import cast

from pydantic import BaseModel

from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.normal_transform import NormalTransform

_QUANTITY = (float, NormalTransform)
"""Base class of every distribution rather than their union: the check runs on every value of a mission."""


def collect_quantities(value: object, path: str, found: dict[str, Quantity]) -> None:
    """Add the quantities in a value of a mission to those found, by key path."""
    if value is None or isinstance(value, bool | str):
        return
    if isinstance(value, _QUANTITY):
        found[path] = cast("Quantity", value)
    elif isinstance(value, BaseModel):
        given = type(value).model_fields
        for name, inner in value:
            collect_quantities(inner, f"{path}.{given[name].alias or name}", found)
    elif isinstance(value, tuple):
        for index, inner in enumerate(value):
            collect_quantities(inner, f"{path}[{index}]", found)
