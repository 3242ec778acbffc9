"""The drift filter's model from a sample of draws."""

from dataclasses import dataclass

import numpy as np
import pytest

from missionplan.effects.currents import InertialCurrent, MeanCurrent, SurfaceDrift
from missionplan.effects.oscillation import EARTH_ROTATION
from missionplan.effects.random_errors import PersistentError, RandomWalk
from missionplan.effects.tidal_current import PERIODS, TidalCurrent
from missionplan.phases.hooks import DriftParts, TransitEffect
from missionplan.phases.transit.compensation import Forecast, PlannedLeg
from missionplan.phases.transit.kalman_filter import PERSISTENT, STEADY, SURFACE, WAVES, DriftFilter
from missionplan.scenario.transits import DriftSample, drift_model

FORECAST = Forecast(current=None, mean_error=np.array([0.01, 0.0]), depth=5.0, surfacing_time=60.0)
NORMALS = np.random.default_rng(1).standard_normal((4, 500))


def model(*effects, error=(0.01, 0.0), is_recorded=False, current=None):
    sample = DriftSample(
        trials=500,
        velocity_error=np.array(error)[:, None],
        current=current,
        is_recorded=is_recorded,
        depth=5.0,
        surfacing_time=60.0,
        effects=effects,
    )
    return drift_model(sample, FORECAST, covariance=0.03**2 * np.eye(2), latitude=0.6, fix_error=3.0)


@pytest.mark.parametrize("is_recorded", [False, True])
def test_the_prior_is_that_of_the_draws_beyond_the_forecast(is_recorded):
    built = model(MeanCurrent(0.1 + 0.02 * NORMALS[0], 0.05 * NORMALS[1]), is_recorded=is_recorded)
    steady = slice(STEADY, STEADY + 2)
    assert built.mean[steady] == pytest.approx([0.1 + 0.02 * NORMALS[0].mean(), 0.05 * NORMALS[1].mean()])
    expected = np.cov(np.array([0.02, 0.05])[:, None] * NORMALS[:2])
    np.testing.assert_allclose(built.prior[steady, steady], expected, rtol=1e-9)


def test_a_drift_at_the_surface_displaces_by_its_time_there():
    built = model(SurfaceDrift(0.2 + 0.1 * NORMALS[0], -0.3))
    surface = slice(SURFACE, SURFACE + 2)
    assert built.mean[surface] == pytest.approx([60.0 * (0.2 + 0.1 * NORMALS[0].mean()), -18.0])
    assert built.prior[SURFACE, SURFACE] == pytest.approx((60.0 * 0.1) ** 2 * NORMALS[0].var(ddof=1))


class Sheared:
    """A current that turns with depth, with time and from place to place."""

    def velocity(self, t, depth, places):
        east, north = places
        return np.stack((0.3 + 0.02 * depth + 1e-4 * t + 1e-3 * east, -0.1 + 0.01 * depth - 1e-4 * t + 1e-3 * north))


@pytest.mark.parametrize("is_recorded", [False, True])
def test_a_current_is_that_of_the_start_at_the_run_depth_and_at_the_surface(is_recorded):
    built = model(
        current=Sheared(), is_recorded=is_recorded
    )  # error and forecast are alike: what is left is the current
    seen = 0.0 if is_recorded else 1.0
    assert built.mean[STEADY : STEADY + 2] == pytest.approx([0.4 * seen, -0.05 * seen])
    assert built.mean[SURFACE : SURFACE + 2] == pytest.approx([60.0 * 0.3 * seen, -60.0 * 0.1 * seen])


def test_waves_are_coefficients_of_cosine_and_sine():
    tide = TidalCurrent(m2_east=0.2, m2_east_phase=np.pi / 2.0)
    built = model(tide, InertialCurrent(0.1, 0.0))
    assert built.tides == (2.0 * np.pi / PERIODS["m2"],)
    assert built.turning == pytest.approx(2.0 * EARTH_ROTATION * np.sin(0.6))
    assert built.mean[WAVES:] == pytest.approx([0.0, 0.2, 0.0, 0.0, 0.1, 0.0], abs=1e-12)


def test_modulated_waves_are_unsure_and_walk():
    """Each coefficient has the variance of ε times the squared amplitude; its growth is that of the process at first."""
    tide = TidalCurrent(m2_east=0.2, m2_east_phase=0.4, modulation=0.3, coherence_time=4e5)
    built = model(tide, InertialCurrent(0.1, 0.0))
    expected = np.array([0.06**2, 0.06**2, 0.0, 0.0, 0.0, 0.0])
    assert np.diag(built.prior)[WAVES:] == pytest.approx(expected)
    assert built.growth[WAVES:] == pytest.approx(2.0 * expected / 4e5)
    still = model(TidalCurrent(m2_east=0.2))
    assert not np.any(still.growth)
    filtered = DriftFilter(FORECAST, built)
    memory = (built.mean[:, None], built.prior[:, :, None] * 0.0, np.array([1000.0]))
    assert filtered.spread(memory, leg_at(1000.0))[1] < filtered.spread(memory, leg_at(90_000.0))[1]


def leg_at(t):
    one = np.ones(1)
    nominal = np.array([[0.0], [800.0]])
    return PlannedLeg(t * one, np.zeros((2, 1)), nominal, 800.0 * one, np.array([[0.0], [5000.0]]), 50.0)


def test_variances_of_persistent_errors_and_walks_add_up():
    built = model(PersistentError(sigma=0.03, time=900.0), PersistentError(sigma=0.04, time=100.0), RandomWalk(1e-4))
    assert built.prior[PERSISTENT, PERSISTENT] == pytest.approx(0.05**2)
    assert built.persistence == pytest.approx((0.03**2 * 900.0 + 0.04**2 * 100.0) / 0.05**2)  # weighted by variance
    assert built.walk == pytest.approx(1e-4)


@dataclass(frozen=True)
class Seiche(TransitEffect):
    """Another package's effect: a basin that swings with a period of its own."""

    speed: float

    def drift(self):
        return DriftParts(waves={1800.0: np.array([self.speed, 0.0, 0.0, 0.0])}, walk=2e-4)


def test_the_filter_estimates_what_any_effect_declares():
    built = model(Seiche(0.1), TidalCurrent(m2_north=0.2), Seiche(0.2), RandomWalk(1e-4))
    assert built.tides == (2.0 * np.pi / 1800.0, 2.0 * np.pi / PERIODS["m2"])
    assert built.mean[WAVES:] == pytest.approx([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0], abs=1e-12)
    assert built.walk == pytest.approx(3e-4)


def test_nothing_uncertain_leaves_no_prior():
    built = model()
    assert not built.prior.any()
    assert not built.mean.any()
