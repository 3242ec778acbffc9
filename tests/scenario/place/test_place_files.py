"""One bay in every format, axis, convention and unit: the same depths; and files that cannot be meant."""

import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.mission.schema.place import BathymetryFile, Geographic, TideHeight
from missionplan.phases.place import Place, SeaLevel
from missionplan.scenario.grid_files import _SCALE, _TIE_POINT, esri, placed_pixels, without_fills
from missionplan.scenario.grid_files import netcdf as netcdf_grid
from missionplan.scenario.place import _evened, _index, _near, drawn_place, read_place
from missionplan.scenario.polygons import Chart, _windows
from missionplan.scenario.scenario import Scenario

shapely = pytest.importorskip("shapely")
xarray = pytest.importorskip("xarray")

LATITUDE, LONGITUDE = 37.0, -76.0
STEP = 0.002
MISSION = {
    "name": "a bay",
    "site": {"origin": {"latitude": f"{LATITUDE} deg", "longitude": f"{LONGITUDE} deg"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s", "fix_error": "3 m"},
    "phases": [
        {
            "transit": {
                **{"name": "out", "from": ["0 m", "0 m"], "to": ["2 km", "0 m"], "speed": "1.2 m/s"},
                **{"d_max": "1 km", "arrival_radius": "60 m"},
            }
        }
    ],
}


def axes():
    """Centres of cells, as in a pixel-registered grid."""
    return LONGITUDE + STEP * (np.arange(-60, 60) + 0.5), LATITUDE + STEP * (np.arange(-50, 50) + 0.5)


def elevation():
    x, y = axes()
    return -(20.0 + 500.0 * (x[None, :] - LONGITUDE) + 200.0 * (y[:, None] - LATITUDE))


@pytest.fixture
def write(tmp_path):
    def make(name, start=None, **site):
        path = tmp_path / f"{name}.yaml"
        data = MISSION | {"site": MISSION["site"] | site} | ({"start": start} if start else {})
        path.write_text(yaml.safe_dump(data))
        return path

    return make


def placed(path):
    return read_place(load(path))


def check(place, abs_=0.02):
    """Depth at the origin, and 1 km east of it."""
    degree = 1000.0 / (6378137.0 / math.sqrt(1 - 0.00669438 * math.sin(math.radians(LATITUDE)) ** 2))
    degree = math.degrees(degree / math.cos(math.radians(LATITUDE)))
    found = place.ground.depth_at(np.array([[0.0, 1000.0], [0.0, 0.0]]))
    assert found == pytest.approx([20.0, 20.0 + 500.0 * degree], abs=abs_)


def netcdf(path, values=None, names=("lat", "lon"), attrs=None, variable="elevation", order=slice(None), shift=0.0):
    x, y = axes()
    values = elevation() if values is None else values
    coords = {names[0]: (names[0], y[order], {"units": "degrees_north"})}
    coords |= {names[1]: (names[1], (x + shift), {"units": "degrees_east"})}
    attrs = {"units": "m"} if attrs is None else attrs
    xarray.Dataset({variable: (names, values[order].astype("f4"), attrs)}, coords=coords).to_netcdf(path)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"attrs": {"units": "m", "standard_name": "height_above_reference_ellipsoid"}},
        {"order": slice(None, None, -1)},
        {"shift": 360.0},
        {"names": ("latitude", "longitude")},
        {"values": -elevation(), "variable": "depth"},
        {"values": -elevation(), "variable": "anything", "attrs": {"units": "m", "positive": "down"}},
        {"values": 100.0 * elevation(), "attrs": {"units": "cm", "positive": "up"}},
        {
            "values": -elevation(),
            "variable": "deptho",
            "attrs": {"units": "m", "standard_name": "sea_floor_depth_below_geoid"},
        },
    ],
    ids=str,
)
def test_netcdf_in_every_convention(tmp_path, write, changes):
    netcdf(tmp_path / "bay.nc", **changes)
    check(placed(write("m", bathymetry={"file": "bay.nc"})))


