"""Missions changed in Python and written back: keys, units, comments."""

from pathlib import Path
from shutil import copytree

import hypothesis.strategies as st
import numpy as np
import pytest
import yaml
from hypothesis import given, settings

from missionplan import Mission, init, load
from missionplan.errors import InputError
from missionplan.mission.yaml_text import edited
from missionplan.montecarlo.distributions import LogNormal, Normal

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def starter_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("written") / "starter"
    init(folder)
    return folder


@pytest.fixture
def starter(starter_files: Path, tmp_path: Path) -> Mission:
    return load(copytree(starter_files, tmp_path / "starter") / "mission.yaml")


def test_a_mission_is_shown_in_a_line(starter: Mission) -> None:
    assert repr(starter) == (
        f"<Mission 'First mission' of {starter.file}: phases ingress, moor, egress; 4 uncertain quantities>"
    )


def test_a_key_alone_is_that_of_every_phase_that_has_it(starter: Mission) -> None:
    changed = starter.with_(speed="1.2 m/s", trials=500)
    assert [transit.speed for transit in changed.transits] == [1.2, 1.2]
    assert changed.monte_carlo.trials == 500
    assert [transit.speed for transit in starter.transits] == [1.5, 1.5]


@pytest.mark.parametrize(
    ("key", "value", "path"),
    [
        ("ingress.speed", 1.25, "ingress.speed"),
        ("phases[2].transit.speed", 1.25, "egress.speed"),
        ("navigation.velocity_error.sigma", 0.05, "navigation.velocity_error.sigma"),
        ("sigma", np.float64(0.05), "navigation.velocity_error.sigma"),
        ("site.current[1].speed", 0.3, "site.current[1].speed"),
        ("vehicle.anchor.drag_coefficient", 0.25, "vehicle.anchor.drag_coefficient"),
        ("moor.anchor_wet_weight", 20, "moor.anchor_wet_weight"),
        ("site.water.temperature", 12, "site.water.temperature"),
    ],
)
def test_numbers_are_in_si(starter: Mission, key: str, value: float, path: str) -> None:
    assert starter.with_({key: value}).quantities()[path] == value


def test_distributions_by_text_number_and_object(starter: Mission) -> None:
    for value in ({"mean": "2 s", "sd": 0.5}, Normal(2.0, 0.5)):
        changed = starter.with_({"moor.galvanic_release": value})
        assert (
            changed.quantities()["moor.galvanic_release"]
            == starter.with_({"moor.galvanic_release": {"mean": "2 s", "sd": "0.5 s"}}).quantities()[
                "moor.galvanic_release"
            ]
        )
    skewed = starter.with_({"moor.galvanic_release": LogNormal(2.0, 1.5)}).quantities()["moor.galvanic_release"]
    assert (skewed.median, skewed.factor) == (2.0, 1.5)
    narrower = starter.with_({"site.current[0].speed.sd": "0.01 kn"})
    assert narrower.uncertain()["site.current[0].speed"].sd == pytest.approx(0.01 * 1852 / 3600)


def test_effects_are_named_by_their_ids(starter: Mission) -> None:
    biased = starter.with_(effects=[{"compass-bias": {"angle": {"mean": 0.05, "sd": 0.01}}}])
    again = biased.with_({"effects.compass-bias.angle": "2 deg"})
    assert again.quantities()["effects.compass-bias.angle"] == pytest.approx(np.radians(2.0))
    assert biased.with_(effects=None).effects == ()


def test_an_item_of_a_list_is_taken_out_by_none(starter: Mission) -> None:
    first, second = starter.raw["site"]["current"]
    assert starter.with_({"site.current[0]": None}).raw["site"]["current"] == [second]
    assert starter.with_({"site.current[1]": {**second, "toward": 1.0}}).raw["site"]["current"][0] == first


