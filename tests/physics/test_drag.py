import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import drag
from missionplan.physics.drag import (
    Hull,
    QuadraticDrag,
    Sail,
    VehicleDrag,
    anchor_drag,
    range_notes,
    terminal_velocity,
)
from missionplan.physics.water import Water

INCH = 0.0254
WATER = Water(1026.02, 1.1892e-6)
PROTOTYPE = VehicleDrag(Hull(44 * INCH, 4.75 * INCH), Sail(4 * INCH, 4 * INCH, 0.6 * INCH), 1.25, WATER)
ANCHOR = anchor_drag(4.75 * INCH, 0.2, WATER.density)
speeds = st.floats(1e-4, 20.0)


def test_published_intermediate_values_at_1_6_m_s():
    reynolds = drag.reynolds_number(1.6, 44 * INCH, 1.189e-6)
    assert reynolds == pytest.approx(1.504e6, rel=1e-3)
    assert drag.friction_coefficient(reynolds) == pytest.approx(0.004298, abs=5e-7)
    factor = drag.form_factor(44 * INCH, 4.75 * INCH)
    assert factor == pytest.approx(2.705, abs=5e-4)
    coefficient = drag.body_drag_coefficient(drag.friction_coefficient(reynolds), factor, 44 * INCH, 4.75 * INCH)
    assert coefficient == pytest.approx(0.431, abs=5e-4)
    streamlined = drag.form_factor(44 * INCH, 4.75 * INCH, drag.FORM_CONSTANTS["hoerner"])
    assert coefficient * streamlined / factor == pytest.approx(0.169, abs=5e-4)
    assert drag.drag_force(1.6, 0.2, drag.disc_area(4.75 * INCH), 1026.0) == pytest.approx(3.00, abs=0.005)


def test_build_up_of_the_prototype():
    parts = PROTOTYPE.build_up(1.62, ANCHOR)
    assert parts.body == pytest.approx(6.614, abs=5e-4)
    assert parts.sail == pytest.approx(0.281, abs=5e-4)
    assert parts.vehicle == pytest.approx(8.619, abs=5e-4)
    assert parts.anchor == pytest.approx(3.078, abs=5e-4)
    assert parts.total == pytest.approx(11.697, abs=5e-4)


def test_friction_is_held_below_ten_thousand():
    held = drag.friction_coefficient(1e4)
    assert held == pytest.approx(0.075 / 4.0)
    assert drag.friction_coefficient(np.array([0.0, 100.0, 9999.0])) == pytest.approx(held)


@given(speeds)
def test_one_logarithm_gives_the_plain_equations(speed):
    plain = (PROTOTYPE.body(speed) + PROTOTYPE.sail_drag(speed)) * PROTOTYPE.appendage_factor
    assert PROTOTYPE(speed) == pytest.approx(plain, rel=1e-12)


@given(speeds)
def test_drag_is_odd_in_speed(speed):
    assert PROTOTYPE(-speed) == -PROTOTYPE(speed)
    assert ANCHOR(-speed) == -ANCHOR(speed)


@given(speeds, st.floats(1.01, 3.0))
def test_drag_rises_with_speed_and_slower_than_its_square(speed, factor):
    ratio = PROTOTYPE(speed * factor) / PROTOTYPE(speed)
    assert factor**1.5 < ratio <= factor**2 * (1 + 1e-12)


def test_rest_has_no_drag():
    assert PROTOTYPE(0.0) == 0.0


def test_without_sail_only_the_body_is_left():
    bare = VehicleDrag(PROTOTYPE.hull, None, 1.0, WATER)
    assert bare(1.5) == pytest.approx(bare.body(1.5))
    assert bare.build_up(1.5, ANCHOR).sail == 0.0


@given(st.floats(1e-3, 500.0))
def test_terminal_velocity_balances_the_weight(weight):
    v = terminal_velocity(lambda speed: PROTOTYPE(speed) + ANCHOR(speed), weight)
    assert PROTOTYPE(v) + ANCHOR(v) == pytest.approx(weight, rel=1e-10)


def test_terminal_velocity_over_trials_and_without_weight():
    v = terminal_velocity(QuadraticDrag(np.array([1.0, 4.0, 1.0])), np.array([4.0, 4.0, -1.0]))
    assert v == pytest.approx([2.0, 1.0, 0.0])


def test_parameters_may_be_arrays_over_trials():
    lengths = np.array([1.0, 1.1176, 2.0])
    law = VehicleDrag(Hull(lengths, 4.75 * INCH), PROTOTYPE.sail, 1.25, WATER)
    single = [VehicleDrag(Hull(length, 4.75 * INCH), PROTOTYPE.sail, 1.25, WATER)(1.2) for length in lengths]
    assert law(1.2) == pytest.approx(single)


def test_ranges_are_reported():
    notes = range_notes(PROTOTYPE, 1.62, 1.515)
    assert len(notes) == 2
    assert "sail" in notes[0]
    assert "1.5" in notes[1]
    bare = VehicleDrag(PROTOTYPE.hull, None, 1.25, WATER)
    assert range_notes(bare, 1.62, 3.0) == ()
    assert range_notes(bare, 1.62, 2.0) == range_notes(bare, 1.62, 10.0) == ()  # Hoerner's range includes its ends
    assert "beyond" in range_notes(VehicleDrag(Hull(400.0, 40.0), None, 1.0, WATER), 50.0)[0]
    assert range_notes(VehicleDrag(Hull(400.0, 40.0), None, 1.0, WATER), 25.0) == ()  # Re = 8.4e9
