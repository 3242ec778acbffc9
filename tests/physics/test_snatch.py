import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from missionplan.physics.vehicle_dynamics import mass_at_nose, peak_tension


def test_a_uniform_rod_weighs_a_quarter_at_its_end():
    assert mass_at_nose(20.0, 1.1) == pytest.approx(5.0)


@given(st.floats(1.0, 100.0), st.floats(0.3, 5.0), st.floats(0.0, 1.0))
def test_the_mass_at_the_nose_is_less_the_further_the_centre(mass, length, share):
    near, far = (mass_at_nose(mass, length, place * length) for place in (0.9 * share, share))
    assert 0.0 < far <= near <= mass


def test_mass_at_the_nose_by_a_pull_on_a_rod():
    """Of a rod of 20 kg and 1.2 m, centre of mass at 0.5 m: the acceleration of its end under a newton, part by part."""
    mass, length, centre = 20.0, 1.2, 0.5
    turning = centre / (mass * length**2 / 12.0)
    acceleration = 1.0 / mass + turning * centre
    assert mass_at_nose(mass, length, centre) == pytest.approx(1.0 / acceleration)


@given(st.floats(200.0, 1e5), st.floats(0.1, 5.0), st.floats(1.0, 20.0), st.floats(1.0, 50.0), st.floats(-5.0, 20.0))
def test_without_forces_energy_of_the_motion_apart_becomes_that_of_the_spring(stiffness, speed, anchor, vehicle, pull):
    tension = peak_tension(stiffness, speed, (anchor, vehicle), pull)
    stretch = tension / stiffness
    reduced = anchor * vehicle / (anchor + vehicle)
    work = reduced * pull / anchor * stretch
    assert 0.5 * stiffness * stretch**2 == pytest.approx(0.5 * reduced * speed**2 + work, rel=1e-9)


def test_against_an_integration_of_both_bodies():
    stiffness, anchor, vehicle, pull, resistance = 1e4, 3.33, 5.0, 8.0, 0.9

    def motion(_, y):
        tension = stiffness * max(y[0] - y[1], 0.0)
        return [y[2], y[3], (pull - tension) / anchor, (tension - resistance) / vehicle]

    found = solve_ivp(motion, (0.0, 0.06), [0.0, 0.0, 2.97, 0.0], rtol=1e-9, atol=1e-12, max_step=1e-4)
    peak = stiffness * np.max(found.y[0] - found.y[1])
    assert peak_tension(stiffness, 2.97, (anchor, vehicle), pull, resistance) == pytest.approx(peak, rel=1e-5)
    assert 400.0 < peak < 500.0


def test_a_rigid_line_bears_without_bound_and_a_soft_one_hardly():
    loads = peak_tension(np.array([1e2, 1e4, 1e6]), 3.0, (3.3, 5.0), 8.0)
    assert loads[0] < 60.0
    assert loads[2] / loads[1] == pytest.approx(10.0, rel=0.02)
