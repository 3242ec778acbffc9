"""Correlations that a mission's effects carry are part of their prior: halves of a record tell what the whole does."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.linalg import block_diag

from missionplan import diagnose
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.dives.model import DescentModel, given_on_descent
from missionplan.diagnosis.extended_mission import Hypothesis, extended_mission
from missionplan.diagnosis.given import GivenEffect, RecordPosterior, tied
from missionplan.diagnosis.given.priors import given_priors
from missionplan.diagnosis.inference.marginal_likelihood import gaussian_marginal
from missionplan.diagnosis.inference.prior import Prior
from missionplan.effects import effects_of
from missionplan.mission import Mission
from missionplan.montecarlo.posterior import NOWHERE
from tests.fixtures import dated

LEGS = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}
HALVES = ((0.5 * np.pi, np.radians(6.0)), (0.2 * np.pi, np.radians(10.0)))
"""Middle and spread of the headings: a half alone tells a slow vehicle from a current ahead badly."""
WIDE = [
    {"speed-scale": {"fraction": {"mean": 0, "sd": 0.06}}},
    {"mean-current": {"east": {"mean": "0 m/s", "sd": "8 cm/s"}, "north": {"mean": "0 m/s", "sd": "8 cm/s"}}},
]
SLOW = {"drag-bias": {"fraction": {"mean": 0, "sd": 0.3}}}
DOWN = {"vertical-current": {"speed": {"mean": "0 m/s", "sd": "12 cm/s"}}}


def slow_in_a_current(t, heading):
    """Speed 6 % low, in a current of 5 cm/s to the north."""
    return -0.06 * 1.2 * np.stack([np.sin(heading), np.cos(heading)]) + np.array([[0.0], [0.05]])


EFFECTS = ("speed-scale", "mean-current", "drag-bias", "vertical-current")


def told(mission):
    """Means and standard deviations of the effects' parameters in the likeliest set."""
    draws = mission.posterior.draws.of_set(0)
    return {
        f"{effect}.{name}": (np.mean(draws.column((effect, name))[0]), np.std(draws.column((effect, name))[0]))
        for effect, name in draws.columns
        if effect in EFFECTS
    }


def untied(mission):
    """The mission with each effect stated by itself, without what ties it to others."""
    units = {"mean-current": " m/s", "vertical-current": " m/s"}
    effects = {}
    for name, (mean, sd) in told(mission).items():
        effect, _, parameter = name.partition(".")
        unit = units.get(effect, "")
        effects.setdefault(effect, {})[parameter] = {key: f"{value}{unit}" if unit else value
                                                     for key, value in (("mean", float(mean)), ("sd", float(sd)))}  # fmt: skip
    data = {key: value for key, value in mission.raw.items() if key != "posterior"}
    return Mission.from_data(data | {"effects": [{name: own} for name, own in effects.items()]})


def distance(found, whole):
    """Largest difference of the means [standard deviations of the whole], and of ln sd."""
    means = [abs(found[name][0] - value) / sd for name, (value, sd) in whole.items()]
    return max(means), max(abs(np.log(found[name][1] / sd)) for name, (_, sd) in whole.items())


@pytest.mark.slow
def test_two_halves_one_after_the_other_tell_what_the_whole_does(transit_mission, legs, folder):
    """Nearly: between records every effect may change by its spike, and σ_v is fitted to each half."""
    mission = Mission.from_data({**transit_mission.raw, "effects": WIDE})
    tables = [legs(40, seed=3 + k, about=HALVES[k], sigma=0.1, error=slow_in_a_current) for k in range(2)]

    def after(before, table):
        return Mission.from_data(diagnose(before, folder(LEGS, table), plan=False).extended)

    half = after(mission, dated(tables[0]))
    later = tables[1].assign(leg=tables[1].leg + 40, run=2)
    later[["t_start_s", "t_end_s"]] += tables[0].t_end_s.max() + 600.0
    whole = told(after(mission, pd.concat([tables[0].assign(run=1), later])))
    found, without = (distance(told(after(each, dated(tables[1], 12.0))), whole) for each in (half, untied(half)))
    draws = half.posterior.draws.of_set(0)
    slow, east = (draws.column(each)[0] for each in (("speed-scale", "fraction"), ("mean-current", "east")))
    assert abs(np.corrcoef(slow, east)[0, 1]) > 0.5
    assert found[0] < 0.2  # 0.08
    assert without[0] > 2.0 * found[0]  # 0.27
    assert found[1] < 0.1


