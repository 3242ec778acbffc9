import numpy as np
import pytest

from missionplan.phases.currents import layers
from missionplan.phases.hooks import DescentEffect, TransitEffect, TrialState
from missionplan.phases.mooring import MoorPlan, moor
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.hold import Hold
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.physics.drag import QuadraticDrag
from missionplan.physics.held_line import HeldBody, HeldLine
from missionplan.physics.seafloor import LyingAnchor

N = 40
DIVE = Dive(
    wet_weight=11.8,
    anchor_mass=2.8,
    anchor_added_mass=0.5,
    anchor_drag=QuadraticDrag(1.15),
    vehicle_mass=10.2,
    vehicle_added_mass=0.25,
    net_buoyancy=0.9,
    vehicle_drag=QuadraticDrag(3.3),
    line_length=5.0,
    site_depth=12.2,
)
HELD = Hold(
    HeldBody(1.2, 0.12, 0.9, 0.5 * 1.2 * 0.9, 0.0, 1.1, QuadraticDrag(3.3), 1025.0),
    HeldLine(5.0),
    LyingAnchor(11.8, 0.12, 0.2),
    12.2,
)
PLAN = MoorPlan(DIVE, HELD, 20.0, 10.0, 1800.0, 90.0, hotel_power=8.0, surfacing_energy=50.0)
NONE = np.zeros((2, N))


def state(**changes):
    start = TrialState.at(np.array([100.0, -50.0]), N)
    return TrialState(**{**vars(start), "clock": np.full(N, 500.0), "energy": np.full(N, 7.0), **changes})


def still(speed=0.0):
    return layers([50.0], [speed], [np.pi / 2])


def test_time_and_energy_add_up():
    after, record = moor(PLAN, state(), NONE, still())
    expected = 10.0 + record.descent.descent_time + 1200.0 + 600.0 + record.ascent_time + 90.0
    assert record.duration == pytest.approx(expected, rel=1e-12)
    assert after.clock == pytest.approx(500.0 + expected, rel=1e-12)
    assert record.energy == pytest.approx(8.0 * expected + 50.0, rel=1e-12)
    assert after.energy == pytest.approx(7.0 + record.energy, rel=1e-12)


def test_in_still_water_it_comes_up_where_it_went_down():
    after, record = moor(PLAN, state(), NONE, still())
    assert np.array_equal(after.position, state().position)
    assert np.array_equal(after.fix, after.position)
    assert np.all(record.offset_distance == 0.0)
    assert record.within_radius.all()
    assert after.alive.all()


def test_the_current_carries_it_down_up_and_at_the_surface():
    after, record = moor(PLAN, state(), NONE, still(0.2))
    sinking = 10.0 + record.descent.descent_time
    assert record.anchor[0] == pytest.approx(100.0 + 0.2 * sinking, rel=1e-9)
    assert record.offset[0] == pytest.approx(0.2 * sinking, rel=1e-9)
    standing = record.hold.parted_from
    assert standing[0] == pytest.approx(record.hold.excursion)
    assert np.all(standing[0] > 3.0)
    assert record.surfaced_at[0] == pytest.approx(record.anchor[0] + standing[0] + 0.2 * record.ascent_time, rel=1e-9)
    assert after.position[0] == pytest.approx(record.surfaced_at[0] + 0.2 * 90.0, rel=1e-9)


def test_moving_everything_moves_nothing_else():
    shift = np.array([[30.0], [-400.0]])
    near, far = state(), state(position=state().position + shift, fix=state().fix + shift)
    (one, first), (two, second) = (moor(PLAN, begin, NONE, still(0.2)) for begin in (near, far))
    assert two.position == pytest.approx(one.position + shift)
    assert second.offset == pytest.approx(first.offset)


def test_the_offset_counts_from_the_fix():
    error = np.array([[3.0], [-4.0]]) * np.ones(N)
    _, record = moor(PLAN, state(fix=state().position + error), NONE, still())
    assert record.offset == pytest.approx(-error)
    assert record.offset_distance == pytest.approx(5.0)


