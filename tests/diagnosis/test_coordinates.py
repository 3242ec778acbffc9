"""Parameters to coordinates and back."""

import numpy as np
import pytest

from missionplan.diagnosis.coordinates import coordinates_of, estimates, is_possible, parameters_from
from missionplan.effects import CATALOGUE
from missionplan.effects.oscillation import MODULATION_PARAMETERS


@pytest.mark.parametrize("info", CATALOGUE.values(), ids=lambda info: info.id)
def test_centre_is_the_neutral_effect_with_its_usual_shape(info):
    coordinates = coordinates_of(info)
    parameters = parameters_from(coordinates, [coordinate.centre for coordinate in coordinates])[info.id]
    for name, parameter in info.parameters.items():
        if info.is_modulated and name in MODULATION_PARAMETERS:
            continue  # random: a hyperparameter
        expected = parameter.median if parameter.is_shape else 0.0
        assert parameters[name] == pytest.approx(expected)


def test_amplitude_and_phase_come_from_cosine_and_sine():
    coordinates = coordinates_of(CATALOGUE["inertial-current"])
    assert [coordinate.kind for coordinate in coordinates] == ["cosine", "sine"]
    parameters = parameters_from(coordinates, [0.3, 0.4])["inertial-current"]
    assert parameters["amplitude"] == pytest.approx(0.5)
    assert parameters["phase"] == pytest.approx(np.arctan2(0.4, 0.3))


def test_polar_estimate_propagates_linearly():
    coordinates = coordinates_of(CATALOGUE["inertial-current"])
    amplitude, phase = estimates(coordinates, np.array([0.5, 0.0]), np.diag([0.01**2, 0.02**2]))
    assert (amplitude.name, amplitude.value, amplitude.sd) == ("amplitude", 0.5, pytest.approx(0.01))
    assert (phase.name, phase.value, phase.sd) == ("phase", 0.0, pytest.approx(0.04))


def test_shape_has_a_log_normal_interval():
    info = CATALOGUE["slow-flooding"]
    coordinates = coordinates_of(info)
    found = {e.name: e for e in estimates(coordinates, np.array([0.3, np.log(5.0)]), np.diag([0.01**2, 0.2**2]))}
    assert found["time"].value == pytest.approx(5.0)
    assert found["time"].low * found["time"].high == pytest.approx(25.0)


@pytest.mark.parametrize(("value", "possible"), [(0.2, True), (-0.2, False), (6.0, False)])
def test_wrong_sign_or_size_is_not_the_effect(value, possible):
    coordinates = coordinates_of(CATALOGUE["line-payout"])
    assert is_possible(estimates(coordinates, np.array([value]), np.array([[1e-4]]))) is possible


def test_an_unknown_phase_is_as_unsure_as_an_angle_can_be():
    coordinates = coordinates_of(CATALOGUE["inertial-current"])
    _, phase = estimates(coordinates, np.array([1e-5, 0.0]), 0.02**2 * np.eye(2))
    assert phase.sd == pytest.approx(np.std(np.linspace(-np.pi, np.pi, 100_001)), rel=1e-4)
