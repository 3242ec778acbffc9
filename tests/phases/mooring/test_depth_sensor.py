"""Readings of a depth sensor: stages, effects of the sensor and of its clock, the rise to the mooring."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from missionplan.arrays import Scalars
from missionplan.effects.dive_forces import VerticalCurrent
from missionplan.effects.dive_log import ClockOffset, DepthScale, SensorLag
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.forces import Dive
from missionplan.physics.drag import Hull, QuadraticDrag, VehicleDrag
from missionplan.physics.water import Water
from tests.depth_readings import simulate_readings

DIVE = Dive(
    wet_weight=11.7,
    anchor_mass=2.8,
    anchor_added_mass=0.54,
    anchor_drag=QuadraticDrag(1.17),
    vehicle_mass=10.2,
    vehicle_added_mass=0.24,
    net_buoyancy=0.89,
    vehicle_drag=VehicleDrag(Hull(1.1176, 0.12065), None, 1.25, Water(1026.0, 1.19e-6)),
    line_length=5.0,
    site_depth=24.0,
)
TIMES = np.linspace(0.0, 40.0, 161)[:, None]


def test_a_dive_from_the_surface_to_the_mooring():
    depth = simulate_readings(DIVE, TIMES)[:, 0]
    assert (depth[TIMES[:, 0] < 2.0] == 0.0).all()
    assert depth.max() < 24.0
    assert depth[-1] == pytest.approx(19.0)
    assert np.argmax(depth) < len(depth) - 20


def test_the_step_is_fine_enough_for_a_millimetre():
    coarse, fine = (simulate_readings(DIVE, TIMES, step=step) for step in (0.1, 0.01))
    assert coarse == pytest.approx(fine, abs=1.5e-3)


def test_each_trial_has_its_own_dive_and_times():
    dive = replace(
        DIVE, wet_weight=np.array([9.0, 15.0]), line_length=np.array([4.0, 6.0]), site_depth=np.array([20, 30.0])
    )
    times = np.stack((np.linspace(0, 12, 30), np.linspace(1, 8, 30)), axis=1)
    times[20:, 1] = np.nan
    both = simulate_readings(dive, times)
    assert np.isnan(both[20:, 1]).all()
    for trial, rows in ((0, 30), (1, 20)):
        own = replace(
            dive, **{name: float(getattr(dive, name)[trial]) for name in ("wet_weight", "line_length", "site_depth")}
        )
        alone = simulate_readings(own, times[:rows, trial : trial + 1])
        assert both[:rows, trial] == pytest.approx(alone[:, 0], abs=1e-9)


def test_times_that_end_early_give_the_same_depths():
    whole = simulate_readings(DIVE, TIMES)
    assert simulate_readings(DIVE, TIMES[:40]) == pytest.approx(whole[:40], abs=1e-9)


def test_a_clock_shifts_and_a_scale_stretches():
    plain = simulate_readings(DIVE, TIMES)
    late = simulate_readings(DIVE, TIMES + 0.5, effects=(ClockOffset(0.5),))
    assert late == pytest.approx(plain, abs=1e-9)
    assert simulate_readings(DIVE, TIMES, effects=(DepthScale(0.05),)) == pytest.approx(1.05 * plain)


def test_a_lag_is_late_by_its_time_constant_at_a_steady_speed():
    steady = np.array([[8.0], [9.0], [10.0], [11.0]])
    lagged = simulate_readings(DIVE, steady, effects=(SensorLag(0.4),))
    assert lagged == pytest.approx(simulate_readings(DIVE, steady - 0.4), abs=5e-3)


def test_the_seafloor_stops_a_vehicle_that_strikes_it():
    depth = simulate_readings(replace(DIVE, line_length=2.0), TIMES)[:, 0]
    assert depth.max() == 24.0
    assert depth[-1] == pytest.approx(22.0)


@dataclass(frozen=True)
class SlowAtFirst(DescentEffect):
    """Four times the drag for some time after the line is taut."""

    lasts: float

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        return np.where(np.asarray(since_taut) < self.lasts, 4.0, 1.0)


def test_the_rise_to_the_mooring_knows_how_long_the_line_has_been_taut():
    """Drag that is normal again before the touchdown stays so: the vehicle rises by v τ ln cosh(t/τ)."""
    dive = replace(DIVE, vehicle_drag=QuadraticDrag(3.3), line_length=12.0, site_depth=40.0)
    times = np.linspace(0.0, 70.0, 7001)[:, None]
    depth = simulate_readings(dive, times, effects=(SlowAtFirst(20.0),))[:, 0]
    lowest = np.argmax(depth)
    moored = lowest + np.argmax(depth[lowest:] <= 28.0)
    terminal = np.sqrt(0.89 / 3.3)
    tau = dive.free_mass * terminal / 0.89
    expected = tau * np.arccosh(np.exp((depth[lowest] - 28.0) / (terminal * tau)))
    assert times[moored, 0] - times[lowest, 0] == pytest.approx(expected, abs=0.1)


def test_the_rise_to_the_mooring_starts_at_rest_over_the_ground():
    """Without drag moving water changes no depth, neither on the way down nor on the way up."""
    slippery = QuadraticDrag(1e-9)
    buoyant = replace(
        DIVE, vehicle_drag=slippery, anchor_drag=slippery, net_buoyancy=5.0, line_length=10.0, site_depth=12.0
    )
    plain, carried = (simulate_readings(buoyant, TIMES, effects=effects) for effects in ((), (VerticalCurrent(0.2),)))
    assert plain.max() > 7.0
    assert plain[-1] == pytest.approx(2.0)
    assert carried == pytest.approx(plain, abs=1e-5)