def test_a_projected_netcdf_is_placed_by_its_grid_mapping(tmp_path, write):
    from pyproj import CRS, Transformer

    system = CRS.from_epsg(32618)
    to = Transformer.from_crs(system, 4326, always_xy=True)
    x0, y0 = Transformer.from_crs(4326, system, always_xy=True).transform(LONGITUDE, LATITUDE)
    x, y = x0 + np.arange(-9000, 9000, 150.0), y0 + np.arange(-9000, 9000, 150.0)
    longitude, latitude = to.transform(*np.meshgrid(x, y))
    values = 20.0 + 500.0 * (longitude - LONGITUDE) + 200.0 * (latitude - LATITUDE)
    data = xarray.Dataset(
        {"depth": (("y", "x"), values, {"units": "m", "grid_mapping": "crs"}), "crs": ((), 0, system.to_cf())},
        coords={"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})},
    )
    data.to_netcdf(tmp_path / "utm.nc")
    check(placed(write("m", bathymetry={"file": "utm.nc"})))


def test_a_grid_in_kilometres_that_names_no_system_is_in_metres(tmp_path):
    units = {"units": "km"}
    data = xarray.Dataset(
        {"depth": (("y", "x"), np.full((2, 3), 20.0), {"units": "m"})},
        coords={"x": ("x", [0.0, 0.5, 1.0], units), "y": ("y", [3.0, 4.5], units)},
    )
    data.to_netcdf(tmp_path / "km.nc")
    grid = netcdf_grid(Chart("k", BathymetryFile(file=str(tmp_path / "km.nc")), None, np.zeros(2), np.ones(2)))
    assert (grid.x.tolist(), grid.y.tolist()) == ([0.0, 500.0, 1000.0], [3000.0, 4500.0])


@pytest.mark.parametrize("kind", ["int16", "float32"])
@pytest.mark.parametrize("south_up", [False, True])
def test_geotiff(tmp_path, write, kind, south_up):
    x, y = axes()
    tags, values = ImageFileDirectory_v2(), elevation()
    tags[34735] = (1, 1, 0, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    if south_up:
        tags[34264] = (STEP, 0.0, 0.0, x[0] - STEP / 2, 0.0, STEP, 0.0, y[0] - STEP / 2, *[0.0] * 8)
    else:
        tags[33550], tags[33922] = (STEP, STEP, 0.0), (0.0, 0.0, 0.0, x[0] - STEP / 2, y[-1] + STEP / 2, 0.0)
        values = values[::-1]
    values = np.round(values) if kind == "int16" else values.copy()
    values[50, 40] = -32768
    tags[42113] = "-32768"
    Image.fromarray(values.astype(kind)).save(tmp_path / "bay.tif", tiffinfo=tags)
    place = placed(write("m", bathymetry={"file": "bay.tif"}))
    check(place, abs_=0.6 if kind == "int16" else 0.02)
    assert np.isnan(place.ground.depth).sum() == 1


@pytest.mark.parametrize("corner", ["corner", "center"])
def test_esri_grid(tmp_path, write, corner):
    x, y = axes()
    values = elevation()[::-1].copy()
    values[50, 40] = -9999.0
    half = STEP / 2 if corner == "corner" else 0.0
    head = f"ncols {x.size}\nNROWS {y.size}\nxll{corner} {x[0] - half}\nyll{corner} {y[0] - half}\ncellsize {STEP}\n"
    rows = "\n".join(" ".join(f"{value:.4f}" for value in row) for row in values)
    (tmp_path / "bay.asc").write_text(f"{head}NODATA_value -9999\n{rows}\n")
    place = placed(write("m", bathymetry={"file": "bay.asc"}))
    check(place)
    assert np.isnan(place.ground.depth).sum() == 1


def test_cells_that_are_higher_than_wide_and_a_tie_point_inside_are_where_they_say(tmp_path):
    """Columns 10 m and rows 20 m apart from a corner at (100, 50); a tie at the third row's fourth corner."""
    (tmp_path / "bay.asc").write_text("ncols 3\nnrows 2\nxllcorner 100\nyllcorner 50\ndx 10\ndy 20\n1 2 3 4 5 6\n")
    grid = esri(Chart("k", BathymetryFile(file=str(tmp_path / "bay.asc")), None, np.zeros(2), np.ones(2)))
    assert (grid.x.tolist(), grid.y.tolist()) == ([105.0, 115.0, 125.0], [80.0, 60.0])
    assert grid.values.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    tags = {_SCALE: (10.0, 20.0, 0.0), _TIE_POINT: (3.0, 2.0, 0.0, 130.0, 50.0, 0.0)}
    assert placed_pixels(None, tags) == ((100.0, 10.0), (90.0, -20.0), None)


@pytest.mark.parametrize(
    ("separator", "point", "names"),
    [
        *[
            (" ", ".", "x y z"),
            (",", ".", "lon lat z"),
            ("; ", ".", ""),
            (", ", ".", ""),
            (" ,", ".", ""),
            ("\t", ",", "lon lat z"),
        ],
        *[
            (";", ",", ""),
            (" ", ",", "lat lon z"),
            (",", ".", "Latitude Longitude Depth_m"),
            (";", ",", "Lon Lat depth"),
        ],
    ],
)
def test_xyz_of_a_grid_in_any_order(tmp_path, write, separator, point, names):
    x, y = axes()
    rows = np.stack([axis.ravel() for axis in (*np.meshgrid(x, y), elevation())], axis=1)
    np.random.default_rng(1).shuffle(rows)
    if "epth" in names:
        rows[:, 2] *= -1.0
    if names.lower().startswith("lat"):
        rows = rows[:, [1, 0, 2]]
    rows[5, 2] = -9999.0  # not known there
    text = "\n".join(separator.join(f"{value:.8f}".replace(".", point) for value in row) for row in rows)
    header = separator.join(names.split())
    (tmp_path / "bay.xyz").write_text(f"# x y z\n{header}\n{text}\n")
    check(placed(write("m", bathymetry={"file": "bay.xyz"})))


def test_soundings_anywhere_and_depths_that_count_down(tmp_path, write):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-9000, 9000, (2, 3000))
    rows = np.stack((x, y, 20.0 + 0.004 * x + 0.002 * y), axis=1)
    np.savetxt(tmp_path / "soundings.xyz", rows)
    site = {"file": "soundings.xyz", "projection": "local", "positive": "down"}
    found = placed(write("m", bathymetry=site)).ground.depth_at(np.array([[0.0, 1000.0], [0.0, 500.0]]))
    assert found == pytest.approx([20.0, 25.0], abs=0.05)


def test_contours_of_a_slope(tmp_path, write):
    lines = [
        {
            "type": "Feature",
            "properties": {"depth": float(depth)},
            "geometry": {
                "type": "LineString",
                "coordinates": [
                    [LONGITUDE + (depth - 20.0) / 500.0, LATITUDE + at] for at in np.linspace(-0.1, 0.1, 81)
                ],
            },
        }
        for depth in range(0, 60, 2)
    ]
    (tmp_path / "c.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": lines}))
    check(placed(write("m", bathymetry={"file": "c.geojson"})), abs_=0.3)


