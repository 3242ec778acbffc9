"""JSON schemas of the sections that read files, as pydantic writes them: quantities, effects of the catalogue, keys."""

import inspect
import math
import re
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic.json_schema import GenerateJsonSchema, models_json_schema
from pydantic_core import core_schema

from missionplan.effects import CATALOGUE
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.mission.quantity_paths import default_of
from missionplan.mission.schema import IDENTITY, read_moment
from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.mission.schema.quantity_parser import CoordinateParser, Limit, OrWord, QuantityParser
from missionplan.mission.sections import MOST_LEARNED
from missionplan.mission.validation_errors import keys_of, meaning_of, parsers_of
from missionplan.moments import EXAMPLE

Schema = dict[str, Any]

NUMBER_WITH_UNIT = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?(\s+\S|[^0-9\s.]).*$"
_FORMS = (("mean", "sd", "low", "high"), ("low", "high"), ("median", "factor"), ("choices",))
_WRITTEN_IN: Mapping[str, tuple[tuple[float, str], ...]] = {
    "s": ((86_400.0, "d"), (3600.0, "h"), (120.0, "min")),
    "rad": ((math.radians(1.0), "deg"),),
    "m": ((5000.0, "km"),),
}
"""Units in which examples are written, from which size on."""
_NAME = "$name"
"""Key by which a part of a schema says how `shared` calls it."""
_OPTIONAL: Mapping[tuple[str, ...], tuple[str, ...]] = {("mean", "sd", "low", "high"): ("mean", "sd")}
"""Keys that a form needs, where it can do without the others."""


def object_of(properties: Mapping[str, Schema], required: Sequence[str] | None = None) -> dict[str, Any]:
    """Return the schema of an object with these properties and no others; all are required where none are named."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties if required is None else required),
        "additionalProperties": False,
    }


def quantity(parser: QuantityParser) -> Schema:
    """Return the schema of a quantity: text with a unit or a bare number, or a distribution of it."""
    value = _value(parser)
    if parser.fixed:
        return value
    name = re.sub(r"[^\w.-]+", "_", f"{value['examples'][0]}{_range(parser)}".replace("/", "_per_"))
    words = {"description": value.pop("description"), "examples": value["examples"]}  # an editor shows the innermost
    forms = {_NAME: f"distribution_like_{name}", "anyOf": [_distribution(value, form) for form in _FORMS]}
    plain = {key: item for key, item in value.items() if key != "examples"}
    return {"anyOf": [{_NAME: f"like_{name}", **plain}, forms], **words}


def shared(schema: Schema) -> Schema:
    """Return a file's schema with what quantities of one kind have in common among its definitions, once."""
    definitions: dict[str, Schema] = {}

    def referring(part: Any) -> Any:
        if isinstance(part, list):
            return [referring(item) for item in part]
        if not isinstance(part, dict):
            return part
        written = {key: referring(value) for key, value in part.items() if key != _NAME}
        if _NAME not in part:
            return written
        definitions[part[_NAME]] = written
        return {"$ref": f"#/definitions/{part[_NAME]}"}

    whole: Schema = referring(schema)
    whole["definitions"] |= definitions
    return whole


def parameter(declaration: Parameter) -> Schema:
    """Return the schema of an effect's parameter."""
    described = f"{declaration.doc}{f' [{declaration.unit}]' if declaration.unit else ''}"
    examples = {"examples": [_written(declaration.scale, declaration.unit)]} if declaration.scale > 0.0 else {}
    return {**quantity(QuantityParser(declaration.unit)), "description": described, **examples}


def example(info: FieldInfo) -> Schema:
    """Return an example of a key: its own, a quantity of its usual range, or its default."""
    if info.examples:
        return {"examples": info.examples}
    limit = next((annotation for annotation in info.metadata if isinstance(annotation, Limit)), None)
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
    size, unit = next((pair for pair in _WRITTEN_IN.get(unit, ()) if value >= pair[0]), (1.0, unit))
    rounded = float(f"{value / size:.{digits}g}")
    return f"{rounded:g} {unit}" if unit else rounded


