"""JSON schemas of files: what is shipped fits them, what is mistyped does not."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import cast

import jsonschema
import pint
import pytest
import yaml

import missionplan
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.studies.schema import KINDS, READ, schema

MISSIONS = Path(__file__).parents[3] / "missions"
VALIDATORS = {kind: jsonschema.Draft7Validator(missionplan.schema(kind)) for kind in ("mission", "vehicle", "dataset")}


def problems(kind: str, data: object) -> list[str]:
    return [error.message for error in VALIDATORS[kind].iter_errors(data)]


@pytest.mark.parametrize("kind", VALIDATORS)
def test_each_is_a_schema(kind: str) -> None:
    jsonschema.Draft7Validator.check_schema(VALIDATORS[kind].schema)


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_missions_fit(path: Path) -> None:
    assert problems("mission", yaml.safe_load(path.read_text())) == []
    assert problems("mission", json.loads(json.dumps(missionplan.load(path).raw, default=str))) == []


@pytest.mark.parametrize("path", sorted((MISSIONS / "vehicles").glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_vehicles_fit(path: Path) -> None:
    assert problems("vehicle", yaml.safe_load(path.read_text())) == []


@pytest.mark.parametrize("path", sorted(MISSIONS.rglob("dataset.yaml")), ids=lambda path: path.parent.name)
def test_shipped_data_sets_fit(path: Path) -> None:
    assert problems("dataset", yaml.safe_load(path.read_text())) == []


def test_the_starter_files_name_their_schemas_and_fit_them(tmp_path: Path) -> None:
    missionplan.init(tmp_path)
    for name in ("mission.yaml", "vehicle.yaml", "sea-trial/dataset.yaml"):
        path = tmp_path / name
        first = path.read_text().splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema=")
        schema = json.loads((path.parent / first.partition("=")[2]).read_text())
        assert not list(jsonschema.Draft7Validator(schema).iter_errors(yaml.safe_load(path.read_text())))


def _starter(tmp_path: Path) -> dict[str, object]:
    missionplan.init(tmp_path)
    return cast(dict[str, object], yaml.safe_load((tmp_path / "mission.yaml").read_text()))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("navigatoin",), {}),
        (("phases", 0, "transit", "sped"), "1 m/s"),
        (("phases", 0, "transit", "speed"), 1.5),
        (("phases", 1, "moor", "release_time"), {"mean": "1 s", "sdd": "1 s"}),
        (("navigation", "drift_compensation"), "means"),
        (("monte_carlo", "trials"), "many"),
        (("phases", 1, "moor", "release_time"), {"mean": "1 s"}),
        (("phases", 1, "moor", "release_time"), {"low": "1 s"}),
        (("phases", 1, "moor", "release_time"), {"mean": "1 s", "factor": 2}),
        (("phases", 1, "moor", "release_time"), {"median": "1 s", "factor": 0.5}),
        (("phases", 1, "moor", "release_time"), {"choices": []}),
        (("phases", 1, "moor", "release_time"), {"choices": [5, 6]}),
        (("phases", 1, "moor", "line_lenght"), "5 m"),
        (("phases", 1, "moor", "radius"), "ten"),
        (("site", "depth"), ["30 m"]),
        (("site", "origin", "longitud"), "3 deg"),
        (("site", "water", "salinity"), -20),
        (("site", "water", "salinity"), {"choices": [-20]}),
        (("effects",), [{"compas-bias": {"angle": "2 deg"}}]),
        (("effects",), [{"compass-bias": {"angel": "2 deg"}}]),
    ],
)
def test_what_is_mistyped_does_not_fit(tmp_path: Path, path: tuple[str | int, ...], value: object) -> None:
    changed: object = _starter(tmp_path)
    place: object = changed
    for part in path[:-1]:
        place = place[part]  # type: ignore[index]
    place[path[-1]] = value  # type: ignore[index]
    assert problems("mission", changed)


def test_effects_and_explanations_fit(tmp_path: Path) -> None:
    data = _starter(tmp_path)
    known = {"compass-bias": {"angle": {"mean": "2 deg", "sd": "0.5 deg"}}}
    data["effects"] = [known, {"one-of": [{"probability": 0.6, "effects": [{"speed-scale": {"fraction": 0.1}}]}]}]
    assert problems("mission", data) == []


def test_every_parameter_of_the_catalogue_is_described() -> None:
    definitions = cast(Mapping[str, Mapping[str, Mapping[str, Mapping[str, object]]]], VALIDATORS["mission"].schema)
    entries = definitions["definitions"]["effect"]["properties"]
    assert set(entries) == set(CATALOGUE)
    for name, info in CATALOGUE.items():
        dated = {"epoch"} if info.frequency_of is not None else set()
        assert set(cast(Mapping[str, object], entries[name]["properties"])) == set(info.parameters) | dated


def test_what_quantities_of_one_kind_share_stands_once_in_strict_json() -> None:
    text = json.dumps(schema("mission"), allow_nan=False)
    assert text.count('"pattern"') < 500  # 2500 where each key has its own


def test_another_kind_is_refused() -> None:
    with pytest.raises(InputError, match="expected one of mission, vehicle, dataset"):
        missionplan.schema("misson")  # type: ignore[arg-type]


def test_a_file_may_say_which_form_it_has_and_one_that_does_not_is_of_the_first(transit_mission):
    raw = dict(transit_mission.raw)
    said = Mission.from_data({**raw, "schema": "missionplan/mission/1"})
    assert said.file_schema == Mission.from_data(raw).file_schema == schema("mission")["version"]
    assert said.identified() == Mission.from_data(raw).identified()


@pytest.mark.parametrize(
    ("given", "words"),
    [("missionplan/mission/2", "of a newer missionplan"), ("missionplan/dataset/1", "expected missionplan/mission/1")],
)
def test_a_file_of_a_newer_form_is_refused(transit_mission, given, words):
    with pytest.raises(InputError, match=words):
        Mission.from_data({**transit_mission.raw, "schema": given})


def test_every_schema_says_its_version():
    assert {kind: schema(kind)["version"].rpartition("/")[0] for kind in KINDS} == {
        kind: f"missionplan/{kind}" for kind in KINDS
    }


def test_a_key_states_its_meaning_and_its_default() -> None:
    keys = schema("mission")["definitions"]["Navigation"]["properties"]
    assert keys["fix_error"]["default"] == "0 m"
    assert keys["max_legs"]["default"] == 400
    assert keys["surfacing_time"]["description"].startswith("time at the surface for a fix: a quantity in s")
    assert "default" not in keys["surfacing_time"]
    assert "default" not in schema("mission")["definitions"]["TransitPhase"]["properties"]["speed"]


def _is_shown(written: dict) -> bool:
    """Whether an editor can offer a value: an example, a choice, or the keys of a section."""
    inner = [
        *written.get("anyOf", ()),
        *written.get("allOf", ()),
        *([written["items"]] if isinstance(written.get("items"), dict) else []),
    ]
    return any(key in written for key in ("examples", "enum", "$ref", "properties")) or any(map(_is_shown, inner))


@pytest.mark.parametrize("kind", READ)
def test_every_key_has_a_sentence_and_an_example_that_its_own_schema_takes(kind: str) -> None:
    whole = schema(kind)
    sections = {"": whole, **whole["definitions"]}
    sections |= {each["if"]["properties"]["kind"]["const"]: each["then"] for each in whole.get("allOf", ())}
    keys = {f"{name}.{key}": each for name, own in sections.items() for key, each in own.get("properties", {}).items()}
    assert [key for key, each in keys.items() if not _is_shown(each)] == []
    assert [key for key, each in keys.items() if not each.get("description")] == []
    refused = {
        key: example
        for key, each in keys.items()
        for example in each.get("examples", ())
        if not jsonschema.Draft7Validator({**each, "definitions": whole["definitions"]}).is_valid(example)
    }
    assert refused == {}


def _inner_keys(written: object) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Every key of a schema at any depth, but of the definitions it refers to."""
    parts = written.values() if isinstance(written, dict) else written if isinstance(written, list) else ()
    for part in parts:
        yield from _inner_keys(part)
    if isinstance(written, dict) and isinstance(written.get("properties"), dict):
        yield from written["properties"].items()