def test_polygons_are_the_same_in_geojson_shapefile_and_geopackage(tmp_path, write):
    geopandas = pytest.importorskip("geopandas")
    ring = shapely.box(-76.0 + 0.01, 37.0 - 0.002, -76.0 + 0.012, 37.0 + 0.002)
    frame = geopandas.GeoDataFrame({"name": ["islet"]}, geometry=[ring], crs=4326)
    frame.to_file(tmp_path / "islet.geojson")
    frame.to_file(tmp_path / "islet.gpkg")
    frame.to_crs(32618).to_file(tmp_path / "islet.shp")
    frame.to_crs(32618).to_file(tmp_path / "islet.json", driver="GeoJSON")  # which names it by `crs`
    endings = ("geojson", "gpkg", "shp", "json")
    zones = [placed(write(ending, land={"file": f"islet.{ending}"})).zones[0] for ending in endings]
    assert {zone.name for zone in zones} == {"islet"}
    for zone in zones[1:]:
        assert zone.geometry.hausdorff_distance(zones[0].geometry) < 0.05


def test_times_and_depths_of_a_zone(tmp_path, write):
    feature = {
        "type": "Feature",
        "properties": {
            "name": "range",
            "from": "2026-06-01T09:00:00.000000+01:00",
            "to": "2026-06-01T10:00Z",
            "above": "30 ft",
        },
        "geometry": shapely.geometry.mapping(shapely.box(-76.01, 36.99, -75.99, 37.01)),
    }
    (tmp_path / "k.geojson").write_text(json.dumps(feature))
    (zone,) = placed(write("m", start="2026-06-01T07:00Z", keep_out={"file": "k.geojson"})).zones
    assert (zone.since, zone.until, zone.above, zone.is_land) == (3600.0, 10800.0, pytest.approx(9.144), False)
    feature["properties"] |= {"above": 5, "below": 20}
    (tmp_path / "k.geojson").write_text(json.dumps(feature))
    zones = placed(write("m", start="2026-06-01T07:00Z", keep_out={"file": "k.geojson"})).zones
    assert [(zone.above, zone.below) for zone in zones] == [(5.0, -math.inf), (math.inf, 20.0)]
    feature["properties"] |= {"above": 30, "below": 20}  # what is between alone
    (tmp_path / "k.geojson").write_text(json.dumps(feature))
    (zone,) = placed(write("m", start="2026-06-01T07:00Z", keep_out={"file": "k.geojson"})).zones
    assert (zone.above, zone.below) == (30.0, 20.0)
    with pytest.raises(InputError, match="start"):
        placed(write("m", keep_out={"file": "k.geojson"}))


