"""Fields on the grids of ocean models, written here by the models' formulas, against interpolation by brute force."""

from types import SimpleNamespace

import brute_force as slow
import numpy as np
import pytest
import scipy
from model_files import HOURS, bent_grid, fvcom, mesh_nodes, roms, split, ugrid
from pyproj import Transformer

from missionplan.errors import InputError
from missionplan.mission.schema.place import Geographic, curvature_of_parallel, to_geographic, to_plane
from missionplan.phases.currents import Span
from missionplan.phases.grids import RegularGrid
from missionplan.scenario.currents import regular as regular_grids
from missionplan.scenario.currents.area import SKIN, Area, _deepest
from missionplan.scenario.currents.reading import read_field
from missionplan.scenario.currents.unstructured import _coordinates, _sigma_levels
from missionplan.scenario.currents.vertical import good_down_to

netcdf = pytest.importorskip("netCDF4")
xarray = pytest.importorskip("xarray")
ORIGIN = Geographic.model_construct(latitude=np.radians(45.0), longitude=np.radians(-124.0))
START = np.datetime64("2026-05-01T12:00:00", "ns")


def area(**changes):
    return Area(**{"origin": ORIGIN, "start": START, "places": np.zeros((2, 1))} | changes)


def inner_points(points, count, rng):
    """Random places in the middle of a grid."""
    middle = points.mean(axis=1)
    reach = 0.4 * (points.max(axis=1) - points.min(axis=1))
    return middle[:, None] + rng.uniform(-reach[:, None], reach[:, None], (2, count))


@pytest.mark.parametrize("transform", [1, 2])
def test_roms_is_linear_between_its_nodes(tmp_path, transform):
    """Random places, times and depths: bilinear across, linear in depth and time, of turned means of the faces."""
    made = roms(tmp_path / "roms.nc", transform)
    current = read_field([str(tmp_path / "roms.nc")], area(), "roms.nc")
    rng = np.random.default_rng(8)
    rows, columns = made["angle"].shape
    x, y = current.grid.points.reshape(2, rows - 2, columns - 2)
    turned = [
        [slow.rho_points(u, v, made["angle"]) for u, v in zip(*now, strict=True)]
        for now in zip(made["u"], made["v"], strict=True)
    ]
    values = np.array(turned).transpose(0, 1, 3, 4, 2)[:, :, 1:-1, 1:-1]  # time, level, row, column, component
    place, t, depth = (
        inner_points(current.grid.points, 240, rng),
        rng.uniform(0.0, 10_800.0, 240),
        rng.uniform(0.0, 60.0, 240),
    )
    found = current.velocity(t, depth, place)
    compared = 0
    for k in range(240):
        cell = slow.quad_about(x, y, place[:, k])
        if cell is None:
            continue
        j, i, (a, b) = cell

        def at(step, j=j, i=i, a=a, b=b, k=k):
            total = np.zeros(2)
            for dj, di, weight in ((0, 0, (1 - a) * (1 - b)), (0, 1, a * (1 - b)), (1, 0, (1 - a) * b), (1, 1, a * b)):
                row, column = j + dj, i + di
                levels = slow.s_level_depths(
                    made["s"],
                    made["stretching"],
                    made["critical"],
                    transform,
                    made["bottom"][row + 1, column + 1],
                    made["surface"][step, row + 1, column + 1],
                )
                total += weight * np.array(
                    [slow.in_column(levels, values[step, :, row, column, part], depth[k]) for part in (0, 1)]
                )
            return total

        assert found[:, k] == pytest.approx(slow.in_time(HOURS * 3600.0, t[k], at), abs=1e-5)
        compared += 1
    assert compared > 200


def test_a_depth_for_all_trials_gives_the_same_as_one_a_trial(tmp_path):
    roms(tmp_path / "roms.nc", 2)
    current = read_field([str(tmp_path / "roms.nc")], area(), "roms.nc")
    rng = np.random.default_rng(1)
    place, t = inner_points(current.grid.points, 50, rng), rng.uniform(0.0, 10_800.0, 50)
    assert current.velocity(t, 7.0, place) == pytest.approx(current.velocity(t, np.full(50, 7.0), place), abs=1e-12)