def test_every_key_of_a_distribution_and_of_an_explanation_has_its_sentence_and_an_example() -> None:
    sections = schema("mission")
    _, of_speed = sections["definitions"]["TransitPhase"]["properties"]["speed"]["anyOf"]
    speed = sections["definitions"][of_speed["$ref"].rpartition("/")[2]]
    keys = [*_inner_keys(speed), *_inner_keys(sections["properties"])]
    assert {"mean", "sd", "low", "high", "median", "factor", "choices", "one-of", "rho", "sha256"} <= dict(keys).keys()
    assert [key for key, each in keys if "description" not in each and "$ref" not in each] == []
    assert [key for key, each in _inner_keys(speed) if not each.get("examples")] == []


def test_the_examples_of_quantities_are_read_and_of_a_usual_size() -> None:
    sections = schema("mission")["definitions"]
    keys = {
        (section, key): each["examples"]
        for section, written in sections.items()
        if section != "effect"
        for key, each in written.get("properties", {}).items()
        if "examples" in each
    }
    assert keys["MoorPhase", "hold"] == ["9 d"]
    assert keys["SlopeSection", "angle"] == ["2 deg"]
    assert len(keys) > 80
    effects = {name: each["properties"] for name, each in sections["effect"]["properties"].items()}
    assert effects["compass-bias"]["angle"]["examples"] == ["5 deg"]
    assert keys["Geographic", "latitude"] == ["60 06.0 N"]
    quantities = [each for (each,) in keys.values() if re.match(r"[0-9.e+-]+ [A-Za-z1]", str(each)) and each[-1] != "N"]
    assert len(quantities) > 100
    units = pint.UnitRegistry()
    for each in quantities:
        assert units(each.replace("degC", "delta_degC")).magnitude >= 0.0, each
