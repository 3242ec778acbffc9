"""The drift filter: exact conditional means, limits, the oscillations of the effects."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats
from transit_examples import run, start

from missionplan.effects.currents import InertialCurrent
from missionplan.effects.oscillation import EARTH_ROTATION
from missionplan.effects.tidal_current import PERIODS, TidalCurrent
from missionplan.phases.hooks import Leg
from missionplan.phases.transit.compensation import CompletedLeg, Forecast, PlannedLeg, RunningMean
from missionplan.phases.transit.kalman_filter import (
    MISS_REMAINDER,
    MISS_UNDERSHOOT,
    PERSISTENT,
    STEADY,
    SURFACE,
    WAVES,
    DriftFilter,
    DriftModel,
    stop_short,
    time_over_ground,
)
from missionplan.phases.transit.plan import VelocityError

STILL = Forecast(None, np.zeros(2), 0.0, 60.0)
M2 = 2.0 * np.pi / PERIODS["m2"]


def model(**changes):
    waves = 4 * len(changes.get("tides", ())) + 2 * bool(changes.get("turning"))
    size = WAVES + waves
    given = {
        "mean": np.zeros(size),
        "prior": np.zeros((size, size)),
        "tides": (),
        "turning": 0.0,
        "persistence": 1000.0,
        "walk": 0.0,
        "growth": np.zeros(size),
        "covariance": 4e-4 * np.eye(2),
        "fix_error": 3.0,
    }
    return DriftModel(**{**given, **changes})


def behind(velocity_error, seconds, drift, t):
    zero = np.zeros((2, 1))
    return CompletedLeg(velocity_error[:, None], np.array([seconds]), drift[:, None], zero, np.array([t]), zero, zero)


def ahead(t, seconds, nominal=(0.0, 0.0)):
    zero, nominal = np.zeros((2, 1)), np.array(nominal)[:, None]
    return PlannedLeg(np.array([t]), zero, nominal, np.array([seconds]), nominal, 0.0)


def wide_prior(size):
    """A prior in which all components are correlated."""
    root = np.random.default_rng(3).normal(size=(size, size)) * 0.05
    root[SURFACE : SURFACE + 2] *= 60.0
    prior = root @ root.T
    persistent = slice(PERSISTENT, PERSISTENT + 2)
    prior[persistent] = prior[:, persistent] = 0.0
    prior[persistent, persistent] = 0.04**2 * np.eye(2)
    return prior


@pytest.mark.parametrize(("duration", "pause"), [(60.0, 90.0), (1800.0, 90.0), (20_000.0, 600.0)])
def test_the_persistent_velocity_is_felt_as_its_mean_over_a_leg(duration, pause):
    """Standard deviation and correlation of two legs' means, by sums in time."""
    drift_model = model(prior=wide_prior(WAVES))
    steps = (np.arange(500) + 0.5) / 500.0 * duration
    t = np.concatenate([steps, steps + duration + pause])
    pointwise = np.exp(-np.abs(t[:, None] - t) / drift_model.persistence)
    means = pointwise.reshape(2, 500, 2, 500).mean(axis=(1, 3))
    row = drift_model.under_way(np.zeros(1), np.array([duration]))[0, PERSISTENT, 0]
    kept = drift_model.kept(np.array([duration + pause]), np.array([duration]))
    assert row == pytest.approx(np.sqrt(means[0, 0]), rel=1e-4)
    assert kept[0] == pytest.approx(means[0, 1] / means[0, 0], rel=1e-3)


