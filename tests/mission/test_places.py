"""What belongs to a place or to some days is not handed on to another one."""

import copy
import io

import numpy as np
import pytest
from pyproj import Geod

from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.includes import hash_of
from missionplan.mission.learned import _distance, not_handed_on, still_alike
from missionplan.montecarlo.posterior import PosteriorFile, WeightedDraws
from tests.fixtures import TRANSIT

HERE = (np.radians(37.0), np.radians(-76.0), 1.78e9)
ALL = ("compass-bias", "mean-current", "tidal-current", "inertial-current", "persistent-error")
COLUMNS = tuple((effect, "") for effect in ALL)


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
    assert set(not_handed_on(ALL, (HERE,), there)) == gone


def test_what_was_learned_on_a_long_way_holds_all_along_it():
    """The middle of the data is 40 km and 45 days from here, their end is near."""
    way = tuple(moved(north_km=-80.0 + 20.0 * n, days=-90.0 + 22.0 * n) for n in range(5))
    assert not_handed_on(ALL, way, HERE) == {}
    assert set(not_handed_on(ALL, way[2:3], HERE)) == {"mean-current", "tidal-current", "inertial-current"}
    alike = still_alike(COLUMNS, way, HERE)
    assert alike["mean-current"] == pytest.approx(np.exp(-0.5 * (2.0 / 30.0) ** 2), rel=1e-6)
    assert still_alike([("mean-current", "east")], way[:4], HERE)["mean-current"] == pytest.approx(
        np.exp(-0.5 * (1.0 + (24.0 / 30.0) ** 2)), rel=1e-3
    )


def test_a_file_with_the_middle_of_the_data_alone_is_read():
    arrays = dict(np.load(io.BytesIO(learned().content)))
    content = io.BytesIO()
    np.savez_compressed(content, **{**arrays, "format": np.array(2), "place": arrays["place"][0]})
    assert PosteriorFile(content.getvalue()).places == (HERE,)


def learned():
    columns = (("compass-bias", "angle"), ("mean-current", "east"), ("mean-current", "north"))
    values = np.full((100, 3), 0.05)
    values[:50, 1:] = np.nan
    which = np.repeat([0, 1], 50)
    draws = WeightedDraws(
        (("compass-bias",), ("compass-bias", "mean-current")), which, columns, values, np.full(100, 0.01)
    )
    return PosteriorFile.of(draws, hash_of(()), {}, HERE[2], (HERE,))


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


def drawn_here(draws, start_days=0.0, east_km=0.0):
    """Draws that a mission there has of what was learned at `HERE`."""
    latitude, longitude, date = moved(east_km=east_km, days=start_days)
    data = copy.deepcopy(TRANSIT)
    data["site"]["origin"] = {"latitude": f"{np.degrees(latitude)} deg", "longitude": f"{np.degrees(longitude)} deg"}
    data["start"] = f"{np.datetime64(int(date), 's')}Z"
    posterior = PosteriorFile.of(draws, hash_of(()), {}, HERE[2], (HERE,))
    return Mission.from_data({**data, "posterior": posterior}).effect_list.learned.draws


def test_doubt_grows_with_distance_and_season():
    """A smooth field: mean·ρ and variance·ρ² + scale²(1 − ρ²), ρ = exp(−((km/20)² + (days/30)²)/2)."""
    normals = np.random.default_rng(3).standard_normal((4000, 2))
    values = [0.3, -0.1] + 0.02 * normals
    columns = (("mean-current", "east"), ("mean-current", "north"))
    draws = WeightedDraws((("mean-current",),), np.zeros(4000, int), columns, values, np.full(4000, 1 / 4000))
    np.testing.assert_allclose(drawn_here(draws).values, values, rtol=1e-5, atol=1e-6)
    scale = CATALOGUE["mean-current"].parameters["east"].scale
    for km, days in ((10.0, 0.0), (0.0, 20.0), (5.0, 7.0)):
        share = np.exp(-0.5 * ((km / 20.0) ** 2 + (days / 30.0) ** 2))
        found = drawn_here(draws, days, km).values
        assert found.mean(axis=0) == pytest.approx(share * values.mean(axis=0), rel=1e-3)
        expected = np.sqrt(share**2 * values.var(axis=0) + (1.0 - share**2) * scale**2)
        assert found.std(axis=0) == pytest.approx(expected, rel=1e-3)


