"""Missions that carry effects on a descent: their distributions are priors, and the extended mission the posterior."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.special import logsumexp

from missionplan import diagnose
from missionplan.diagnosis.dives.model import given_on_descent
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.effects import CATALOGUE
from missionplan.errors import InputError
from missionplan.mission import Mission
from tests.learned import held, moments

CAUSES = ("drag-bias", "added-mass", "clock-offset")
SPIKE = CATALOGUE["drag-bias"].parameters["fraction"].spike


@pytest.fixture
def carrying(mission, descent_mission):
    """The mission of dives with effects of its own."""
    return lambda *effects: mission({**descent_mission.raw, "effects": list(effects)})


@pytest.fixture
def logged(measured, folder):
    """Write simulated dives with one effect as a data set."""

    def write(name, **parameters):
        logs = measured(name, **parameters).forward.logs
        runs = {
            log.name: {
                "anchor_wet_weight": f"{log.wet_weight} N",
                "line_length": f"{log.line_length} m",
                "depth": f"{log.site_depth} m",
            }
            for log in logs
        }
        rows = [pd.DataFrame({"run": log.name, "t_s": log.t, "depth_m": log.depth}) for log in logs]
        return folder({"kind": "descent", "name": "dives", "noise": {"depth": "0.03 m"}, "runs": runs}, pd.concat(rows))

    return write


def again(diagnosis, data):
    return diagnose(Mission.from_data(diagnosis.extended), data, plan=False)


def bound(measured, mission, *name, **parameters):
    """The model of simulated dives under a mission that carries effects."""
    return replace(measured(*name, **parameters), given=given_on_descent(mission))


@pytest.mark.parametrize("sd", [0.02, 0.15])
def test_the_base_model_is_the_density_of_the_mission_as_it_stands(measured, carrying, sd):
    """Its evidence, against quadrature of the drag with the phase itself: no linearisation along it."""
    mission = carrying({"drag-bias": {"fraction": {"mean": 0.3, "sd": sd}}})
    model = bound(measured, mission, "drag-bias", fraction=0.38)
    (fit,) = model.relinearised(model.fit_all([((), ())]), 0.0)
    linear, sd_here = fit.state.linear, np.hypot(sd, SPIKE)
    drag = model.index("drag-bias")
    assert model.prior(()).sd[drag] == pytest.approx(sd_here, rel=1e-3)
    fractions = np.linspace(0.28, 0.48, 41)
    settings = np.repeat(model.prior(()).centre[:, None], len(fractions), axis=1)
    settings[drag] = fractions
    readings = model.forward.readings(model.coordinates, settings, delays=linear.release_delays)
    residuals = model.y[:, None] - readings + model.release_delay_shift(linear)[:, None]
    others = model.prior(()).sd
    others[drag] = 0.0
    logs = []
    for noise in noise_grid():
        density = stats.multivariate_normal(np.zeros(len(model.y)), model.covariance(linear, noise, others).dense())
        logs.append(noise.log_prior + density.logpdf(residuals.T))
    prior = stats.norm(0.3, sd_here).logpdf(fractions)
    quadrature = logsumexp(logsumexp(logs, axis=0) + prior) + np.log(fractions[1] - fractions[0])
    assert fit.log_evidence == pytest.approx(quadrature, abs=0.15)


def test_what_is_known_after_the_dives_is_the_posterior(measured, carrying):
    """A wide prior leaves what the dives say, a narrow one what the mission said; precisions add up."""
    fits = {}
    for sd in (0.01, 0.05, 0.2):
        mission = carrying({"drag-bias": {"fraction": {"mean": 0.3, "sd": sd}}})
        model = bound(measured, mission, "drag-bias", fraction=0.38)
        (fit,) = model.fit_all([((), ())])
        (fits[sd],) = fit.given
    plain = measured("drag-bias", fraction=0.38)
    (alone,) = plain.fit_all([(("drag-bias",), ())])
    (estimate,) = alone.estimates
    drag = plain.index("drag-bias")
    in_record = float(np.sqrt(alone.state.marginal.covariance[drag, drag]))
    assert fits[0.2].value == pytest.approx(estimate.value, abs=0.3 * in_record)
    for sd, found in fits.items():
        record = np.hypot(in_record, SPIKE)
        assert found.sd == pytest.approx((sd**-2 + record**-2) ** -0.5, rel=0.15)
        expected = (0.3 / sd**2 + estimate.value / record**2) * found.sd**2
        assert found.value == pytest.approx(expected, abs=0.5 * found.sd)


def test_a_shape_of_the_missions_own_effect_is_fitted(measured, carrying):
    mission = carrying(
        {"slow-flooding": {"fraction": {"mean": 0.4, "sd": 0.05}, "time": {"median": "5 s", "factor": 1.5}}}
    )
    model = bound(measured, mission, "slow-flooding", fraction=0.4, time=4.0)
    (fit,) = model.fit_all([((), ())])
    time = next(estimate for estimate in fit.given if estimate.name == "time")
    assert abs(time.value - 4.0) < 3.0 * time.sd
    assert time.sd < 0.6 * 5.0 * np.log(1.5)
    (without,) = measured("slow-flooding", fraction=0.4, time=4.0).fit_all([((), ())])
    assert fit.log_evidence > without.log_evidence + 20.0


@pytest.mark.usefixtures("among_few")
def test_an_effect_that_is_as_the_mission_knows_is_confirmed(carrying, logged):
    mission = carrying({"drag-bias": {"fraction": {"mean": 0.35, "sd": 0.05}}})
    found = diagnose(mission, logged("drag-bias", fraction=0.38), plan=False)
    assert found.verdict == "adequate"
    assert found.causes == ()
    (entry,) = found.diagnosis()["confirmed"]
    assert entry["prior"]["value"] == pytest.approx(0.35)
    assert entry["posterior"]["sd"] < 0.8 * entry["prior"]["sd"]
    assert abs(entry["posterior"]["value"] - 0.38) < 2.5 * entry["posterior"]["sd"]
    mean, _ = moments(found.extended, "drag-bias", "fraction")
    assert mean == pytest.approx(entry["posterior"]["value"], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("given", [{"mean": 0.2, "sd": 0.02}, 0.2])
def test_an_effect_that_changed_is_a_cause_of_its_own(carrying, logged, given):
    """A fifth more drag in the mission, half as much again in the data; and once more with the mission it wrote."""
    data = logged("drag-bias", fraction=0.5)
    found = diagnose(carrying({"drag-bias": {"fraction": given}}), data, plan=False)
    assert found.causes == ("drag-bias",)
    assert found.changed == ("drag-bias",)
    (estimate,) = found.best.parameters
    assert abs(estimate.value - 0.5) < 2.5 * estimate.sd
    second = again(found, data)
    assert second.verdict == "adequate"
    assert not second.changed
    assert abs(moments(second.extended, "drag-bias", "fraction")[0] - estimate.value) < estimate.sd


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("slow-flooding", {"fraction": 0.4, "time": 4.0}),
        ("sensor-lag", {"time": 2.0}),  # 0.8 s is ambiguous: a broadside start with a late clock rivals it
    ],
)
def test_dives_diagnosed_again_are_adequate_and_nothing_grows(carrying, logged, name, parameters):
    data = logged(name, **parameters)
    found = diagnose(carrying(), data, plan=False)
    assert found.causes == (name,)
    second = again(found, data)
    assert second.verdict == "adequate"
    assert held(second.extended) == (name,)
    for before, after in zip(found.best.parameters, second.confirmed, strict=True):
        assert abs(after.value - before.value) < 0.5 * before.sd


def test_effects_that_cannot_be_held_together_are_refused(carrying, logged):
    mission = carrying({"drag-bias": {"fraction": 0.1}}, {"drag-bias": {"fraction": 0.2}})
    with pytest.raises(InputError, match="drag-bias is given 2 times"):
        diagnose(mission, logged("drag-bias", fraction=0.2), plan=False)