@pytest.mark.parametrize("fix_error", [0.3, 3.0])
def test_the_estimate_is_the_conditional_mean_of_the_model(fix_error):
    """Every leg's measurements and the state ahead are jointly normal: compare with one solve for all of them."""
    covariance = np.array([[4e-4, 1e-4], [1e-4, 2e-4]])
    drift_model = model(
        tides=(M2,),
        prior=wide_prior(WAVES + 4),
        mean=np.linspace(-0.05, 0.05, WAVES + 4),
        covariance=covariance,
        fix_error=fix_error,
        walk=1e-3,
    )
    times, durations = np.array([0.0, 700.0, 1900.0, 2200.0]), np.array([600.0, 1100.0, 200.0, 900.0])
    middles = times + 0.5 * durations
    size = len(drift_model.mean)

    def state_covariance(i, j):
        """Covariance of the states at the middles of two legs."""
        result = drift_model.prior.copy()
        persistent = slice(PERSISTENT, PERSISTENT + 2)
        after = slice(min(i, j) + 1, max(i, j) + 1)
        apart = np.diff(middles, prepend=0.0)[after]
        result[persistent, persistent] *= np.prod(drift_model.kept(apart, durations[after]))
        walked = drift_model.walk**2 * (min(middles[i], middles[j]) - middles[0])
        result[[STEADY, STEADY + 1], [STEADY, STEADY + 1]] += walked
        return result

    legs = len(times) - 1
    rows = [drift_model.under_way(times[i : i + 1], durations[i : i + 1])[:, :, 0] for i in range(len(times))]
    surface = np.zeros((2, size))
    surface[[0, 1], [SURFACE, SURFACE + 1]] = 1.0
    seen_by = [np.concatenate([row, surface]) for row in rows[:legs]]
    joint = np.zeros((4 * legs, 4 * legs))
    ahead_with = np.zeros((size, 4 * legs))
    for i in range(legs):
        part = slice(4 * i, 4 * i + 4)
        for j in range(legs):
            joint[part, 4 * j : 4 * j + 4] = seen_by[i] @ state_covariance(i, j) @ seen_by[j].T
        noise = np.zeros((4, 4))
        noise[:2, :2] = covariance + 2.0 * fix_error**2 / durations[i] ** 2 * np.eye(2)
        noise[2:, 2:] = 2.0 * fix_error**2 * np.eye(2)
        noise[:2, 2:] = noise[2:, :2] = -(fix_error**2) / durations[i] * np.eye(2)
        joint[part, part] += noise
        ahead_with[:, part] = state_covariance(legs, i) @ seen_by[i].T
    seen = np.random.default_rng(5).normal(size=4 * legs) * np.tile([0.1, 0.1, 5.0, 5.0], legs)
    mean = drift_model.mean.copy()
    mean[PERSISTENT : PERSISTENT + 2] = 0.0
    expected_seen = np.concatenate([row @ mean for row in seen_by])
    best = mean + ahead_with @ np.linalg.solve(joint, seen - expected_seen)

    drift_model = model(**{**vars(drift_model), "mean": mean})
    drift_filter = DriftFilter(STILL, drift_model)
    memory = drift_filter.begin(1)
    for i in range(legs):
        memory = drift_filter.update(
            memory, behind(seen[4 * i : 4 * i + 2], durations[i], seen[4 * i + 2 : 4 * i + 4], times[i])
        )
    velocity, drift = drift_filter.expected(memory, ahead(times[-1], durations[-1]))
    assert velocity[:, 0] == pytest.approx(rows[-1] @ best, rel=1e-5)
    assert drift[:, 0] == pytest.approx(best[SURFACE : SURFACE + 2], rel=1e-5)

    course = np.array([0.6, -0.8])
    along, across = drift_filter.spread(memory, ahead(times[-1], durations[-1], 900.0 * course))
    left = state_covariance(legs, legs) - ahead_with @ np.linalg.solve(joint, ahead_with.T)
    moves = rows[-1] * durations[-1] + surface
    ends = moves @ left @ moves.T + covariance * durations[-1] ** 2 + 2.0 * fix_error**2 * np.eye(2)
    assert along == pytest.approx(np.sqrt(course @ ends @ course), rel=1e-5)
    assert across == pytest.approx(np.sqrt(np.trace(ends) - course @ ends @ course), rel=1e-5)


def test_without_anything_uncertain_it_is_the_forecast():
    forecast = Forecast(None, np.array([0.03, -0.04]), 0.0, 60.0)
    drift_filter = DriftFilter(forecast, model())
    memory = drift_filter.update(drift_filter.begin(1), behind(np.array([0.2, 0.1]), 500.0, np.array([9.0, 9.0]), 0.0))
    leg = ahead(600.0, 300.0)
    velocity, drift = drift_filter.expected(memory, leg)
    assert velocity * leg.duration + drift == pytest.approx(forecast.offset((), leg))


