"""An effect on some of the trials is the effect with zero strength on the others."""

from dataclasses import replace

import numpy as np
import pytest
from test_depth_sensor import DIVE

from missionplan.diagnosis.dives.forward import SubsetEffect
from missionplan.effects import CATALOGUE, effects_of
from missionplan.phases.hooks import DescentEffect
from tests.depth_readings import simulate_readings

TRIALS = np.array([1, 4])
TIMES = np.tile(np.linspace(0.0, 15.0, 61)[:, None], (1, 5))


def parameters(info, strength_on):
    """Plausible parameters; strengths are zero outside the trials, where they are not left out."""
    values = {}
    for name, parameter in info.parameters.items():
        if parameter.is_shape:
            values[name] = parameter.default if parameter.default is not None else parameter.median
        else:
            strength = np.zeros(5)
            strength[TRIALS] = 0.5 * parameter.scale
            values[name] = strength[strength_on]
    return values


@pytest.mark.parametrize("name", [info.id for info in effects_of("descent")])
def test_outside_the_subset_an_effect_has_zero_strength(name):
    info = CATALOGUE[name]
    dive = replace(DIVE, wet_weight=np.linspace(9.0, 14.0, 5))
    everywhere = info.make(parameters(info, slice(None)))
    subset = SubsetEffect(info.make(parameters(info, TRIALS)), TRIALS, 5)
    found = simulate_readings(dive, TIMES, effects=(subset,), step=0.1)
    np.testing.assert_allclose(found, simulate_readings(dive, TIMES, effects=(everywhere,), step=0.1), atol=1e-9)
    plain = simulate_readings(dive, TIMES, step=0.1)
    assert np.abs(found - plain)[:, TRIALS].max(axis=0).min() > 1e-4
    np.testing.assert_allclose(found[:, [0, 2, 3]], plain[:, [0, 2, 3]], atol=1e-9)


def test_refines_what_its_effect_refines():
    subset = SubsetEffect(CATALOGUE["added-mass"].make({"fraction": np.array([0.1])}), np.array([0]), 2)
    assert subset.refines("mass_factor")
    assert not subset.refines("lift")
    assert not DescentEffect().refines("mass_factor")