@pytest.mark.parametrize(
    ("site", "words"),
    [
        ({"bathymetry": {"file": "no.nc"}}, "no such file"),
        ({"bathymetry": {"file": "broken.nc"}}, "NetCDF"),
        ({"bathymetry": {"file": "away.nc"}}, "nothing about the mission"),
        ({"bathymetry": {"file": "both.nc"}}, "both signs"),
        ({"bathymetry": {"file": "bay.nc", "variable": "elevations"}}, "elevations"),
        ({"bathymetry": {"file": "bay.nc"}, "depth": "20 m"}, "beside site.bathymetry"),
        ({"bathymetry": {"file": "bay.nc", "projection": "EPSG:999999"}}, "no reference system"),
        ({"bathymetry": {"file": "curved.nc"}}, "no coordinates along i"),
        ({"land": {"file": "line.geojson"}}, "no polygons"),
        ({"land": {"file": "bay.nc"}}, "expected .geojson"),
        ({"land": {"file": "broken.geojson"}}, "GeoJSON"),
        ({"land": {"file": "nested.geojson"}}, "cannot be read as GeoJSON: RecursionError"),
        ({"land": {"file": "named.geojson"}}, "`properties` of a feature are no object"),
        ({"bathymetry": {"file": "short.asc"}}, "has 3 values"),
        ({"bathymetry": {"file": "words.xyz"}}, "line 3"),
    ],
)
def test_a_file_that_cannot_be_meant_is_named_with_its_key(tmp_path, write, site, words):
    netcdf(tmp_path / "bay.nc")
    netcdf(tmp_path / "away.nc", shift=30.0)
    netcdf(tmp_path / "both.nc", values=elevation() + 20.0, variable="level")
    xarray.Dataset(
        {"elevation": (("j", "i"), elevation(), {"units": "m"})}, {"j": np.arange(len(elevation()))}
    ).to_netcdf(tmp_path / "curved.nc")
    (tmp_path / "broken.nc").write_bytes(b"nothing")
    line = {"type": "LineString", "coordinates": [[-76, 37], [-76.1, 37]]}
    (tmp_path / "line.geojson").write_text(json.dumps(line))
    (tmp_path / "broken.geojson").write_text('{"type": "Polygon"')
    (tmp_path / "nested.geojson").write_text("[" * 100_000)
    named = {"type": "Feature", "properties": ["name"], "geometry": shapely.geometry.mapping(shapely.box(0, 0, 1, 1))}
    (tmp_path / "named.geojson").write_text(json.dumps(named))
    (tmp_path / "short.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n")
    (tmp_path / "words.xyz").write_text("0 0 1\n1 0 1\n0 x 1\n1 1 1\n")
    with pytest.raises(InputError, match=words) as caught:
        placed(write("m", **site))
    (problem,) = caught.value.problems
    assert problem.key.startswith("site")


