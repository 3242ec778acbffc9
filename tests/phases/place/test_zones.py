"""Polygons against geometry: a strait, times, depths, edges; the field of distances leaves none out."""

import numpy as np
import pytest

from missionplan.phases.place import Cause, Contact, Place, Way
from missionplan.phases.zones import Fence, Zone

shapely = pytest.importorskip("shapely")

LAND = Zone(shapely.box(400.0, -1000.0, 600.0, -20.0), "south", is_land=True)
NORTH = Zone(shapely.box(400.0, 20.0, 600.0, 1000.0), "north", is_land=True)


def meets(zones, north, **changes):
    """Sail east at some norths, past x = 400 to 600."""
    north = np.atleast_1d(np.asarray(north, dtype=float))
    n = north.size
    start, end = np.stack((np.zeros(n), north)), np.stack((np.full(n, 1000.0), north))
    way = {"begun": np.zeros(n), "ended": np.full(n, 1000.0), "least": 5.0, "greatest": 5.0, **changes}
    return Place(None, Fence(zones)).meets(Way(start, end, **way))


def test_a_strait_lets_through_what_keeps_between_its_shores():
    contact = meets((LAND, NORTH), [-500.0, -21.0, -20.0, -19.0, 0.0, 19.0, 21.0])
    assert contact.cause.tolist() == [3, 3, 3, 0, 0, 0, 3]  # an edge belongs to the land
    assert contact.where[:, 1] == pytest.approx([400.0, -21.0])


def test_a_way_between_two_ends_at_sea_that_crosses_a_spit_is_found():
    spit = Zone(shapely.box(499.9, -1000.0, 500.1, 1000.0), "spit", is_land=True)
    assert meets((spit,), 0.0).cause[0] == Cause.ON_LAND


def test_a_vehicle_that_stays_on_a_zone_has_met_it():
    still = np.array([[500.0], [-100.0]])
    contact = Place(None, Fence((LAND,))).meets(Way(still, still, np.zeros(1), np.ones(1)))
    assert contact.cause[0] == Cause.ON_LAND


@pytest.mark.parametrize(
    ("limits", "met"),
    [
        ({}, True),
        ({"since": 0.0, "until": 399.0}, False),  # it is there from 400 s to 600 s
        ({"since": 0.0, "until": 400.0}, True),
        ({"since": 600.5}, False),
        ({"since": 550.0}, True),
        ({"above": 5.0}, False),  # sails at 5 m, and keeps out of what is less deep
        ({"above": 5.1}, True),
        ({"below": 5.0}, False),
        ({"below": 4.9}, True),
        ({"below": 4.0, "above": 6.0}, True),
        ({"below": 6.0, "above": 9.0}, False),
    ],
)
def test_a_zone_holds_at_its_times_and_depths(limits, met):
    zone = Zone(LAND.geometry, "range", is_land=False, **limits)
    contact = meets((zone,), -100.0)
    assert contact.cause[0] == (Cause.KEEP_OUT if met else Cause.NONE)
    if met and limits.get("since", 0.0) == 550.0:
        assert contact.where[0, 0] == pytest.approx(550.0)


def test_a_hole_in_land_is_water():
    lake = shapely.box(0.0, 0.0, 1000.0, 1000.0).difference(shapely.box(100.0, 100.0, 900.0, 900.0))
    zone = Zone(lake, "ring", is_land=True)
    start, end = np.array([[200.0, 200.0], [500.0, 500.0]]), np.array([[800.0, 950.0], [500.0, 500.0]])
    contact = Place(None, Fence((zone,))).meets(Way(start, end, np.zeros(2), np.ones(2)))
    assert contact.cause.tolist() == [Cause.NONE, Cause.ON_LAND]


def test_no_way_that_touches_is_left_out():
    rng = np.random.default_rng(7)
    shapes = [shapely.Point(*rng.uniform(-400, 1400, 2)).buffer(rng.uniform(2, 60)) for _ in range(25)]
    around = Fence(tuple(Zone(shape, "islet", is_land=True) for shape in shapes))
    start = rng.uniform(-2500, 3000, (2, 4000))
    end = start + rng.normal(0.0, 150.0, (2, 4000))
    touching = shapely.intersects(shapely.union_all(shapes), shapely.linestrings(np.stack((start.T, end.T), axis=1)))
    assert touching.sum() > 30
    for few, all_of in ((7, 1400), (400, 4000), (4000, 4000)):  # a few ways at a time leave zones out of their box
        share = np.full(all_of, np.inf)
        for begin in range(0, all_of, few):
            ways = start[:, begin : begin + few], end[:, begin : begin + few]
            times = np.zeros(ways[0].shape)
            share[begin : begin + few], _ = around.first(*ways, times, times + 1.0, around.reached(*ways))
        assert (np.isfinite(share) == touching[:all_of]).all()


def test_how_near_a_way_comes_is_by_place_time_and_depth_together():
    """10 m east of a zone at 1 m/s: 90 s before it holds or 60 s after, and 3 m deeper than what it forbids, or less."""
    box = shapely.box(0.0, 0.0, 10.0, 10.0)
    ways = np.array([[20.0, 5.0], [5.0, 5.0]]), np.array([[30.0, 6.0], [5.0, 5.0]])  # the second inside, at 0.1 m/s
    depths = np.array([[8.0, 8.0], [9.0, 9.0]])
    over, under = (
        Zone(box, "range", is_land=False, since=100.0, until=200.0, **limit)
        for limit in ({"above": 5.0}, {"below": 12.0})
    )
    for zone in (over, under):
        early = zone.distance(*ways, np.array([[0.0, 0.0], [10.0, 10.0]]), depths)
        assert early == pytest.approx(np.sqrt([10.0**2 + 90.0**2 + 3.0**2, 9.0**2 + 3.0**2]))
        late = zone.distance(*ways, np.array([[260.0, 150.0], [270.0, 160.0]]), depths)
        assert late == pytest.approx(np.sqrt([10.0**2 + 60.0**2 + 3.0**2, 3.0**2]))


def test_of_two_zones_the_first_on_the_way_is_met_whichever_is_named_first():
    near, far = (
        Zone(shapely.box(x, -5.0, x + 10.0, 5.0), "range", is_land=land) for x, land in ((30.0, True), (60.0, False))
    )
    for zones in ((near, far), (far, near)):
        assert meets(zones, 0.0).cause.tolist() == [Cause.ON_LAND]


def test_what_a_trial_met_first_stays_with_its_leg_its_place_and_how_near_it_came_by_then():
    def met(*causes, east):
        count = len(causes)
        where = np.where(np.array(causes) == Cause.NONE, np.nan, np.full((2, count), east))
        return Contact(
            np.array(causes, dtype=np.int8), np.zeros(count, dtype=int), where, np.full((4, count), 10.0 * east)
        )

    found = Contact.none(3, measured=True)
    found.note(np.array([0, 2]), met(Cause.KEEP_OUT, Cause.NONE, east=5.0), 1)
    found.note(np.arange(3), met(Cause.ON_LAND, Cause.ON_LAND, Cause.NONE, east=3.0), 2)
    assert found.cause.tolist() == [Cause.KEEP_OUT, Cause.ON_LAND, Cause.NONE]
    assert found.leg.tolist() == [1, 2, 0]
    np.testing.assert_array_equal(found.where[0], [5.0, 3.0, np.nan])
    assert found.nearest[0].tolist() == [50.0, 30.0, 30.0]
