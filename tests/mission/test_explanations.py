"""`one-of` in the section `effects`: explanations of which one holds, with probabilities."""

import copy

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from missionplan import Mission, load
from missionplan.errors import InputError
from missionplan.montecarlo.distributions import Normal, WhichHolds
from tests.fixtures import any_text

DATA = {
    "name": "in doubt",
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.5 m/s",
                "d_max": "1500 m",
                "arrival_radius": "100 m",
            }
        }
    ],
    "effects": [
        {"speed-scale": {"fraction": {"mean": 0.01, "sd": 0.01}}},
        {
            "one-of": [
                {"probability": 0.6, "effects": [{"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.5 deg"}}}]},
                {
                    "probability": 0.3,
                    "effects": [
                        {"mean-current": {"east": {"mean": 0.1, "sd": 0.02}, "north": {"mean": 0.05, "sd": 0.02}}},
                        {"fix-error": {"sd": "20 m"}},
                    ],
                    "correlations": [{"between": ["mean-current.east", "mean-current.north"], "rho": 0.8}],
                },
            ]
        },
    ],
}
PLACE = "effects[1].one-of"


def written():
    data = copy.deepcopy(DATA)
    for quantity in data["effects"][1]["one-of"][1]["effects"][0]["mean-current"].values():
        quantity.update({key: f"{value} m/s" for key, value in quantity.items()})
    return data


def test_every_parameter_and_which_one_holds_have_a_key_path():
    quantities = Mission.from_data(written()).quantities()
    assert quantities[PLACE] == WhichHolds((0.6, 0.3))
    assert quantities[f"{PLACE}[1].mean-current.east"] == Normal(0.1, 0.02)
    assert quantities[f"{PLACE}[1].fix-error.sd"] == 20.0
    assert quantities["effects.speed-scale.fraction"] == Normal(0.01, 0.01)


def test_what_probabilities_leave_has_none_of_the_explanations():
    (doubt,) = Mission.from_data(written()).doubts
    assert doubt.probabilities == pytest.approx((0.6, 0.3, 0.1))
    assert doubt.causes == (("compass-bias",), ("mean-current", "fix-error"), ())


def test_a_mission_with_explanations_survives_the_round_trip(tmp_path):
    mission = Mission.from_data(written())
    file = tmp_path / "mission.yaml"
    file.write_text(yaml.safe_dump(dict(mission.raw)))
    assert load(file).quantities() == mission.quantities()
    assert load(file).correlated == mission.correlated


def test_an_explanation_that_is_known_is_no_longer_drawn():
    mission = Mission.from_data(written())
    known = mission.knowing(PLACE, 1)
    assert known.quantities()[PLACE] == 1.0
    assert {**known.quantities(), PLACE: None} == {**mission.quantities(), PLACE: None}


def changed(change):
    data = written()
    change(data["effects"][1]["one-of"])
    return data