def test_dives_of_two_weights_one_after_the_other_tell_what_all_together_do(descent_mission, measured):
    """Dives of one weight tell more drag from a current upwards badly, dives of two weights well."""
    weights = np.array([9.0, 9.0, 20.0, 20.0])
    every = measured("drag-bias", weights=weights, lines=np.full(4, 4.0), fraction=0.25)
    wide = Mission.from_data({**descent_mission.raw, "effects": [SLOW, DOWN]})

    def after(mission, dives):
        forward = replace(every.forward, logs=tuple(every.forward.logs[k] for k in dives))
        (fit,) = DescentModel(forward, given_on_descent(mission)).fit_all([((), ())])
        held = Hypothesis((), 1.0, mission, ("drag-bias", "vertical-current"), fit, mission.raw)
        return Mission.from_data(extended_mission([held]))

    half, whole = after(wide, (0, 1)), told(after(wide, range(4)))
    drag, up = (
        half.posterior.draws.column(each)[0] for each in (("drag-bias", "fraction"), ("vertical-current", "speed"))
    )
    assert abs(np.corrcoef(drag, up)[0, 1]) > 0.9
    same_day = (each.at_place(NOWHERE, None) for each in (half, untied(half)))
    found, without = (distance(told(after(each, (2, 3))), whole) for each in same_day)
    assert found[0] < 0.4  # 0.35; 1.9 without
    assert without[0] > 2.0 * found[0]


def test_a_joint_prior_is_conditioned_as_on_paper():
    """Two coefficients of correlation ρ, the first seen with the error of its own sd: the second follows by ρ/2."""
    rho, sd = 0.8, np.array([2.0, 0.5])
    covariance = np.outer(sd, sd) * np.array([[1.0, rho], [rho, 1.0]])
    prior = Prior(np.zeros(2), sd, tied=((np.arange(2), covariance),))
    seen = np.array([[1.0, 0.0, 3.0]]) / sd[0]  # column of the first, of the second, and the datum, over the error
    found = gaussian_marginal(seen.T @ seen, prior.root(sd), 2.0 * np.log(sd[0]), 1)
    assert found.mean == pytest.approx([1.5, 0.5 * rho * 3.0 * sd[1] / sd[0]])
    after = covariance - np.outer(covariance[0], covariance[0]) / (2.0 * sd[0] ** 2)
    np.testing.assert_allclose(found.covariance, after, rtol=1e-12)
    assert found.log_density == pytest.approx(stats.norm.logpdf(3.0, scale=np.sqrt(2.0) * sd[0]))


def test_densities_and_parts_of_a_joint_prior():
    covariance = np.array([[4.0, 1.2, 0.0], [1.2, 1.0, -0.3], [0.0, -0.3, 0.5]])
    sd = np.array([2.0, 3.0, 1.0, np.sqrt(0.5)])
    prior = Prior(np.array([1.0, 2.0, 3.0, 4.0]), sd, tied=((np.array([0, 2, 3]), covariance),))
    at = np.array([[0.3, 1.0, 2.0, 5.0], [2.0, -1.0, 3.5, 4.0]])
    joint = stats.multivariate_normal(prior.centre[[0, 2, 3]], covariance).logpdf(at[:, [0, 2, 3]])
    np.testing.assert_allclose(prior.log_density(at), joint + stats.norm.logpdf(at[:, 1], 2.0, 3.0))
    part = prior.of(np.array([1, 2, 3]))
    joint = stats.multivariate_normal(prior.centre[[2, 3]], covariance[1:, 1:]).logpdf(at[:, 2:])
    np.testing.assert_allclose(part.log_density(at[:, 1:]), joint + stats.norm.logpdf(at[:, 1], 2.0, 3.0))
    root = prior.root(sd)
    np.testing.assert_allclose((root @ root.T)[np.ix_([0, 2, 3], [0, 2, 3])], covariance)


