import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import trapezoid
from scipy.interpolate import RegularGridInterpolator

from missionplan.errors import InputError
from missionplan.phases.currents import Current, LayeredCurrent, Span, layers
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.grids import FieldWater, RegularGrid
from missionplan.phases.recorded_currents import SeriesCurrent, bracket, even_step

HERE = np.zeros((2, 1))
RNG = np.random.default_rng(11)


SERIES = SeriesCurrent(
    np.array([0.0, 600.0, 1500.0, 1800.0]),
    np.array([0.0, 10.0, 25.0]),
    RNG.normal(size=(4, 3)),
    RNG.normal(size=(4, 3)),
)


def field():
    axes = (np.array([0.0, 3600.0, 7200.0]), np.array([0.0, 5.0]), np.array([-2e3, 0.0, 3e3]), np.array([-1e3, 2e3]))
    shape = tuple(map(len, axes))
    return axes, RNG.normal(size=shape), RNG.normal(size=shape)


def gridded(axes, east, north):
    time, depth, north_axis, east_axis = axes
    values = (east + 1j * north).reshape(time.size, depth.size, -1).transpose(0, 2, 1)
    return GriddedCurrent.of(time, RegularGrid(north_axis, east_axis), depth, values, np.full(values.shape[1], 99.0))


def test_layers_set_towards_their_course():
    current = layers([5.0, 12.0], [0.4, 0.2], [np.radians(90.0), np.radians(180.0)])
    assert current.velocity(0.0, 2.0, HERE)[:, 0] == pytest.approx([0.4, 0.0], abs=1e-15)
    assert current.velocity(0.0, 7.0, HERE)[:, 0] == pytest.approx([0.0, -0.2], abs=1e-15)


def test_a_layer_holds_down_to_its_end_and_the_deepest_goes_on():
    current = LayeredCurrent(np.array([5.0, 12.0]), np.array([1.0, 2.0]), np.zeros(2))
    depths = np.array([0.0, 5.0, 5.001, 12.0, 40.0])
    assert current.velocity(0.0, depths, np.zeros((2, 5)))[0].tolist() == [1.0, 1.0, 2.0, 2.0, 2.0]


def test_layers_may_differ_from_trial_to_trial():
    current = layers([5.0, 12.0], [np.array([0.1, 0.2, 0.3]), 0.5], [0.0, 0.0])
    assert current.velocity(0.0, 1.0, HERE)[1].tolist() == [0.1, 0.2, 0.3]
    assert current.velocity(0.0, np.array([1.0, 9.0, 1.0]), HERE)[1].tolist() == [0.1, 0.5, 0.3]
    assert current.take(np.array([2, 0])).velocity(0.0, 1.0, HERE)[1].tolist() == [0.3, 0.1]
    steady = LayeredCurrent(np.array([5.0, 12.0]), np.array([1.0, 2.0]), np.zeros(2))
    assert steady.take(np.array([1])).velocity(0.0, 1.0, HERE)[0] == [1.0]


def test_a_series_is_linear_between_samples_and_held_at_the_ends():
    current = SERIES
    theory = RegularGridInterpolator((current.time, current.depth), current.east)
    t, depth = RNG.uniform(0.0, 1800.0, 50), RNG.uniform(0.0, 25.0, 50)
    assert current.velocity(t, depth, HERE)[0] == pytest.approx(theory((t, depth)))
    assert current.velocity(9999.0, 99.0, HERE)[:, 0] == pytest.approx([current.east[-1, -1], current.north[-1, -1]])
    assert current.velocity(-5.0, 0.0, HERE)[:, 0] == pytest.approx([current.east[0, 0], current.north[0, 0]])


