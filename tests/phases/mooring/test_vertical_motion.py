"""The integrator of descents and ascents on forces whose motion has a closed form."""

from dataclasses import dataclass

import numpy as np
import pytest

from missionplan.arrays import Array
from missionplan.phases.mooring.motion import Integration, Stop, integrate_stage


@dataclass(frozen=True)
class Spring:
    """Pulled toward a depth of neutral buoyancy, in water that moves."""

    omega: float
    neutral: float
    water_velocity: float = 0.0

    def acceleration(self, t: float, depth: Array, speed: Array) -> Array:
        return -(self.omega**2) * (depth - self.neutral)


@dataclass(frozen=True)
class SwitchedPush:
    """Pushed up until a time, down afterwards."""

    until: float
    push: float
    water_velocity: float = 0.0

    def acceleration(self, t: float, depth: Array, speed: Array) -> Array:
        return np.full_like(depth, -self.push if t < self.until else self.push)


def deepest_error(step: float, water: float) -> float:
    """Error of the depth after 8 s of an oscillation; the water carries its centre along."""
    omega, neutral, start = 0.9, 40.0, 30.0
    found = integrate_stage(
        Spring(omega, neutral, water), np.array([start]), np.array([0.0]), Stop(), Integration(8.0, step, keep=True)
    )
    # z'' = -ω²(z - neutral) with z'(0) = w
    t = step * (len(found.depths) - 1)
    exact = neutral + (start - neutral) * np.cos(omega * t) + water / omega * np.sin(omega * t)
    return float(abs(found.depths[-1, 0] - exact))


@pytest.mark.parametrize("water", [0.0, 0.3])
def test_a_force_that_depends_on_depth_is_integrated_to_fourth_order(water):
    coarse, fine = deepest_error(0.4, water), deepest_error(0.2, water)
    assert 12.0 < coarse / fine < 21.0


def test_nothing_rises_out_of_the_water_and_what_waits_at_the_surface_gathers_no_speed():
    found = integrate_stage(
        SwitchedPush(5.0, 0.5), np.array([0.3]), np.array([0.1]), Stop(), Integration(9.0, 0.1, keep=True)
    )
    t = 0.1 * np.arange(len(found.depths))
    assert np.all(found.depths >= 0.0)
    waiting = (t > 2.0) & (t <= 5.0)
    assert np.all(found.depths[waiting] == 0.0)
    # within the steps in which the push turns
    assert found.depths[-1, 0] == pytest.approx(0.25 * (9.0 - 5.0) ** 2, abs=0.25)


def test_at_the_surface_of_rising_water_the_vehicle_stays_with_the_surface():
    found = integrate_stage(
        SwitchedPush(100.0, 0.2, -0.3), np.array([1.0]), np.array([0.0]), Stop(), Integration(20.0, 0.1, keep=True)
    )
    assert np.all(found.depths >= 0.0)
    assert found.depths[-1, 0] == 0.0
    assert found.speed[0] == pytest.approx(0.3)
    assert found.rates[-1, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_stage_ends_where_its_closed_form_crosses():
    found = integrate_stage(
        Spring(0.5, 20.0), np.array([10.0]), np.array([0.0]), Stop(deepest=20.0), Integration(20.0, 0.05)
    )
    assert found.ended.all()
    assert found.time[0] == pytest.approx(np.pi / 2.0 / 0.5, abs=1e-5)
    assert found.depth[0] == pytest.approx(20.0, abs=1e-6)
    assert found.speed[0] == pytest.approx(0.5 * 10.0, abs=1e-5)
