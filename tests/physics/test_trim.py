"""Trim of a submerged vehicle."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics.anchor_remedies import Weight, trim

BUOYANCY = Weight(100.9, 0.56, 0.0)


def test_centres_one_above_the_other_lie_level():
    state = trim("alone", (Weight(100.0, 0.56, 0.005),), BUOYANCY)
    assert state.pitch == pytest.approx(0.0)
    assert state.verdict == "level"
    assert state.net_force == pytest.approx(0.9)


@pytest.mark.parametrize(("ahead", "verdict"), [(0.004, "nose-heavy"), (-0.004, "tail-heavy"), (0.0001, "level")])
def test_the_centre_of_gravity_hangs_below_that_of_buoyancy(ahead, verdict):
    state = trim("alone", (Weight(100.0, 0.56 - ahead, 0.005),), BUOYANCY)
    assert math.tan(state.pitch) == pytest.approx(ahead / 0.005)
    assert state.verdict == verdict


def test_a_flooded_anchor_on_the_nose_puts_it_down():
    state = trim("flooded", (Weight(100.0, 0.56, 0.005), Weight(11.8, -0.05, 0.0)), BUOYANCY)
    assert state.moment == pytest.approx(11.8 * 0.61)
    assert math.degrees(state.pitch) > 80.0
    assert state.net_force == pytest.approx(-10.9)


def test_a_vehicle_with_its_weight_on_top_turns_over():
    state = trim("alone", (Weight(100.0, 0.56, -0.005),), BUOYANCY)
    assert state.pitch is None
    assert "turns over" in state.verdict


def test_centres_that_are_not_known_give_no_pitch():
    assert "not known" in trim("alone", (Weight(100.0, 0.56, 0.0),), BUOYANCY, centres_known=False).verdict


@given(st.floats(0.3, 0.8), st.floats(0.001, 0.03), st.floats(-0.5, 1.0))
def test_where_the_nose_is_counted_from_does_not_matter(aft, below, shift):
    weights, buoyancy = (Weight(100.0, aft, below),), Weight(101.0, 0.5, 0.0)
    moved = trim("moved", (Weight(100.0, aft + shift, below),), Weight(101.0, 0.5 + shift, 0.0))
    assert trim("here", weights, buoyancy).pitch == pytest.approx(moved.pitch, abs=1e-9)