@given(st.floats(-900.0, 2500.0), st.floats(1.0, 3000.0), st.floats(0.0, 30.0))
def test_the_mean_of_a_series_is_its_integral(t, duration, depth):
    current = SERIES
    inside = current.time[(current.time > t) & (current.time < t + duration)]
    moments = np.concatenate(([t], inside, [t + duration]))
    integral = trapezoid(current.velocity(moments, depth, HERE)[1], moments)
    mean = current.mean_velocity(t, duration, depth, HERE, HERE)
    assert mean.shape == (2, 1)
    assert mean[1, 0] == pytest.approx(integral / duration, abs=1e-9)


def test_the_mean_of_a_series_over_no_time_is_its_value():
    current = SERIES
    durations = np.array([0.0, 100.0])
    mean = current.mean_velocity(np.full(2, 700.0), durations, 3.0, np.zeros((2, 2)), np.zeros((2, 2)))
    assert mean[:, :1] == pytest.approx(current.velocity(700.0, 3.0, HERE))


def test_a_series_of_one_sample_is_constant():
    current = SeriesCurrent(np.array([5.0]), np.array([0.0]), np.array([[0.2]]), np.array([[-0.1]]))
    assert current.velocity(99.0, 3.0, HERE)[:, 0] == pytest.approx([0.2, -0.1])
    assert current.mean_velocity(0.0, 50.0, 3.0, HERE, HERE)[:, 0] == pytest.approx([0.2, -0.1])


def test_a_field_is_linear_between_nodes():
    axes, *parts = field()
    current = gridded(axes, *parts)
    t, depth = RNG.uniform(0.0, 7200.0, 40), RNG.uniform(0.0, 5.0, 40)
    place = np.stack((RNG.uniform(-1e3, 2e3, 40), RNG.uniform(-2e3, 3e3, 40)))
    for component, values in enumerate(parts):
        theory = RegularGridInterpolator(axes, values)((t, depth, place[1], place[0]))
        assert current.velocity(t, depth, place)[component] == pytest.approx(theory)


def test_the_mean_along_a_track_follows_the_current_that_bends_it():
    """In a linear shear dx/dt = k y, y' = U the closed form of the mean is k times the mean of y."""
    axes = (np.array([0.0]), np.array([0.0]), np.array([0.0, 5000.0]), np.array([-9e3, 9e3]))
    east = np.zeros((1, 1, 2, 2))
    east[0, 0, 1] = 5000.0 * 1e-4
    current = gridded(axes, east, np.full_like(east, 0.1))
    mean = current.mean_velocity(0.0, 1000.0, 0.0, HERE, np.array([[0.0], [1500.0]]))
    assert mean[:, 0] == pytest.approx([1e-4 * 0.5 * (1500.0 + 100.0), 0.1])


def test_the_base_quadrature_is_exact_for_a_tide():
    class Tide(Current):
        def velocity(self, t, depth, position):
            return np.stack(np.broadcast_arrays(np.cos(1.405e-4 * np.asarray(t)), 0.0))[:, None]

    mean = Tide().mean_velocity(1000.0, 3600.0, 0.0, HERE, HERE)
    theory = (np.sin(1.405e-4 * 4600.0) - np.sin(1.405e-4 * 1000.0)) / (1.405e-4 * 3600.0)
    assert mean[0, 0] == pytest.approx(theory, rel=1e-9)


def test_missing_nodes_take_the_water_above_them_then_beside_them():
    values = np.array([[[[1.0, 2.0, np.nan]], [[5.0, np.nan, np.nan]]]])
    axes = (np.zeros(1), np.array([0.0, 5.0]), np.zeros(1), np.array([0.0, 1e3, 2e3]))
    current = gridded(axes, values, 0.0 * values)
    assert current.values[0].T.real.tolist() == [[1.0, 2.0, 2.0], [5.0, 2.0, 2.0]]
    assert current.wet.tolist() == [[True, True, False]]
    assert np.isnan(values).sum() == 3, "the caller's array is left alone"


def test_a_time_without_any_value_is_refused():
    with pytest.raises(InputError, match="time without any value"):
        gridded((np.zeros(1), np.zeros(1), np.arange(2.0), np.arange(2.0)), *np.full((2, 1, 1, 2, 2), np.nan))