def tide(*constituents):
    """Draws of a tide in which a record resolved these constituents, each of 0.4 m/s to the east."""
    columns = tuple(("tidal-current", f"{name}_east{part}") for name in constituents for part in ("", "_phase"))
    values = np.tile([0.4, 1.0], len(constituents)) + 0.01 * np.random.default_rng(4).standard_normal(
        (4000, len(columns))
    )
    return WeightedDraws((("tidal-current",),), np.zeros(4000, int), columns, values, np.full(4000, 1 / 4000))


def test_a_tide_outlasts_the_season_and_is_in_doubt_elsewhere():
    """Both components of each constituent shrink towards nothing and widen; at the same place hardly anything changes."""
    draws = tide("m2", "s2", "n2", "k2")
    size = drawn_here(draws, 200.0).values[:, 0]
    np.testing.assert_allclose(size, draws.values[:, 0], rtol=1e-6)
    draws = tide("m2")
    there = drawn_here(draws, 0.0, 15.0).values
    pair = there[:, 0] * np.exp(1j * there[:, 1])
    before = draws.values[:, 0] * np.exp(1j * draws.values[:, 1])
    share = np.exp(-0.5 * (15.0 / 20.0) ** 2)
    assert pair.mean() == pytest.approx(share * before.mean(), rel=2e-3)
    scale = CATALOGUE["tidal-current"].parameters["m2_east"].scale
    assert pair.real.std() == pytest.approx(np.sqrt((1 - share**2) * scale**2 + share**2 * before.real.var()), rel=1e-2)


def test_what_is_only_like_what_was_learned_correlates_as_a_gaussian_of_distance_and_time():
    """Of 20 km; a mean lasts a month, an inertial current three days, and tides outlast a season."""
    for there in (moved(10.0, 0.0, 2.0), moved(0.0, -10.0, -2.0)):
        found = still_alike(COLUMNS, (HERE,), there)
        squares = {
            "mean-current": 0.5**2 + (2.0 / 30.0) ** 2,
            "tidal-current": 0.5**2,
            "inertial-current": 0.5**2 + (2.0 / 3.0) ** 2,
        }
        assert found == {name: pytest.approx(np.exp(-0.5 * squared), rel=1e-4) for name, squared in squares.items()}
    assert still_alike(COLUMNS, (HERE,), (np.nan, np.nan, np.nan))["mean-current"] == 1.0
    sphere = Geod(a=6.371e6, b=6.371e6)
    for one, other in (((60.0, 179.0), (59.0, -178.0)), ((-30.0, 10.0), (45.0, 80.0))):
        *_, expected = sphere.inv(one[1], one[0], other[1], other[0])
        assert _distance((*np.radians(one), 0.0), (*np.radians(other), 0.0)) == pytest.approx(expected)


@pytest.mark.parametrize("days", [1.0, 3.7, 7.4, 14.77, 100.0])
def test_springs_say_little_of_neaps_where_a_record_took_both_for_one(days):
    """Tides of M2, S2, N2 and K2 with the sizes of the catalogue, by their phasors: how alike the sums are later."""
    parameters = CATALOGUE["tidal-current"].parameters
    hours = {"m2": 12.4206012, "s2": 12.0, "n2": 12.65834751, "k2": 11.96723606}
    generator, now, later = np.random.default_rng(8), 0.0, 0.0
    for name, period in hours.items():
        phasor = parameters[f"{name}_east"].scale * (generator.standard_normal((2, 40_000)).T @ [1.0, 1.0j])
        now, later = now + phasor, later + phasor * np.exp(2j * np.pi * 24.0 * days * (1 / period - 1 / hours["m2"]))
    expected = np.mean(now * later.conj()).real / np.mean(np.abs(now) ** 2)
    draws, turned = tide("m2"), np.exp(2j * np.pi * 24.0 * days / hours["m2"])
    before, there = (
        np.mean(each[:, 0] * np.exp(1j * each[:, 1])) for each in (draws.values, drawn_here(draws, days).values)
    )
    assert there * turned / before == pytest.approx(expected, abs=0.03)