def _value(parser: QuantityParser) -> Schema:
    value = next((size for size in (1.5, -1.5) if parser.low < size < parser.high), 0.5 * (parser.low + parser.high))
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
    free["examples"] = value["examples"]
    keys: Mapping[str, Schema] = {
        "choices": {"type": "array", "items": value, "minItems": 1, "examples": [value["examples"]]},
        "factor": {"type": "number", "exclusiveMinimum": 1.0, "examples": [1.4]},
    }
    return object_of(
        {key: {**keys.get(key, free), "description": _PARTS[key]} for key in form}, _OPTIONAL.get(form, form)
    )


_PARTS: Mapping[str, str] = {
    "mean": "mean of a normal distribution",
    "sd": "standard deviation",
    "low": "least that it may be",
    "high": "most that it may be",
    "median": "median of a log-normal distribution",
    "factor": "68 % lie within the median times this and over this",
    "choices": "values, of which each trial draws one",
}
"""Keys of a distribution."""
_PAIR: Schema = {
    "type": "array",
    "items": {"type": "string"},
    "minItems": 2,
    "maxItems": 2,
    "description": "two parameters of these effects",
    "examples": [["mean-current.east", "mean-current.north"]],
}
_RHO: Schema = {"type": "number", "minimum": -1, "maximum": 1, "description": "their correlation", "examples": [0.8]}
_CORRELATIONS: Schema = {
    "type": "array",
    "items": object_of({"between": _PAIR, "rho": _RHO}),
    "description": "correlations of the parameters",
}


def effects() -> tuple[Schema, dict[str, Schema]]:
    """Return the schema of the list, and the definitions that it refers to."""
    entries = {name: _entry(info) for name, info in CATALOGUE.items()}
    entry: Schema = {"type": "object", "properties": entries, "additionalProperties": False, "maxProperties": 1}
    needed: dict[str, Schema] = {
        "probability": {
            "type": "number",
            "exclusiveMinimum": 0,
            "maximum": 1,
            "description": "of this explanation; what is left to 1 is that none holds",
            "examples": [0.6],
        },
        "effects": {
            "type": "array",
            "items": {"$ref": "#/definitions/effect"},
            "description": "effects that act where it holds",
        },
    }
    explanation = object_of({**needed, "correlations": _CORRELATIONS}, list(needed))
    words = "explanations, of which each trial draws one"
    doubt = object_of({ONE_OF: {"type": "array", "items": explanation, "minItems": 1, "description": words}})
    listed: Schema = {"type": "array", "items": {"anyOf": [{"$ref": "#/definitions/effect"}, doubt]}}
    return listed, {"effect": {**entry, "minProperties": 1}}


def _entry(info: EffectInfo) -> Schema:
    words = "the date of the phases; default: the mission's start"
    epoch: Schema = {"type": "string", "description": words, "examples": [EXAMPLE]}
    dated = {"epoch": epoch} if info.frequency_of is not None else {}
    return {
        "type": "object",
        "description": info.what,
        "properties": {**{name: parameter(declaration) for name, declaration in info.parameters.items()}, **dated},
        "additionalProperties": False,
    }


_TEXT_OR_NUMBER: Schema = {"anyOf": [{"type": "string", "pattern": NUMBER_WITH_UNIT}, {"type": "number"}]}
"""A quantity whose unit follows from other keys."""
_FILE: Schema = {
    "file": {"type": "string", "description": "file of the draws", "examples": ["posterior.npz"]},
    "sha256": {"type": "string", "description": "its SHA-256, by which it is known", "examples": [64 * "0"]},
    "summary": {"type": "object", "description": "what they tell, for the reader: nothing reads it", "examples": [{}]},
}
_POSTERIOR: Schema = {
    "type": "object",
    "description": "draws of what was learned, as diagnose writes them beside the mission",
    **object_of(_FILE, ("file", "sha256")),
}
_LEARNED: Schema = {
    "type": "array",
    "items": {"type": "string", "pattern": f"^{IDENTITY.pattern}$"},
    "maxItems": MOST_LEARNED,
}
_REPLACED: Mapping[tuple[str, str], Schema] = {
    ("Mission", "effects"): {"description": "effects of the catalogue, each as `effect-id: {parameter: quantity}`"},
    ("Mission", "posterior"): _POSTERIOR,
    ("Mission", "learned_from"): _LEARNED,
    ("Requirement", "at_most"): _TEXT_OR_NUMBER,
    ("Requirement", "at_least"): _TEXT_OR_NUMBER,
    ("SweepGrid", "from"): _TEXT_OR_NUMBER,
    ("SweepGrid", "to"): _TEXT_OR_NUMBER,
}
"""Schemas of keys that no annotation tells, by the section's name and the key."""