def test_a_tide_moves_the_depth(tmp_path, write):
    netcdf(tmp_path / "bay.nc")
    grid, here = {"file": "bay.nc"}, np.zeros((2, 3))
    t = np.array([0.0, 1800.0, 3600.0])
    place = placed(write("m", bathymetry=grid, tide_height="0.5 m"))
    assert place.water_at(here, t) == pytest.approx([20.5] * 3, abs=0.02)
    (tmp_path / "tide.csv").write_text("t_s,height_m\n0,0\n3600,1.2\n")
    place = placed(write("m", bathymetry=grid, tide_height={"file": "tide.csv", "level": "-1 m"}))
    assert place.water_at(here, t) == pytest.approx([19.0, 19.6, 20.2], abs=0.02)
    (tmp_path / "tide.csv").write_text("t_s,height_m\n0,0,5\n3600,1,2\n")  # decimal commas
    with pytest.raises(InputError, match="more cells than the header"):
        placed(write("m", bathymetry=grid, tide_height={"file": "tide.csv"}))


def test_a_constituent_has_its_period_and_amplitude_and_the_error_its_spread(tmp_path, write):
    netcdf(tmp_path / "bay.nc")
    wave = {"name": "M2", "amplitude": "0.4 m", "phase": "100 deg"}
    tide = {"constituents": [wave], "error": {"mean": "0 m", "sd": "0.1 m"}}
    path = write("m", start="2026-06-01T07:00Z", bathymetry={"file": "bay.nc"}, tide_height=tide)
    drawn = Scenario.at_means(load(path)).sampled(seed=1, block=0, size=4000)
    assert np.std(drawn.place.sea_level.level) == pytest.approx(0.1, rel=0.05)
    hours = np.arange(0.0, 24.85, 0.05)
    tide_alone = placed(path).sea_level.at(3600.0 * hours)
    assert tide_alone.max() == pytest.approx(0.4, rel=0.04)  # the node changes M2 by at most 3.8 %
    assert hours[np.argmax(tide_alone[:240])] + 12.42 == pytest.approx(
        hours[248 + np.argmax(tide_alone[248:])], abs=0.1
    )


