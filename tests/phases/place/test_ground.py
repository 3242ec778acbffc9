"""Depths on a grid against closed forms: a plane, a shelf, one shoal cell; and every way against dense sampling."""

import numpy as np
import pytest
from ground_examples import STEP, ground
from hypothesis import given, settings
from hypothesis import strategies as st

from missionplan.phases.ground import Frame
from missionplan.phases.place import Cause, Contact, Place, SeaLevel, Way
from missionplan.phases.zones import Fence, Zone


def plane(east=0.02, north=-0.05, deep=10.0, shape=(30, 40)):
    rows, columns = np.mgrid[0 : shape[0], 0 : shape[1]]
    return ground(deep + STEP * (east * columns + north * rows))


def test_depth_and_slope_of_a_plane_are_exact():
    places = np.array([[15.0, 33.3, 200.0], [15.0, 12.0, 155.5]])
    assert plane().depth_at(places) == pytest.approx(10.0 + 0.02 * places[0] - 0.05 * places[1], abs=1e-5)
    angle, toward = plane().slope_at(places)
    assert angle == pytest.approx(np.full(3, np.arctan(np.hypot(0.02, 0.05))), rel=1e-3)
    assert np.degrees(toward) == pytest.approx(np.full(3, np.degrees(np.arctan2(0.02, -0.05))), abs=0.1)


def test_a_way_up_a_slope_grounds_where_the_water_is_as_deep_as_it_needs():
    # depth 10 + 0.02 x: going west from x = 300 it is 12 m deep at x = 100, two thirds of the way to 0
    start, end = np.array([[300.0], [50.0]]), np.array([[0.0], [50.0]])
    share, depth, unknown = plane(north=0.0).too_shallow(start, end, np.full((2, 1), 12.0))
    assert share[0] == pytest.approx(2.0 / 3.0, abs=0.01)
    assert depth[0] == pytest.approx(12.0, abs=0.1)
    assert np.isinf(unknown[0])


def test_a_centimetre_to_spare_is_enough_and_none_is_not():
    shelf = ground(np.full((8, 8), 5.0))
    way = np.array([[5.0], [5.0]]), np.array([[60.0], [60.0]])
    assert np.isinf(shelf.too_shallow(*way, np.full((2, 1), 4.99))[0][0])
    assert shelf.too_shallow(*way, np.full((2, 1), 5.0))[0][0] == 0.0


def test_water_that_falls_on_the_way_counts():
    shelf = ground(np.full((8, 8), 5.0))
    way = np.array([[5.0], [5.0]]), np.array([[65.0], [5.0]])
    share, _, _ = shelf.too_shallow(*way, np.array([[4.0], [6.0]]))
    assert share[0] == pytest.approx(0.5, abs=0.07)


def test_one_shoal_cell_is_found_by_a_long_way_over_it_and_by_none_beside():
    depth = np.full((200, 300), 50.0)
    depth[100, 150] = 1.0
    shoal = ground(depth)
    start, end = np.array([[0.0, 0.0], [1000.0, 1021.0]]), np.array([[2900.0, 2900.0], [1000.0, 1021.0]])
    share, _, _ = shoal.too_shallow(start, end, np.full((2, 2), 10.0))
    assert share[0] * 2900.0 == pytest.approx(1490.0 + 40.0 / 4.9, abs=1.3)  # it rises by 4.9 a metre
    assert np.isinf(share[1])


def test_beyond_the_outer_edge_of_the_outermost_cell_the_depth_is_unknown():
    shelf = ground(np.full((4, 5), 5.0))
    edge = np.array([[-4.9, -5.1, 44.9, 45.1], [15.0, 15.0, 15.0, 15.0]])
    assert np.isnan(shelf.depth_at(edge)).tolist() == [False, True, False, True]
    share, _, unknown = shelf.too_shallow(np.array([[20.0], [15.0]]), np.array([[70.0], [15.0]]), np.zeros((2, 1)))
    assert np.isinf(share[0])
    assert unknown[0] == pytest.approx(0.5, abs=0.1)


def test_a_missing_cell_is_unknown():
    depth = np.full((6, 6), 5.0)
    depth[3, 3] = np.nan
    assert np.isnan(ground(depth).depth_at(np.array([[30.0], [30.0]])))[0]
    share, _, unknown = ground(depth).too_shallow(
        np.array([[0.0], [30.0]]), np.array([[50.0], [30.0]]), np.zeros((2, 1))
    )
    assert np.isinf(share[0])
    assert np.isfinite(unknown[0])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_ways_are_found_shallow_as_by_dense_sampling(seed):
    rng = np.random.default_rng(seed)
    rough = ground(rng.uniform(0.0, 30.0, (rng.integers(3, 40), rng.integers(3, 40))))
    rows, columns = rough.depth.shape
    ends = rng.uniform(-4.0, 1.0, (2, 2, 30)) + rng.random((2, 2, 30)) * STEP * np.array([columns, rows])[:, None] * 0.9
    start, end = np.clip(ends[0], -4.0, None), np.clip(ends[1], -4.0, None)
    at = np.linspace(0.0, 1.0, 4001)
    least = np.array([rough.depth_at(start[:, [k]] + at * (end - start)[:, [k]]).min() for k in range(30)])
    needed = rng.uniform(0.0, 20.0, 30)
    clear = np.isinf(rough.too_shallow(start, end, np.stack((needed, needed)))[0])
    sure = np.abs(least - needed) > 0.15  # the samples of both are some centimetres off the least depth
    assert (clear == (least > needed))[sure].all()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_a_box_that_is_deep_is_so_everywhere_in_it_and_one_of_a_plane_is_judged_within_some_cells(seed):
    rng = np.random.default_rng(seed)
    shape = rng.integers(3, 40, 2)
    rough = ground(np.where(rng.random(shape) < 0.02, np.nan, rng.uniform(10.0, 30.0, shape)))
    low = rng.uniform(-8.0, 1.0, 2) + rng.random(2) * STEP * shape[::-1] * 0.8
    high = low + rng.uniform(0.0, 200.0, 2)
    inside = low[:, None] + rng.random((2, 4000)) * (high - low)[:, None]
    if rough.is_deep(low, high, 9.9):
        assert (rough.depth_at(inside) > 9.9).all()
    sloping = plane(east=0.0, north=0.05, shape=(200, 200))
    box = np.array([300.0, 500.0]), np.array([900.0, 700.0])  # 35 m deep at its south edge
    assert not sloping.is_deep(*box, 35.1)
    assert sloping.is_deep(*box, 35.0 - 0.05 * 80.0)