def written(*sections: type[BaseModel]) -> tuple[list[dict[str, Any]], dict[str, dict[str, Any]]]:
    """Return the schemas of sections, and the definitions of those inside them, by name."""
    _, whole = models_json_schema(
        [(model, "validation") for model in sections], ref_template="#/definitions/{model}", schema_generator=_Writer
    )
    definitions = whole["$defs"]
    for definition in definitions.values():
        definition.pop("title", None)
    return [definitions.pop(model.__name__) for model in sections], definitions


class _Writer(GenerateJsonSchema):
    """What pydantic writes of a section, as people write files: quantities with units, nothing for null."""

    def model_schema(self, schema: core_schema.ModelSchema) -> dict[str, Any]:
        section, inner = schema["cls"], self.generate_inner(schema["schema"])
        kind_field = {name: info for name, info in section.model_fields.items() if name == "kind" and not info.exclude}
        properties = {
            name: _described(info, _REPLACED.get((section.__name__, name), inner["properties"][name]))
            for name, info in (kind_field | keys_of(section)).items()
        }
        described = {"description": inspect.getdoc(section) or "", "additionalProperties": False}
        return {**inner, **described, "properties": properties}

    def function_plain_schema(self, schema: Any) -> Schema:
        read = schema["function"]["function"]
        if isinstance(read, OrWord):
            return {"anyOf": [{"enum": list(read.words)}, quantity(read.parser)]}
        if read is read_moment:
            return {"type": "string", "description": "a time, ISO 8601", "examples": [EXAMPLE]}
        return quantity(read) if isinstance(read, QuantityParser) else {}

    def date_schema(self, schema: core_schema.DateSchema) -> Schema:
        return {"type": "string", "description": "a date, ISO 8601"}

    def default_schema(self, schema: Any) -> Schema:
        return self.generate_inner(schema["schema"])

    nullable_schema = default_schema

    def dict_schema(self, schema: core_schema.DictSchema) -> Schema:
        return {"type": "object", "additionalProperties": self.generate_inner(schema["values_schema"])}

    def field_title_should_be_set(self, schema: object) -> bool:
        return False

    def list_schema(self, schema: core_schema.ListSchema) -> Schema:
        return {}

    def literal_schema(self, schema: core_schema.LiteralSchema) -> Schema:
        return {"enum": schema["expected"], "examples": schema["expected"][:1]}

    def str_schema(self, schema: core_schema.StringSchema) -> Schema:
        return {"type": ["string", "number"]}

    def tagged_union_schema(self, schema: core_schema.TaggedUnionSchema) -> Schema:
        return {"anyOf": [self.generate_inner(choice) for choice in schema["choices"].values()]}

    def tuple_schema(self, schema: core_schema.TupleSchema) -> Schema:
        items = [self.generate_inner(inner) for inner in schema["items_schema"]]
        if "variadic_item_index" in schema:
            return {"type": "array", "items": items[0]}
        return {"type": "array", "items": items, "minItems": len(items), "maxItems": len(items)}


def _described(info: FieldInfo, value: Schema) -> Schema:
    """Return the schema of a key: of its values, with its meaning, default and an example."""
    # beside a reference nothing counts
    schema: Schema = {"type": "object", "allOf": [value]} if "$ref" in value else dict(value)
    if "anyOf" in schema:
        unions = [[part] if _NAME in part else part.get("anyOf", [part]) for part in schema["anyOf"]]
        schema["anyOf"] = list(chain.from_iterable(unions))  # of one inside another the choices, but of a shared one
    words = [text for text in (meaning_of(info), schema.get("description")) if text]
    if words:
        schema["description"] = ": ".join(map(str, words))
    default = default_of(info)
    if isinstance(default, str | int | float) and not re.match("nan|$", str(default)):
        schema["default"] = default
    return {**schema, **example(info)}
