"""Whatever a diagnosis estimates, the mission that it writes can be read, and draws what is physically possible."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.diagnosis.coordinates import SIGMA_V, JointPosterior, coordinates_of
from missionplan.diagnosis.extended_mission import Hypothesis, _in_words, _told, extended_mission
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.kind import extended_transit_mission
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission, load

MISSION = load(Path(__file__).parents[2] / "missions" / "chesapeake.yaml")
EFFECTS = [name for name, info in CATALOGUE.items() if info.phase != "tank"]


def hypothesis(causes, probability, posterior, before=MISSION, shown=()):
    fit = CauseFit(causes, 0.0, (), {}, True, None, (), posterior)
    return Hypothesis(causes, probability, before, shown, fit, before.raw)


def normal(effect, mean, sd):
    coordinates = coordinates_of(CATALOGUE[effect])
    k = len(coordinates)
    return JointPosterior(coordinates, np.resize(mean, k), np.diag(np.resize(sd, k) ** 2))


@given(st.sampled_from(EFFECTS), st.floats(-3.0, 3.0), st.floats(1e-3, 3.0))
def test_what_is_written_can_be_read_and_draws_inside_the_range(effect, size, spread):
    coordinates = coordinates_of(CATALOGUE[effect])
    mean = np.array([c.centre + size * c.slab for c in coordinates])
    sd = np.array([spread * c.slab for c in coordinates])
    found = extended_mission([hypothesis((effect,), 1.0, normal(effect, mean, sd))])
    (entry,) = Mission.from_data(found).effects
    assert entry.effect == effect
    for name, column in entry.parameters.items():
        parameter = CATALOGUE[effect].parameters[name]
        assert np.all((column.values >= parameter.low - 1e-6) & (column.values <= parameter.high + 1e-6))


def test_the_draws_have_the_moments_of_what_is_known_and_each_sets_probability():
    """By the definition of a mixture: P, mean and covariance of each part, and of the noise with them."""
    compass = coordinates_of(CATALOGUE["compass-bias"])[0]
    scale = coordinates_of(CATALOGUE["speed-scale"])[0]
    covariance = np.array([[4e-4, 3e-4, 0.0], [3e-4, 9e-4, 0.0], [0.0, 0.0, 0.01]])
    both = JointPosterior((compass, scale, SIGMA_V), np.array([0.05, -0.03, np.log(0.04)]), covariance)
    nothing = JointPosterior((SIGMA_V,), np.array([np.log(0.06)]), np.array([[0.02]]))
    found = extended_mission([hypothesis(("compass-bias", "speed-scale"), 0.7, both), hypothesis((), 0.3, nothing)])
    draws = found["posterior"].draws
    assert dict(zip(draws.sets, draws.probabilities, strict=True)) == pytest.approx(
        {("compass-bias", "speed-scale"): 0.7, (): 0.3}
    )
    own = draws.of_set(draws.sets.index(("compass-bias", "speed-scale")))
    rows = np.stack([own.column(c)[0] for c in (("compass-bias", "angle"), ("speed-scale", "fraction"))])
    np.testing.assert_allclose(rows.mean(axis=1), [0.05, -0.03], rtol=1e-4)
    np.testing.assert_allclose(np.cov(rows, bias=True), covariance[:2, :2], rtol=1e-3)
    centre = 0.7 * np.log(0.04) + 0.3 * np.log(0.06)
    spread = 0.7 * 0.01 + 0.3 * 0.02 + 0.21 * np.log(1.5) ** 2
    sigma = Mission.from_data(found).navigation.velocity_error.sigma
    assert sigma.median == pytest.approx(np.exp(centre), rel=1e-3)
    assert np.log(sigma.factor) ** 2 == pytest.approx(spread, rel=0.01)


def test_what_the_data_do_not_concern_is_carried_as_it_was():
    before = Mission.from_data({**MISSION.raw, "effects": [
        {"one-of": [{"probability": 0.25, "effects": [{"drag-bias": {"fraction": {"mean": 0.3, "sd": 0.02}}}]}]},
        {"added-mass": {"fraction": {"mean": 0.1, "sd": 0.05}}},
        {"compass-bias": {"angle": {"mean": "3 deg", "sd": "1 deg"}}},
    ]})  # fmt: skip
    (doubt,) = before.doubts
    compass = normal("compass-bias", 0.06, 0.004)
    found = [
        hypothesis((), share, compass, before.knowing(doubt.place, number), ("compass-bias",))
        for number, share in enumerate(doubt.probabilities)
    ]
    written = extended_mission(sorted(found, key=lambda each: -each.probability))
    assert written["effects"] == [{"added-mass": {"fraction": {"mean": 0.1, "sd": 0.05}}}]
    draws = written["posterior"].draws
    assert draws.probability("drag-bias") == pytest.approx(0.25, abs=1e-6)
    assert draws.probability("compass-bias") == pytest.approx(1.0)
    drag, _ = draws.column(("drag-bias", "fraction"))
    assert (drag.mean(), drag.std()) == pytest.approx((0.3, 0.02), rel=0.02)
    once_more = Mission.from_data(written)
    again = extended_mission([
        hypothesis((), share, None, once_more.knowing("posterior", number))
        for number, share in enumerate(once_more.effect_list.learned.probabilities)
    ])["posterior"].draws  # fmt: skip
    assert again.probability("drag-bias") == pytest.approx(0.25, abs=1e-6)
    assert np.mean(again.column(("compass-bias", "angle"))[0]) == pytest.approx(0.06, abs=1e-3)


def test_a_mission_that_nothing_was_found_for_has_the_place_and_date_that_draws_may_need(transit_mission):
    raw = {key: value for key, value in transit_mission.raw.items() if key not in ("site", "start")}
    best = SimpleNamespace(calibration={}, given=(), estimates=())
    data = SimpleNamespace(origin=(math.radians(48.5), math.radians(-123.5)), epoch=1_655_231_485.0)
    extended = extended_transit_mission(raw, best, data)
    assert extended["site"]["origin"] == {"latitude": "48.5000000 deg", "longitude": "-123.5000000 deg"}
    assert extended["start"] == "2022-06-14T18:31:25Z"


def test_draws_are_told_by_moments_of_their_kind():
    """A size by mean and deviation, a direction about north, a time by the deviation of its logarithm."""
    half = np.full(2, 0.5)
    assert _in_words(("compass-bias", "angle"), np.radians([2.0, 6.0]), half) == {"mean": "4 deg", "sd": "2 deg"}
    north = _in_words(("compass-deviation", "phase"), np.radians([350.0, 20.0]), half)
    assert north == {"mean": "5 deg", "sd": "15 deg"}
    assert _in_words(("persistent-error", "time"), np.array([100.0, 400.0]), half) == {"median": "200 s", "factor": 2.0}
    weighted = _in_words(("mean-current", "east"), np.array([0.1, 0.2]), np.array([3.0, 1.0]))
    assert weighted == {"mean": "0.125 m/s", "sd": "0.0433 m/s"}


def test_a_record_tells_of_a_level_what_it_adds_to_what_was_known_and_nothing_where_it_adds_none():
    """Known 0.04 ± 0.03 and then 0.03 ± 0.02: the precision 2500 - 1111 is the record's, and 75 - 44.4 its pull."""
    before = Mission.from_data(
        {**MISSION.raw, "effects": [{"compass-bias": {"angle": {"mean": "0.04 rad", "sd": "0.03 rad"}}}]}
    )

    def told(sd):
        own = hypothesis((), 1.0, normal("compass-bias", 0.03, sd), before, ("compass-bias",))
        return [seen for _, seen in _told(own, "a record")]

    (seen,) = told(0.02)
    assert (seen.value, seen.sd) == pytest.approx((0.022, 7.2e-4**0.5), rel=1e-6)
    assert len(told(0.03 * 0.998**0.5)) == 1
    assert told(0.03 * 0.9995**0.5) == told(0.031) == []