def test_a_projection_that_is_not_linear_bounds_the_cells_of_a_box():
    low, high = np.array([-1000.0, -500.0]), np.array([3000.0, 2500.0])
    rng = np.random.default_rng(3)
    places = low[:, None] + rng.random((2, 400)) * (high - low)[:, None]

    def bent(where):
        x, y = where
        return np.stack((x / 10.0 + 2e-6 * x * y, y / 10.0 - 1e-6 * x * x))

    frame = Frame.fitted(low, high, places, bent(places))
    corner, size = np.array([200.0, 300.0]), np.array([700.0, 40.0])
    least, greatest = frame.box(corner, corner + size)
    cells = bent(corner[:, None] + rng.random((2, 4000)) * size[:, None])
    assert (cells.min(axis=1) >= least).all()
    assert (cells.max(axis=1) <= greatest).all()
    assert (greatest - least < 2.0 * (cells.max(axis=1) - cells.min(axis=1)) + 1.0).all()
    assert frame.box(corner, high + 1.0) is None


def test_the_side_of_a_cell_is_known():
    assert plane().cell == pytest.approx(STEP)


def test_room_over_level_ground_is_what_is_not_needed_and_grows_with_the_way_to_a_shoal():
    way = np.array([[5.0], [35.0]]), np.array([[65.0], [35.0]])
    shelf = ground(np.full((8, 8), 10.0))
    assert shelf.spare_along(*way, np.full((2, 1), 4.0))[0] == pytest.approx([6.0])
    assert shelf.spare_along(*way, np.array([[3.0], [5.0]]))[0] == pytest.approx([5.0])
    depth = np.full((8, 8), 10.0)
    depth[0] = 1.0  # 30 m south of the way along the fourth row
    along = np.array([[5.0], [30.0]]), np.array([[65.0], [30.0]])
    assert ground(depth).spare_along(*along, np.full((2, 1), 4.0))[0] == pytest.approx([6.0 * (1.0 + 3.0)])


def meets(depth, zones=(), needed=3.0, **place):
    """What a vehicle that sails east along the middle of a shelf meets first."""
    n = np.ones(1)
    way = Way(np.array([[5.0], [35.0]]), np.array([[185.0], [35.0]]), 0.0 * n, 180.0 * n, 2.0 * n, needed * n)
    return Place(ground(depth), Fence(zones) if zones else None, **place).meets(way)


def test_of_a_shoal_and_a_zone_the_first_on_the_way_is_met():
    box = pytest.importorskip("shapely").box
    depth = np.full((8, 20), 10.0)
    depth[:, 10] = 1.0  # from x = 90 + 10·7/9, where 3 m are left
    after, before = (Zone(box(x, 0.0, x + 10.0, 70.0), "range", is_land=False) for x in (140.0, 40.0))
    assert meets(depth).cause.tolist() == meets(depth, (after,)).cause.tolist() == [Cause.AGROUND]
    assert meets(depth, (after,)).where[0] == pytest.approx([90.0 + 70.0 / 9.0], abs=0.7)
    contact = meets(depth, (before,))
    assert (contact.cause.tolist(), contact.where[0].tolist()) == ([Cause.KEEP_OUT], pytest.approx([40.0]))


def test_a_sea_below_the_datum_leaves_less_water():
    shelf, fallen = np.full((60, 60), 5.0), SeaLevel(time=np.array([0.0, 1e4]), height=np.array([-1.0, -1.0]))
    assert meets(shelf, needed=4.5).cause.tolist() == [Cause.NONE]
    assert meets(shelf, needed=4.5, sea_level=fallen).cause.tolist() == [Cause.AGROUND]
    assert meets(shelf, needed=3.9, sea_level=fallen).cause.tolist() == [Cause.NONE]
    assert meets(shelf, needed=3.5, draught=0.3, clearance=0.3, sea_level=fallen).cause.tolist() == [Cause.AGROUND]


def test_what_trials_came_near_to_is_the_nearest_of_their_legs():
    contact, near = Contact.none(2, measured=True), Contact.none(2, measured=True)
    for room in (3.0, 7.0):
        near.nearest[0] = room
        contact.note(np.arange(2), near, 1)
    assert contact.nearest[0].tolist() == [3.0, 3.0]
