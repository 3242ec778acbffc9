"""Transits over ground and past land: where they stop, what is recorded, and that nothing else changes."""

import numpy as np
import pytest
from transit_examples import run, start

from missionplan.phases.ground import Frame, Ground
from missionplan.phases.place import Cause, Place, SeaLevel
from missionplan.phases.transit.plan import VelocityError
from missionplan.phases.zones import Fence, Zone

shapely = pytest.importorskip("shapely")


def sea(depth=50.0, **changes):
    """Ten metres to a cell from the origin, 1.2 km east, 200 m north."""
    low, high = np.array([-10.0, -10.0]), np.array([1250.0, 250.0])
    places = np.stack(
        [axis.ravel() for axis in np.meshgrid(*(np.linspace(*ends, 9) for ends in zip(low, high, strict=True)))]
    )
    depths = np.broadcast_to(depth, (21, 121)).astype(np.float32)
    return Place(Ground(depths, Frame.fitted(low, high, places, places / 10.0)), **changes)


def shelf():
    """50 m deep to 600 m east, then 3 m."""
    return sea(np.where(np.arange(121) * 10.0 < 600.0, 50.0, 3.0))


def test_deep_water_changes_nothing():
    error = {"velocity_error": VelocityError.isotropic(0.01), "d_max": 200.0}
    begin = start(400, at=(50.0, 100.0))
    goal = {"goal": np.array([1000.0, 100.0])}
    (_, plain), (_, watched) = (run(error | goal, begin, place=place) for place in (None, sea()))
    assert np.array_equal(plain.distance, watched.distance)
    assert plain.arrived.all()
    assert watched.arrived.all()
    assert not watched.contact.met.any()


def test_a_vehicle_stops_at_the_shelf_on_the_leg_that_meets_it():
    changes = {"goal": np.array([1000.0, 100.0]), "d_max": 200.0, "depth": 10.0}
    state, record = run(changes, start(at=(50.0, 100.0)), place=shelf(), tracked=1)
    assert not record.arrived.any()
    assert (record.contact.cause == Cause.AGROUND).all()
    assert (record.contact.leg == 3).all()  # from 450 m to 650 m
    assert state.position[0] == pytest.approx(np.full(3, 590.0 + 10.0 * 40.0 / 47.0), abs=1.5)
    assert record.track[0, -1, 0] == pytest.approx(state.position[0, 0])


@pytest.mark.parametrize(
    ("depth", "changes", "met"),
    [
        (2.5, {}, False),
        (2.5, {"draught": 0.4}, False),
        (2.5, {"draught": 0.6}, True),
        (2.5, {"clearance": 0.6}, True),
        (2.5, {"clearance": 0.6, "sea_level": SeaLevel(0.2)}, False),
        (2.5, {"sea_level": SeaLevel(-0.5)}, True),
    ],
)
def test_hull_clearance_and_tide_count(depth, changes, met):
    goal = {"goal": np.array([1000.0, 100.0]), "depth": depth}
    place = Place(shelf().ground, **changes)
    _, record = run(goal, start(at=(50.0, 100.0)), place=place)
    assert record.contact.met.all() == met


def test_a_vehicle_that_sails_under_a_zone_meets_it_only_where_it_surfaces():
    zone = Zone(shapely.box(300.0, 0.0, 500.0, 200.0), "lane", is_land=False, above=5.0)
    place = Place(None, Fence((zone,)))
    goal = {"goal": np.array([1000.0, 100.0]), "depth": 20.0}
    assert run({**goal, "d_max": 550.0}, start(at=(50.0, 100.0)), place=place)[1].arrived.all()
    _, record = run({**goal, "d_max": 400.0}, start(at=(50.0, 100.0)), place=place)
    assert (record.contact.cause == Cause.KEEP_OUT).all()
    assert record.contact.where[0] == pytest.approx(np.full(3, 450.0))


def test_trials_that_arrived_are_not_watched_any_more_and_dropping_them_changes_nothing():
    error = {"velocity_error": VelocityError.isotropic(0.05), "d_max": 150.0, "goal": np.array([1000.0, 100.0])}
    begin = start(1000, at=(50.0, 100.0))
    zone = Zone(shapely.box(700.0, 104.0, 800.0, 200.0), "islet", is_land=True)
    place = Place(sea().ground, Fence((zone,)))
    (_, dropped), (_, kept) = (run(error, begin, place=place, tracked=tracked) for tracked in (0, 1))
    assert np.array_equal(dropped.contact.cause, kept.contact.cause)
    assert np.array_equal(dropped.arrived, kept.arrived)
    assert 0.1 < dropped.contact.met.mean() < 0.9
    assert (dropped.arrived ^ dropped.contact.met).all()