def test_land_is_no_water_and_a_face_on_the_coast_has_no_flow(tmp_path):
    """West of the coast all is masked; the column beside it keeps half of the flow through its one open face."""
    rows, columns = bent_grid()[0].shape
    mask = np.ones((rows, columns))
    mask[:, :5] = 0.0
    u = np.full((HOURS.size, 5, rows, columns - 1), 0.4)
    u[..., :5] = np.nan  # faces of land, and the one on the coast
    v = np.zeros((HOURS.size, 5, rows - 1, columns))
    v[..., :5] = np.nan
    made = roms(tmp_path / "roms.nc", 2, mask=mask, u=u, v=v)
    current = read_field([str(tmp_path / "roms.nc")], area(), "roms.nc")
    points = current.grid.points.reshape(2, rows - 2, columns - 2)
    at = [points[:, 3, column][:, None] for column in (2, 4, 5)]
    assert [bool(current.holds(place)[0]) for place in at] == [False, True, True]
    assert not current.covers(Span(0.0, 600.0, 5.0, (at[0], at[0])))[0]
    assert current.covers(Span(0.0, 600.0, 5.0, (at[1], at[2])))[0]
    speeds = [np.hypot(*current.velocity(0.0, 5.0, place))[0] for place in at]
    assert speeds[1:] == pytest.approx([0.2, 0.4], abs=1e-6)
    assert speeds[0] == pytest.approx(0.2, abs=1e-6), "beyond the coast the nearest water, never none"
    assert made["mask"].sum() < rows * columns


def test_outside_in_space_time_and_depth_is_told(tmp_path):
    roms(tmp_path / "roms.nc", 2, bottom=np.full(bent_grid()[0].shape, 30.0), surface=np.zeros((HOURS.size, 9, 11)))
    current = read_field([str(tmp_path / "roms.nc")], area(), "roms.nc")
    here, away = np.zeros((2, 1)), np.array([[9e4], [0.0]])

    def covered(start, end, depth, *places):
        return bool(current.covers(Span(start, end, depth, places))[0])

    assert covered(0.0, 3600.0, 20.0, here, here)
    assert not covered(0.0, 3600.0, 20.0, here, away)
    assert not covered(0.0, 11_000.0, 20.0, here, here)
    assert covered(0.0, 3600.0, 36.0, here, here), "good to a fifth of the depth below the model's bottom"
    assert not covered(0.0, 3600.0, 36.1, here, here)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"angle": np.full((9, 11), 20.0)}, "its rows run .* from east, `angle` says .*degrees or radians"),
        ({"units": "furlong"}, "u is in 'furlong'; expected a speed"),
        ({"u": np.full((5, 5, 9, 10), 9999.0)}, "u reaches 9999 m/s; no current is faster"),
        ({"u": np.full((5, 5, 9, 10), np.nan), "v": np.full((5, 5, 8, 11), np.nan)}, "a time without any value"),
        ({"longitude": bent_grid()[0] + 5.0}, "holds nothing within 20 km of the mission"),
        ({"s": np.arange(5.0)}, "do not lie between -1 and 0"),
    ],
)
def test_what_no_model_means_is_refused(tmp_path, changes, message):
    roms(tmp_path / "roms.nc", 2, **changes)
    with pytest.raises(InputError, match=message):
        read_field([str(tmp_path / "roms.nc")], area(), "roms.nc")


def test_centimetres_and_degrees_are_converted_as_their_attributes_say(tmp_path):
    made = roms(tmp_path / "metres.nc", 2)
    others = {name: 100.0 * made[name] for name in ("u", "v")}
    roms(tmp_path / "other.nc", 2, angle=np.degrees(made["angle"]), angle_units="degrees", units="cm/s", **others)
    here = np.array([[100.0], [200.0]])
    first, second = (
        read_field([str(tmp_path / n)], area(), n).velocity(900.0, 8.0, here) for n in ("metres.nc", "other.nc")
    )
    assert first == pytest.approx(second, abs=1e-6)


