"""The JSON schema of `summary.json`: what studies answer fits it, and it says what each entry is."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.results import to_json

MISSIONS = Path(__file__).parents[3] / "missions"
SCHEMA: dict[str, Any] = missionplan.schema("summary")
STUDIES = {
    "simulate": lambda: missionplan.simulate(MISSIONS / "chesapeake.yaml", trials=50, seed=1),
    "of members": lambda: missionplan.simulate(MISSIONS / "estuary.yaml", trials=50, seed=1),
    "sweep-dmax": lambda: missionplan.sweep_dmax(few_lengths(), trials=20, seed=1),
    "analytic": lambda: missionplan.sweep_dmax(few_lengths(), method="analytic"),
    "explore": lambda: missionplan.explore(
        MISSIONS / "chesapeake.yaml", ["ingress.speed=1:2:0.5 m/s"], trials=30, seed=1
    ),
    "compare": lambda: missionplan.compare_missions(MISSIONS / "chesapeake.yaml", MISSIONS / "estuary.yaml", trials=20),
    "identify": lambda: missionplan.identify(MISSIONS / "measured" / "avila-drag"),
    "size-anchor": lambda: missionplan.size_anchor(MISSIONS / "anchor-design.yaml", trials=20, seed=1),
}


def few_lengths() -> Mission:
    whole = missionplan.load(MISSIONS / "fig8.yaml").raw
    return Mission.from_data({**whole, "sweep": {"d_max": ["3 km", "7 km"], "sigma": ["0.015 m/s", "0.035 m/s"]}})


@pytest.mark.parametrize("study", STUDIES)
def test_what_studies_answer_fits(study: str) -> None:
    summary = json.loads(to_json(STUDIES[study]().summary()))
    assert [error.message for error in jsonschema.Draft7Validator(SCHEMA).iter_errors(summary)] == []


def test_it_is_a_schema_and_holds_no_record_open() -> None:
    jsonschema.Draft7Validator.check_schema(SCHEMA)
    definitions = SCHEMA["definitions"].items()
    assert [name for name, record in definitions if record.get("additionalProperties") is not False] == ["TrimState"]


def test_a_key_that_is_not_stated_does_not_fit() -> None:
    summary = json.loads(to_json(missionplan.simulate(MISSIONS / "fig8.yaml", trials=20, seed=1).summary()))
    for place in (summary, summary["phases"][0], summary["total"]):
        place["mistyped"] = 1
        assert list(jsonschema.Draft7Validator(SCHEMA).iter_errors(summary))
        del place["mistyped"]
    del summary["phases"][0]["kind"]
    assert list(jsonschema.Draft7Validator(SCHEMA).iter_errors(summary))


def test_every_entry_says_what_it_is() -> None:
    unsaid = [f"{place}.{key}" for place, key, entry in entries(SCHEMA["definitions"], "") if not entry["description"]]
    assert unsaid == []


def entries(value: Any, place: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for key, inner in value.items() if isinstance(value, dict) else ():
        if key == "properties":
            yield from ((place, name, each) for name, each in inner.items() if "description" in each)
        yield from entries(inner, f"{place}.{key}")
