"""The propeller and vehicle of the worked example of Blanke, Lindegaard & Fossen (2000), its Tables 1 and 2."""

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from missionplan.arrays import Array
from missionplan.physics.drag import disc_area
from missionplan.physics.propeller import Propeller, Resistance, from_open_water, surge_flow_damping

Damping = Literal["surge", "momentum"]

TABLE_1_RESISTANCE = Resistance(mass=1050.0, linear=0.2, quadratic=500.0)
"""The vehicle of Table 1: 1000 kg and 5 % added mass."""


def table_1(damping: Damping = "surge") -> Propeller:
    """Propeller of Table 1, with the T° and Q° that its a = 0.25 gives.

    m_f = ρ A_p l with γ = 1 (21.74 kg) is assumed; the paper does not give γ.

    Parameters
    ----------
    damping : {"surge", "momentum"}
        Axial-flow damping by Eqs. 34 and 35, or by Eq. 12.
    """
    hull = TABLE_1_RESISTANCE
    paper = {"axial_flow_factor": 0.25, "wake_fraction": 0.2, "thrust_deduction": 0.1}
    flow_damping = (
        surge_flow_damping(float(hull.linear), float(hull.quadratic), **paper) if damping == "surge" else None
    )
    return from_open_water(
        0.30,
        (0.4243, -0.9435),
        (0.0626, -0.1212),
        density=1025.0,
        shaft_inertia=1.0,
        flow_mass=1025.0 * float(disc_area(0.30)) * 0.30,
        flow_damping=flow_damping,
        **paper,
    )


def as_printed(damping: Damping = "surge") -> Propeller:
    """Propeller with the constants of Table 2, whose T° and Q° are those of a = 0.1, not of Table 1's a."""
    turn = 2.0 * math.pi
    return replace(
        table_1(damping),
        thrust_nn=3.523 / turn**2,
        thrust_nu=-23.74 / turn,
        torque_nn=0.1559 / turn**2,
        torque_nu=-0.9148 / turn,
    )


def eq_36_torque(time_step: float, final_time: float = 100.0) -> Array:
    """Motor torque of the paper's simulation [N m]: 5, -5 and 2.5 N m; t_f = 100 s is assumed."""
    time = time_step * (np.arange(round(final_time / time_step)) + 0.5)
    return np.select([time <= 0.3 * final_time, time <= 0.6 * final_time], [5.0, -5.0], 2.5)