@pytest.mark.parametrize("layers", [None, -np.array([0.1, 0.4, 0.8]), np.array([0.0, 5.0, 20.0])])
def test_a_ugrid_mesh_is_linear_in_triangles_and_in_depth(tmp_path, layers):
    made = ugrid(tmp_path / "mesh.nc", "node", layers)
    current = read_field([str(tmp_path / "mesh.nc")], area(projection="local"), "mesh.nc")
    rng = np.random.default_rng(9)
    nodes, triangles = np.stack((made["x"], made["y"]), axis=1), split(made["faces"])
    place, t = rng.uniform(-1900.0, 1900.0, (2, 200)), rng.uniform(0.0, 10_800.0, 200)
    depth = rng.uniform(0.0, 14.0, 200) if layers is not None else np.zeros(200)
    found = current.velocity(t, depth, place)
    for k in range(200):
        number, shares = slow.triangle_about(nodes, np.array(triangles), place[:, k])
        for part, name in enumerate(("ucx", "ucy")):

            def at(step, name=name, number=number, shares=shares, k=k):
                columns = []
                for node in triangles[number]:
                    if layers is None:
                        columns.append(made[name][step, node])
                        continue
                    levels = layers if layers.max() > 0.0 else -layers * made["bottom"][node]
                    columns.append(slow.in_column(levels, made[name][step, :, node], depth[k]))
                return shares @ columns

            assert found[part, k] == pytest.approx(slow.in_time(HOURS * 3600.0, t[k], at), abs=1e-6)


def test_velocities_at_faces_reproduce_a_linear_field_inside_and_the_nearest_cell_at_the_edge(tmp_path):
    made = ugrid(tmp_path / "mesh.nc", "face")
    centre = np.array([[np.mean([made[c][n - 1] for n in face if n > 0]) for c in "xy"] for face in made["faces"]])
    with netcdf.Dataset(tmp_path / "mesh.nc", "a") as file:
        file["ucx"][:] = 0.1 + centre @ np.array([2e-5, -1e-5])
        file["ucy"][:] = 0.2
    current = read_field([str(tmp_path / "mesh.nc")], area(projection="local"), "mesh.nc")
    place = np.random.default_rng(2).uniform(-1200.0, 1200.0, (2, 200))
    east, north = current.velocity(600.0, 0.0, place)
    assert east == pytest.approx(0.1 + np.array([2e-5, -1e-5]) @ place, abs=1e-7)
    assert north == pytest.approx(0.2, abs=1e-7)
    edge = np.array([[0.0], [-2150.0]])
    assert current.velocity(600.0, 0.0, edge)[0, 0] in np.float32(0.1 + centre @ np.array([2e-5, -1e-5]))


def test_coordinates_in_metres_need_a_projection(tmp_path):
    ugrid(tmp_path / "mesh.nc", "node")
    with pytest.raises(InputError, match=r"in metres of a projection that the file lacks.*site.current.projection"):
        read_field([str(tmp_path / "mesh.nc")], area(), "mesh.nc")


def test_the_places_of_a_meshs_nodes_are_told_by_their_units_not_their_order(tmp_path):
    made = ugrid(tmp_path / "mesh.nc", "node")
    latitude, longitude = to_geographic(made["x"], made["y"], ORIGIN)
    for order in ("node_x node_y", "node_y node_x"):
        with netcdf.Dataset(tmp_path / "mesh.nc", "a") as file:
            file["node_x"][:], file["node_y"][:] = np.degrees(longitude), np.degrees(latitude)
            file["node_x"].units, file["node_y"].units = "degrees_east", "degrees_north"
            file["mesh"].node_coordinates = order
        current = read_field([str(tmp_path / "mesh.nc")], area(), "mesh.nc")
        assert current.grid.points == pytest.approx(np.stack((made["x"], made["y"])), abs=0.01)


