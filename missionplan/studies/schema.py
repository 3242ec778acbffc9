"""`schema`: the JSON schema of a kind of file, from the models that read it.

JSON schema of `summary.json`: the entries that the fields of each result state, command by command.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import partial
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel

from missionplan.datasets import DatasetFormat
from missionplan.datasets.dives import DESCENT
from missionplan.datasets.legs import TRANSIT
from missionplan.datasets.summaries import SUMMARY
from missionplan.datasets.tank import DRAG, FREE_OSCILLATION, PROPELLER_TRANSIENT, THRUSTER
from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.exporters.plan_json import PLAN_FORMAT, PlanFile
from missionplan.mission import Mission
from missionplan.mission.schema import SCHEMAS
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.results import SCHEMA, Provenance, Result
from missionplan.results.anchor_sizing import AnchorSizing
from missionplan.results.decision import Decision
from missionplan.results.entries import Record, StatedField, stated
from missionplan.results.imported import ImportedData
from missionplan.results.learned import Campaign, Diagnosis
from missionplan.results.optimisation import Optimised
from missionplan.results.score import Score
from missionplan.results.simulation import Outcome
from missionplan.studies.comparison.result import Alternatives, Comparison
from missionplan.studies.exploration.result import Exploration
from missionplan.studies.history.result import History
from missionplan.studies.identification.fits import Identification
from missionplan.studies.leg_length.plan_result import LegPlan
from missionplan.studies.leg_length.sweep_result import Sweep
from missionplan.studies.rare_failure import RareFailure
from missionplan.studies.schema_sections import Schema, effects, object_of, shared, written
from missionplan.studies.sweep_transition import TransitionSweep
from missionplan.studies.tide.result import TideResult

_RESULTS: Mapping[str, tuple[type[Result], ...]] = {
    "compare": (Comparison, Alternatives),
    "diagnose": (Diagnosis, Campaign),
    "explore": (Exploration,),
    "history": (History,),
    "identify": (Identification,),
    "import": (ImportedData,),
    "optimise": (Optimised,),
    "plan-legs": (LegPlan,),
    "score": (Score,),
    "simulate": (Outcome, RareFailure),
    "size-anchor": (AnchorSizing,),
    "sweep-dmax": (Sweep,),
    "sweep-transition": (TransitionSweep,),
    "tide": (TideResult,),
}
"""What each command may answer with."""
_NUMBER: Schema = {"type": ["number", "null"]}
_PLAIN: Mapping[object, Schema] = {
    str: {"type": "string"},
    int: {"type": "integer"},
    float: _NUMBER,
    bool: {"type": "boolean"},
    NoneType: {"type": "null"},
}
_OF_TRIALS: Mapping[type, tuple[str, ...]] = {
    Statistic: ("mean", "sd", "p05", "p50", "p95", "standard_error"),
    Probability: ("value", "low", "high"),
}


@dataclass
class _Records:
    """Definitions of records by name, as they are met."""

    definitions: dict[str, Schema] = field(default_factory=dict)

    def of(self, kind: type[Any], parts: tuple[str, ...] = ()) -> Schema:
        """Return a reference to a record, which is defined where it is not yet; or some of its entries."""
        if parts:
            whole = self.written(kind)
            required = [key for key in parts if key in whole["required"]]
            return object_of({key: whole["properties"][key] for key in parts}, required)
        name = kind.__name__
        if name not in self.definitions:
            self.definitions[name] = {}  # records may hold themselves
            self.definitions[name] = self.written(kind)
        return {"$ref": f"#/definitions/{name}"}

    def written(self, kind: type[Any]) -> dict[str, Any]:
        """Write a record out; one that makes its summary otherwise is left open."""
        if kind in _OF_TRIALS:
            return object_of(dict.fromkeys(_OF_TRIALS[kind], _NUMBER))
        if not issubclass(kind, Record):
            hints = {} if hasattr(kind, "summary") else get_type_hints(kind)
            return object_of({name: self._value(hint) for name, hint in hints.items()}) if hints else {"type": "object"}
        top = self.written(Provenance) if issubclass(kind, Result) else object_of({})
        decision = self.written(Decision) if issubclass(kind, Result) else {}
        for item in stated(kind):  # type: ignore[arg-type]  # a class is hashable
            if decision and item.key == "decision":
                decision = _together(decision, self.written(item.kind))  # type: ignore[arg-type]
            else:
                self._put(top, item)
        if decision:
            top["properties"]["decision"] = {"description": "what the crew is to do", **decision}
            top["required"].append("decision")
        return top if kind.summary in (Record.summary, Result.summary) else {**top, "additionalProperties": True}

    def _put(self, top: dict[str, Any], item: StatedField) -> None:
        group, entry = top, item.entry
        for name in item.groups:
            group = group["properties"].setdefault(name, object_of({}))
        if entry.inline:
            group.update(_together(group, self.written(item.kind)))  # type: ignore[arg-type]
            return
        schema = self._value(item.kind, entry.parts)
        before = group["properties"].get(item.key)
        if before and "properties" in schema:  # other entries stand in this one
            schema = _together(before, schema)
        unit = {"unit": entry.unit} if entry.unit else {}
        if "$ref" in schema:  # beside a reference nothing counts
            schema = {"allOf": [schema]}
        group["properties"][item.key] = {"description": entry.meaning, **unit, **schema}
        if not entry.optional and not entry.when:
            group["required"].append(item.key)

    def _value(self, annotation: object, parts: tuple[str, ...] = ()) -> Schema:
        origin, arguments = get_origin(annotation), get_args(annotation)
        if origin is Annotated:
            return self._value(arguments[0], parts)
        if origin in (Union, UnionType):
            return {"anyOf": [self._value(argument, parts) for argument in arguments]}
        if origin is Literal:
            return {"enum": list(arguments)}
        if origin in (tuple, list):
            return {"type": "array", "items": self._value(arguments[0], parts)}
        if isinstance(origin, type) and issubclass(origin, Mapping):
            return {"type": "object", "additionalProperties": self._value(arguments[1], parts)}
        if isinstance(annotation, type) and (is_dataclass(annotation) or issubclass(annotation, tuple)):
            return self.of(annotation, parts)
        return dict(_PLAIN.get(annotation, {}))


def _together(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Return an object with the entries of two."""
    return object_of(first["properties"] | second["properties"], first["required"] + second["required"])