def test_the_fix_after_the_ascent_errs():
    normals = np.random.default_rng(1).standard_normal((2, N))
    plan = MoorPlan(**{**vars(PLAN), "fix_error": 3.0})
    after, _ = moor(plan, state(), normals, still())
    assert after.fix - after.position == pytest.approx(3.0 * normals)


class Wind(TransitEffect):
    def surface_velocity(self, t, duration, position):
        return np.stack([np.zeros(t.size), np.full(t.size, 0.1)])


def test_what_drifts_at_the_surface_acts_before_release_and_after_the_ascent():
    after, record = moor(PLAN, state(), NONE, still(), surface_effects=[Wind()])
    assert record.offset[1] == pytest.approx(0.1 * 10.0)
    assert after.position[1] == pytest.approx(-50.0 + 0.1 * (10.0 + 90.0))


def test_numbers_may_differ_between_trials():
    hold = np.linspace(0.0, 3600.0, N)
    plan = MoorPlan(**{**vars(PLAN), "moored_time": 600.0 + hold, "radius": np.where(hold > 1800.0, 1.0, 20.0)})
    _, record = moor(plan, state(), NONE, still(0.2))
    assert np.diff(record.duration) == pytest.approx(np.diff(hold))
    assert np.array_equal(record.within_radius, hold <= 1800.0)


def test_what_had_failed_before_stays_where_it_was():
    alive = np.arange(N) % 2 == 0
    after, _ = moor(PLAN, state(alive=alive), NONE, still(0.2))
    assert np.array_equal(after.alive, alive)
    assert np.all(after.position[0, ~alive] == 100.0)
    assert np.all(after.clock[~alive] == 500.0)


def test_an_anchor_too_light_never_moors():
    light = Dive(**{**vars(DIVE), "wet_weight": 0.5})
    after, record = moor(MoorPlan(**{**vars(PLAN), "dive": light}), state(), NONE, still())
    assert not record.descent.touched_down.any()
    assert not after.alive.any()
    assert np.isnan(record.duration).all()
    assert not record.within_radius.any()


def test_a_vehicle_without_buoyancy_does_not_come_up():
    heavy = Dive(**{**vars(DIVE), "net_buoyancy": -0.5})
    after, record = moor(MoorPlan(**{**vars(PLAN), "dive": heavy}), state(), NONE, still())
    assert record.descent.touched_down.all()
    assert not record.surfaced.any()
    assert not after.alive.any()


def test_a_vehicle_that_strikes_the_seafloor_surfaces_too():
    short = Dive(**{**vars(DIVE), "line_length": 1.0})
    after, record = moor(MoorPlan(**{**vars(PLAN), "dive": short}), state(), NONE, still())
    assert record.struck.all()
    assert after.alive.all()


class TautClock(DescentEffect):
    """Records the times since the taut line at which the vehicle's drag is computed."""

    def __init__(self) -> None:
        self.times: list[np.ndarray] = []

    def drag_factor(self, since_taut, speed):
        self.times.append(np.broadcast_to(since_taut, (N,)).copy())
        return 1.0


def test_the_ascent_goes_on_counting_from_the_taut_line():
    clock = TautClock()
    _, record = moor(PLAN, state(), NONE, still(), effects=[clock])
    times = np.array(clock.times)
    first_of_ascent = times[times[:, 0] > 1000.0].min(axis=0)
    expected = record.descent.descent_time - record.descent.payout_time + 1200.0 + 600.0
    assert first_of_ascent == pytest.approx(expected)


def test_at_the_surface_it_drifts_with_the_current_of_that_time():
    """A current to the east that grows by 0.1 m/s an hour: its mean over the 90 s before the fix, which is of their middle."""
    time = np.array([0.0, 36_000.0])
    growing = SeriesCurrent(time, np.array([0.0]), np.array([[0.0], [1.0]]), np.zeros((2, 1)))
    after, record = moor(PLAN, state(), NONE, growing)
    middle = after.clock - 45.0
    assert (after.position - record.surfaced_at)[0] == pytest.approx(90.0 * middle / 36_000.0, rel=1e-9)