@pytest.mark.parametrize(("unit", "metres"), [("m", 1.0), ("km", 1000.0)])
def test_a_projection_places_the_mesh_and_turns_its_velocities(unit, metres, tmp_path):
    """UTM zone 10 has its meridian at 123° W: at 124° W and 45° N grid north is 0.71° west of north."""
    made = ugrid(tmp_path / "mesh.nc", "node")
    x, y = Transformer.from_crs("EPSG:4326", "EPSG:32610", always_xy=True).transform(-124.0, 45.0)
    with netcdf.Dataset(tmp_path / "mesh.nc", "a") as file:
        file["node_x"][:], file["node_y"][:] = (made["x"] + x) / metres, (made["y"] + y) / metres
        file["node_x"].units = file["node_y"].units = unit
        file["ucx"][:], file["ucy"][:] = 0.5, 0.0
    current = read_field([str(tmp_path / "mesh.nc")], area(projection="EPSG:32610"), "mesh.nc")
    velocity = current.velocity(0.0, 0.0, np.zeros((2, 1)))[:, 0]
    # west of its meridian the grid's north lies west of north, and its east north of east
    assert np.arctan2(velocity[1], velocity[0]) == pytest.approx(np.radians(1.0) * np.sin(np.radians(45.0)), abs=2e-4)
    assert np.hypot(*velocity) == pytest.approx(0.5, abs=1e-6)
    away = np.hypot(made["x"], made["y"])
    assert np.hypot(*current.grid.points) == pytest.approx(away, rel=1e-3, abs=0.1)


def test_files_are_joined_in_time_and_the_later_forecast_counts(tmp_path):
    for name, hours, speed in (("a.nc", [-1.0, 0.0, 1.0], 0.1), ("b.nc", [1.0, 2.0, 3.0], 0.3)):
        made = ugrid(tmp_path / name, "node")
        with netcdf.Dataset(tmp_path / name, "a") as file:
            file["ucx"][:] = speed
            file["time"][:] = np.array([*hours, 99.0, 100.0])
    names = [str(tmp_path / name) for name in ("a.nc", "b.nc")]
    current = read_field(names, area(projection="local"), "*.nc")
    assert current.time[:4] / 3600.0 == pytest.approx([0.0, 1.0, 2.0, 3.0])
    speeds = [current.velocity(hour * 3600.0, 0.0, np.zeros((2, 1)))[0, 0] for hour in (0.0, 0.5, 1.0, 3.0)]
    assert speeds == pytest.approx([0.1, 0.2, 0.3, 0.3])
    assert made["x"].size


def test_an_address_without_a_network_is_an_error_in_words():
    with pytest.raises(InputError, match=r"cannot be opened: .*an OPeNDAP address needs the network"):
        read_field(["http://127.0.0.1:9/field.nc"], area(), "field")


@pytest.mark.parametrize("gradients", [True, False])
def test_fvcom_has_a_gradient_in_each_cell(tmp_path, gradients):
    made = fvcom(tmp_path / "fvcom.nc", gradients)
    current = read_field([str(tmp_path / "fvcom.nc")], area(), "fvcom.nc")
    middles = current.grid.points.T
    rng = np.random.default_rng(7)
    place, t, depth = (
        rng.uniform(-1900.0, 1900.0, (2, 220)),
        rng.uniform(0.0, 10_800.0, 220),
        rng.uniform(0.0, 12.0, 220),
    )
    found = current.velocity(t, depth, place)
    x, y = mesh_nodes()
    corners = np.stack((x, y), axis=1) + np.array(
        [middles[:, 0].mean() - x[made["faces"]].mean(), middles[:, 1].mean() - y[made["faces"]].mean()]
    )
    edges = compared = 0
    for k in range(220):
        cell, shares = slow.triangle_about(corners, made["faces"], place[:, k])
        if shares.min() < 0.01:
            continue  # the plane of the package is not quite the one that the nodes were made in
        others = made["beside"][:, cell] - 1

        def column(step, name, which, k=k):
            h, zeta = (values[made["faces"][which]].mean() for values in (made["bottom"], made["surface"][step]))
            return slow.in_column(-made["sigma"] * (h + zeta), made[name][step, :, which], depth[k])

        for part, name in enumerate(("u", "v")):

            def at(step, cell=cell, others=others, name=name, k=k):
                own = column(step, name, cell)
                if others.min() < 0:
                    return own
                away = place[:, k] - middles[cell]
                about = np.array([column(step, name, other) for other in others])
                if gradients:
                    return own + away @ (made["a"][:, :, cell] @ np.append(own, about))
                return own + away @ np.linalg.lstsq(middles[others] - middles[cell], about - own, rcond=None)[0]

            assert found[part, k] == pytest.approx(slow.in_time(HOURS * 3600.0, t[k], at), abs=1e-5)
        edges += others.min() < 0
        compared += 1
    assert 0 < edges < compared // 2
    assert compared > 200