WRONG = {
    "sum": (
        lambda c: c[0].update(probability=0.8),
        "effects[1].one-of: the probabilities sum to 1.1, expected at most 1",
    ),
    "zero": (lambda c: c[0].update(probability=0), "effects[1].one-of[0].probability: given 0, expected more than 0"),
    "drawn": (lambda c: c[0].update(probability={"low": 0, "high": 1}), "expected a fixed value here"),
    "missing": (lambda c: c[0].pop("probability"), "effects[1].one-of[0].probability: missing"),
    "no effects": (lambda c: c[0].pop("effects"), "effects[1].one-of[0].effects: missing"),
    "empty": (lambda c: c[0].update(effects=[]), "effects[1].one-of[0].effects: expected a list of effects"),
    "key": (lambda c: c[0].update(probabilty=0.2), "one-of[0].probabilty: unknown key (did you mean probability?)"),
    "effect": (
        lambda c: c[0].update(effects=[{"compass-bais": {"angle": "1 deg"}}]),
        "effects[1].one-of[0].effects[0].compass-bais: no effect of that name; did you mean compass-bias?",
    ),
    "parameter": (
        lambda c: c[0].update(effects=[{"compass-bias": {"angel": "1 deg"}}]),
        "effects[1].one-of[0].effects[0].compass-bias.angel: compass-bias has no such parameter",
    ),
    "unit": (
        lambda c: c[0].update(effects=[{"compass-bias": {"angle": {"mean": "1 kg", "sd": "1 deg"}}}]),
        "effects[1].one-of[0].effects[0].compass-bias.angle.mean: given 1 kg, expected a quantity in rad",
    ),
    "nested": (
        lambda c: c[0].update(effects=[{"one-of": []}]),
        "effects[1].one-of[0].effects[0].one-of: an explanation cannot hold explanations",
    ),
    "twice": (
        lambda c: c[0].update(effects=[{"compass-bias": {}}, {"compass-bias": {}}]),
        "one-of[0].effects[1].compass-bias: this explanation has the effect already",
    ),
    "correlated": (
        lambda c: c[1]["correlations"][0].update(between=["mean-current.east", "mean-current.nort"]),
        "effects[1].one-of[1].correlations[0].between[1]: no quantity is named 'mean-current.nort' "
        "(did you mean mean-current.north?)",
    ),
    "fixed": (
        lambda c: c[1]["correlations"][0].update(between=["mean-current.east", "fix-error.sd"]),
        "effects[1].one-of[1].correlations[0].between[1]: fix-error.sd is a fixed value, expected a distribution",
    ),
    "rho": (lambda c: c[1]["correlations"][0].update(rho=1.5), "one-of[1].correlations[0].rho: given 1.5"),
    "pair": (lambda c: c[1]["correlations"].append(3), "one-of[1].correlations[1]: given 3, expected {between"),
    "not a list": (lambda c: c[1].update(correlations=3), "one-of[1].correlations: given 3, expected a list"),
    "no mapping": (lambda c: c.append("compass"), "effects[1].one-of[2]: given 'compass', expected an explanation"),
}


@pytest.mark.parametrize(("change", "words"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_said_with_its_key_path(change, words):
    with pytest.raises(InputError) as caught:
        Mission.from_data(changed(change))
    assert words in str(caught.value)
    assert len(caught.value.problems) == 1


def test_all_problems_are_told_at_once_with_their_lines(tmp_path):
    def change(causes):
        causes[0]["probability"] = "often"
        causes[1]["effects"][1] = {"fix-eror": {}}

    file = tmp_path / "mission.yaml"
    file.write_text(yaml.safe_dump(changed(change)))
    with pytest.raises(InputError) as caught:
        load(file)
    first, second = caught.value.problems
    lines = file.read_text().splitlines()
    assert "often" in lines[first.line - 1]
    assert "fix-eror" in lines[second.line - 1]


def test_one_of_stands_alone_in_its_item():
    data = written()
    data["effects"][1]["compass-bias"] = {"angle": "1 deg"}
    with pytest.raises(InputError, match=r"effects\[1\]\.one-of: given compass-bias beside it"):
        Mission.from_data(data)


def test_correlations_of_the_mission_leave_explanations_alone():
    data = written()
    between = [f"{PLACE}[1].mean-current.east", "effects.speed-scale.fraction"]
    data["correlations"] = [{"between": between, "rho": 0.5}]
    with pytest.raises(InputError, match="belongs to an explanation"):
        Mission.from_data(data)


def test_an_unusual_size_in_an_explanation_is_noticed():
    data = changed(lambda causes: causes[0].update(effects=[{"compass-bias": {"angle": "40 deg"}}]))
    (notice,) = Mission.from_data(data).notices()
    assert notice.startswith("effects[1].one-of[0].effects[0].compass-bias.angle: 0.6981 rad is unusual")


@given(
    st.recursive(
        st.none() | st.integers() | any_text(5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["probability", "effects", "correlations", "compass-bias", "angle"]), inner, max_size=3
            )
        ),
        max_leaves=8,
    )
)
def test_whatever_is_given_is_read_or_refused(value):
    data = written()
    data["effects"][1] = {"one-of": value}
    try:
        Mission.from_data(data)
    except InputError as error:
        assert all(problem.key.startswith("effects[1].one-of") for problem in error.problems)