@given(
    arrays(float, (2, 1), elements=st.floats(-0.5, 0.5)),
    arrays(float, (2, 1), elements=st.floats(-5000.0, 5000.0)),
)
def test_what_is_expected_takes_the_vehicle_where_it_was_to_go(velocity, nominal):
    """The leg as steered and the drift while it lasts, not while the nominal leg would, add up to the nominal leg."""
    speed = 0.9
    drift_filter = DriftFilter(Forecast(None, velocity[:, 0], 0.0, 60.0), model())
    seconds = np.hypot(*nominal) / speed
    leg = PlannedLeg(np.zeros(1), np.zeros((2, 1)), nominal, seconds, nominal, 0.0)
    steered = nominal - drift_filter.offset(drift_filter.begin(1), leg)
    assert steered + velocity * np.hypot(*steered) / speed == pytest.approx(nominal, abs=1e-6)


def test_water_that_is_faster_leaves_the_nominal_time():
    found = time_over_ground(np.ones((2, 1)), np.full((2, 1), 3.0), np.ones(1), np.array([7.0]))
    assert found == pytest.approx(7.0)


@pytest.mark.parametrize(("radius", "price"), [(50.0, 90.0), (15.0, 85.0), (50.0, 350.0)])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.2, 0.3])
def test_it_stops_short_where_the_expected_cost_is_least(radius, price, share):
    """Against the exact probability of ending within the circle, both edges and the chord at each offset included."""
    sd = share * radius
    nodes, weights = np.polynomial.hermite_e.hermegauss(61)
    half = np.sqrt(np.maximum(radius**2 - (sd * nodes) ** 2, 0.0))

    def cost(short):
        within = stats.norm.cdf((half + short[:, None]) / sd) - stats.norm.cdf((short[:, None] - half) / sd)
        return -short + (price + radius) * (1.0 - within @ weights / weights.sum())

    found = stop_short(radius, np.array([sd]), np.array([sd]), price)
    best = cost(np.linspace(0.0, radius, 2001)).min()
    assert cost(found)[0] - best < 0.005 * radius


@pytest.mark.parametrize("price", [1.5, 5.0, 20.0])
def test_it_stops_well_short_only_where_a_leg_will_miss(price):
    """Against sampled ends of a leg: of the centre and well short of it, what is chosen costs less."""
    ends = np.random.default_rng(1).standard_normal((2, 200_000))

    def cost(short, sd):
        left = np.hypot(short + sd * ends[0], sd * ends[1])
        return -short + np.mean((left > 1.0) * (price + left))

    chosen = []
    for sd in np.geomspace(0.5, 8.0, 12):
        found = float(stop_short(1.0, np.array([sd]), np.array([sd]), price)[0])
        rival = 0.0 if found else 2.0 * sd
        assert cost(found, sd) < cost(rival, sd) + 0.03 * sd
        chosen.append(found > 0.0)
    assert chosen == sorted(chosen)
    assert chosen[-1]


def test_the_mean_left_over_is_that_of_a_rice_distance():
    assert stats.rice(MISS_UNDERSHOOT).mean() - MISS_UNDERSHOOT == pytest.approx(MISS_REMAINDER, abs=1e-4)


def test_a_plan_that_stops_short_by_itself_is_kept():
    drift_filter = DriftFilter(STILL, model())
    memory, seconds, nominal = drift_filter.begin(1), np.array([300.0]), np.array([[300.0], [0.0]])
    zero = np.zeros((2, 1))
    to_centre = drift_filter.offset(memory, PlannedLeg(zero[0], zero, nominal, seconds, nominal, 50.0))[0, 0]
    assert 20.0 < to_centre < 50.0
    for planned in (10.0, 45.0):
        goal = nominal + np.array([[planned], [0.0]])
        found = drift_filter.offset(memory, PlannedLeg(zero[0], zero, nominal, seconds, goal, 50.0))
        assert found == pytest.approx(np.array([[max(to_centre - planned, 0.0)], [0.0]]), abs=1e-9)


def test_at_least_half_of_a_leg_is_run_however_large_the_error():
    drift_filter = DriftFilter(STILL, model(covariance=4.0 * np.eye(2)))
    seconds, nominal, zero = np.array([300.0]), np.array([[180.0], [-240.0]]), np.zeros((2, 1))
    found = drift_filter.offset(drift_filter.begin(1), PlannedLeg(zero[0], zero, nominal, seconds, nominal, 50.0))
    assert found == pytest.approx(0.5 * nominal)