def test_a_field_of_the_surface_alone_serves_nothing_below_it(tmp_path):
    ugrid(tmp_path / "mesh.nc", "node")
    current = read_field([str(tmp_path / "mesh.nc")], area(projection="local"), "mesh.nc")
    here = np.zeros((2, 1))
    assert current.covers(Span(0.0, 600.0, 0.0, (here, here)))[0]
    assert not current.covers(Span(0.0, 600.0, 3.0, (here, here)))[0]


def test_what_is_read_of_a_wide_field_ends_in_a_failure_and_not_in_its_edge(tmp_path):
    """The current is linear in the file's coordinates, so that it tells whether the right part was read."""
    latitude, longitude = np.arange(44.0, 46.01, 0.05), np.arange(-126.0, -121.99, 0.05)

    def known(north, east):
        return 0.1 * (east + 124.0) - 0.2 * (north - 45.0)

    values = np.broadcast_to(known(latitude[:, None], longitude), (3, latitude.size, longitude.size))
    times = START + np.arange(-1, 2) * np.timedelta64(6, "h")
    xarray.Dataset(
        {
            key: (("time", "lat", "lon"), values, {"standard_name": name, "units": "m s-1"})
            for key, name in (("u", "eastward_sea_water_velocity"), ("v", "northward_sea_water_velocity"))
        },
        {"time": times, "lat": latitude, "lon": longitude},
    ).to_netcdf(tmp_path / "wide.nc")
    current = read_field([str(tmp_path / "wide.nc")], area(), "wide.nc")
    assert current.grid.points.shape[1] < latitude.size * longitude.size / 10
    at = np.array([[45.0, 44.85, 45.0, 44.5], [-124.22, -123.8, -123.5, -124.0]])
    places = np.concatenate(to_plane(*np.radians(at), ORIGIN)).reshape(2, -1)
    held = current.covers(Span(0.0, 3600.0, 0.0, (places, places)))
    assert held.tolist() == [True, True, False, False]
    np.testing.assert_allclose(current.velocity(600.0, 0.0, places)[:, :2], [known(*at[:, :2])] * 2, atol=1e-4)


def regular(path, rng, *, descending):
    """Write random currents on a regular grid with depth; returns its axes [h, m, degrees] and u, v."""
    latitude, longitude = np.linspace(44.9, 45.1, 9), np.linspace(-124.15, -123.85, 8)
    latitude = latitude[::-1] if descending else latitude
    hours, depth = np.array([-1.0, 0.0, 1.0, 2.0, 3.0]), np.array([0.0, 3.0, 8.0, 20.0])
    values = rng.uniform(-0.6, 0.6, (2, hours.size, depth.size, latitude.size, longitude.size))
    with netcdf.Dataset(path, "w") as file:
        axes = {"time": hours, "depth": depth, "lat": latitude, "lon": longitude}
        for name, numbers in axes.items():
            file.createDimension(name, numbers.size)
            file.createVariable(name, "f8", (name,))[:] = numbers
        file["time"].units, file["depth"].units = f"hours since {START}", "m"
        for name, part, toward in (("uo", values[0], "eastward"), ("vo", values[1], "northward")):
            variable = file.createVariable(name, "f8", tuple(axes))
            variable.units, variable.standard_name = "m s-1", f"{toward}_sea_water_velocity"
            variable[:] = part
    return axes, values


