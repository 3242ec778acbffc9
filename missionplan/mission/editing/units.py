"""Numbers of Python, in SI, as a mission file writes them: text with a unit."""

import math
from collections.abc import Mapping, Sequence

from pydantic import BaseModel

from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath
from missionplan.mission.reading.fields import fields_at, parsers_of
from missionplan.montecarlo.distributions import Choices, LogNormal, Normal, TruncatedNormal, Uniform

_SPREADS = ("mean", "sd", "low", "high", "median", "choices")
"""Keys of distributions that are in the quantity's unit."""


def as_written(value: object, path: KeyPath, model: type[BaseModel]) -> object:
    """Return a value as a mission file holds it: bare numbers get the SI unit of their key, where that has one.

    Parameters
    ----------
    value : object
        Text, a number in SI, a distribution, or mappings and lists of them.
    path : tuple of (str or int)
        Its key path.
    model : type
        Of a mission.
    """
    if isinstance(value, Mapping):
        return {str(key): as_written(inner, (*path, str(key)), model) for key, inner in value.items()}
    if isinstance(value, Normal | TruncatedNormal | Uniform | LogNormal | Choices):
        return as_written(_forms(value), path, model)
    if hasattr(value, "tolist"):  # of numpy
        return as_written(value.tolist(), path, model)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [as_written(inner, (*path, index), model) for index, inner in enumerate(value)]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    unit = _unit(path, model)
    short = f"{value:g}"
    return f"{short if float(short) == value else repr(value)} {unit}" if unit else value


def _unit(path: KeyPath, model: type[BaseModel]) -> str:
    """SI unit of the quantity at a key path; empty where it has none, or where it depends on other keys."""
    if path[-1] == "factor":
        return ""
    while path and (isinstance(path[-1], int) or path[-1] in _SPREADS) and path[-1] not in fields_at(path[:-1], model):
        path = path[:-1]
    if path[:1] == ("effects",):
        effect, name = str(path[-2]), str(path[-1])
        parameters = CATALOGUE[effect].parameters if effect in CATALOGUE else {}
        return parameters[name].unit if name in parameters else ""
    field = fields_at(path[:-1], model).get(str(path[-1])) if path else None
    units = {parser.unit for parser in parsers_of(field)} if field is not None else set()
    return units.pop() if len(units) == 1 else ""


def _forms(value: Normal | TruncatedNormal | Uniform | LogNormal | Choices) -> dict[str, object]:
    """A distribution by the keys of a mission file."""
    if isinstance(value, Normal):
        return {"mean": value.mean, "sd": value.sd}
    if isinstance(value, TruncatedNormal):
        bounds = {"low": value.low, "high": value.high}
        finite = {key: bound for key, bound in bounds.items() if math.isfinite(bound)}
        return {"mean": value.parent_mean, "sd": value.parent_sd, **finite}
    if isinstance(value, Uniform):
        return {"low": value.low, "high": value.high}
    if isinstance(value, LogNormal):
        return {"median": value.median, "factor": value.factor}
    return {"choices": list(value.values)}