def test_effects_of_an_explanation_are_named_as_reports_name_them(starter: Mission) -> None:
    explanations = [
        {"probability": 0.6, "effects": [{"speed-scale": {"fraction": 0.05}}]},
        {"probability": 0.3, "effects": [{"fix-error": {"sd": "5 m"}}, {"compass-bias": {"angle": "3 deg"}}]},
    ]
    doubtful = starter.with_(effects=[{"one-of": explanations}])
    key = "effects[0].one-of[1].compass-bias.angle"
    changed = doubtful.with_({key: {"mean": "2 deg", "sd": "1 deg"}, "effects[0].one-of[0].probability": 0.5})
    assert changed.quantities()[key].mean == pytest.approx(np.radians(2.0))
    assert [each.probability for each in changed.doubts[0].explanations] == [0.5, 0.3]
    with pytest.raises(InputError, match=r"no such effect \(did you mean compass-bias\?\)"):
        doubtful.with_({"effects[0].one-of[1].compas-bias.angle": "2 deg"})
    with pytest.raises(InputError, match="no such effect"):
        doubtful.with_({"effects[0].one-of[7].compass-bias.angle": "2 deg"})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"speeed": 1}, "speeed: unknown key (did you mean speed?)"),
        ({"depth": 3}, "depth: could be ingress.depth, egress.depth, site.depth"),
        ({"ingres.speed": 2}, "ingres.speed: unknown key (did you mean ingress?)"),
        ({"ingress.sped": 2}, "phases[0].transit.sped: unknown key (did you mean speed?)"),
        ({"site.current[5].speed": 1}, "site.current has 2 items"),
        ({"name.x": 1}, "which has no key x"),
        ({"speed": "3 kg"}, "given 3 kg, expected a quantity in m/s"),
        ({"site.current[0]speed": 1}, "is not a key path"),
        ({"effects.compass-bias.angle": 1}, "the mission has no such effect"),
    ],
)
def test_what_cannot_be_is_said_with_its_key(starter: Mission, changes: dict[str, object], words: str) -> None:
    with pytest.raises(InputError) as caught:
        starter.with_(changes)
    assert words in str(caught.value)


def test_every_unclear_key_at_once(starter: Mission) -> None:
    with pytest.raises(InputError) as caught:
        starter.with_(speeed=1, depht=2)
    assert len(caught.value.problems) == 2


def test_comments_stay_where_nothing_changed(starter: Mission, tmp_path: Path) -> None:
    before = Path(starter.file).read_text()
    assert starter.to_yaml() == before
    changed = starter.with_({"ingress.d_max": 250}, speed=1.4, drift_compensation=None, max_legs=100)
    after = changed.to_yaml()
    old, new = set(before.splitlines()), set(after.splitlines())
    assert {line.strip().split(":")[0] for line in old ^ new} == {"speed", "d_max", "drift_compensation", "max_legs"}
    assert "      speed: 1.4 m/s               # through the water" in new
    path = changed.save(Path(starter.file).with_name("changed.yaml"))
    assert load(path).raw == changed.raw


def test_a_mission_saved_elsewhere_carries_its_vehicle_with_its_comments(starter: Mission, tmp_path: Path) -> None:
    for changed in (starter, starter.with_({"vehicle.mass": "11 kg"})):
        path = changed.save(tmp_path / "elsewhere.yaml", force=True)
        assert load(path).raw == changed.raw
        assert "# of the returning vehicle, without the anchor" in path.read_text()
        assert "# dead reckoning under water" in path.read_text()


def test_no_file_is_overwritten_unasked(starter: Mission) -> None:
    with pytest.raises(InputError, match="is there already"):
        starter.save(starter.file)


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_missions_are_written_as_they_were_read(path: Path) -> None:
    assert load(path).to_yaml() == path.read_text()


def test_a_mission_built_in_python_is_written_too(tmp_path: Path) -> None:
    built = Mission.from_data({"name": "empty"}).with_(
        navigation={"velocity_error": {"sigma": 0.03}, "surfacing_time": 90},
        phases=[{"transit": {"from": [0, 0], "to": [1000, 0], "speed": 1.5, "d_max": 300, "arrival_radius": 15}}],
    )
    assert load(built.save(tmp_path / "built.yaml")).raw == built.raw
    assert built.transits[0].to == (1000.0, 0.0)


_SCALARS = st.one_of(st.integers(-5, 5), st.booleans(), st.text("ab :#'{},-[]0~\"", max_size=6), st.none())
_KEYS = st.text("abc", min_size=1, max_size=2)
_DATA = st.recursive(_SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_KEYS, inner, max_size=3))


@settings(max_examples=2 * settings.default.max_examples)
@given(st.dictionaries(_KEYS, _DATA, min_size=1, max_size=4), st.dictionaries(_KEYS, _DATA, max_size=4), st.booleans())
def test_an_edited_text_holds_the_new_data(old: dict[str, object], new: dict[str, object], flow: bool) -> None:
    text = yaml.safe_dump(old, default_flow_style=flow or None)
    assert yaml.safe_load(edited(text, new)) == new
    assert edited(text, old) == text