@pytest.mark.parametrize("descending", [False, True])
def test_a_regular_grid_with_depth_is_linear_in_all_four(tmp_path, descending):
    """1000 random places, times and depths, against scipy's interpolation in the file's own coordinates."""
    rng = np.random.default_rng(17)
    axes, values = regular(tmp_path / "regular.nc", rng, descending=descending)
    current = read_field([str(tmp_path / "regular.nc")], area(), "regular.nc")
    x, y = to_plane(*np.radians(np.meshgrid(axes["lat"], axes["lon"], indexing="ij")), ORIGIN)
    nodes = np.stack((x.ravel(), y.ravel()))
    place, t, depth = inner_points(nodes, 1000, rng), rng.uniform(0.0, 10_800.0, 1000), rng.uniform(0.0, 25.0, 1000)
    latitude, longitude = np.degrees(to_geographic(*place, ORIGIN))
    at = np.stack((t / 3600.0, np.minimum(depth, axes["depth"][-1]), latitude, longitude), axis=1)
    found = current.velocity(t, depth, place)
    for part, component in zip(values, found, strict=True):
        numbers = (axes["time"], axes["depth"], axes["lat"], axes["lon"])
        theory = scipy.interpolate.interpn(numbers, part, at)
        assert component == pytest.approx(theory, abs=1e-4)


@pytest.mark.parametrize("latitude", [-60.0, -33.0, 0.0, 45.0, 60.0])
@pytest.mark.parametrize(("distance", "within"), [(10_000.0, 0.05), (50_000.0, 6.0)])
def test_parallels_and_meridians_bend_as_on_the_ellipsoid(latitude, distance, within):
    origin = Geographic.model_construct(latitude=np.radians(latitude), longitude=np.radians(170.0))
    grid = RegularGrid(np.zeros(2), np.zeros(2), curvature_of_parallel(origin.latitude))
    place = np.random.default_rng(5).uniform(-distance, distance, (2, 500))
    at = to_geographic(*place, origin)
    column, _ = to_plane(np.full(500, origin.latitude), at[1], origin)
    _, row = to_plane(at[0], np.full(500, origin.longitude), origin)
    assert np.abs(grid.on_grid(place) - (column, row)).max() < within


def test_an_address_is_passed_to_xarray_which_alone_knows_how_to_read_it(tmp_path, monkeypatch):
    """As with a network: what xarray returns for the address is read like a file."""
    regular(tmp_path / "regular.nc", np.random.default_rng(3), descending=False)
    address, asked = "https://thredds.example.org/dodsC/forecast", []
    whole = xarray.open_dataset

    def opened(name, **options):
        asked.append(name)
        return whole(tmp_path / "regular.nc" if name == address else name, **options)

    monkeypatch.setattr(xarray, "open_dataset", opened)
    far, near = (read_field([name], area(), name) for name in (address, str(tmp_path / "regular.nc")))
    assert asked[0] == address
    place, t = np.zeros((2, 5)), np.linspace(0.0, 9000.0, 5)
    assert far.velocity(t, 4.0, place).tolist() == near.velocity(t, 4.0, place).tolist()


def test_a_file_that_is_no_field_is_refused_in_plain_words(tmp_path):
    (tmp_path / "notes.nc").write_text("not a field")
    with pytest.raises(InputError, match=r"notes\.nc: is no NetCDF file; expected NetCDF 3 or 4$"):
        read_field([str(tmp_path / "notes.nc")], area(), "notes.nc")
    whole = tmp_path / "regular.nc"
    regular(whole, np.random.default_rng(3), descending=False)
    whole.write_bytes(whole.read_bytes()[:300])
    with pytest.raises(InputError, match="cannot be read as NetCDF"):
        read_field([str(whole)], area(), "regular.nc")


def test_a_regular_grid_in_metres_is_refused(tmp_path):
    metres = np.arange(-5000.0, 5001.0, 1000.0)
    values = np.zeros((1, metres.size, metres.size))
    xarray.Dataset(
        {
            key: (("time", "lat", "lon"), values, {"standard_name": name, "units": "m s-1"})
            for key, name in (("u", "eastward_sea_water_velocity"), ("v", "northward_sea_water_velocity"))
        },
        {"time": [START], "lat": ("lat", metres, {"units": "m"}), "lon": ("lon", metres, {"units": "m"})},
    ).to_netcdf(tmp_path / "metres.nc")
    with pytest.raises(InputError, match="in degrees"):
        read_field([str(tmp_path / "metres.nc")], area(), "metres.nc")


