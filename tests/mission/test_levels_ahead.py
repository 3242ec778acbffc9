"""What was learned of the vehicle has the level of the mission's date."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from missionplan.diagnosis.plan_gain import with_urgency
from missionplan.mission import Mission
from missionplan.mission.includes import hash_of
from missionplan.mission.learned import drifted, has_level, series_of
from missionplan.montecarlo.levels import Seen
from missionplan.montecarlo.posterior import NOWHERE, DamagedPosteriorError, PosteriorFile, WeightedDraws
from missionplan.report.diagnosis.findings import trends_in_words
from missionplan.studies.history import parameter_levels
from tests.fixtures import TRANSIT

SPEED, DAY, START = ("speed-scale", "fraction", "strength"), 86400.0, 1.78e9


def learned(values, dates, key=SPEED, sd=0.003, columns=(("speed-scale", "fraction"),), draws=None):
    """A mission's draws of what records, at these dates, have told of a level."""
    seen = [
        Seen(key, f"record {k}", date, value, sd) for k, (value, date) in enumerate(zip(values, dates, strict=True))
    ]
    if draws is None:
        draws = values[-1] + sd * np.random.default_rng(1).standard_normal((2000, 1))
    n = len(draws)
    own = WeightedDraws(((key[0],),), np.zeros(n, dtype=int), columns, draws, np.full(n, 1.0 / n))
    return PosteriorFile.of(own, hash_of(()), {}, START, (NOWHERE,), seen)


def planned(posterior, start=START):
    moment = np.datetime64(int(start), "s")
    return Mission.from_data({**copy.deepcopy(TRANSIT), "start": f"{moment}Z", "posterior": posterior})


def moments(mission):
    values = mission.effect_list.learned.draws.values[:, 0]
    return float(values.mean()), float(values.std())


def test_a_trend_goes_on_to_the_missions_date():
    """2 % slower a month: the next mission, and one three months later, with more doubt."""
    dates = START + 30.0 * DAY * np.arange(5)
    posterior = learned([-0.02, -0.04, -0.06, -0.08, -0.10], dates)
    next_one, later = planned(posterior), planned(posterior, dates[-1] + 90.0 * DAY)
    assert moments(next_one)[0] == pytest.approx(-0.12, abs=0.004)
    assert moments(later)[0] == pytest.approx(-0.16, abs=0.008)
    assert 0.003 < moments(next_one)[1] < moments(later)[1]
    assert moments(next_one.at_place(NOWHERE, missions=3.0))[0] == pytest.approx(-0.16, abs=0.008)


def test_records_that_come_in_another_order_than_their_dates_plan_the_same():
    """The draws are of the record diagnosed last, which is the first sailed."""
    dates, values = START + 30.0 * DAY * np.arange(4), [-0.02, -0.04, -0.06, -0.08]
    in_order, backwards = (planned(learned(values[::way], dates[::way])) for way in (1, -1))
    assert moments(backwards) == pytest.approx(moments(in_order), abs=2e-3)
    (told,) = parameter_levels(backwards.posterior.seen)
    assert moments(backwards) == pytest.approx((told.next_value, told.next_sd), abs=2e-3)
    assert told.next_value == pytest.approx(-0.10, abs=0.005)


def test_the_same_day_changes_nearly_nothing_and_the_past_nothing():
    posterior = learned([-0.05, -0.05], [START, START + 30.0 * DAY])
    mission = planned(posterior)
    np.testing.assert_array_equal(
        mission.at_place(NOWHERE, None).effect_list.learned.draws.values, posterior.draws.values
    )
    soon = moments(mission.at_place(NOWHERE, START + 30.0 * DAY + 3600.0))
    assert soon[0] == pytest.approx(-0.05, abs=0.001)
    assert soon[1] < moments(mission)[1]


def test_dates_can_be_asked_one_after_the_other():
    """Each is counted from the last record, whatever was asked before."""
    mission = planned(learned([-0.02, -0.04, -0.06], START + 30.0 * DAY * np.arange(3)))
    there = mission.at_place(NOWHERE, START + 200.0 * DAY).at_place(NOWHERE, START + 70.0 * DAY)
    assert moments(there) == moments(mission.at_place(NOWHERE, START + 70.0 * DAY))


