"""Areas of highest density hold their share of points that they were not made from, bent, in parts or small."""

import numpy as np
import pytest
from matplotlib.path import Path

from missionplan.studies.simulation.overdue import Cloud


def inside(polygons, points):
    return np.any(
        [np.logical_xor.reduce([Path(r.T).contains_points(points.T) for r in rings]) for rings in polygons], axis=0
    )


def normal(rng, n):
    return rng.multivariate_normal([3.0, 4.0], [[900.0, 300.0], [300.0, 400.0]], n).T


def bent(rng, n):
    angle, radius = rng.normal(0.0, 0.9, n), rng.normal(5000.0, 150.0, n)
    return np.stack((radius * np.sin(angle), radius * np.cos(angle)))


def in_two(rng, n):
    return np.stack((np.where(rng.random(n) < 0.5, -2000.0, 2000.0) + rng.normal(0.0, 300.0, n), rng.normal(0, 700, n)))


@pytest.mark.parametrize("drawn", [normal, bent, in_two])
@pytest.mark.parametrize(("count", "tolerance"), [(4000, 0.025), (250, 0.06)])
def test_an_area_holds_its_share_of_other_points(drawn, count, tolerance):
    rng = np.random.default_rng(7)
    cloud = Cloud(drawn(rng, count), np.full(count, 1.0 / count))
    for share, polygons in zip((0.5, 0.9, 0.95), cloud.areas((0.5, 0.9, 0.95)), strict=True):
        assert np.mean(inside(polygons, drawn(rng, 20_000))) == pytest.approx(share, abs=tolerance)


def test_of_a_normal_cloud_it_is_as_large_as_the_ellipse():
    rng = np.random.default_rng(8)
    (polygons,) = Cloud(normal(rng, 20_000), np.full(20_000, 1.0 / 20_000)).areas((0.9,))
    ((ring, *_),) = (max(polygons, key=lambda rings: rings[0].shape[1]),)
    east, north = ring
    area = 0.5 * abs(np.sum(east * np.roll(north, -1) - np.roll(east, -1) * north))
    exact = -2.0 * np.log(0.1) * np.pi * np.sqrt(900.0 * 400.0 - 300.0**2)
    assert area == pytest.approx(exact, rel=0.05)


def test_two_parts_are_two_polygons_and_none_is_between():
    rng = np.random.default_rng(9)
    polygons = Cloud(in_two(rng, 4000), np.full(4000, 1.0 / 4000)).areas((0.95,))[0]
    assert len([rings for rings in polygons if rings[0].shape[1] > 20]) == 2
    assert not inside(polygons, np.zeros((2, 1)))[0]


def test_weights_move_the_area():
    """Points at two places; those of one were searched and nine of ten would have been found."""
    rng = np.random.default_rng(10)
    points = in_two(rng, 4000)
    weights = np.where(points[0] < 0.0, 0.1, 1.0)
    cloud = Cloud(points, weights / weights.sum())
    fresh = in_two(rng, 40_000)
    kept = fresh[:, (fresh[0] > 0.0) | (rng.random(40_000) < 0.1)]
    assert np.mean(inside(cloud.areas((0.9,))[0], kept)) == pytest.approx(0.9, abs=0.03)
    assert cloud.densest()[0] > 0.0


def test_points_that_lie_alike_have_a_small_area():
    polygons = Cloud(np.ones((2, 100)), np.full(100, 0.01)).areas((0.95,))[0]
    assert np.abs(np.hstack([rings[0] for rings in polygons]) - 1.0).max() < 5.0