def test_of_a_regular_grid_is_read_what_a_mission_to_the_north_near_the_pole_needs(tmp_path):
    """The speed is the distance from the origin in degrees: at 80 N those of longitude are short."""
    latitude, longitude = np.linspace(78.0, 82.0, 21), np.linspace(0.0, 20.0, 51)
    speeds = np.broadcast_arrays(longitude[None, :] - 10.0, latitude[:, None] - 80.0)
    xarray.Dataset(
        {
            key: (("time", "lat", "lon"), values[None], {"standard_name": name, "units": "m s-1"})
            for key, name, values in (
                ("u", "eastward_sea_water_velocity", speeds[0]),
                ("v", "northward_sea_water_velocity", speeds[1]),
            )
        },
        {
            "time": [START],
            "lat": ("lat", latitude, {"units": "degrees_north"}),
            "lon": ("lon", longitude, {"units": "degrees_east"}),
        },
    ).to_netcdf(tmp_path / "pole.nc")
    origin = Geographic.model_construct(latitude=np.radians(80.0), longitude=np.radians(10.0))
    there = area(origin=origin, places=np.array([[0.0, 0.0], [0.0, 60_000.0]]))
    east, north = place = np.array([[55_000.0, -40_000.0], [100_000.0, -50_000.0]])
    found = read_field([str(tmp_path / "pole.nc")], there, "pole.nc").velocity(np.zeros(2), np.ones(2), place)
    expected = np.degrees(np.subtract(to_geographic(east, north, origin), [[origin.latitude], [origin.longitude]]))
    assert found == pytest.approx(expected[::-1], rel=0.05)  # of the plane, whose columns are straight


@pytest.mark.parametrize("by_terms", [False, True])
def test_heights_of_roms_are_in_the_units_that_their_attributes_say(tmp_path, by_terms):
    """Seafloor in cm, surface in mm, critical depth in km; the levels by ROMS's names, or by CF's terms alone."""
    for name in ("metres.nc", "others.nc"):
        roms(tmp_path / name, 2)
    with netcdf.Dataset(tmp_path / "others.nc", "a") as file:
        file["hc"].units = "m"
        for name, units, size in (("h", "cm", 0.01), ("zeta", "mm", 1e-3), ("hc", "km", 1000.0)):
            file[name].units = units
            file[name][...] = file[name][...] / size
        if by_terms:
            file["s_rho"].standard_name = "ocean_s_coordinate_g2"
            file["s_rho"].formula_terms = "s: s_rho C: stretched eta: zeta depth: h depth_c: hc"
            file.renameVariable("Cs_r", "stretched")
    found = [read_field([str(tmp_path / name)], area(), name) for name in ("metres.nc", "others.nc")]
    place = inner_points(found[0].grid.points, 40, np.random.default_rng(2))
    t, depth = np.linspace(0.0, 10_000.0, 40), np.linspace(1.0, 40.0, 40)
    assert found[1].velocity(t, depth, place) == pytest.approx(found[0].velocity(t, depth, place), abs=1e-6)


@pytest.mark.parametrize(
    ("standard", "transform"), [("", 1), ("ocean_s_coordinate_g1", 1), ("ocean_s_coordinate_g2", 2)]
)
def test_the_transform_that_roms_does_not_say_is_that_of_the_standard_name(tmp_path, standard, transform):
    for name in ("says.nc", "silent.nc"):
        roms(tmp_path / name, transform)
    with netcdf.Dataset(tmp_path / "silent.nc", "a") as file:
        file.renameVariable("Vtransform", "not_it")
        if standard:
            file["s_rho"].standard_name = standard
    one, other = (read_field([str(tmp_path / name)], area(), name) for name in ("says.nc", "silent.nc"))
    places = inner_points(one.grid.points, 40, np.random.default_rng(2))
    t, depth = np.linspace(0.0, 10_000.0, 40), np.linspace(1.0, 40.0, 40)
    np.testing.assert_array_equal(other.velocity(t, depth, places), one.velocity(t, depth, places))


@pytest.mark.parametrize("lacking", ["a1u", "a2u", "nbe"])
def test_of_gradients_that_are_not_all_there_none_is_taken(tmp_path, lacking):
    fvcom(tmp_path / "none.nc", gradients=False)
    fvcom(tmp_path / "lacking.nc", gradients=True)
    with netcdf.Dataset(tmp_path / "lacking.nc", "a") as file:
        file.renameVariable(lacking, f"not_{lacking}")
    one, other = (read_field([str(tmp_path / name)], area(), name) for name in ("none.nc", "lacking.nc"))
    places = inner_points(one.grid.points, 50, np.random.default_rng(1))
    t, depth = np.full(50, 1800.0), np.full(50, 4.0)
    np.testing.assert_array_equal(other.velocity(t, depth, places), one.velocity(t, depth, places))