def test_a_deviation_keeps_its_phase_where_its_level_is_still():
    """Amplitude 4° at 60°: both components have levels, which are told in the draws' amplitude and phase."""
    rng = np.random.default_rng(2)
    pair = 0.07 * np.exp(1j * np.radians(60.0)) + 0.002 * (rng.standard_normal(3000) + 1j * rng.standard_normal(3000))
    columns = (("compass-deviation", "amplitude"), ("compass-deviation", "phase"))
    draws = np.stack([np.abs(pair), np.angle(pair)], axis=1)
    key = ("compass-deviation", "amplitude", "cosine")
    posterior = learned([0.035] * 4, [np.nan] * 4, key, 0.002, columns, draws)
    values = planned(posterior).effect_list.learned.draws.values
    mean = np.mean(values[:, 0] * np.exp(1j * values[:, 1]))
    assert (mean.real, mean.imag) == pytest.approx((0.035, 0.07 * np.sin(np.radians(60.0))), abs=1e-3)
    assert np.std(values[:, 0] * np.sin(values[:, 1])) == pytest.approx(np.std(pair.imag), rel=1e-6)


def test_draws_in_which_an_effect_never_holds_are_left_as_they_are():
    """An explanation that is known to hold, beside others that have the effect."""
    draws, dates = np.stack([np.full(50, np.nan), np.full(50, 0.1)], axis=1), START + 30.0 * DAY * np.arange(2)
    own = WeightedDraws(
        (("drag-bias",),), np.zeros(50, int), (SPEED[:2], ("drag-bias", "fraction")), draws, np.full(50, 0.02)
    )
    found = drifted(own, learned([-0.02, -0.04], dates).seen, dates[-1] + 30.0 * DAY)
    np.testing.assert_array_equal(found.values, draws)


def test_what_has_a_level():
    assert has_level(("compass-bias", "angle", "strength"))
    assert has_level(("drag-bias", "fraction", "strength"))
    assert not has_level(("mean-current", "east", "strength"))  # of a place
    assert not has_level(("compass-jump", "angle", "strength"))  # within a record
    assert not has_level(("drag-crisis", "speed", "shape"))


def test_levels_that_are_no_numbers_are_refused():
    with pytest.raises(DamagedPosteriorError, match="levels that are no numbers"):
        learned([0.01], [START], sd=0.0)


@pytest.mark.parametrize(("trend", "ahead"), [(-0.02, 16), (0.02, None)])
def test_a_trend_is_told_with_when_it_will_matter(trend, ahead):
    """Against 0.3 m/s a vehicle of 1.2 m/s that fouls by 2 % a mission: after 21 it makes 0.4 m/s of once 0.9 m/s."""
    data = copy.deepcopy(TRANSIT)
    data["site"] |= {"depth": "20 m", "current": [{"down_to": "20 m", "speed": "0.3 m/s", "toward": "270 deg"}]}
    posterior = learned(trend * np.arange(1, 6), START + 30.0 * DAY * np.arange(5))
    mission = Mission.from_data({**data, "posterior": posterior})
    (found,) = with_urgency(parameter_levels(posterior.seen), mission, 1)
    assert found.matters_in == ahead
    (words,) = trends_in_words([found], simulated=True)
    cleaned = ("clean the hull" in words, "check the log's calibration" in words)
    assert cleaned == ((True, False) if trend < 0.0 else (False, True))
    assert ("In 16 missions it costs success." in words) == (ahead == 16)
    assert ("Within 16 missions it costs no success." in words) == (ahead is None)
    (words,) = trends_in_words([replace(found, matters_in=None)], simulated=False)
    assert "success" not in words


@pytest.mark.parametrize(("trend", "said"), [(0.1, "clean the hull"), (-0.1, "that no fitting is lost")])
def test_less_drag_from_mission_to_mission_is_no_fouling(trend, said):
    key = ("drag-bias", "fraction", "strength")
    posterior = learned(trend * np.arange(1, 6), START + 30.0 * DAY * np.arange(5), key, columns=(key[:2],))
    (words,) = trends_in_words(parameter_levels(posterior.seen), simulated=False)
    assert said in words


def test_what_records_told_of_a_level_is_in_the_order_of_their_dates_and_else_as_it_came():
    def values(*dates):
        (series,) = series_of(learned([0.03, 0.01, 0.02], dates).seen).values()
        return [each.value for each in series.records]

    assert values(3.0, 1.0, 2.0) == [0.01, 0.02, 0.03]
    assert values(3.0, np.nan, 2.0) == [0.03, 0.01, 0.02]