@given(st.integers(2, 40), st.floats(-1e6, 1e6), st.floats(1.0, 1e4), st.integers(0, 2**32 - 1))
def test_counted_nodes_are_those_that_a_search_finds(count, first, step, seed):
    rng = np.random.default_rng(seed)
    axis = first + step * (np.arange(count) + rng.uniform(-4e-6, 4e-6, count))
    step = even_step(axis)
    assert step is not None
    inside, ends = rng.uniform(axis[0], axis[-1], 50), rng.uniform(axis[0] - step, axis[-1] + step, 50)
    for x in (inside, ends, axis, np.nextafter(axis, -np.inf), 0.5 * (axis[1:] + axis[:-1])):
        for counted, found in zip(bracket(axis, x, step), bracket(axis, x), strict=True):
            assert np.array_equal(counted, found)


def test_an_uneven_axis_has_no_step():
    assert even_step(np.array([0.0, 1.0, 3.0])) is None
    assert even_step(np.zeros(1)) is None


@pytest.mark.parametrize(("outside", "mean"), [("hold", 1.5), ("zero", 0.75)])
def test_a_leg_that_outlasts_a_record_has_its_last_value_or_none_for_the_rest(outside, mean):
    """100 s of 1.5 m/s: of 100 s from its middle on half lie beyond its end."""
    record = SeriesCurrent(
        np.array([0.0, 100.0]), np.array([0.0]), np.full((2, 1), 1.5), np.zeros((2, 1)), outside=outside
    )
    assert record.mean_velocity(50.0, 100.0, 0.0, HERE, HERE)[:, 0] == pytest.approx([mean, 0.0])


def test_a_record_is_good_some_metres_beyond_its_depths_and_in_its_time():
    """By 5 m above the first of 10 and 40 m, and by a fifth of the last below it."""
    record = SeriesCurrent(np.array([0.0, 100.0]), np.array([10.0, 40.0]), np.zeros((2, 2)), np.zeros((2, 2)))
    depths, ends = np.array([4.9, 5.0, 48.0, 48.1, 30.0]), np.array([100.0, 100.0, 100.0, 100.0, 100.1])
    assert record.covers(Span(0.0, ends, depths, (HERE,))).tolist() == [False, True, True, False, False]
    assert record.depths_covered == (5.0, 48.0)


def test_places_are_water_by_most_of_their_columns_and_deep_by_the_shallowest():
    """Nine columns 100 m apart; that of the south-west corner is 5 m deep of 20, or always dry."""
    grid = RegularGrid(np.array([0.0, 100.0, 200.0]), np.array([0.0, 100.0, 200.0]))
    wet, bottom = np.ones((2, 9), dtype=bool), np.full(9, 20.0)
    wet[:, 0], bottom[0] = False, 5.0
    dry, shoal = (FieldWater(grid, np.array([0.0, 1.0]), each, bottom) for each in (wet, np.ones_like(wet)))
    assert dry.holds(np.array([[30.0, 25.0, 25.0], [30.0, 25.0, -1.0]])).tolist() == [True, False, False]
    apart, away = np.array([[50.0, 150.0], [50.0, 150.0]]), np.full((2, 1), 150.0)
    assert [shoal.is_all_open(apart, depth) for depth in (5.0, 6.0)] == [True, False]
    assert [shoal.is_all_open(away, depth) for depth in (20.0, 21.0)] == [True, False]
    assert not dry.is_all_open(apart, 0.0)


def test_a_column_without_water_is_as_deep_as_the_nearest_that_has_some():
    values = np.array([[[1.0], [2.0], [np.nan]]], dtype=complex)
    grid = RegularGrid(np.zeros(1), np.array([0.0, 1e3, 1.9e3]))
    found = GriddedCurrent.of(np.zeros(1), grid, np.zeros(1), values, np.array([30.0, 20.0, 70.0]))
    assert (found.bottom.tolist(), found.depths_covered) == ([30.0, 20.0, 20.0], (0.0, 30.0))