def test_high_water_is_when_greenwich_has_it_and_a_record_by_dates_counts_from_the_start(tmp_path, write):
    """S2 of phase 90° is high at 3 and 15 h UTC: 8 h after a start at 7 h, and at mean level 5 h after it."""
    netcdf(tmp_path / "bay.nc")
    tide = {"constituents": [{"name": "S2", "amplitude": "0.4 m", "phase": "90 deg"}]}
    level = placed(write("m", start="2026-06-01T07:00Z", bathymetry={"file": "bay.nc"}, tide_height=tide)).sea_level
    assert level.at(3600.0 * np.array([8.0, 6.5, 5.0, 2.0])) == pytest.approx([0.4, 0.283, 0.0, -0.4], abs=0.01)
    (tmp_path / "tide.csv").write_text("t_s,height_m\n2026-06-01T08:00Z,1.2\n2026-06-01T07:00Z,0\n")
    tide = {"file": "tide.csv"}
    level = placed(write("m", start="2026-06-01T07:00Z", bathymetry={"file": "bay.nc"}, tide_height=tide)).sea_level
    assert level.at(np.array([0.0, 1800.0, 3600.0])) == pytest.approx([0.0, 0.6, 1.2])
    (tmp_path / "tide.csv").write_text("t_s,height_m\n2026-06-01T08:00Z,1.2\n0,0\n2026-06-01T10:00+02:00,3\n")
    with pytest.raises(InputError, match=r"tide\.csv:4: this row has the time of an earlier one"):
        placed(write("m2", start="2026-06-01T07:00Z", bathymetry={"file": "bay.nc"}, tide_height=tide))


def test_continents_collections_and_crossed_outlines_are_read(tmp_path, write):
    land = shapely.box(-130.0, 20.0, -75.99, 60.0).difference(shapely.box(-76.5, 36.5, -75.995, 37.5))
    bowtie = {
        "type": "Polygon",
        "coordinates": [[[-76.01, 37], [-76.0, 37.01], [-76.0, 37], [-76.01, 37.01], [-76.01, 37]]],
    }
    both = {"type": "GeometryCollection", "geometries": [shapely.geometry.mapping(land), bowtie]}
    (tmp_path / "land.geojson").write_text(json.dumps(both))
    (zone,) = placed(write("m", land={"file": "land.geojson"})).zones
    assert zone.geometry.geom_type in ("Polygon", "MultiPolygon")
    assert zone.geometry.bounds[0] > -60_000.0  # cut to what the mission needs
    assert shapely.intersects(zone.geometry, shapely.Point(600.0, 0.0))  # the strip from 75.995 to 75.99 W
    assert not shapely.intersects(zone.geometry, shapely.Point(-5000.0, 0.0))


def test_of_a_continent_all_is_read_that_is_wanted():
    origin = Geographic(latitude=f"{LATITUDE} deg", longitude=f"{LONGITUDE} deg")
    chart = Chart("site.land", BathymetryFile(file="land.geojson"), origin, np.full(2, -5e3), np.full(2, 5e3))
    west, south, east, north = _windows(chart)[1]
    low, high = chart.from_plane(np.array([[-5e3, 5e3], [-5e3, 5e3]]), "EPSG:4326").T
    assert (np.array([west, south]) < low).all()
    assert (np.array([east, north]) > high).all()


def test_a_polygon_over_the_date_line_is_where_it_is(tmp_path, write):
    (tmp_path / "k.geojson").write_text(json.dumps(shapely.geometry.mapping(shapely.box(179.99, -1.0, 180.02, 1.0))))
    path = write("m", origin={"latitude": "0 deg", "longitude": "-179.99 deg"}, keep_out={"file": "k.geojson"})
    (zone,) = placed(path).zones
    assert zone.geometry.bounds[2] == pytest.approx(0.01 * 111_320.0, rel=1e-3)
    assert zone.geometry.bounds[0] == pytest.approx(-0.02 * 111_320.0, rel=1e-3)


def test_polygons_in_metres_that_name_no_system_are_refused(tmp_path, write):
    (tmp_path / "k.geojson").write_text(json.dumps(shapely.geometry.mapping(shapely.box(400.0, 0.0, 900.0, 50.0))))
    with pytest.raises(InputError, match="not degrees"):
        placed(write("m", keep_out={"file": "k.geojson"}))