def test_sigma_layers_rise_with_the_surface_and_are_good_to_the_bottom_under_the_highest():
    """Over 10 m with the surface at 0.5 and 2 m: a tenth and nine tenths of 10.5 and of 12 m."""
    values = {"siglay": np.array([-0.1, -0.9]), "h": np.full(3, 10.0)}
    files = SimpleNamespace(
        **{"required": lambda _, name: name, "fixed": values.get, "depths": lambda name, otherwise: values[name]},
        **{"named": lambda *names: names[0], "variable": lambda _: SimpleNamespace(dims=("time", "node"))},
        **{"series": lambda *_: np.array([[0.5] * 3, [2.0] * 3]), "height_factor": lambda *_: 1.0},
    )
    mesh = SimpleNamespace(
        nodes=np.arange(3),
        mean_over_faces=lambda values: values.mean(axis=-1, keepdims=True),  # one triangle
    )
    levels, good = _sigma_levels(files, mesh, np.zeros(2))
    assert levels == pytest.approx(np.array([[[1.05, 9.45]], [[1.2, 10.8]]]))
    assert good == pytest.approx(good_down_to(np.array([12.0])))


def test_a_column_is_good_to_the_level_below_its_deepest_value_or_beyond_the_last():
    """Values at 0, 10, 40 and 100 m: at one time down to a level, at another to one less deep."""
    levels = np.array([0.0, 10.0, 40.0, 100.0])
    values = np.where(np.tri(4, dtype=bool)[None], 1.0 + 0.0j, np.nan)
    values = np.concatenate((values, np.where(np.tri(4, k=-1, dtype=bool)[None], 1.0 + 0.0j, np.nan)))
    assert _deepest(levels, values) == pytest.approx([10.0, 40.0, 100.0, 120.0])
    assert _deepest(np.zeros(1), values[:, :, :1]).tolist() == [SKIN] * 4


def test_a_staggered_node_has_the_mean_of_its_faces_and_none_where_all_are_dry(monkeypatch):
    nan = np.nan
    u = np.array([[nan] * 3, [nan, nan, 3.0], [2.0, nan, nan], [nan] * 3])
    v = np.array([[nan, 4.0, nan, nan], [nan] * 4, [nan, 2.0, nan, nan]])
    whole = {"lon_rho": np.zeros((4, 4)), "u": u, "v": v}
    files = SimpleNamespace(
        named=lambda name: name,
        variable=lambda name: SimpleNamespace(shape=whole[name].shape, dims=("y", "x")),
        series=lambda name, _, window, dims: whole[name][None, window["y"], window["x"]],
    )
    monkeypatch.setattr(regular_grids, "velocities", lambda files, names, parts: parts[0] + 1j * parts[1])
    found = regular_grids._unstaggered(files, ("u", "v"), None, SimpleNamespace(rows=slice(0, 4), columns=slice(0, 4)))
    np.testing.assert_array_equal(found, [[[2.0j, 1.5], [1.0 + 1.0j, nan]]])


@pytest.mark.parametrize(
    ("named", "longitude", "taken"),
    [
        ({"lon", "lat"}, [0.0, 0.0], ("lon", "lat")),
        ({"lon", "lat", "x", "y"}, [0.0, 3.0], ("lon", "lat")),
        ({"lon", "lat", "x", "y"}, [0.0, 0.0], ("x", "y")),
        ({"x", "y"}, [0.0, 3.0], ("x", "y")),
    ],
)
def test_nodes_lie_at_x_and_y_where_longitudes_are_missing_or_all_nil(named, longitude, taken):
    files = SimpleNamespace(
        named=lambda name: name if name in named else None,
        fixed=lambda _: np.array(longitude),
        required=lambda what, *names: next(name for name in reversed(names) if name in named),
    )
    assert _coordinates(files, "lon", "lat", "x", "y") == taken