def test_correlations_of_a_mission_are_those_of_its_priors(transit_mission):
    """Between effects, within one, and of an amplitude with a size, by its phase."""
    inertial = {"amplitude": {"mean": "0.1 m/s", "sd": "1 cm/s"}, "phase": {"mean": "0.6 rad", "sd": "0.1 rad"}}
    pairs = [
        ("speed-scale.fraction", "mean-current.east", 0.7),
        ("mean-current.east", "mean-current.north", -0.4),
        ("speed-scale.fraction", "inertial-current.amplitude", 0.5),
    ]
    written = [{"between": [f"effects.{a}", f"effects.{b}"], "rho": rho} for a, b, rho in pairs]
    effects = [*WIDE, {"inertial-current": inertial}]
    mission = Mission.from_data({**transit_mission.raw, "effects": effects, "correlations": written})
    (joint,) = tied(given_priors(mission, effects_of("transit")))
    places = {c.key: index for index, c in enumerate(joint.coordinates)}
    speed, east, north = (
        places[key, name, "strength"]
        for key, name in (("speed-scale", "fraction"), ("mean-current", "east"), ("mean-current", "north"))
    )
    assert joint.covariance[speed, east] == pytest.approx(0.7 * 0.06 * 0.08)
    assert joint.covariance[east, north] == pytest.approx(-0.4 * 0.08**2)
    cosine = joint.covariance[speed, places["inertial-current", "amplitude", "cosine"]]
    assert cosine == pytest.approx(0.5 * 0.06 * 0.01 * np.cos(0.6) * np.exp(-0.005), rel=0.02)  # E cos of the phase
    assert np.linalg.eigvalsh(joint.covariance).min() > 0.0


def test_effects_without_correlations_stay_apart(transit_mission):
    mission = Mission.from_data({**transit_mission.raw, "effects": WIDE})
    given = given_priors(mission, effects_of("transit"))
    assert tied(given) == given


def test_a_record_tells_of_the_long_run_through_what_differs_from_record_to_record():
    """Of values x in a record, those of the long run and a scatter of each; beside what a posterior of x leaves open."""
    rng = np.random.default_rng(2)
    root = rng.normal(size=(2, 2))
    covariance, scatter, mean = root @ root.T, np.array([0.3, 0.7]), np.array([0.1, -0.2])
    coordinates = tuple(Coordinate("mean-current", name, "strength", 0.0, 1.0, 0.1) for name in ("east", "north"))
    given = GivenEffect("mean-current", coordinates, mean, covariance, scatter)
    noise = np.diag([0.05, 0.2])  # of a measurement of x
    here = covariance + np.diag(scatter)
    y = np.array([1.0, 0.4])
    known = here @ np.linalg.inv(here + noise)
    posterior_of_x = mean + known @ (y - mean), here - known @ here
    whole = covariance @ np.linalg.inv(here + noise)  # of the long run, from the measurement itself
    expected = mean + whole @ (y - mean), covariance - whole @ covariance
    np.testing.assert_allclose(given.long_run(posterior_of_x[0]), expected[0])
    after = RecordPosterior(coordinates, *posterior_of_x).afterwards((given,), ())
    np.testing.assert_allclose(after.mean, expected[0])
    np.testing.assert_allclose(after.covariance, expected[1], atol=1e-12)
    told = given.posterior(*posterior_of_x)
    assert [each.value for each in told] == pytest.approx(expected[0].tolist())
    assert [each.sd for each in told] == pytest.approx(np.sqrt(np.diag(expected[1])).tolist())
    cause = Coordinate("compass-bias", "angle", "strength", 0.0, 1.0, 0.1)
    with_cause = RecordPosterior(
        (cause, *coordinates), np.append(9.0, posterior_of_x[0]), block_diag([[0.5]], posterior_of_x[1])
    )
    both = with_cause.afterwards((given,), (0,))
    assert (both.mean[-1], both.covariance[-1, -1], both.coordinates[-1]) == (9.0, 0.5, cause)  # as it is in the record
    np.testing.assert_allclose(both.covariance[:2, :2], expected[1], atol=1e-12)
