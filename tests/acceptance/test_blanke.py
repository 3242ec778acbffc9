"""Blanke, Lindegaard & Fossen (2000): the simulation of Figs. 4 and 5, at the end of each torque segment."""

from dataclasses import replace

import numpy as np
import pytest

from tests.physics import propeller_example as example

STEP = 0.02
ENDS = (1500, 3000, 5000)


@pytest.fixture(scope="module")
def run():
    return example.simulate_propulsion(
        example.table_1("surge"), example.TABLE_1_RESISTANCE, example.eq_36_torque(STEP), STEP
    )


def test_end_of_segment_values(run):
    """Axial-flow damping of Eqs. 30, 34 and 35, a = 0.25, J ω̇ = Q, shaft rate shown in rev/s; to 1 %."""
    rate = run.shaft_rate[list(ENDS)] / (2.0 * np.pi)
    np.testing.assert_allclose(rate, [6.87, -6.75, 4.68], rtol=0.01)
    np.testing.assert_allclose(run.speed[list(ENDS)], [0.431, -0.418, 0.284], rtol=0.01)
    assert run.axial_flow[ENDS[0]] == pytest.approx(0.432, rel=0.01)
    assert run.thrust[ENDS[0]] == pytest.approx(104.1, rel=0.01)


def test_end_of_first_segment_with_momentum_damping():
    """Eq. 12 in place of Eqs. 30, 34 and 35."""
    run = example.simulate_propulsion(example.table_1("momentum"), example.TABLE_1_RESISTANCE, np.full(1500, 5.0), STEP)
    assert run.shaft_rate[-1] / (2.0 * np.pi) == pytest.approx(8.59, rel=0.01)
    assert run.speed[-1] == pytest.approx(0.395, rel=0.01)
    assert run.axial_flow[-1] == pytest.approx(0.955, rel=0.01)


def test_axial_flow_settles_on_the_speed(run):
    """Fig. 4: (1 + a)(1 - w) = 1 was chosen 'to give easy comparison between u and u_p'."""
    end = ENDS[0]
    assert run.axial_flow[end] == pytest.approx(run.speed[end], rel=0.01)
    early = int(5.0 / STEP)
    assert run.axial_flow[early] > 1.3 * run.speed[early]


def test_the_literal_shaft_equation_is_two_pi_faster():
    """J_m ṅ = Q with n in rev/s, as printed: the shaft's inertia is 1/2π of that of J_m ω̇ = Q."""
    table_1 = example.table_1()
    literal = replace(table_1, shaft_inertia=table_1.shaft_inertia / (2.0 * np.pi))
    torque = np.full(5, 5.0)
    slow, fast = (
        example.simulate_propulsion(unit, example.TABLE_1_RESISTANCE, torque, 1e-3) for unit in (table_1, literal)
    )
    assert fast.shaft_rate[-1] / slow.shaft_rate[-1] == pytest.approx(2.0 * np.pi, rel=1e-3)
