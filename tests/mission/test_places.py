"""What belongs to a place or to some days is not handed on to another one."""

import copy

import numpy as np
import pytest
from conftest import TRANSIT

from missionplan.mission import Mission
from missionplan.mission.epochs import not_handed_on
from missionplan.mission.reading.includes import hash_of
from missionplan.montecarlo.posterior import WeightedDraws
from missionplan.montecarlo.posterior_file import PosteriorFile

HERE = (np.radians(37.0), np.radians(-76.0), 1.78e9)
ALL = ("compass-bias", "mean-current", "tidal-current", "inertial-current", "persistent-error")


def moved(north_km=0.0, east_km=0.0, days=0.0):
    latitude = HERE[0] + north_km / 6371.0
    return latitude, HERE[1] + east_km / 6371.0 / np.cos(HERE[0]), HERE[2] + 86400.0 * days


@pytest.mark.parametrize(
    ("there", "gone"),
    [
        (moved(5.0, -5.0, 1.0), set()),
        (moved(0.0, 350.0, 35.0), {"mean-current", "tidal-current", "inertial-current"}),
        (moved(19.0), set()),
        (moved(0.0, -21.0), {"mean-current", "tidal-current", "inertial-current"}),
        (moved(days=-10.0), {"inertial-current"}),
        (moved(days=60.0), {"mean-current", "inertial-current"}),
        ((np.nan, np.nan, np.nan), set()),
    ],
)
def test_what_is_handed_on(there, gone):
    assert set(not_handed_on(ALL, HERE, there)) == gone


def learned():
    columns = (("compass-bias", "angle"), ("mean-current", "east"), ("mean-current", "north"))
    values = np.full((100, 3), 0.05)
    values[:50, 1:] = np.nan
    which = np.repeat([0, 1], 50)
    draws = WeightedDraws(
        (("compass-bias",), ("compass-bias", "mean-current")), which, columns, values, np.full(100, 0.01)
    )
    return PosteriorFile.of(draws, hash_of(()), {}, HERE[2], HERE)


def test_a_plan_for_another_place_has_none_of_its_currents():
    here = Mission.from_data({**copy.deepcopy(TRANSIT), "posterior": learned()})
    assert {entry.effect for entry in here.effects} == {"compass-bias", "mean-current"}
    data = copy.deepcopy(TRANSIT)
    data["site"]["origin"] = {"latitude": "40 deg", "longitude": "-73 deg"}
    there = Mission.from_data({**data, "posterior": learned()})
    assert [entry.effect for entry in there.effects] == ["compass-bias"]
    assert there.effect_list.learned.probabilities == pytest.approx((1.0,))
    assert any("mean-current was learned" in notice and "not handed on" in notice for notice in there.notices())


def test_draws_without_an_effect_keep_the_weights_of_the_others():
    draws = learned().draws
    without = draws.without(["compass-bias"])
    assert without.sets == ((), ("mean-current",))
    assert without.probabilities == pytest.approx((0.5, 0.5))
    assert without.columns == draws.columns[1:]
