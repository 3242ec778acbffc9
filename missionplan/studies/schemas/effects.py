"""JSON schema of the `effects:` section: the catalogue with its parameters, and explanations in doubt."""

from missionplan.effects import CATALOGUE
from missionplan.effects.info import EffectInfo
from missionplan.mission.schema.effect_list import ONE_OF
from missionplan.studies.schemas.values import Schema, parameter

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
    return {
        "type": "object",
        "description": info.what,
        "properties": {name: parameter(each.unit, each.doc) for name, each in info.parameters.items()},
        "additionalProperties": False,
    }
