"""Parts of readers of messages, by themselves: what is nearest in time, and from which origin a filter counts."""

import numpy as np
import pytest

from missionplan.importers.geodesy import displacement
from missionplan.importers.importer import ChannelStore, Samples
from missionplan.importers.readers import ardupilot, moos


def test_a_latitude_takes_the_longitude_nearest_in_time_before_or_after_it():
    store = ChannelStore()
    store.add("lon", np.array([0.0, 1.0, 2.0, 20.0]), np.array([10.0, 11.0, 12.0, 30.0]))
    found = moos._nearest(store, "lon", np.array([-0.2, 1.4, 1.6, 2.9, 3.5, 19.4]))
    np.testing.assert_array_equal(found, [10.0, 11.0, 12.0, 12.0, np.nan, 30.0])


@pytest.mark.parametrize(("has_origin", "count"), [(True, 3), (False, 0)])
def test_a_filter_that_counts_from_an_origin_needs_that_origin(has_origin, count):
    samples = {
        "place": Samples(("t", "lat", "lon")),
        "plane": Samples(("t", "north", "east")),
        "origin": Samples(("t", "lat", "lon")),
    }
    for t in range(3):
        samples["plane"].add(float(t), 100.0 * t, 30.0 * t)
    if has_origin:
        samples["origin"].add(0.0, 48.5, -123.25)
    found, words = ardupilot._reckoned(samples)
    assert len(found) == count
    assert words == ("the autopilot's filter (north, east)" if count else "the autopilot logs no position of its own")
    if count:
        east, north = displacement(48.5, -123.25, found.latitude, found.longitude)
        assert east == pytest.approx([0.0, 30.0, 60.0], abs=2e-3)
        assert north == pytest.approx([0.0, 100.0, 200.0], abs=2e-3)
