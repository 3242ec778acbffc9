"""What chance allows: the statistic against its published law, and missions whose σ is off by half."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

import missionplan
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.dives.preparation import PreparedDives
from missionplan.diagnosis.scoring import expected_by_vehicle, legs
from missionplan.diagnosis.scoring.holdout import _kept
from missionplan.diagnosis.scoring.legs import _fix_covariance, leg_errors
from missionplan.diagnosis.scoring.predictive import Ensemble, Mixture, Noise, Part, one_step_ahead
from missionplan.diagnosis.scoring.yardsticks import anderson_darling, persistent, random_walk, with_spread, yardsticks
from missionplan.errors import InputError
from tests.diagnosis.scoring.test_score_legs import Truth, made_legs, mission


def test_the_distance_has_its_published_law():
    """Anderson & Darling (1954): mean 1, and 2.492 is passed by one of twenty, 3.857 by one of a hundred."""
    found = anderson_darling(np.random.default_rng(3).uniform(size=(40_000, 80)))
    assert found.mean() == pytest.approx(1.0, abs=0.02)
    assert np.mean(found > 2.492) == pytest.approx(0.05, abs=0.005)
    assert np.mean(found > 3.857) == pytest.approx(0.01, abs=0.002)


def test_the_distance_of_three_values_by_hand():
    u = np.array([0.2, 0.5, 0.9])
    terms = [(2 * i - 1) * (np.log(u[i - 1]) + np.log(1.0 - u[3 - i])) for i in (1, 2, 3)]
    assert anderson_darling(u[None, ::-1])[0] == pytest.approx(-3.0 - sum(terms) / 3.0)


@pytest.mark.parametrize(("made", "stated"), [(0.03, 0.02), (0.02, 0.03)])
def test_a_sigma_off_by_half_is_found_in_sixty_legs(tmp_path: Path, made: float, stated: float):
    for seed in range(2):
        legs = made_legs(tmp_path / str(seed), Truth(sigma_v=made), 300 + seed, legs=60)
        found = missionplan.score(mission(stated), legs)
        assert not found.is_within_chance


def test_a_true_sigma_is_rarely_found_wrong(tmp_path: Path):
    """At most one of twenty in the long run: more than one of four in at most one of 70 such tests."""
    found = [
        missionplan.score(mission(0.02), made_legs(tmp_path / str(seed), Truth(sigma_v=0.02), 400 + seed, legs=60))
        for seed in range(4)
    ]
    assert sum(not each.is_within_chance for each in found) <= 1


def test_a_persistent_error_is_the_best_of_the_yardsticks_on_one():
    """An error that keeps 0.8 of itself from leg to leg, by its own recursion, seen through a little noise."""
    rng = np.random.default_rng(5)
    slow, values = np.zeros(2), []
    for _ in range(300):
        slow = 0.8 * slow + 0.6 * rng.standard_normal(2)
        values.append(slow + 0.2 * rng.standard_normal(2))
    found = yardsticks(values, lambda later, earlier: values[earlier], [np.ones(2)] * 300, 1.0)
    y = np.concatenate(values)
    error = {name: float(np.mean((y - point.mean) ** 2)) for name, point in found.items()}
    assert min(error, key=lambda name: error[name]) == "persistent"
    assert error["persistent"] < 0.95 * error["last_leg"]
    assert np.all(found["wider_sigma"].mean == 0.0)
    assert found["wider_sigma"].sd[-1] == pytest.approx(y.std(), rel=0.02)


def test_yardsticks_are_the_recursions_that_they_are_named_after():
    past = list(np.random.default_rng(2).normal(size=(6, 3)))
    for gain, kept in ((0.2, 0.9), (0.7, 0.5)):
        mean, seen = past[0], np.zeros(3)
        for number, value in enumerate(past):
            mean = mean + gain * (value - mean) if number else value
            seen = kept * (seen + gain * (value - seen))
        assert np.tensordot(random_walk(gain, len(past)), past, 1) == pytest.approx(mean)
        assert np.tensordot(persistent(gain, kept, len(past)), past, 1) == pytest.approx(seen)


def test_the_spread_before_a_group_is_that_of_the_errors_before_it_but_the_first():
    """Until the second is seen it is what was expected; errors count over their scales."""
    values = [np.array(each) for each in ([50.0, 1.0], [3.0, 9.0], [2.0, -4.0], [0.0, 0.0])]
    means, scales = (
        [np.full(2, each) for each in (0.0, 1.0, 0.0, 0.0)],
        [np.full(2, each) for each in (1.0, 2.0, 0.5, 10.0)],
    )
    found = with_spread(values, means, scales, 2.0).sd.reshape(4, 2)[:, 0]
    third, fourth = [1.0, 16.0], [16.0, 64.0]  # squares of errors over their scales: 2 and 8 of 2, 2 and 4 of ½
    assert found == pytest.approx([2.0, 4.0, 0.5 * np.sqrt(np.mean(third)), 10.0 * np.sqrt(np.mean(third + fourth))])


def test_the_crps_of_many_components_is_nearly_that_of_all_pairs():
    rng = np.random.default_rng(4)
    weights, means, sds = (
        rng.uniform(0.5, 2.0, (150, 1)),
        rng.normal(0.0, 2.0, (150, 1)),
        rng.uniform(0.5, 1.5, (150, 1)),
    )
    weights /= weights.sum()
    grid = np.linspace(-15.0, 15.0, 3001)
    below = (weights * ndtr((grid - means) / sds)).sum(axis=0)
    for y in (-3.0, 5.0):
        exact = np.trapezoid((below - (grid >= y)) ** 2, grid)  # the integral that the score is
        assert Mixture(weights, means, sds).crps(np.array([y]))[0] == pytest.approx(exact, rel=0.08)  # of a sample


def test_legs_that_share_a_fix_share_its_error():
    """Fixes of 3 m, one of 6 that two legs share, and 5 m² that an effect adds to each; the third leg is of another run."""
    end = np.array([[10.0, 30.0, 70.0], [0.0, 0.0, 0.0]])
    start = np.array([[0.0, 10.0, 30.0], [0.0, 0.0, 0.0]])
    data = SimpleNamespace(
        typical_fix_sd=None, fix_scale=np.array([2.0, 1.0, 1.0]), start=start, end=end, run=np.array([0, 0, 1])
    )
    effect = SimpleNamespace(fix_variance=lambda: 5.0)
    found = _fix_covariance(data, SimpleNamespace(fix_error=3.0), [effect])
    expected = np.array(
        [[9.0 + 36.0 + 10.0, -41.0, 0.0], [-41.0, 36.0 + 9.0 + 10.0, 0.0], [0.0, 0.0, 9.0 + 9.0 + 10.0]]
    )
    np.testing.assert_allclose(found, np.kron(expected, np.eye(2)))


@pytest.mark.parametrize("way", ["mean", "last-leg", "none"])
def test_a_vehicle_that_makes_up_for_its_drift_expects_what_it_saw_in_the_same_run(way):
    """Errors of velocity so far, or the last one, over the time of the leg to come; of each run by itself."""
    rng, under_way, run = (
        np.random.default_rng(3),
        np.array([100.0, 200.0, 300.0, 150.0, 120.0, 80.0]),
        np.array([0, 0, 0, 1, 1, 1]),
    )
    through, error = rng.normal(size=(2, 2, 6)) * [[[300.0]], [[20.0]]]
    start, t = np.zeros((2, 6)), np.cumsum(under_way) + 60.0 * np.arange(6)
    data = TransitData(
        "a",
        "a",
        np.arange(6).astype(str),
        run,
        t,
        under_way,
        np.zeros(6),
        start,
        through,
        through + error,
        None,
        3.0,
        True,
        (),
    )
    whole = {**mission().raw}
    whole["navigation"] = {**whole["navigation"], "drift_compensation": way, "fix_error": "0 m"}
    found = expected_by_vehicle(data, missionplan.Mission.from_data(whole))
    if way == "none":
        assert found is None
        return
    for leg in range(6):
        past = [other for other in range(leg) if run[other] == run[leg]][0 if way == "mean" else -1 :]
        expected = (error / under_way)[:, past].mean(axis=1) * under_way[leg] if past else np.zeros(2)
        assert found[leg] == pytest.approx(expected, abs=1e-9), leg


def test_a_mission_has_learned_from_so_many_legs_as_a_diagnosis_of_the_rest_leaves():
    legs, dives = (
        (TransitData(*["a"] * 4, np.zeros(n), *[None] * 9) for n in (40, 15)),
        PreparedDives("a", "a", (None,) * 10, ()),
    )
    many, few = legs
    assert [_kept(data, 0.25) for data in (many, dives)] == [30, 8]  # 7.5 dives
    for data, share in ((many, 0.0), (many, 1.0), (few, 0.5), (many, 0.9), (dives, 0.99)):
        with pytest.raises(InputError, match="holdout"):
            _kept(data, share)


def test_a_leg_is_predicted_by_the_explanations_as_the_legs_before_it_left_them():
    """Of 0 and of 3 m, either with 1 m: a first leg of 3 m is for the second by exp(-4.5), and the first as they were."""
    noise = Noise(1.0, np.diag([1.0, 4.0]), np.ones(1), np.zeros(2))
    parts = tuple(Part(share, np.full((1, 2), mean), (noise,)) for share, mean in ((0.8, 0.0), (0.2, 3.0)))
    found = one_step_ahead(Ensemble(np.array([3.0, 9.0]), np.array([0, 1]), parts))
    left = 0.8 * np.exp(-4.5) / (0.8 * np.exp(-4.5) + 0.2)
    assert found.mixture.weights == pytest.approx(np.array([[0.8, left], [0.2, 1.0 - left]]))
    assert found.mixture.means == pytest.approx(np.array([[0.0, 0.0], [3.0, 3.0]]))
    assert found.mixture.sds == pytest.approx(np.array([[1.0, 2.0], [1.0, 2.0]]))


def test_the_drift_at_the_surface_is_that_of_the_time_and_place_where_a_leg_ends(monkeypatch):
    """A leg of 100 s from 1000 s on, from 7 m to 57 m; then 20 s at the surface, the flow told as its time and place."""

    class Moved:
        def __init__(self, plan, *_):
            self.plan = plan

        def of_leg(self, number, own, t, duration, start, through, speed):
            assert (t.tolist(), duration.tolist(), speed) == ([1000.0], [100.0], 0.5)
            return np.array([[0.3], [0.0]])

        def at_surface(self, t, place):
            assert self.plan.surfacing_time == 20.0
            return np.stack((t, place[0]))

    monkeypatch.setattr(legs, "GroundVelocity", Moved)
    data = SimpleNamespace(
        **{"n": 1, "run": np.zeros(1), "under_way": np.array([100.0]), "surface": np.array([20.0])},
        **{"t_start": np.array([1000.0]), "start": np.array([[7.0], [0.0]])},
        dead_reckoned=np.array([[57.0], [0.0]]),
    )
    scenario = SimpleNamespace(transit=lambda: None, transit_plan=lambda _: None, current=None)
    monkeypatch.setattr(legs, "replace", lambda plan, **changes: SimpleNamespace(**changes))
    normals = SimpleNamespace(velocity=SimpleNamespace(leg=lambda _: np.zeros((2, 1))))
    assert leg_errors(data, scenario, (), normals, 1)[0, :, 0] == pytest.approx([30.0 + 20.0 * 1100.0, 20.0 * 57.0])