def summaries() -> Schema:
    """Return the schema of the summaries of all commands."""
    records = _Records()
    answers = {
        command: {"anyOf": [records.of(kind) for kind in kinds]} if len(kinds) > 1 else records.of(kinds[0])
        for command, kinds in _RESULTS.items()
    }
    return {
        "type": "object",
        "properties": {"schema": {"const": SCHEMA}, "command": {"enum": list(_RESULTS)}},
        "required": ["schema", "command"],
        "allOf": [
            {"if": {"properties": {"command": {"const": command}}}, "then": answer}
            for command, answer in answers.items()
        ],
        "definitions": records.definitions,
    }


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
VERSIONS: Mapping[Kind, str] = {
    **{kind: f"missionplan/{kind}/{SCHEMAS[kind]}" for kind in READ},
    "summary": SCHEMA,
    "plan": f"missionplan/plan/{PLAN_FORMAT}",
}
"""Name and version of each form: the number goes up when a file of it would be read otherwise or no more."""


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
    head: Schema = {"$schema": _DRAFT, "title": f"missionplan {kind} file", "version": VERSIONS[kind]}
    return shared({**head, **_WRITTEN[kind]()})


def _of_model(model: type[BaseModel]) -> Schema:
    (top,), definitions = written(model)
    vehicle = top
    if model is Mission:
        vehicle = definitions["Vehicle"]
        _or_text(top, "vehicle", "the vehicle's file, relative to this one")
        listed, effect = effects()
        top["properties"]["effects"] |= listed
        definitions |= effect
    _or_text(vehicle, "reliability", "a class of vehicle, or a file")
    return {**top, "definitions": definitions}


def _or_text(section: dict[str, Any], key: str, words: str) -> None:
    """Let a key take text too, which is described by these words."""
    value = section["properties"][key]
    text = {"type": "string", "description": words}
    section["properties"][key] = {"anyOf": [text, value], "description": value["description"]}


def _of_datasets() -> Schema:
    settings, definitions = written(*(form.settings for form in _FORMATS))
    kinds: list[Schema] = []
    kind, every = settings[0]["properties"]["kind"], [form.kind for form in _FORMATS]
    for form, section in zip(_FORMATS, settings, strict=True):
        section["properties"]["kind"] = {**kind, "const": form.kind, "examples": [form.kind]}
        kinds.append({"if": {"properties": {"kind": {"const": form.kind}}}, "then": section})
    return {
        "type": "object",
        "properties": {"kind": {**kind, "enum": every, "examples": every[:1]}},
        "required": ["kind"],
        "allOf": kinds,
        "definitions": definitions,
    }


def _of_plan() -> Schema:
    records = _Records()
    return {**records.written(PlanFile), "definitions": records.definitions}


_WRITTEN: Mapping[Kind, Callable[[], Schema]] = {
    "mission": partial(_of_model, Mission),
    "vehicle": partial(_of_model, Vehicle),
    "dataset": _of_datasets,
    "summary": summaries,
    "plan": _of_plan,
}
