"""An anchor on the seafloor: friction, slope, and the current near the bed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from missionplan.physics.seafloor import (
    LyingAnchor,
    Slope,
    anchor_drag_on_bed,
    holding_margin,
    lateral_coefficient,
    least_weight,
    near_bed_share,
)

ANCHOR = LyingAnchor(11.8, 0.12065, 0.183, friction=0.5)
NO_DRAG = np.zeros((2, 1))
LEVEL = Slope()


def pull(east, north, up):
    return np.array([[east], [north], [up]], dtype=float)


def test_on_level_ground_the_margin_is_the_weight_to_spare():
    assert holding_margin(ANCHOR, pull(0, 0, 0), NO_DRAG, LEVEL) == pytest.approx([1.0])
    assert holding_margin(ANCHOR, pull(2.0, 0.0, 0.8), NO_DRAG, LEVEL) == pytest.approx([1 - (0.8 + 2.0 / 0.5) / 11.8])
    drag = np.array([[0.0], [1.5]])
    assert holding_margin(ANCHOR, pull(2.0, 0.0, 0.8), drag, LEVEL) == pytest.approx([1 - (0.8 + 2.5 / 0.5) / 11.8])
    for along in (0.7, -0.7):  # the current drags the anchor the way that the line pulls, or the other
        drag = np.array([[along], [0.0]])
        expected = 1 - (0.8 + (2.0 + along) / 0.5) / 11.8
        assert holding_margin(ANCHOR, pull(2.0, 0.0, 0.8), drag, LEVEL) == pytest.approx([expected])


def test_on_a_slope_an_anchor_slides_beyond_the_friction_angle():
    for angle, holds in ((np.arctan(0.49), True), (np.arctan(0.51), False)):
        slope = Slope(angle, 1.0)
        assert (holding_margin(ANCHOR, pull(0, 0, 0), NO_DRAG, slope)[0] > 0.0) == holds
        assert np.isfinite(least_weight(0.5, pull(0, 0, 0), NO_DRAG, slope)[0]) == holds


def test_a_pull_downhill_is_worse_than_one_uphill():
    slope = Slope(0.1, 0.5 * np.pi)  # falls to the east
    down, up = (holding_margin(ANCHOR, pull(side * 1.0, 0, 0.5), NO_DRAG, slope)[0] for side in (1, -1))
    assert down < up


@given(
    st.floats(-20, 20), st.floats(-20, 20), st.floats(0, 5), st.floats(0.1, 1.0), st.floats(0, 0.09), st.floats(0, 6.3)
)
def test_with_the_least_weight_the_margin_is_nil(east, north, up, friction, angle, toward):
    slope, load = Slope(angle, toward), pull(east, north, up)
    weight = least_weight(friction, load, NO_DRAG, slope)
    if weight[0] > 1e-6:
        margin = holding_margin(LyingAnchor(weight, 0.12, 0.18, friction), load, NO_DRAG, slope)
        assert margin * weight == pytest.approx([0.0], abs=1e-6 * (1.0 + weight[0]))


def test_the_seafloor_falls_away_downhill():
    slope = Slope(np.radians(10.0), 0.0)
    assert slope.fall(np.array([[3.0, 3.0], [5.0, -5.0]])) == pytest.approx(
        5.0 * np.tan(np.radians(10.0)) * np.array([1, -1])
    )


@given(height=st.floats(0.001, 1.0), roughness=st.floats(1e-5, 5e-3))
def test_the_share_near_the_bed_is_the_integral_of_the_logarithmic_layer(height, roughness):
    def square(z):
        return (np.log(z / roughness) / np.log(1.0 / roughness)) ** 2

    expected = quad(square, roughness, height)[0] if height > roughness else 0.0
    assert near_bed_share(height, roughness) * height == pytest.approx(expected, rel=1e-5, abs=1e-12)


def test_the_anchor_meets_less_than_half_of_the_force_of_the_free_current():
    assert near_bed_share(0.12065) == pytest.approx(0.40, abs=0.02)
    velocity = np.array([[0.9], [0.0]])
    drag = anchor_drag_on_bed(ANCHOR, velocity, 1009.5)
    free = 0.5 * 1009.5 * 0.12065 * 0.183 * 0.9**2 * 0.66
    assert drag[0, 0] == pytest.approx(free * near_bed_share(0.12065), rel=0.01)


def test_short_cylinders_have_less_drag():
    assert lateral_coefficient(1.0) == pytest.approx(0.64)
    assert lateral_coefficient(40.0) == pytest.approx(0.98)
    assert 0.64 < lateral_coefficient(1.52) < 0.68
