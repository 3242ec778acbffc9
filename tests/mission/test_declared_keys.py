"""Every key that takes a quantity declares at its field what it means; the schema says so, and `explore` may vary it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from missionplan.datasets.dives import DESCENT
from missionplan.datasets.legs import TRANSIT
from missionplan.datasets.summaries import SUMMARY
from missionplan.datasets.tank import TANK_FORMATS
from missionplan.mission import Mission, load
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.schema.quantity_parser import Limit
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.mission.validation_errors import keys_of, meaning_of, parsers_of, sections_in
from missionplan.studies.exploration import known_keys
from missionplan.studies.schema import schema

MISSIONS = Path(__file__).parents[2] / "missions"
FORMATS = (TRANSIT, DESCENT, SUMMARY, *TANK_FORMATS.values())


def keys(model: type[BaseModel], seen: set[type[BaseModel]]) -> Iterator[tuple[str, str, FieldInfo]]:
    for name, field in keys_of(model).items():
        yield model.__name__, name, field
        for section in sections_in(field.annotation):
            if section not in seen:
                seen.add(section)
                yield from keys(section, seen)


def quantities(model: type[BaseModel]) -> Iterator[tuple[str, str, FieldInfo]]:
    for name, field in keys_of(model).items():
        if parsers_of(field):
            yield model.__name__, name, field
        for section in sections_in(field.annotation):
            yield from quantities(section)


DECLARED = {(section, name): field for section, name, field in quantities(Mission)}


@pytest.mark.parametrize("model", [Mission, Vehicle, *(form.settings for form in FORMATS)])
def test_every_key_says_what_it_means(model):
    assert [f"{section}.{name}" for section, name, field in keys(model, set()) if not meaning_of(field)] == []


@pytest.mark.parametrize("phase", [MoorPhase, TransitPhase])
def test_every_size_of_a_phase_declares_what_it_may_be(phase):
    sized = {name for name, field in keys_of(phase).items() if parsers_of(field)} - {"from", "to", "via"}
    limited = {
        name for name, field in keys_of(phase).items() if any(isinstance(each, Limit) for each in field.metadata)
    }
    assert sized == limited


def test_the_usual_lies_within_the_possible():
    for key, field in DECLARED.items():
        for limit in (each for each in field.metadata if isinstance(each, Limit)):
            assert limit.possible[0] <= limit.usual[0] < limit.usual[1] <= limit.possible[1], key
            assert limit.source, key


def test_the_schema_quotes_each_meaning():
    written = schema("mission")["definitions"]
    for (section, name), field in DECLARED.items():
        if meaning_of(field) and section in written:
            assert written[section]["properties"][name]["description"].startswith(meaning_of(field))


def test_every_size_of_a_phase_may_be_varied():
    keys = known_keys(load(MISSIONS / "chesapeake.yaml"))
    for phase, kind in (("moor", MoorPhase), ("ingress", TransitPhase)):
        sized = {name for name, field in keys_of(kind).items() if parsers_of(field)} - {"from", "to", "via"}
        assert {f"{phase}.{name}" for name in sized} <= keys
