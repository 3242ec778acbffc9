"""Look-ups in the field of an ocean model: packed cells, where it is good, and means along legs."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from missionplan.phases.currents import Current, Span
from missionplan.phases.ensemble import Ensemble
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.grids import RegularGrid
from missionplan.phases.mooring.motion import HorizontalDrift

NORTH, EAST = np.arange(5) * 200.0 - 400.0, np.arange(7) * 300.0
TIME, LEVELS = np.arange(6) * 900.0, np.array([0.0, 2.0, 5.0, 12.0])


def field(north, seed=3, wet=None):
    generator = np.random.default_rng(seed)
    shape = TIME.size, north.size * EAST.size, LEVELS.size
    values = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    if wet is not None:
        values[:, ~wet.ravel()] = np.nan
    bottom = np.full(shape[1], 15.0)
    return GriddedCurrent.of(TIME, RegularGrid(north, EAST), LEVELS, values, bottom)


@given(seed=st.integers(0, 1000))
def test_packed_cells_hold_the_linear_interpolation(seed):
    generator, count = np.random.default_rng(seed), 300
    t, depth = generator.uniform(-500.0, 5500.0, count), generator.uniform(0.0, 14.0, count)
    position = np.stack((generator.uniform(-200.0, 2100.0, count), generator.uniform(-500.0, 500.0, count)))
    current = field(NORTH)
    # one row out of step: it is looked up column by column
    uneven = field(np.append(NORTH[:-1], NORTH[-1] + 1e6))
    inside = position[1] <= NORTH[-2]
    for deep in (depth, 3.0):
        packed, plain = (each.velocity(t, deep, position)[:, inside] for each in (current, uneven))
        assert current._lattice(deep) is not None
        assert uneven._lattice(deep) is None
        np.testing.assert_allclose(packed, plain, atol=3e-6)


def test_each_depth_has_a_slice_of_its_own():
    """One depth for all places, however near the one before, is each place's depth looked up alone; also asked anew."""
    even, uneven = field(NORTH), field(np.append(NORTH[:-1], NORTH[-1] + 1e6))
    place = np.stack((np.linspace(10.0, 1700.0, 9), np.linspace(-350.0, 150.0, 9)))
    for current in (even, uneven):
        for depth in (3.0, 3.04, 3.4, 2.96, 3.0, 0.004, 0.0, 11.996, *np.linspace(1.0, 1.3, 40), 3.04):
            alike, each = (current.velocity(1000.0, deep, place) for deep in (depth, np.full(9, depth)))
            np.testing.assert_allclose(alike, each, atol=3e-6)


