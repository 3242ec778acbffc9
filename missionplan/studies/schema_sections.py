"""JSON schemas of the sections that read files: quantities, effects of the catalogue, every key with its range."""

import inspect
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date, datetime
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from missionplan.effects import CATALOGUE
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.mission.quantity_paths import default_of
from missionplan.mission.schema import ReadBy
from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.mission.schema.quantity_parser import CoordinateParser, Limit, OrWord, QuantityParser
from missionplan.mission.validation_errors import keys_of, meaning_of, parsers_of
from missionplan.moments import EXAMPLE

Schema = dict[str, object]

NUMBER_WITH_UNIT = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?(\s+\S|[^0-9\s.]).*$"
_FORMS = (("mean", "sd"), ("mean", "sd", "low", "high"), ("low", "high"), ("median", "factor"), ("choices",))
_WRITTEN_IN: Mapping[str, tuple[tuple[float, str], ...]] = {
    "s": ((86_400.0, "d"), (3600.0, "h"), (120.0, "min")),
    "rad": ((math.radians(1.0), "deg"),),
    "m": ((5000.0, "km"),),
}
"""Units in which examples are written, from which size on."""
_OPTIONAL: Mapping[tuple[str, ...], tuple[str, ...]] = {("mean", "sd", "low", "high"): ("mean", "sd")}
"""Keys that a form needs, where it can do without the others."""


def quantity(parser: QuantityParser) -> Schema:
    """Return the schema of a quantity: text with a unit or a bare number, or a distribution of it."""
    value = _value(parser)
    if parser.fixed:
        return value
    several = [value, *(_distribution(value, form) for form in _FORMS)]
    return {"anyOf": several, "description": value["description"], "examples": value["examples"]}


def parameter(known: Parameter) -> Schema:
    """Return the schema of an effect's parameter."""
    described = f"{known.doc}{f' [{known.unit}]' if known.unit else ''}"
    examples = {"examples": [_written(known.scale, known.unit)]} if known.scale > 0.0 else {}
    return {**quantity(QuantityParser(known.unit)), "description": described, **examples}


def example(info: FieldInfo) -> Schema:
    """Return an example of a key: its own, a quantity of its usual range, or its default."""
    if info.examples:
        return {"examples": info.examples}
    limit = next((each for each in info.metadata if isinstance(each, Limit)), None)
    parsers = parsers_of(info)
    if limit is None or not parsers:
        default = default_of(info)
        return {"examples": [default]} if isinstance(default, int | str) and default != "" and not parsers else {}
    low, high = limit.usual
    middle = math.sqrt(low * high) if low > 0.0 else 0.1 * high
    written = _written(middle, parsers[0].unit if limit.unit is None else limit.unit)
    components = get_args(info.annotation) if get_origin(info.annotation) is tuple else ()
    return {"examples": [[written] * len(components) if components else written]}


def _written(value: float, unit: str, digits: int = 1) -> str | float:
    """A quantity as a person writes it."""
    size, unit = next((each for each in _WRITTEN_IN.get(unit, ()) if value >= each[0]), (1.0, unit))
    rounded = float(f"{value / size:.{digits}g}")
    return f"{rounded:g} {unit}" if unit else rounded


def _value(parser: QuantityParser) -> Schema:
    value = 1.5 if parser.low < 1.5 < parser.high else 0.5 * (parser.low + parser.high)
    examples = [
        f"60 06.0 {parser.signs[0]}" if isinstance(parser, CoordinateParser) else _written(value, parser.unit, 2)
    ]
    if parser.unit:
        words = f"a quantity in {parser.unit} or a unit like it, such as '{examples[0]}'{_range(parser)}"
        return {"type": "string", "pattern": NUMBER_WITH_UNIT, "description": words, "examples": examples}
    schema: Schema = {"type": "number", "description": f"a number{_range(parser)}", "examples": examples}
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


_PAIR: Schema = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
_CORRELATIONS: Schema = {
    "type": "array",
    "items": {
        "type": "object",
        "properties": {"between": _PAIR, "rho": {"type": "number", "minimum": -1, "maximum": 1}},
        "required": ["between", "rho"],
        "additionalProperties": False,
    },
}


def effects() -> tuple[Schema, dict[str, Schema]]:
    """Return the schema of the list, and the definitions that it refers to."""
    entries = {name: _entry(info) for name, info in CATALOGUE.items()}
    entry: Schema = {"type": "object", "properties": entries, "additionalProperties": False, "maxProperties": 1}
    explanation: Schema = {
        "type": "object",
        "properties": {
            "probability": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
            "effects": {"type": "array", "items": {"$ref": "#/definitions/effect"}},
            "correlations": _CORRELATIONS,
        },
        "required": ["probability", "effects"],
        "additionalProperties": False,
    }
    one_of: Schema = {"type": "array", "items": explanation, "minItems": 1}
    doubt: Schema = {
        "type": "object",
        "properties": {ONE_OF: one_of},
        "required": [ONE_OF],
        "additionalProperties": False,
    }
    listed: Schema = {"type": "array", "items": {"anyOf": [{"$ref": "#/definitions/effect"}, doubt]}}
    return {**listed, "description": "effects of the catalogue, each as `effect-id: {parameter: quantity}`"}, {
        "effect": {**entry, "minProperties": 1}
    }


