"""Effects of tank data far beyond their usual size: estimated as they are, not shrunk towards it."""

import math
from functools import partial

import numpy as np
import pytest

from missionplan.diagnosis.tank.fitting import TankFitting
from missionplan.diagnosis.tank.forward import Nuisance, TankForward, oscillation
from missionplan.effects import CATALOGUE
from missionplan.effects.info import TankRecord
from missionplan.physics.tank import displacement, natural_frequency

STIFFNESS, MASS, NOISE = 4000.0, 20.0, 0.0003
USUAL = CATALOGUE["quadratic-damping"].parameters["rate"].scale


def swings(rate, seed=3):
    """A release from 50 mm with a quadratic damping [1/m], and the constants of the base model as good as unknown."""
    time = 0.05 * np.arange(80)
    clean = displacement(time, 0.05, 0.0, natural_frequency(STIFFNESS, MASS), 0.2, rate)
    y = clean + np.random.default_rng(seed).normal(0.0, NOISE, len(time))
    constants = (("start_m", 0.05, 0.1), ("start_velocity_m_s", 0.0, 1.0), ("offset_m", 0.0, 0.05))
    nuisances = [Nuisance(*each) for each in (*constants, ("log_linear_rate", math.log(0.3), 1.5))]
    return TankFitting(
        TankForward(
            kind="free-oscillation",
            record=TankRecord(),
            quantity="displacement_m",
            y=y,
            sd=np.full_like(time, NOISE),
            stated=True,
            nuisances=tuple(nuisances),
            predict=partial(oscillation, time, STIFFNESS, MASS, 1.0),
            axes={"time": time},
            groups=np.repeat(["first", "second"], 40),
        )
    )


def test_only_causes_have_heavy_tails():
    model = swings(2.0)
    heavy = model.prior(("quadratic-damping",)).heavy
    effects = [""] * model.fixed + [coordinate.effect for coordinate in model.coordinates]
    assert [name for name, is_heavy in zip(effects, heavy, strict=True) if is_heavy] == ["quadratic-damping"]
    assert not np.any(model.prior(()).heavy)


@pytest.mark.parametrize("times", [pytest.param(0.3, marks=pytest.mark.slow), 1.0, 10.0])
def test_a_strong_damping_is_measured_as_it_is(times):
    """At ten times its usual size a normal prior takes two standard deviations off."""
    rate = times * USUAL
    errors = []
    for seed in range(6):
        (fit,) = swings(rate, seed).fit_all([(("quadratic-damping",), ())])
        (estimate,) = fit.estimates
        errors.append((estimate.value - rate) / estimate.sd)
    assert abs(np.mean(errors)) < 2.5 / math.sqrt(len(errors))


def test_the_scale_of_a_strong_cause_is_wide_and_of_a_usual_one_as_stated():
    for times, least, most in ((1.0, 0.6, 1.5), (10.0, 4.0, 7.0)):
        model = swings(times * USUAL)
        (fit,) = model.fit_all([(("quadratic-damping",), ())])
        place = [model.is_of(fit.causes, int(index)) for index in fit.state.active].index(True)
        assert least < fit.state.prior_sd[place] / USUAL < most
