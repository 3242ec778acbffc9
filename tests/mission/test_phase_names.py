"""Names of phases are labels: none of them changes which quantity a key path means."""

from copy import deepcopy
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.mission.mission import with_values
from missionplan.mission.quantity_paths import SECTIONS, phase_keys, resolved_path
from missionplan.studies.exploration import known_key
from tests.fixtures import any_text

MISSIONS = Path(__file__).parents[2] / "missions"
CHESAPEAKE = load(MISSIONS / "chesapeake.yaml")
KEYS = ["ingress", "moor", "egress"]


def _renamed(names, **changes) -> Mission:
    """Return the mission with other names of its phases, in the requirements too."""
    data = deepcopy(dict(CHESAPEAKE.raw)) | changes
    for entry, name in zip(data["phases"], names, strict=True):
        next(iter(entry.values()))["name"] = name
    written = dict(zip([*KEYS, "total"], [*names, "total"], strict=True))
    for requirement in data["requirements"]:
        phase, _, quantity = requirement["quantity"].partition(".")
        requirement["quantity"] = f"{written[phase]}.{quantity}"
    return Mission.from_data(data)


def test_no_section_of_a_mission_is_the_name_of_a_phase_in_key_paths():
    assert {field.alias or name for name, field in Mission.model_fields.items()} | {"total"} == SECTIONS


@given(st.lists(st.sampled_from([*SECTIONS, "moor", "phases[0]", "site.depth", "a.b", "a.b.c"]) | any_text(8)))
def test_every_phase_has_a_key_of_its_own(names):
    names = list(dict.fromkeys(names))
    keys = phase_keys(names)
    assert len(set(keys)) == len(names)
    assert not any("." in key or key in SECTIONS for key in keys)
    for name, key in zip(names, keys, strict=True):
        assert resolved_path(f"{name}.speed", names, with_sections=False) == f"{key}.speed"
        assert resolved_path(f"{key}.speed", names) == f"{key}.speed"
        assert resolved_path("site.depth", names) == "site.depth"


@pytest.mark.parametrize(
    "names",
    [
        ("site", "vehicle", "effects"),
        ("limit run", "site.current", "phases[0]"),
        ("a.b", "a", "a.b.c"),
        ("in$^$", "</script><b>", "x: not arrived"),
        ("monte_carlo", "", "nan"),
        ("phases[1]", "phases[2]", "phases[0]"),
    ],
)
def test_a_name_of_a_phase_replaces_no_quantity_and_is_not_lost(names):
    mission, plain, renamed = _renamed(names), CHESAPEAKE.quantities(), _renamed(names).quantities()
    keys = dict(zip(KEYS, phase_keys(names), strict=True))
    moved = {f"{keys.get(path.partition('.')[0], path.partition('.')[0])}.{path.partition('.')[2]}" for path in plain}
    assert renamed.keys() == moved
    assert len(renamed) == len(plain)
    assert renamed["site.depth"] == plain["site.depth"]
    assert tuple(phase.label for phase in mission.phases) == names
    assert [each.written for each in mission.requirements][:2] == [f"{names[0]}.arrived", f"{names[1]}.offset"]
    assert mission.transits[0].label in repr(mission)


def test_a_phase_of_any_name_is_reached_by_its_name_or_its_place():
    names = ("site", "to moor: 5 % a.b", "egress")
    correlations = [{"between": ["to moor: 5 % a.b.release_time", "site.current[0].speed"], "rho": 0.5}]
    mission = _renamed(names, correlations=correlations)
    assert mission.correlated[0].between == ("phases[1].release_time", "site.current[0].speed")
    changed = mission.with_({"phases[0].speed": "1.2 m/s", "to moor: 5 % a.b.hold": "9 min", "site.water.salinity": 16})
    assert changed.transits[0].speed == 1.2
    assert changed.transits[0].depth == 2.0
    assert changed.moors[0].hold == 540.0
    assert changed.site.water.salinity == 16.0
    assert mission.with_({"phases[0].transit.speed": "1.2 m/s"}).transits[0].speed == 1.2
    assert known_key(mission, "to moor: 5 % a.b.hold", "vary") == "phases[1].hold"
    key = known_key(mission, "phases[0].speed", "vary")
    assert Mission.from_data(with_values(mission.raw, {key: "1.1 m/s"})).transits[0].speed == 1.1
    with pytest.raises(InputError, match="does not have"):
        known_key(mission, "site.arrival_radius", "vary")