def _entry(info: EffectInfo) -> Schema:
    epoch: Schema = {"type": "string", "description": "the date of the phases; default: the mission's start"}
    dated = {"epoch": epoch} if info.frequency_of is not None else {}
    return {
        "type": "object",
        "description": info.what,
        "properties": {**{name: parameter(each) for name, each in info.parameters.items()}, **dated},
        "additionalProperties": False,
    }


_PLAIN: Mapping[object, Schema] = {
    str: {"type": ["string", "number"]},
    int: {"type": "integer"},
    float: {"type": "number"},
    bool: {"type": "boolean"},
    datetime: {"type": "string", "description": "a time, ISO 8601", "examples": [EXAMPLE]},
    date: {"type": "string", "description": "a date, ISO 8601"},
    NoneType: {"type": "null"},
    object: {},
}
_LIMITS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}
TEXT_OR_NUMBER: Schema = {"anyOf": [{"type": "string", "pattern": NUMBER_WITH_UNIT}, {"type": "number"}]}
"""A quantity whose unit follows from other keys."""


@dataclass
class Sections:
    """Definitions of sections, by name, as they are met."""

    replaced: Mapping[tuple[str, str], Schema]
    """Schemas of keys that no annotation tells, by the section's name and the key."""
    definitions: dict[str, dict[str, Any]] = field(default_factory=dict)

    def of(self, section: type[BaseModel]) -> Schema:
        """Return a reference to a section, which is defined where it is not yet."""
        name = section.__name__
        if name not in self.definitions:
            self.definitions[name] = {}  # sections may hold themselves
            self.definitions[name] = self.written(section)
        return {"$ref": f"#/definitions/{name}"}

    def written(self, section: type[BaseModel]) -> dict[str, Any]:
        """Write a section out."""
        keys = keys_of(section)
        if "kind" in section.model_fields and not section.model_fields["kind"].exclude:
            keys = {"kind": section.model_fields["kind"], **keys}
        required = [name for name, each in keys.items() if each.default is PydanticUndefined and each.is_required()]
        return {
            "type": "object",
            "description": inspect.getdoc(section) or "",
            "properties": {name: self._key(section, name, each) for name, each in keys.items()},
            **({"required": required} if required else {}),
            "additionalProperties": False,
        }

    def _key(self, section: type[BaseModel], name: str, info: FieldInfo) -> Schema:
        replaced = self.replaced.get((section.__name__, name))
        schema = dict(replaced) if replaced is not None else self._annotated(info.annotation, info.metadata)
        words = [each for each in (meaning_of(info), schema.get("description")) if each]
        if words and "$ref" not in schema:
            schema["description"] = ": ".join(map(str, words))
        default = default_of(info)
        if isinstance(default, str | int | float) and not re.match("nan|$", str(default)) and "$ref" not in schema:
            schema["default"] = default
        return schema if "$ref" in schema else {**schema, **example(info)}

    def _annotated(self, annotation: object, metadata: list[object]) -> Schema:
        for item in metadata:
            if isinstance(item, ReadBy) and annotation is not datetime:
                return self._read(item)
        schema = self._value(annotation)
        for item in metadata:
            for name, keyword in _LIMITS.items():
                if getattr(item, name, None) is not None:
                    schema = {**schema, keyword: getattr(item, name)}
        return schema

    def _read(self, reader: ReadBy) -> Schema:
        if isinstance(reader.read, QuantityParser):
            return quantity(reader.read)
        if isinstance(reader.read, OrWord):
            words: Schema = {"enum": list(reader.read.words)}
            return {"anyOf": [words, quantity(reader.read.parser)]}
        return {}

    def _value(self, annotation: object) -> Schema:
        origin, arguments = get_origin(annotation), get_args(annotation)
        if origin is Annotated:
            return self._annotated(arguments[0], list(arguments[1:]))
        if origin in (Union, UnionType):
            several = [self._value(each) for each in arguments if each is not NoneType]
            return several[0] if len(several) == 1 else {"anyOf": several}
        if origin is Literal:
            return {"enum": list(arguments), "examples": [arguments[0]]}
        if origin is tuple:
            return self._list(arguments)
        if isinstance(origin, type) and issubclass(origin, Mapping):
            return {"type": "object", "additionalProperties": self._value(arguments[1])}
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return self.of(annotation)
        return dict(_PLAIN.get(annotation, {}))

    def _list(self, items: tuple[object, ...]) -> Schema:
        if len(items) == 2 and items[1] is Ellipsis:
            return {"type": "array", "items": self._value(items[0])}
        written = [self._value(each) for each in items]
        return {"type": "array", "items": written, "minItems": len(items), "maxItems": len(items)}
