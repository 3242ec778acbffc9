import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics.anchor import (
    layer_thicknesses,
    required_terminal_velocity,
    required_terminal_velocity_vector,
)

FOOT = 0.3048


def test_prototype_needs_1_62_m_s():
    layers = layer_thicknesses(np.array([50.0, 100.0]) * FOOT, 100 * FOOT)
    assert required_terminal_velocity(np.array([1.3, 1.13]), layers, 75 * FOOT) == pytest.approx(1.62)


def test_layers_are_cut_at_the_seafloor_and_the_last_one_reaches_it():
    assert layer_thicknesses(np.array([10.0, 20.0, 30.0]), 15.0) == pytest.approx([10.0, 5.0, 0.0])
    assert layer_thicknesses(np.array([10.0, 20.0]), 50.0) == pytest.approx([10.0, 40.0])


@pytest.mark.parametrize("edges", [[], [10.0, 10.0], [-1.0, 5.0]])
def test_layers_that_make_no_column_are_refused(edges):
    with pytest.raises(ValueError, match="layer"):
        layer_thicknesses(np.array(edges), 10.0)


@given(st.lists(st.tuples(st.floats(-2, 2), st.floats(0, 7), st.floats(0.1, 50)), min_size=1, max_size=5))
def test_vector_sum_never_exceeds_the_aligned_worst_case(rows):
    speeds, toward, thicknesses = (np.array(column) for column in zip(*rows, strict=True))
    vector = required_terminal_velocity_vector(speeds, toward, thicknesses, 10.0)
    assert vector <= required_terminal_velocity(speeds, thicknesses, 10.0) * (1 + 1e-12) + 1e-15
    turned = required_terminal_velocity_vector(speeds, toward + 1.0, thicknesses, 10.0)
    assert turned == pytest.approx(vector, abs=1e-12)


def test_one_layer_and_trials_last():
    speeds = np.array([[1.0, 2.0, 3.0]])
    assert required_terminal_velocity(speeds, np.array([20.0]), 10.0) == pytest.approx([2.0, 4.0, 6.0])