def test_with_a_wide_prior_on_a_steady_drift_it_is_the_weighted_mean():
    sigma, prior = 0.02, np.zeros((WAVES, WAVES))
    prior[[STEADY, STEADY + 1], [STEADY, STEADY + 1]] = 1e4
    drift_filter = DriftFilter(STILL, model(prior=prior, covariance=sigma**2 * np.eye(2), fix_error=0.0))
    mean = RunningMean(sigma**2 * np.eye(2), 0.0)
    memory, known = drift_filter.begin(1), mean.begin(1)
    for t, velocity in ((0.0, [0.1, -0.2]), (800.0, [0.05, 0.3]), (1900.0, [-0.02, 0.0])):
        leg = behind(np.array(velocity), 600.0, np.zeros(2), t)
        memory, known = drift_filter.update(memory, leg), mean.update(known, leg)
    leg = ahead(3000.0, 400.0)
    velocity, _ = drift_filter.expected(memory, leg)
    assert velocity * leg.duration == pytest.approx(mean.offset(known, leg), rel=1e-6)


def test_a_trial_that_did_not_move_learns_nothing():
    drift_filter = DriftFilter(STILL, model(prior=np.eye(WAVES)))
    before = drift_filter.begin(1)
    after = drift_filter.update(before, behind(np.array([9.0, 9.0]), 0.0, np.array([9.0, 9.0]), 100.0))
    for old, new in zip(before, after, strict=True):
        np.testing.assert_array_equal(old, new)


def test_variances_shrink_with_every_fix_and_stay_positive():
    prior = wide_prior(WAVES)
    drift_filter = DriftFilter(STILL, model(prior=prior, persistence=1e9))
    memory = drift_filter.begin(1)
    for number in range(30):
        before = np.diag(memory[1][:, :, 0])
        memory = drift_filter.update(memory, behind(np.array([0.1, 0.0]), 500.0, np.array([1.0, 2.0]), 600.0 * number))
        covariance = memory[1][:, :, 0]
        assert np.all(np.diag(covariance) <= before + 1e-9)
        assert np.linalg.eigvalsh(covariance).min() > -1e-9


def test_oscillations_are_those_of_the_effects():
    t, duration, latitude = np.array([0.0, 5000.0, 30000.0]), np.array([900.0, 4000.0, 100.0]), 0.65
    legs = Leg(t, duration, np.zeros((2, 3)), np.ones((2, 3)), 1.0, latitude)
    amplitude, phase, turned = 0.2, 0.7, 1.9
    tide = TidalCurrent(m2_east=amplitude, m2_east_phase=phase, m2_north=0.1, m2_north_phase=turned)
    inertial = InertialCurrent(0.3, 0.4)
    drift_model = model(tides=(M2,), turning=2.0 * EARTH_ROTATION * np.sin(latitude))
    state = np.zeros(WAVES + 6)
    state[WAVES:] = [
        amplitude * np.cos(phase),
        amplitude * np.sin(phase),
        0.1 * np.cos(turned),
        0.1 * np.sin(turned),
        0.3 * np.cos(0.4),
        0.3 * np.sin(0.4),
    ]
    velocity = np.einsum("akn,k->an", drift_model.under_way(t, duration), state)
    assert velocity == pytest.approx(tide.velocity(legs) + inertial.velocity(legs))


def test_dropping_trials_keeps_what_they_have_learnt():
    prior = np.zeros((WAVES, WAVES))
    prior[[0, 1, 2, 3], [0, 1, 2, 3]] = [0.01, 0.01, 9.0, 9.0]
    drift_filter = DriftFilter(STILL, model(prior=prior))
    changes = {
        "d_max": 700.0,
        "velocity_error": VelocityError.isotropic(0.1, np.array([0.03, -0.04])),
        "fix_error": 2.0,
        "max_legs": 40,
    }
    dropped = run(changes, start(1024), compensation=drift_filter)[1]
    kept = run(changes, start(1024), compensation=drift_filter, tracked=1)[1]
    assert np.array_equal(dropped.duration, kept.duration)