def test_rows_of_a_grid_by_hand_and_what_trials_draw_of_a_place():
    axis = 10.0 * np.arange(11.0)
    assert _index(axis, np.array([-5.0, 0.0, 25.0, 104.0])) == pytest.approx([-0.5, 0.0, 2.5, 10.4])
    spans = {
        (33.0, 47.0): (2, 7),
        (-9.0, -4.9): (0, 2),
        (-9.0, -5.1): (0, 0),
        (104.9, 120.0): (9, 11),
        (105.1, 120.0): (0, 0),
    }
    for wanted, (first, end) in spans.items():
        found = _near(axis, np.array(wanted))
        assert (found.start, found.stop) == (first, end), wanted
    bent = axis + np.where(axis == 50.0, 5.0, 0.0)
    assert _evened(bent) is bent
    assert _evened(axis + 1e-9 * np.arange(11.0) ** 2)[5] == pytest.approx(50.0 + 5e-8, abs=1e-12)
    tide = TideHeight.model_construct(level=0.3, error=0.05)
    site = SimpleNamespace(tide_height=tide, clearance=0.7)
    drawn = SimpleNamespace(site=site, vehicle=SimpleNamespace(hull=SimpleNamespace(diameter=0.2)))
    found = drawn_place(Place(None, None, SeaLevel()), drawn)
    assert (found.sea_level.level, found.draught, found.clearance) == pytest.approx((0.35, 0.1, 0.7))


@pytest.mark.parametrize("hole", [False, True])
def test_an_edge_from_179_east_to_179_west_is_the_short_one(write, tmp_path, hole):
    site = {"origin": {"latitude": "37 deg", "longitude": "180 deg"}}
    ring = [[179.9, 36.9], [-179.9, 36.9], [-179.9, 37.1], [179.9, 37.1], [179.9, 36.9]]
    inner = [[[179.995, 36.99], [-179.99, 36.99], [-179.99, 37.01], [179.995, 37.01], [179.995, 36.99]]] * hole
    (tmp_path / "a.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring, *inner]}))
    land = {"file": "a.geojson"}
    (zone,) = placed(write("over", **site, land=land)).zones
    assert shapely.intersects(zone.geometry, shapely.Point(0.0, 0.0)) is np.bool_(not hole)
    assert shapely.intersects(zone.geometry, shapely.Point(-1000.0, 0.0))
    site["origin"]["longitude"] = "0 deg"
    assert not placed(write("elsewhere", **site, land=land)).zones


@pytest.mark.parametrize(
    ("header", "size"),
    [
        ("id,lon,lat,Depth (ft)", 0.3048),
        ("Depth [fathom];lat;lon", 1.8288),
        ("water_depth_m\tLongitude\tLatitude", 1.0),
    ],
)
def test_a_header_says_what_columns_are_and_in_which_unit(write, tmp_path, header, size):
    separator = next(each for each in ",;\t" if each in header)
    x, y = np.meshgrid(*axes())
    columns = {"id": x, "lo": x, "la": y, "de": -elevation() / size, "wa": -elevation() / size}
    cells = np.stack([columns[name[:2].lower()].ravel() for name in header.split(separator)], axis=1)
    np.savetxt(tmp_path / "a.csv", cells, "%.7f", separator, header=header, comments="")
    check(placed(write("m", bathymetry={"file": "a.csv"})))


@pytest.mark.parametrize("filled", [-999.0, 999.0, -99999.0, 9999.9])
def test_what_stands_for_no_depth_is_none(filled):
    depth = np.linspace(0.0, 300.0, 50)
    assert np.isnan(without_fills(np.where(depth > 200.0, filled, depth))).sum() == (depth > 200.0).sum()
    assert np.isfinite(without_fills(-np.arange(0.0, 12_000.0))).all()


@pytest.mark.filterwarnings("ignore:The 'generic' unit")  # pyogrio's with numpy 2.5, where a date is blank
def test_a_blank_date_or_depth_of_a_table_is_none(write, tmp_path):
    pyogrio = pytest.importorskip("pyogrio")
    areas = shapely.to_wkb(
        [shapely.box(LONGITUDE + x, LATITUDE, LONGITUDE + x + 0.01, LATITUDE + 0.01) for x in (0, 0.02)]
    )
    columns = {"from": np.array(["2026-06-01T08:00", "NaT"], dtype="datetime64[ms]"), "above": np.array([np.nan, 5.0])}
    pyogrio.raw.write(
        tmp_path / "a.gpkg", areas, list(columns.values()), list(columns), crs="EPSG:4326", geometry_type="Polygon"
    )
    zones = placed(write("m", start="2026-06-01T00:00Z", keep_out={"file": "a.gpkg"})).zones
    assert [(zone.since, zone.above) for zone in zones] == [(28_800.0, np.inf), (-np.inf, 5.0)]


@pytest.mark.parametrize("key", ["above", "below"])
def test_a_zones_depths_count_down(write, tmp_path, key):
    ring = [[LONGITUDE + x, LATITUDE + y] for x, y in ((0, 0), (0.01, 0), (0, 0.01), (0, 0))]
    feature = {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [ring]}, "properties": {key: -5}}
    (tmp_path / "a.geojson").write_text(json.dumps(feature))
    with pytest.raises(InputError, match=f"{key}: given -5, expected a depth, positive down"):
        placed(write("up", keep_out={"file": "a.geojson"}))


