"""Missions that carry effects already: their distributions are priors, and the extended mission the posterior."""

import re

import numpy as np
import pytest
from scipy import stats

from missionplan import diagnose
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.given.priors import BARE_SHAPE_LOG_SD, given_priors
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.diagnosis.legs.likelihood.hyperparameters import values_of
from missionplan.effects import CATALOGUE, effects_of
from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.report.render import render_report
from tests.learned import held, moments


def words_of(found):
    """Return the report with plain spaces."""
    return re.sub("[\u00a0\u202f]", " ", render_report(found).html)


CAUSES = ("compass-bias", "mean-current")
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}
SPIKE = CATALOGUE["compass-bias"].parameters["angle"].spike


@pytest.fixture
def carrying(transit_mission, mission):
    """The mission of transits with effects of its own."""
    return lambda *effects: mission({**transit_mission.raw, "effects": list(effects)})


def turned(degrees):
    angle = np.radians(degrees)

    def error(t, heading):
        actual = heading + angle
        return 1.2 * np.stack([np.sin(actual) - np.sin(heading), np.cos(actual) - np.cos(heading)])

    return error


def angle_of(diagnosis):
    return moments(diagnosis.extended, "compass-bias", "angle")


def again(diagnosis, folder):
    return diagnose(Mission.from_data(diagnosis.extended), folder, plan=False)


def test_a_distribution_gives_the_moments_of_its_coordinates(carrying):
    mission = carrying(
        {"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.3 deg"}}},
        {"persistent-error": {"sigma": {"median": "6 cm/s", "factor": 1.5}, "time": "2 h"}},
        {
            "inertial-current": {
                "amplitude": {"mean": "0.1 m/s", "sd": "0.01 m/s"},
                "phase": {"mean": "0.7 rad", "sd": "0.2 rad"},
            }
        },
    )
    compass, persistent, inertial = given_priors(mission, effects_of("transit"))
    assert compass.mean == pytest.approx([np.radians(3.0)], rel=1e-6)
    assert np.sqrt(compass.covariance[0, 0]) == pytest.approx(np.radians(0.3), rel=1e-6)
    assert compass.scatter == pytest.approx([SPIKE**2])
    assert persistent.mean == pytest.approx(np.log([0.06, 7200.0]))
    assert np.sqrt(np.diag(persistent.covariance)) == pytest.approx([np.log(1.5), BARE_SHAPE_LOG_SD], rel=5e-3)
    rng = np.random.default_rng(5)
    size, phase = rng.normal(0.1, 0.01, 400_000), rng.normal(0.7, 0.2, 400_000)
    pair = size * np.stack([np.cos(phase), np.sin(phase)])
    np.testing.assert_allclose(inertial.mean, pair.mean(axis=1), atol=1e-4)
    np.testing.assert_allclose(inertial.covariance, np.cov(pair), atol=4e-6)


def test_the_base_model_is_the_density_of_the_mission_as_it_stands(carrying, folder, legs):
    """Evidence of the base model at given hyperparameters: a normal about the mission's expectation."""
    mission = carrying(
        {"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.3 deg"}}}, {"mean-current": {"east": "5 cm/s"}}
    )
    data = read_transit(folder(KIND, legs(error=turned(3.2))), mission)
    bound = transit_model(data, mission, seed=1)
    linear = bound.linearised(())
    logarithms = np.log([0.03, 3.0])
    found = bound.marginal(bound.hyperparameters(()), logarithms, linear)
    columns = bound.columns(bound.expected).reshape(2 * data.n, -1)
    variances = []
    for coordinate in bound.coordinates:
        known = {"compass-bias": np.radians(0.3) ** 2 + SPIKE**2}
        variances.append(known.get(coordinate.effect, coordinate.spike**2))
    noise = bound.noise(values_of(bound.hyperparameters(()), logarithms))
    total = columns @ np.diag(variances) @ columns.T
    total[: data.n, : data.n] += noise[0]
    total[data.n :, data.n :] += noise[1]
    expected_east = 1.2 * (np.sin(np.arctan2(*bound.leg.along) + np.radians(3.0)) - bound.leg.along[0]) + 0.05
    np.testing.assert_allclose(bound.base[0], expected_east, atol=1e-9)
    density = stats.multivariate_normal(np.zeros(2 * data.n), total).logpdf(bound.y.ravel())
    assert found.log_density == pytest.approx(density, abs=1e-6)


@pytest.mark.slow
def test_an_effect_that_is_as_the_mission_knows_is_confirmed(carrying, folder, legs):
    mission = carrying({"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.5 deg"}}})
    data = folder(KIND, legs(error=turned(3.3)))
    found = diagnose(mission, data, plan=False)
    assert found.verdict == "adequate"
    assert found.causes == ()
    assert not found.changed
    (entry,) = found.diagnosis()["confirmed"]
    assert entry["prior"]["value"] == pytest.approx(np.radians(3.0))
    after = entry["posterior"]
    assert entry["prior"]["sd"] > 1.5 * after["sd"]
    assert abs(after["value"] - np.radians(3.3)) < 2.5 * after["sd"]
    mean, sd = angle_of(found)
    assert (mean, sd) == pytest.approx((after["value"], after["sd"]), rel=1e-3)
    assert "compass bias is 3." in words_of(found)
    assert "Plan on with mission.yaml in this folder" in words_of(found)
    # what was learned adds precision: conjugate normals, the spike being the error from record to record
    fresh = diagnose(carrying(), data, plan=False).best.parameters[0]
    precision = 1.0 / np.radians(0.5) ** 2 + 1.0 / fresh.sd**2
    assert after["sd"] == pytest.approx(precision**-0.5, rel=0.05)


