"""JSON schemas of quantities and distributions of them."""

import math
from collections.abc import Mapping

from missionplan.mission.schema.quantity_parser import QuantityParser

Schema = dict[str, object]

NUMBER_WITH_UNIT = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?(\s+\S|[^0-9\s.]).*$"
_FORMS = (("mean", "sd"), ("mean", "sd", "low", "high"), ("low", "high"), ("median", "factor"), ("choices",))
_OPTIONAL: Mapping[tuple[str, ...], tuple[str, ...]] = {("mean", "sd", "low", "high"): ("mean", "sd")}
"""Keys that a form needs, where it can do without the others."""


def quantity(parser: QuantityParser) -> Schema:
    """Return the schema of a quantity: text with a unit or a bare number, or a distribution of it."""
    value = _value(parser)
    if parser.fixed:
        return value
    return {"anyOf": [value, *(_distribution(value, form) for form in _FORMS)], "description": value["description"]}


def parameter(unit: str, description: str) -> Schema:
    """Return the schema of an effect's parameter."""
    return {**quantity(QuantityParser(unit)), "description": f"{description}{f' [{unit}]' if unit else ''}"}


def _value(parser: QuantityParser) -> Schema:
    if parser.unit:
        words = f"a quantity in {parser.unit} or a unit like it, such as '1.5 {parser.unit}'{_range(parser)}"
        return {"type": "string", "pattern": NUMBER_WITH_UNIT, "description": words}
    schema: Schema = {"type": "number", "description": f"a number{_range(parser)}"}
    if math.isfinite(parser.low):
        schema["exclusiveMinimum" if parser.open_low else "minimum"] = parser.low
    if math.isfinite(parser.high):
        schema["maximum"] = parser.high
    return schema


def _range(parser: QuantityParser) -> str:
    unit = f" {parser.unit}" if parser.unit else ""
    low = f"{'more than' if parser.open_low else 'at least'} {parser.low:g}{unit}" if math.isfinite(parser.low) else ""
    high = f"at most {parser.high:g}{unit}" if math.isfinite(parser.high) else ""
    words = " and ".join(part for part in (low, high) if part)
    return f"; {words}" if words else ""


def _distribution(value: Schema, form: tuple[str, ...]) -> Schema:
    free = {"type": value["type"], **({"pattern": NUMBER_WITH_UNIT} if "pattern" in value else {})}
    keys: Mapping[str, Schema] = {
        "choices": {"type": "array", "items": value, "minItems": 1},
        "factor": {"type": "number", "exclusiveMinimum": 1.0},
    }
    return {
        "type": "object",
        "properties": {key: keys.get(key, free) for key in form},
        "required": list(_OPTIONAL.get(form, form)),
        "additionalProperties": False,
    }
