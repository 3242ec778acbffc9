"""Fields as models published them, shared beside the repository (skipped if absent), against brute force.

Two hundred random places and times each, to 1 mm/s; the sources are told in the folder's README.
"""

from pathlib import Path

import numpy as np
import pytest

from missionplan.mission.schema.place import Geographic, to_plane
from missionplan.phases.currents import Span
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.reading import read_field
from tests.scenario.currents import brute_force as slow

xarray = pytest.importorskip("xarray")
DATA = Path(__file__).parents[3].parent / "shared" / "data" / "currents"
POINTS = 200
WITHIN = 1e-3


def origin(latitude, longitude):
    return Geographic.model_construct(latitude=np.radians(latitude), longitude=np.radians(longitude))


def files(*names):
    found = [DATA / name for name in names]
    if not all(path.is_file() for path in found):
        pytest.skip(f"no measured data: {DATA}")
    return [str(path) for path in found]


def plane(longitude, latitude, site):
    longitude, latitude = np.asarray(longitude, dtype=float), np.asarray(latitude, dtype=float)
    east = (np.radians(longitude) - site.longitude + np.pi) % (2.0 * np.pi) - np.pi
    return np.stack(to_plane(np.radians(latitude), site.longitude + east, site))


def drawn(points, t_end, deepest):
    rng = np.random.default_rng(25)
    low, high = points.min(axis=1), points.max(axis=1)
    size = 5 * POINTS
    return (
        rng.uniform(low[:, None], high[:, None], (2, size)),
        rng.uniform(0.0, t_end, size),
        rng.uniform(0.0, deepest, size),
    )


def compare(current, points, t_end, deepest, reference):
    """Largest difference from the reference at places that it holds, which have to be `POINTS`."""
    place, t, depth = drawn(points, t_end, deepest)
    held = current.covers(Span(t, t, 0.0, (place, place)))
    found, worst, compared = current.velocity(t, depth, place), 0.0, 0
    for k in np.flatnonzero(held):
        theory = reference(place[:, k], t[k], depth[k])
        if theory is not None:
            worst, compared = max(worst, float(np.abs(found[:, k] - theory).max())), compared + 1
        if compared == POINTS:
            break
    assert compared == POINTS
    return worst


def test_roms_of_the_west_coast():
    (name,) = files("WCOFS_subset.nc")
    site = origin(45.0, -124.6)
    current = read_field([name], Area(site, np.datetime64("2024-10-17T01:00:00", "ns"), np.zeros((2, 1))), name)
    with xarray.open_dataset(name) as data:
        x, y = plane(data.lon_rho.to_numpy(), data.lat_rho.to_numpy(), site)
        mask, angle = data.mask_rho.to_numpy() > 0.5, data.angle.to_numpy()
        steps = [
            slow.rho_points(u, v, angle) for u, v in zip(data.u_sur.to_numpy(), data.v_sur.to_numpy(), strict=True)
        ]
    times = np.arange(4) * 3600.0

    def reference(place, t, depth):
        found = slow.quad_about(x, y, place)
        if found is None:
            return None
        j, i, (a, b) = found
        if not mask[j : j + 2, i : i + 2].all():
            return None  # beside the coast the nearest water counts, which is not interpolation
        weights = np.array([[(1 - a) * (1 - b), a * (1 - b)], [(1 - a) * b, a * b]])
        return slow.in_time(
            times, t, lambda step: np.array([np.sum(weights * part[j : j + 2, i : i + 2]) for part in steps[step]])
        )

    assert compare(current, current.grid.points, 10_800.0, 0.0, reference) < WITHIN
    assert not current.covers(Span(0.0, 60.0, 5.0, (np.zeros((2, 1)),)))[0], "it holds the surface alone"
    inland = plane(np.array([-123.4]), np.array([45.0]), site)
    assert not current.holds(inland)[0]


def test_fvcom_of_san_francisco_bay():
    (name,) = files("SFBOFS_subset1.nc")
    site = origin(37.88, -122.49)
    current = read_field([name], Area(site, np.datetime64("2024-05-23T00:00:00", "ns"), np.zeros((2, 1))), name)
    with xarray.open_dataset(name) as data:
        nodes = plane(data.lon.to_numpy(), data.lat.to_numpy(), site).T
        middles = plane(data.lonc.to_numpy(), data.latc.to_numpy(), site).T
        faces, beside = data.nv.to_numpy().T - 1, data.nbe.to_numpy() - 1
        sigma, bottom, surface = data.siglay.to_numpy(), data.h.to_numpy(), data.zeta.to_numpy()
        parts = data.u.to_numpy(), data.v.to_numpy()
    times = np.arange(10) * 3600.0

    def column(part, step, cell, depth):
        corners = faces[cell]
        height = bottom[corners].mean() + surface[step, corners].mean()
        return slow.in_column(-sigma[:, corners].mean(axis=1) * height, part[step, :, cell], depth)

    def reference(place, t, depth):
        found = slow.triangle_about(nodes, faces, place)
        if found is None:
            return None
        cell, others = found[0], beside[:, found[0]]

        def at(step):
            own = np.array([column(part, step, cell, depth) for part in parts])
            if others.min() < 0:
                return own
            about = np.array([[column(part, step, other, depth) for part in parts] for other in others])
            slopes = np.linalg.lstsq(middles[others] - middles[cell], about - own, rcond=None)[0]
            return own + (place - middles[cell]) @ slopes

        return slow.in_time(times, t, at)

    assert compare(current, current.grid.points, 32_400.0, 12.0, reference) < WITHIN


def test_schism_of_a_quarter_of_an_annulus():
    names = files(*(f"SCHISM/{part}_1.nc" for part in ("horizontalVelX", "horizontalVelY", "out2d", "zCoordinates")))
    places = np.array([[4e4, 1.4e5], [4e4, 1.4e5]])
    current = read_field(
        names, Area(origin(0.0, 0.0), np.datetime64("2000-02-01T01:00:00", "ns"), places, "local"), "SCHISM"
    )
    with xarray.open_dataset(names[0]) as data:
        nodes = np.stack((data.SCHISM_hgrid_node_x.to_numpy(), data.SCHISM_hgrid_node_y.to_numpy()), axis=1)
        faces = data.SCHISM_hgrid_face_nodes.to_numpy()
    parts = [xarray.load_dataset(names[k])[f"horizontalVel{axis}"].to_numpy() for k, axis in enumerate("XY")]
    heights = xarray.load_dataset(names[3]).zCoordinates.to_numpy()
    triangles = (
        np.array([(f[0], f[k], f[k + 1]) for f in faces for k in (1, 2) if np.isfinite(f[k + 1])], dtype=int) - 1
    )
    times = np.arange(24) * 3600.0

    def reference(place, t, depth):
        found = slow.triangle_about(nodes, triangles, place)
        if found is None:
            return None
        corners, shares = triangles[found[0]], found[1]

        def at(step):
            below = [heights[step, node].max() - heights[step, node] for node in corners]
            return np.array(
                [
                    shares
                    @ [slow.in_column(d, part[step, node], depth) for d, node in zip(below, corners, strict=True)]
                    for part in parts
                ]
            )

        return slow.in_time(times, t, at)

    assert compare(current, current.grid.points, 82_800.0, 10.0, reference) < WITHIN