@pytest.mark.usefixtures("among_few")
def test_an_effect_that_changed_is_a_cause_of_its_own(carrying, folder, legs):
    """Three degrees in the mission, six in the data."""
    mission = carrying({"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.3 deg"}}})
    found = diagnose(mission, folder(KIND, legs(24, error=turned(6.0))), plan=False)
    assert found.causes == ("compass-bias",)
    assert found.changed == ("compass-bias",)
    assert found.diagnosis()["changed"] is True
    assert found.diagnosis()["confirmed"] == []
    estimate = found.best.parameters[0]
    assert estimate.low < np.radians(6.0) < estimate.high
    mean, sd = angle_of(found)
    assert abs(mean - np.radians(6.0)) < 2.0 * sd
    assert "Compass bias has changed from 3.0° ± 0.3° to 6" in words_of(found)


@pytest.mark.slow
def test_an_effect_that_changed_is_as_the_mission_says_once_it_is_written(carrying, folder, legs):
    mission = carrying({"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.3 deg"}}})
    data = folder(KIND, legs(40, error=turned(6.0)))
    found = diagnose(mission, data, plan=False)
    second = again(found, data)
    assert second.verdict == "adequate"
    assert not second.changed
    mean, sd = angle_of(second)
    assert abs(mean - np.radians(6.0)) < 2.0 * sd


@pytest.mark.slow
def test_a_bare_number_is_known_to_within_the_spike(carrying, folder, legs):
    """0.025 rad in the mission and 0.0505 rad in the data: the whole of it is written, not the increment."""
    mission = carrying({"compass-bias": {"angle": "0.025 rad"}})
    (given,) = given_priors(mission, effects_of("transit"))
    assert given.here[0, 0] == pytest.approx(SPIKE**2)
    found = diagnose(mission, folder(KIND, legs(error=turned(np.degrees(0.0505)))), plan=False)
    assert found.changed == ("compass-bias",)
    assert angle_of(found)[0] == pytest.approx(0.0505, abs=0.006)


def drifting(sigma, time, seed=3):
    def error(t, heading):
        rng = np.random.default_rng(seed)
        covariance = sigma**2 * np.exp(-np.abs(t[:, None] - t[None, :]) / time)
        return np.linalg.cholesky(covariance + 1e-12 * np.eye(len(t))) @ rng.normal(size=(len(t), 2))

    return lambda t, heading: error(t, heading).T


@pytest.mark.slow
def test_random_effects_of_the_mission_are_in_the_covariance(carrying, folder, legs):
    data = folder(KIND, legs(120, error=drifting(0.08, 7200.0)))
    fresh = diagnose(carrying(), data, plan=False)
    assert fresh.causes == ("persistent-error",)
    second = again(fresh, data)
    assert second.verdict == "adequate"
    assert held(second.extended) == ("persistent-error",)
    sizes = [moments(each.extended, "persistent-error", "sigma")[0] for each in (fresh, second)]
    assert sizes[1] == pytest.approx(sizes[0], rel=0.1)


@pytest.mark.slow
def test_an_alternative_replaces_the_missions_own(carrying, folder, legs):
    """A mission that believes in heavy tails, data whose errors persist."""
    mission = carrying({"heavy-tails": {"dof": 4.0}})
    found = diagnose(mission, folder(KIND, legs(120, error=drifting(0.08, 7200.0))), plan=False)
    assert found.causes == ("persistent-error",)
    assert not found.changed
    assert held(found.extended) == ("persistent-error",)
    assert found.extended["posterior"].draws.probability("persistent-error") > 0.9


def test_effects_that_cannot_be_held_together_are_refused(carrying, folder, legs):
    data = folder(KIND, legs())
    mission = carrying(
        {"persistent-error": {"sigma": "5 cm/s"}},
        {"random-walk": {"rate": "1e-4 m/s**1.5"}},
        {"compass-bias": {"angle": "0.1 rad"}},
        {"compass-bias": {"angle": "0.1 rad"}},
    )
    with pytest.raises(InputError, match=r"compass-bias is given 2 times(.|\n)*one of persistent-error, random-walk"):
        diagnose(mission, data, plan=False)


def test_effects_without_size_are_left_out(carrying):
    mission = carrying({"persistent-error": {"sigma": "0 m/s"}}, {"heavy-tails": {}})
    assert given_priors(mission, effects_of("transit")) == ()


@pytest.mark.usefixtures("among_few")
def test_the_mission_written_is_yaml_that_reads_back(carrying, folder, legs, tmp_path):
    mission = carrying({"compass-bias": {"angle": {"mean": "3 deg", "sd": "0.3 deg"}}})
    found = diagnose(mission, folder(KIND, legs(error=turned(3.3))), plan=False)
    for name in ("mission.yaml", "posterior.npz"):
        content = found.files()[name]
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    assert load(tmp_path / "mission.yaml").effects[0].effect == "compass-bias"