def test_polygons_far_away_are_told_of(write, tmp_path):
    ring = [[LATITUDE, LONGITUDE], [LATITUDE, LONGITUDE + 0.1], [LATITUDE + 0.1, LONGITUDE], [LATITUDE, LONGITUDE]]
    (tmp_path / "turned.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
    (notice,) = placed(write("turned", land={"file": "turned.geojson"})).notices
    found = re.fullmatch(r"site\.land: no polygon is near the mission; the nearest is (\S+) km away\.", notice)
    there, site = (np.radians(each) for each in ((LONGITUDE, LATITUDE), (LATITUDE, LONGITUDE)))
    cosine = np.sin(there[0]) * np.sin(site[0]) + np.cos(there[0]) * np.cos(site[0]) * np.cos(there[1] - site[1])
    assert float(found[1]) == pytest.approx(6371.0 * np.arccos(cosine), rel=0.01)


def test_a_hole_at_the_edge_of_its_polygon_is_water(tmp_path, write):
    """As where a land with a lake is cut at the date line."""
    ring = [[-76.02, 36.99], [-75.98, 36.99], [-75.98, 37.01], [-76.02, 37.01], [-76.02, 36.99]]
    lake = [[-75.99, 36.995], [-75.98, 36.995], [-75.98, 37.005], [-75.99, 37.005], [-75.99, 36.995]]
    (tmp_path / "land.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring, lake]}))
    (zone,) = placed(write("m", land={"file": "land.geojson"})).zones
    assert not shapely.intersects(zone.geometry, shapely.Point(1400.0, 0.0))
    assert shapely.intersects(zone.geometry, shapely.Point(1400.0, 900.0))


def test_polygons_of_a_mercator_map_over_the_date_line_keep_their_holes(tmp_path, write):
    turn = 20_037_508.342789244  # half of it, where longitudes begin anew
    box = shapely.box(-3e3, -3e3, 3e3, 3e3).difference(shapely.box(-1e3, -1e3, 1e3, 1e3))
    wrapped = shapely.transform(box, lambda points: points - [1.0, 0.0] * np.sign(points[:, :1]) * turn)
    said = {"crs": {"type": "name", "properties": {"name": "EPSG:3857"}}}
    (tmp_path / "land.geojson").write_text(json.dumps(shapely.geometry.mapping(wrapped) | said))
    origin = {"latitude": "0 deg", "longitude": "180 deg"}
    (zone,) = placed(write("m", origin=origin, land={"file": "land.geojson"})).zones
    assert zone.geometry.area == pytest.approx(32e6, rel=0.01)
    assert not shapely.intersects(zone.geometry, shapely.Point(0.0, 0.0))