def test_cells_beside_land_are_judged_by_their_columns():
    wet = np.ones((NORTH.size, EAST.size), dtype=bool)
    wet[:, 4:] = False
    current = field(NORTH, wet=wet)
    places = np.array([[100.0, 1000.0, 1040.0, 1060.0, 1500.0, -1.0, 100.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    depth = np.array([3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 16.0])
    good = current.covers(Span(np.zeros(7), np.full(7, 60.0), depth, (places, places)))
    assert good.tolist() == [True, True, True, False, False, False, False]


@given(seed=st.integers(0, 10_000), spread=st.sampled_from([50.0, 500.0, 3000.0]))
def test_places_are_good_together_where_each_is_good_alone(seed, spread):
    generator = np.random.default_rng(seed)
    wet = generator.random((NORTH.size, EAST.size)) < 0.8
    wet[0, 0] = True
    water = field(NORTH, wet=wet)._water
    middle = np.array([[generator.uniform(0.0, 1800.0)], [generator.uniform(-400.0, 400.0)]])
    places = middle + spread * generator.uniform(-0.5, 0.5, (2, 20))
    depth = generator.uniform(10.0, 15.5, 20)
    together = np.broadcast_to(water.is_good(places, 60.0, depth), 20)
    assert together.tolist() == [
        bool(water.is_good(places[:, [trial]], 60.0, depth[[trial]])[0]) for trial in range(20)
    ]
    assert together.tolist() == water._is_good_by_columns(places, 60.0, depth).tolist()


@given(seed=st.integers(0, 10_000), spread=st.sampled_from([50.0, 500.0]), last=st.sampled_from([4400.0, 4700.0]))
def test_spans_are_covered_together_where_each_is_covered_alone(seed, spread, last):
    generator, count = np.random.default_rng(seed), 20
    wet = generator.random((NORTH.size, EAST.size)) < 0.9
    wet[0, 0] = True
    current = field(NORTH, wet=wet)
    middle = np.array([[generator.uniform(0.0, 1800.0)], [generator.uniform(-400.0, 400.0)]])
    places = [middle + spread * generator.uniform(-0.5, 0.5, (2, count)) for _ in range(2)]
    start, depth = generator.uniform(0.0, last - 300.0, count), generator.uniform(0.0, 5.0, count)
    together = current.covers(Span(start, start + 300.0, depth, tuple(places)))
    alone = [
        current.covers(Span(start[i], start[i] + 300.0, depth[i], tuple(place[:, [i]] for place in places)))[0]
        for i in range(count)
    ]
    assert np.broadcast_to(together, count).tolist() == alone


def test_the_mean_along_a_leg_follows_the_track_that_the_current_bends():
    gain = 1e-3  # the current grows by this along the way [1/s]
    values = np.broadcast_to((gain * np.tile(EAST, NORTH.size))[None, :, None] + 0j, (TIME.size, 35, LEVELS.size))
    current = GriddedCurrent.of(TIME, RegularGrid(NORTH, EAST), LEVELS, values, np.full(35, 15.0))
    start, duration = np.array([[100.0, 200.0, 300.0], [0.0, 0.0, 50.0]]), np.array([250.0, 700.0, 0.0])
    through = 0.8 * duration * np.array([[1.0], [0.0]])
    mean = current.mean_velocity(np.zeros(3), duration, 3.0, start, through)
    # x' = 0.8 + gain x
    end = (start[0] + 0.8 / gain) * np.exp(gain * duration) - 0.8 / gain
    expected = np.append((end - start[0] - through[0])[:2] / duration[:2], gain * start[0, 2])
    np.testing.assert_allclose(mean[0], expected, atol=1e-3)
    np.testing.assert_allclose(mean[1], 0.0, atol=1e-12)


class Shear(Current):
    """Grows with depth and time, so that the drift of a body that sinks evenly has a closed form."""

    steady_for = 1.0

    def velocity(self, t, depth, position):
        return np.stack((0.02 * np.asarray(depth) + 0.001 * np.asarray(t), np.zeros(np.size(t))))


def test_steps_that_are_gathered_drift_as_far_as_they_should():
    drift = HorizontalDrift(Shear(), np.zeros((2, 2)), np.array([10.0, 20.0]))
    step, rate, lasting = 0.3, 1.2, np.array([7.35, 4.0])
    on_step = drift.stage(below=2.0)
    for number in range(25):
        t = number * step
        spent = np.clip(lasting - t, 0.0, step)
        on_step(t, spent, rate * (t + 0.5 * spent))
    # ∫ 0.02 (2 + rate t) + 0.001 (start + t) dt
    start = drift.clock
    expected = 0.02 * (2.0 * lasting + 0.5 * rate * lasting**2) + 0.001 * (start * lasting + 0.5 * lasting**2)
    np.testing.assert_allclose(drift.position, np.stack((expected, np.zeros(2))), rtol=1e-12)


def test_a_later_start_meets_a_later_part_of_all_members():
    fields = [field(NORTH, seed=seed) for seed in (1, 2)]
    ensemble = Ensemble.of(fields, ("one", "two"), (0.5, 0.5))
    place = np.array([[500.0], [30.0]])
    for current in (*fields, ensemble):
        later = current.later(1234.0)
        np.testing.assert_allclose(later.velocity(100.0, 4.0, place), current.velocity(1334.0, 4.0, place), atol=1e-6)
    assert ensemble.later(1234.0).time[0] == TIME[0] - 1234.0
