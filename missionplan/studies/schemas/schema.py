"""`schema`: the JSON schema of a kind of file, from the models that read it."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Literal, get_args

from pydantic import BaseModel

from missionplan.datasets.dives import DESCENT
from missionplan.datasets.legs import TRANSIT
from missionplan.datasets.reading import DatasetFormat
from missionplan.datasets.summaries import SUMMARY
from missionplan.datasets.tank.formats import DRAG, FREE_OSCILLATION, PROPELLER_TRANSIENT, THRUSTER
from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.exporters.plan_json import plan_schema
from missionplan.mission import Mission
from missionplan.mission.mission import MOST_LEARNED
from missionplan.mission.schema.section import IDENTITY
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.studies.schemas.sections import TEXT_OR_NUMBER, Schema, Sections, effects
from missionplan.studies.schemas.summaries import summaries

Kind = Literal["mission", "vehicle", "dataset", "summary", "plan"]
KINDS: tuple[Kind, ...] = get_args(Kind)
READ: tuple[Kind, ...] = ("mission", "vehicle", "dataset")
"""Kinds of files that people write."""
_DRAFT = "http://json-schema.org/draft-07/schema#"
_FORMATS: tuple[DatasetFormat, ...] = (  # type: ignore[type-arg]
    TRANSIT,
    DESCENT,
    SUMMARY,
    DRAG,
    FREE_OSCILLATION,
    THRUSTER,
    PROPELLER_TRANSIENT,
)
_DEPENDENT: Mapping[tuple[str, str], Schema] = {
    ("Requirement", "at_most"): TEXT_OR_NUMBER,
    ("Requirement", "at_least"): TEXT_OR_NUMBER,
    ("SweepGrid", "from"): TEXT_OR_NUMBER,
    ("SweepGrid", "to"): TEXT_OR_NUMBER,
}
"""Keys whose unit follows from others."""
_LEARNED: Schema = {
    "type": "array",
    "items": {"type": "string", "pattern": f"^{IDENTITY.pattern}$"},
    "maxItems": MOST_LEARNED,
    "description": "hashes of what the effects were learned from, as diagnose writes them",
}


def schema(kind: Kind) -> dict[str, object]:
    """Return the JSON schema (draft 7) of a kind of file, for completion and checks in editors.

    It tells keys, units, ranges of numbers and the effects of the catalogue; what depends on several keys at once only
    `validate` checks.

    Parameters
    ----------
    kind : {'mission', 'vehicle', 'dataset', 'summary', 'plan'}

    Raises
    ------
    InputError
        When there is no such kind.
    """
    if kind not in KINDS:
        message = f"given {shown(kind)}, expected one of {', '.join(KINDS)}"
        raise InputError([Problem(message, key="kind", hint=did_you_mean(str(kind), KINDS))])
    head: Schema = {"$schema": _DRAFT, "title": f"missionplan {kind} file"}
    return {**head, **_WRITTEN[kind]()}


def _of_model(model: type[BaseModel]) -> Schema:
    listed, definitions = effects()
    sections = Sections({**_DEPENDENT, ("Mission", "effects"): listed, ("Mission", "learned_from"): _LEARNED})
    top = sections.written(model)
    if model is Mission:
        properties = top["properties"]
        if isinstance(properties, dict):
            file: Schema = {"type": "string", "description": "the vehicle's file, relative to this one"}
            properties["vehicle"] = {"anyOf": [file, sections.of(Vehicle)]}
    vehicle = top if model is Vehicle else sections.definitions["Vehicle"]
    _or_name(vehicle, "reliability", "a class of vehicle, or a file")
    return {**top, "definitions": {**sections.definitions, **(definitions if model is Mission else {})}}


def _or_name(section: object, key: str, meaning: str) -> None:
    """Let a section's key take the name of what is put in its place."""
    if isinstance(section, dict) and isinstance(properties := section["properties"], dict):
        properties[key] = {"anyOf": [{"type": "string", "description": meaning}, properties[key]]}


def _of_datasets() -> Schema:
    sections = Sections(_DEPENDENT)
    kinds: list[Schema] = []
    for form in _FORMATS:
        written = sections.written(form.settings)
        properties = written["properties"]
        if isinstance(properties, dict):
            properties["kind"] = {"const": form.kind}
        kinds.append({"if": {"properties": {"kind": {"const": form.kind}}}, "then": written})
    return {
        "type": "object",
        "properties": {"kind": {"enum": [form.kind for form in _FORMATS]}},
        "required": ["kind"],
        "allOf": kinds,
        "definitions": sections.definitions,
    }


_WRITTEN: Mapping[Kind, Callable[[], Schema]] = {
    "mission": partial(_of_model, Mission),
    "vehicle": partial(_of_model, Vehicle),
    "dataset": _of_datasets,
    "summary": summaries,
    "plan": plan_schema,
}
