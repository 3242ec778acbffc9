"""Every quantity in a section of a mission by its name, and the same section with other values in their places."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from pydantic import BaseModel

from missionplan.montecarlo.normal_transform import NormalTransform

_Section = TypeVar("_Section")
_QUANTITY = (float, NormalTransform, np.ndarray)
"""Base class of every distribution rather than their union: the check runs on every value of a mission."""
Change = Callable[[str, Any], Any]
"""From a quantity's name and value to its new value."""


def changed(section: _Section, name: str, change: Change) -> _Section:
    """Return a section, or any value of one, with each of its quantities changed; itself where none is.

    Parameters
    ----------
    section : section, tuple or quantity
    name : str
        Of the section in the names of its quantities, which are its key paths with phases by name.
    change : callable
        From a quantity's name and value to its new value.
    """
    if isinstance(section, _QUANTITY):
        return cast("_Section", change(name, section))
    if isinstance(section, BaseModel):
        fields = type(section).model_fields
        inside = {
            field: new
            for field, value in section
            if (new := changed(value, f"{name}.{fields[field].alias or field}", change)) is not value
        }
        return section.model_copy(update=inside) if inside else section
    if isinstance(section, tuple):
        items = tuple(changed(item, f"{name}[{index}]", change) for index, item in enumerate(section))
        same = all(new is old for new, old in zip(items, section, strict=True))
        return section if same else cast("_Section", items)
    return section
