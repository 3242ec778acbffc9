"""One field written in the ways that CF allows, and in ways that it does not: the same current, or a refusal."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission.schema.place import Geographic, to_geographic
from missionplan.scenario.currents import attributes
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.files import undeclared_fill
from missionplan.scenario.currents.reading import member_count, read_field

netcdf = pytest.importorskip("netCDF4")
pytest.importorskip("xarray")
ORIGIN = Geographic.model_construct(latitude=np.radians(45.0), longitude=np.radians(-124.0))
DEPTHS = np.array([1.0, 5.0, 12.0, 20.0, 40.0])
"""Of the levels [m], where the seafloor is 50 m deep."""
FLOOR = 50.0
HOURS = np.arange(-2.0, 9.0)
LATITUDE, LONGITUDE = 45.0 + np.linspace(-0.2, 0.2, 5), -124.0 + np.linspace(-0.2, 0.2, 6)
MIDNIGHT = datetime.fromisoformat("2026-06-01T00:00+00:00")
DOWN = {"units": "m", "positive": "down", "standard_name": "depth"}
SIGMA = {
    "standard_name": "ocean_sigma_coordinate",
    "formula_terms": "sigma: lev eta: zeta depth: deep",
    "positive": "up",
}


def speeds():
    """Toward east and north, shape (t, d, y, x) [m/s]: another one at each depth and hour."""
    t, z = HOURS[:, None], DEPTHS[None, :]
    east, north = 0.5 - 0.3 * z / FLOOR + 0.02 * t, 0.1 + 0.004 * z - 0.01 * t
    return tuple(
        np.broadcast_to(each[:, :, None, None], (*each.shape, LATITUDE.size, LONGITUDE.size)) for each in (east, north)
    )


def write(path, *, time=(HOURS, {"units": "hours since 2026-06-01 00:00:00"}), lev=(DEPTHS, DOWN), speed=(1.0, {"units": "m s-1"}),
          lat=(LATITUDE, {"units": "degrees_north"}), lon=(LONGITUDE, {"units": "degrees_east"}), deep=None, zeta=None,
          flip=(), names=("lev", "lat", "lon", "u", "v"), more=None):  # fmt: skip
    """Write the field; what is not told is as in the plain file."""
    level, north, east, *components = names
    axes = {"time": time, level: lev, north: lat, east: lon}
    with netcdf.Dataset(path, "w") as file:
        file.createDimension("lat2", 2)
        for name, (values, attributes) in axes.items():
            file.createDimension(name, len(values))
            variable = file.createVariable(name, "f8", (name,))
            variable.setncatts(attributes)
            variable[:] = values[::-1] if name in flip else values
        step = tuple(slice(None, None, -1 if name in flip else 1) for name in axes)
        for name, values in zip(components, speeds(), strict=True):
            variable = file.createVariable(name, "f8", tuple(axes))
            variable.setncatts(speed[1].get(name, speed[1]))
            variable[:] = (values / speed[0])[step]
        for name, (values, attributes, dims) in (
            ((more or {}) | {"deep": deep, "zeta": zeta}).items() if deep or more else ()
        ):
            variable = file.createVariable(name, "f8", dims)
            variable.setncatts(attributes)
            variable[...] = values


def drift(path):
    """Displacement over five hours at 8 m and at 16 m, and between levels in a place that is no node [m]."""
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    current = read_field([str(path)], area, path.name)
    place = np.array([[700.0], [-900.0]])
    t = np.arange(0.0, 18_000.0, 600.0)
    return 600.0 * np.array([sum(current.velocity(each, depth, place)[:, 0] for each in t) for depth in (8.0, 16.0)])


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    path = tmp_path_factory.mktemp("cf") / "plain.nc"
    write(path)
    return drift(path)


def test_the_plain_field_is_the_one_that_was_written(plain):
    """Linear in depth and time, so that the drift is the formula's, summed."""
    hours = 0.5 + np.arange(0.0, 18_000.0, 600.0) / 3600.0
    for row, depth in zip(plain, (8.0, 16.0), strict=True):
        assert row[0] == pytest.approx(600.0 * np.sum(0.5 - 0.3 * depth / FLOOR + 0.02 * hours), rel=1e-6)
        assert row[1] == pytest.approx(600.0 * np.sum(0.1 + 0.004 * depth - 0.01 * hours), rel=1e-6)


def since(units, **shift):
    """Return the times of the field in units since another moment, which is that much after midnight UTC."""
    unit = timedelta(**{units[0]: 1})
    return (
        HOURS * timedelta(hours=1) / unit - timedelta(**shift) / unit,
        {"units": f"{units[0]} since {units[1]}"} | units[2],
    )


def deep(size=1.0, **attributes):
    return np.full((LATITUDE.size, LONGITUDE.size), FLOOR / size), {"units": "m"} | attributes, ("lat", "lon")


def level(size=1.0, offset=0.0, **attributes):
    return DEPTHS / size + offset, {key: value for key, value in (DOWN | attributes).items() if value is not None}


def zeta(hourly):
    """A surface that moves: levels of the sigma kind move with it, so that depths below it stay in the same share."""
    return np.broadcast_to(hourly, (HOURS.size, LATITUDE.size, LONGITUDE.size)), {"units": "m"}, ("time", "lat", "lon")


def stretched(kind):
    """Levels `s` that lie at the depths of the field by the formulas of CF, appendix D, with a surface at rest."""
    critical, a, b = 10.0, 3.0, 0.4
    s = np.linspace(-1.0, 0.0, 100_001)
    stretching = (1 - b) * np.sinh(a * s) / np.sinh(a) + b * (np.tanh(a * (s + 0.5)) / (2 * np.tanh(a / 2)) - 0.5)
    z = critical * s + (FLOOR - critical) * stretching
    if kind.endswith("g2"):
        z = FLOOR * (critical * s + FLOOR * stretching) / (critical + FLOOR)
    ours = np.interp(-DEPTHS, z, s)
    more = {
        "depth_c": (critical, {"units": "m"}, ()),
        "a": (a, {}, ()),
        "b": (b, {}, ()),
        "C": (np.interp(ours, s, stretching), {}, ("lev",)),
    }
    terms = "a: a b: b" if kind == "ocean_s_coordinate" else "C: C"
    attributes = {
        "standard_name": kind,
        "formula_terms": f"s: lev {terms} eta: zeta depth: deep depth_c: depth_c",
        "units": "1",
    }
    return {"lev": (ours, attributes), "deep": deep(), "zeta": zeta(0.0), "more": more}


SAME = {
    **{f"depth in {unit}": {"lev": level(size, units=unit)} for unit, size in {
        "cm": 0.01, "centimeters": 0.01, "ft": 0.3048, "feet": 0.3048, "km": 1000.0, "fathom": 1.8288, "Meters": 1.0, "metre": 1.0,
        "M": 1.0, "mm": 1e-3, "decimeter": 0.1, "0.1 m": 0.1}.items()},
    "heights": {"lev": level(-1.0, positive="up", standard_name="height")},
    "heights, Up": {"lev": level(-1.0, positive="Up", standard_name=None)},
    "heights in cm": {"lev": level(-0.01, units="cm", positive="up", standard_name=None)},
    "heights by their sign": {"lev": level(-1.0, positive=None, standard_name=None)},
    "depths by their sign": {"lev": level(positive=None, standard_name=None)},
    "depths by their standard name": {"lev": level(positive=None)},
    "names of attributes in capitals": {"lev": (DEPTHS / 0.01, {"Units": "cm", "POSITIVE": "Down"}), "speed": (0.01, {"UNITS": "cm/s"})},
    "depths beside the numbers of levels": {"lev": (np.arange(5.0), {"units": "1"}), "deep": deep(), "zeta": zeta(0.0),
        "more": {"a_share": (np.full(5, 0.2), {"units": "1"}, ("lev",)), "z_of_levels": (DEPTHS, DOWN, ("lev",))}},
    "from below": {"flip": ("lev",)},
    "from north": {"flip": ("lat",)},
    "from east": {"flip": ("lon",)},
    "backward in time": {"flip": ("time",)},
    "longitudes of 0 to 360": {"lon": (LONGITUDE + 360.0, {"units": "degreesE"})},
    "degree_N": {"lat": (LATITUDE, {"units": "degree_N"})},
    "coordinates by their units": {"names": ("lev", "ROW", "COLUMN", "u", "v")},
    "coordinates by standard names": {
        "names": ("z_axis", "row", "column", "east_speed", "north_speed"),
        "lat": (LATITUDE, {"units": "degrees_north", "standard_name": "latitude"}),
        "lon": (LONGITUDE, {"units": "degrees_east", "standard_name": "longitude"}),
        "speed": (1.0, {name: {"units": "m s-1", "standard_name": f"{way}_sea_water_velocity"}
                        for name, way in (("east_speed", "eastward"), ("north_speed", "northward"))}),
    },
    **{f"speed in {unit}": {"speed": (size, {"units": unit})} for unit, size in {
        "m/s": 1.0, "meter second-1": 1.0, "m s^-1": 1.0, "m.s-1": 1.0, "M S-1": 1.0, "cm s-1": 0.01, "cm s**-1": 0.01, "cm/sec": 0.01, "mm/s": 1e-3,
        "knots": 1852 / 3600, "kt": 1852 / 3600, "km/h": 1 / 3.6, "km hour-1": 1 / 3.6, "centimeters per second": 0.01, "ft/s": 0.3048, "0.01 m s-1": 0.01, "1e-2 m/s": 0.01}.items()},
    **{f"{units[0]} since {units[1]} {units[2]}": {"time": since(units, **shift)} for units, shift in [
        (("hours", "2026-06-01T02:00:00+02:00", {}), {}), (("hours", "2026-06-01 00:00 +02:00", {}), {"hours": -2}),
        (("seconds", "2026-05-31 19:00:00 -5", {}), {}), (("minutes", "2026-06-01T00:00:00Z", {}), {}),
        (("seconds", "1970-01-01T00:00:00Z", {}), {"days": -20605}), (("days", "1950-01-01", {}), {"days": -27910}),
        (("hours", "2026-06-01 00:00 UTC", {"calendar": "Gregorian"}), {}), (("hours", "2026-6-1 0:0:0.0", {"calendar": "proleptic_gregorian"}), {}),
        (("days", "0001-01-01", {"calendar": "proleptic_gregorian"}), {"days": -739767}), (("days", "0001-01-01", {"calendar": "standard"}), {"days": -739769})]},
    "timezone for time_zone": {"time": (HOURS - 7.0, {"units": "hours since 2026-06-01", "TimeZone": "-07:00"})},
    "means named by their starts": {"time": (HOURS - 0.5, {"units": "hours since 2026-06-01", "bounds": "ends"}),
        "speed": (1.0, {"units": "m s-1", "cell_methods": "area: mean time: mean"}), "deep": deep(), "zeta": zeta(0.0), "more": {"ends": (np.stack((HOURS - 0.5, HOURS + 0.5), 1), {}, ("time", "lat2"))}},
    "sigma": {"lev": (-DEPTHS / FLOOR, SIGMA), "deep": deep(), "zeta": zeta(0.0)},
    "sigma, seafloor in km": {"lev": (-DEPTHS / FLOOR, SIGMA), "deep": deep(1000.0, units="km"), "zeta": zeta(0.0)},
    "sigma, seafloor as a height": {"lev": (-DEPTHS / FLOOR, SIGMA), "deep": deep(-1.0, positive="up"), "zeta": zeta(0.0)},
    "sigma, all of it higher": {"lev": (-DEPTHS / FLOOR, SIGMA), "deep": (*deep(FLOOR / 45.0)[:1], *deep()[1:]), "zeta": zeta(5.0)},
    **{kind: stretched(kind) for kind in ("ocean_s_coordinate", "ocean_s_coordinate_g1", "ocean_s_coordinate_g2")},
}  # fmt: skip

REFUSED = {
    "no units of speed": ({"speed": (1.0, {})}, "u has no attribute `units`"),
    "speed in m": ({"speed": (1.0, {"units": "m"})}, "expected a speed"),
    "endless powers": ({"speed": (1.0, {"units": "9**9**9**9 m s-1"})}, "expected a speed"),
    "speed in 1": ({"speed": (1.0, {"units": "1"})}, "expected a speed"),
    "no units of depth": ({"lev": level(units=None)}, "lev has no attribute `units`"),
    "pressures": ({"lev": level(units="dbar", standard_name="sea_water_pressure")}, "lev is in 'dbar'; expected depths"),
    "numbers of levels": ({"lev": (np.arange(5.0), {"units": "1", "positive": "down"})}, "lev is in '1'; expected depths"),
    "above the seafloor": ({"lev": level(standard_name="height_above_sea_floor", positive="up")}, "lev is a height_above_sea_floor"),
    "downward above the surface": ({"lev": level(-1.0)}, "40 m above the surface"),
    "positive aside": ({"lev": level(positive="east")}, "positive = 'east'"),
    "both signs": ({"lev": level(1.0, -10.0, positive=None, standard_name=None)}, "both signs"),
    "sigma without terms": ({"lev": (-DEPTHS / FLOOR, {"standard_name": "ocean_sigma_coordinate"})}, "formula_terms lack depth"),
    "sigma without the file's seafloor": ({"lev": (-DEPTHS / FLOOR, SIGMA)}, "formula_terms of lev name zeta"),
    "sigma z": ({"lev": (-DEPTHS / FLOOR, SIGMA | {"standard_name": "ocean_sigma_z_coordinate"})}, "ocean_sigma_z_coordinate, which cannot"),
    "sigma the wrong way": ({"lev": (DEPTHS / FLOOR, SIGMA), "deep": deep(), "zeta": zeta(0.0)}, "between -1 and 0"),
    "femtometres, or fathoms": ({"lev": level(units="fm")}, "lev is in 'fm'; expected depths"),
    "a local time": ({"time": (HOURS, {"units": "hours since 2026-06-01", "long_name": "local time"})}, "says 'local time', its units UTC"),
    "wind by its long name": ({"speed": (1.0, {"units": "m s-1", "long_name": "10 m wind"})}, "u is a 10 m wind; expected the current"),
    "westward by its long name": ({"speed": (1.0, {"units": "m s-1", "long_name": "Westward velocity"})}, "u is a Westward velocity"),
    "greatest of a day": ({"speed": (1.0, {"units": "m s-1", "cell_methods": "time: maximum"})}, "u is a maximum; expected"),
    "EST": ({"time": (HOURS, {"units": "hours since 2026-06-01 00:00 EST"})}, "'EST' has no offset"),
    "months": ({"time": (HOURS, {"units": "months since 2026-06-01"})}, "time: units 'months since"),
    "noleap": ({"time": (HOURS, {"units": "hours since 2026-06-01", "calendar": "noleap"})}, "'noleap' is not the standard"),
    "360_day": ({"time": (HOURS, {"units": "hours since 2026-06-01", "calendar": "360_day"})}, "'360_day' is not the standard"),
    "no date": ({"time": (HOURS, {"units": "hours"})}, "its times are no dates"),
    "a zone by its name": ({"time": (HOURS, {"units": "hours since 2026-06-01", "time_zone": "US/Pacific"})}, "US/Pacific"),
    "radians": ({"lat": (np.radians(LATITUDE), {"units": "radian"})}, "lat is in 'radian'; expected degrees"),
    "two clocks": ({"time": (HOURS, {"units": "1"}), "deep": deep(), "zeta": zeta(0.0), "more": {name: (HOURS, {"units": "hours since 2026-06-01"}, ("time",)) for name in ("run", "valid")}}, "which of run, valid is the time"),
    "degrees_west": ({"lon": (-LONGITUDE, {"units": "degrees_west"})}, "lon is in 'degrees_west'; expected degrees east"),
    "components exchanged": ({"speed": (1.0, {name: {"units": "m s-1", "standard_name": f"{way}_sea_water_velocity"}
        for name, way in (("u", "northward"), ("v", "eastward"))})}, "u is a northward_sea_water_velocity; expected"),
    "swapped": ({"lat": (LATITUDE, {"units": "degrees_east"})}, "lat is in 'degrees_east'; expected degrees north"),
    "another pole": ({"lat": (LATITUDE, {"units": "degrees", "standard_name": "grid_latitude"})}, "about another pole"),
    "rows in km": ({"lat": (LATITUDE, {"units": "km"}), "lon": (LONGITUDE, {"units": "km"})}, "in metres; expected rows"),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_the_same_field_gives_the_same_drift(tmp_path, plain, name):
    write(tmp_path / "field.nc", **SAME[name])
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_told_is_refused_in_words(tmp_path, name):
    changes, message = REFUSED[name]
    write(tmp_path / "field.nc", **changes)
    with pytest.raises(InputError, match=message):
        drift(tmp_path / "field.nc")


@pytest.mark.parametrize(
    "order", [("lev", "lat", "lon", "time"), ("lev", "time", "lat", "lon"), ("time", "lon", "lev", "lat")]
)
def test_dimensions_stand_in_any_order(tmp_path, plain, order):
    xarray = pytest.importorskip("xarray")
    write(tmp_path / "plain.nc")
    with xarray.open_dataset(tmp_path / "plain.nc", decode_times=False) as field:
        field.transpose(*order).to_netcdf(tmp_path / "field.nc")
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)


def bent(path, kind, angle=0.5, names=("u", "v"), more=None):
    """The field on rows that run `angle` from east, its velocities along them where the standard names say so."""
    y, x = np.meshgrid(np.linspace(-25e3, 25e3, 11), np.linspace(-25e3, 25e3, 12), indexing="ij")
    place = to_geographic(x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), ORIGIN)
    east, north = (each[..., :1, :1] * np.ones(x.shape) for each in speeds())
    along = (east + 1j * north) * np.exp(-1j * angle * (kind[0] != "" and not kind[0].startswith("east")))
    axes = {"time": (HOURS, {"units": "hours since 2026-06-01"}, ("time",)), "lev": (DEPTHS, DOWN, ("lev",))}
    axes |= {name: (np.degrees(each), {}, ("j", "i")) for name, each in zip(("lat", "lon"), place, strict=True)}
    of_velocity = [{"units": "m s-1"} | ({"standard_name": each} if each else {}) for each in kind]
    speed = {name: (each, said, ("time", "lev", "j", "i"))
             for name, each, said in zip(names, (along.real, along.imag), of_velocity, strict=True)}  # fmt: skip
    with netcdf.Dataset(path, "w") as file:
        for name, size in {"time": HOURS.size, "lev": DEPTHS.size, "j": 11, "i": 12}.items():
            file.createDimension(name, size)
        for name, (values, said, dims) in {**axes, **speed, **(more or {})}.items():
            variable = file.createVariable(name, "f8", dims)
            variable.setncatts(said)
            variable[...] = values


def test_velocities_on_rows_that_do_not_run_east_say_along_what_they_are(tmp_path, plain):
    path = tmp_path / "field.nc"
    turned = {"angle": (np.full((11, 12), 0.5), {"units": "radian"}, ("j", "i"))}
    ways = [tuple(f"{each}_sea_water_velocity" for each in ("eastward", "northward")),
            tuple(f"sea_water_{each}_velocity" for each in "xy"), ("x_sea_water_velocity", "y_sea_water_velocity"),
            ("grid_eastward_sea_water_velocity", "grid_northward_sea_water_velocity")]  # fmt: skip
    for kind, names, more in [(ways[0], ("u", "v"), {}), (ways[0], ("u", "v"), turned), (ways[1], ("u", "v"), {}),
                              (ways[1], ("uo", "vo"), {}), (ways[2], ("u", "v"), {}), (ways[3], ("u", "v"), {}),
                              (("", ""), ("u_eastward", "v_northward"), turned)]:  # fmt: skip
        bent(path, kind, names=names, more=more)
        assert drift(path) == pytest.approx(plain, rel=2e-3)
    bent(path, ("", ""), angle=0.01)
    assert drift(path) == pytest.approx(plain, rel=2e-3)
    bent(path, ("", ""))
    with pytest.raises(InputError, match=r"is u toward east, or along its rows, which run 28\.6° from east\?"):
        drift(path)


def test_velocities_of_two_files_are_at_one_place(tmp_path, plain):
    xarray = pytest.importorskip("xarray")
    bent(tmp_path / "field.nc", [f"{each}_sea_water_velocity" for each in ("eastward", "northward")])
    paths = [str(tmp_path / f"{name}.nc") for name in "uv"]
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    for shift in (0.0, 0.01):
        with xarray.open_dataset(tmp_path / "field.nc", decode_times=False) as field:
            field.drop_vars("v").to_netcdf(paths[0])
            field.drop_vars("u").assign(lon=field["lon"] + shift).to_netcdf(paths[1])
        if shift:
            with pytest.raises(InputError, match="u and v are at other places: lon is another"):
                read_field(paths, area, "field")
        else:
            assert read_field(paths, area, "field").depth[0] == pytest.approx(DEPTHS[0])


def test_components_on_axes_of_their_own_are_asked_to_be_brought_together(tmp_path):
    xarray = pytest.importorskip("xarray")
    write(tmp_path / "plain.nc")
    with xarray.open_dataset(tmp_path / "plain.nc", decode_times=False) as field:
        field["v"] = field["v"].rename(lat="lat_v").assign_coords(lat_v=field["lat"].to_numpy() - 0.05)
        field.to_netcdf(tmp_path / "field.nc")
    with pytest.raises(InputError, match=r"u and v do not both lie along lat and lon .bring both to the middles"):
        drift(tmp_path / "field.nc")


def test_a_record_at_one_place_is_named(tmp_path):
    with netcdf.Dataset(tmp_path / "field.nc", "w") as file:
        for name in ("lat", "lon"):
            file.createVariable(name, "f8", ())[...] = 45.0
    with pytest.raises(InputError, match="is a record at one place: lat is one number"):
        drift(tmp_path / "field.nc")


def test_sigma_levels_move_with_the_surface(tmp_path):
    """A surface 5 m up and 45 m deep is a column of 50 m; one 5 m up and 50 m deep has each level 10 % deeper."""
    write(tmp_path / "field.nc", lev=(-DEPTHS / FLOOR, SIGMA), deep=deep(), zeta=zeta(5.0))
    hours = 0.5 + np.arange(0.0, 18_000.0, 600.0) / 3600.0
    for row, depth in zip(drift(tmp_path / "field.nc"), (8.0, 16.0), strict=True):
        assert row[0] == pytest.approx(600.0 * np.sum(0.5 - 0.3 * depth / 1.1 / FLOOR + 0.02 * hours), rel=1e-5)


def test_a_column_reaches_as_deep_as_its_highest_surface_makes_it(tmp_path):
    """50 m under a surface that rises to 5 m: good to a fifth more."""
    write(tmp_path / "field.nc", lev=(-DEPTHS / FLOOR, SIGMA), deep=deep(),
          zeta=zeta(np.linspace(-3.0, 5.0, HOURS.size)[:, None, None]))  # fmt: skip
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    assert read_field([str(tmp_path / "field.nc")], area, "field.nc").depth == pytest.approx([0.0, 1.2 * 55.0])


@pytest.mark.parametrize(
    ("filled", "unit", "size"),
    [(-9.0, "m s-1", 1.0), (9.0, "m s-1", 1.0), (99.9, "cm s-1", 0.01)],
)
def test_a_number_that_stands_for_none_is_no_current(tmp_path, filled, unit, size):
    path = tmp_path / "a.nc"
    write(path, speed=(size, {"units": unit}))
    with netcdf.Dataset(path, "a") as file:
        for name in ("u", "v"):
            file[name][:, 2:, 3, 4] = filled  # a land's column
    with pytest.raises(
        InputError, match=rf"u and v are both {filled:g} at many places, which is no current .*_FillValue"
    ):
        drift(path)


@pytest.mark.parametrize("packed", [False, True])
def test_what_is_beyond_the_valid_range_is_none(tmp_path, plain, packed):
    """9.5 and 8.5 m/s, in a land's column of 5 m/s and more that no fill value declares."""
    path = tmp_path / "a.nc"
    write(path)
    with netcdf.Dataset(path, "a") as file:
        for name, filled in (("u", 9.5), ("v", 8.5)):
            file.renameVariable(name, f"old_{name}")
            variable = file.createVariable(name, "i4" if packed else "f8", file[f"old_{name}"].dimensions)
            variable.setncatts(
                {"units": "m s-1", "valid_range": np.array([-5e5, 5e5], "i4") if packed else [-5.0, 5.0]}
            )
            if packed:
                variable.scale_factor = 1e-5
            variable[:] = file[f"old_{name}"][:]
            variable[:, :, 2, 2] = filled
    assert drift(path) == pytest.approx(plain, rel=1e-3)


@pytest.mark.parametrize(("low", "is_left_out"), [(-5000, True), (-32768, False)])
def test_a_lowest_value_alone_of_packed_numbers_is_packed(low, is_left_out):
    xarray = pytest.importorskip("xarray")
    variable = xarray.DataArray([0.1, -9.0], attrs={"valid_min": np.int16(low)})
    variable.encoding = {"scale_factor": 1e-3}
    assert np.isnan(attributes.valid(variable)).tolist() == [False, is_left_out]


@pytest.mark.parametrize("said", [{"valid_range": "-5, 5"}, {"valid_range": [1.0, 2.0, 3.0]}, {"valid_min": "none"}])
def test_a_valid_range_that_is_not_of_two_numbers_is_named(said):
    xarray = pytest.importorskip("xarray")
    with pytest.raises(attributes.FieldAttributeError, match=r"u has a valid range of .*; expected two numbers"):
        attributes.valid(xarray.DataArray([0.1], name="u", attrs=said))


def test_a_scalar_coordinate_is_the_depth_of_a_field_without_a_vertical_axis(tmp_path):
    xarray = pytest.importorskip("xarray")
    write(tmp_path / "plain.nc")
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    with xarray.open_dataset(tmp_path / "plain.nc", decode_times=False) as field:
        field.isel(lev=4).to_netcdf(tmp_path / "field.nc")  # 40 m
        field.isel(lev=0).drop_vars("lev").to_netcdf(tmp_path / "surface.nc")
    assert read_field([str(tmp_path / "field.nc")], area, "field.nc").depth == pytest.approx([40.0, 48.0])
    assert read_field([str(tmp_path / "surface.nc")], area, "surface.nc").depth == pytest.approx([0.0, 1.0])


def test_a_run_of_a_forecast_is_no_vertical_axis_and_levels_may_lie_beside_it(tmp_path, plain):
    xarray = pytest.importorskip("xarray")
    write(tmp_path / "plain.nc")
    with xarray.open_dataset(tmp_path / "plain.nc", decode_times=False) as field:
        field.expand_dims("run").rename_dims(lev="k").reset_index("lev").reset_coords("lev").to_netcdf(
            tmp_path / "field.nc"
        )
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)


def test_velocities_lie_where_their_own_coordinates_say(tmp_path, plain):
    """Corners half a cell away stand first, as in files of POP."""
    path = tmp_path / "field.nc"
    kind = [f"{each}_sea_water_velocity" for each in ("eastward", "northward")]
    bent(path, kind)
    with netcdf.Dataset(path, "a") as file:
        for old, new in (("lat", "place_n"), ("lon", "place_e")):
            file.renameVariable(old, new)
            file[new].units = "degrees_north" if old == "lat" else "degrees_east"
            corner = file.createVariable(old, "f8", ("j", "i"))
            corner.units = file[new].units
            corner[:] = file[new][:] + 0.05
        for name in ("u", "v"):
            file[name].coordinates = "place_e place_n"
    assert drift(path) == pytest.approx(plain, rel=2e-3)


def test_components_that_agree_by_chance_are_a_current(tmp_path, plain):
    path = tmp_path / "a.nc"
    write(path, speed=(1.0, {"units": "m s-1"}))
    with netcdf.Dataset(path, "a") as file:
        file["u"][:], file["v"][:] = np.round(file["u"][:], 2), np.round(file["v"][:], 2)
        file["v"][0, 0] = file["u"][0, 0]
    assert np.isfinite(drift(path)).all()


@pytest.mark.parametrize(
    "standard", ["eastward_wind", "sea_surface_wave_stokes_drift_x_velocity", "westward_sea_water_velocity"]
)
def test_what_is_no_current_by_its_standard_name_is_refused(tmp_path, standard):
    units = {"units": "m s-1"}
    write(tmp_path / "a.nc", speed=(1.0, {"u": {**units, "standard_name": standard}, "v": units}))
    with pytest.raises(InputError, match=f"u is a {standard}; expected the current toward east and north"):
        drift(tmp_path / "a.nc")


def opened_field(path):
    xarray = pytest.importorskip("xarray")
    write(path)
    with xarray.open_dataset(path, decode_times=False) as field:
        return field.load()


def test_of_two_components_that_is_taken_which_is_no_wind_and_no_deviation(tmp_path, plain):
    named = opened_field(tmp_path / "plain.nc").rename(u="ucur", v="vcur")
    for name, way in (("ucur", "eastward"), ("vcur", "northward")):
        named[name].attrs["standard_name"] = f"{way}_sea_water_velocity"
    for words in ({"standard_name": "eastward_wind"}, {"long_name": "wind at 10 m"}, {"long_name": "Stokes drift"}):
        values = {name: named[f"{name}cur"].to_numpy() for name in "uv"}
        wind = {name: (named["ucur"].dims, 9.0 * each, {"units": "m s-1", **words}) for name, each in values.items()}
        named.assign(wind).to_netcdf(tmp_path / "field.nc")
        assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)
    same = {f"a_{name}": (named[name] * 0.1).assign_attrs(named[name].attrs) for name in ("ucur", "vcur")}
    for each in same.values():
        each.attrs["cell_methods"] = "time: standard_deviation"
    xarray = pytest.importorskip("xarray")
    xarray.Dataset(same).assign(named.data_vars).to_netcdf(tmp_path / "field.nc")
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)
    for each in same.values():
        each.attrs["cell_methods"] = "time: mean"
    xarray.Dataset(same).assign(named.data_vars).to_netcdf(tmp_path / "field.nc")
    with pytest.raises(InputError, match=r"which of (a_ucur, ucur|ucur, a_ucur) is the current\?"):
        drift(tmp_path / "field.nc")


@pytest.mark.parametrize("said", [{}, {"flag_values": np.array([0, 1], "i1"), "flag_meanings": "bad_data good_data"}])
def test_what_a_flag_calls_bad_is_none(tmp_path, plain, said):
    field = opened_field(tmp_path / "plain.nc")
    field["u"][:, :, 2, 2] = 5.0
    bad, good = (0, 1) if said else (4, 1)
    field["u_qc"] = field["u"].copy(data=np.where(field["u"] == 5.0, bad, good)).assign_attrs(said)
    field.to_netcdf(tmp_path / "field.nc")
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=1e-3)


def test_of_the_runs_of_a_forecast_the_latest_counts_in_whatever_order_they_stand(tmp_path, plain):
    """An older run whose current is 0.7 m/s off: along an axis of its own, with times of its own, or after the newer."""
    xarray = pytest.importorskip("xarray")
    path, latest = tmp_path / "field.nc", opened_field(tmp_path / "plain.nc")
    older = latest.assign(u=latest["u"] + 0.7, v=latest["v"] - 0.7)
    begun = {"units": "hours since 2026-06-01", "standard_name": "forecast_reference_time"}
    for order in ((older, latest), (latest, older)):
        starts = [-12.0 if each is older else -6.0 for each in order]
        along = xarray.concat(order, "run").assign_coords(run=("run", starts, begun))
        along.to_netcdf(path)
        assert drift(path) == pytest.approx(plain, rel=2e-5)
        clocks = np.stack([latest["time"] + (0.0 if each is latest else -6.0) for each in order])
        steps = xarray.concat([each.drop_vars("time").rename(time="step") for each in order], "run")
        clocks = (("run", "step"), clocks, {**latest["time"].attrs, "standard_name": "time"})
        steps.assign_coords(run=("run", starts, begun), valid=clocks).to_netcdf(path)
        assert drift(path) == pytest.approx(plain, rel=2e-5)
        rows = xarray.concat(order, "time")
        rows.assign(begun=("time", np.repeat(starts, HOURS.size), begun)).to_netcdf(path)
        assert drift(path) == pytest.approx(plain, rel=2e-5)


@pytest.mark.parametrize("nominal", [False, True])
@pytest.mark.parametrize("is_moving", [False, True])
def test_levels_lie_where_each_column_has_them(tmp_path, plain, nominal, is_moving):
    """Beside the numbers of levels, or nominal depths of which the velocity's `coordinates` says better."""
    field = opened_field(tmp_path / "plain.nc").rename(lev="k")
    field["k"] = ("k", np.arange(1.0, 6.0), {"units": "m", "positive": "down"} if nominal else {})
    depth = np.broadcast_to(DEPTHS[:, None, None], field["u"].shape[1:]).copy()
    depth[3:, 0, 0] = np.nan
    field["u"][:, 3:, 0, 0] = np.nan
    dims = ("k", "lat", "lon")
    if is_moving:
        depth, dims = np.broadcast_to(-depth, field["u"].shape), ("time", *dims)
    field["z_of_cells"] = (dims, depth, {"units": "m", "positive": "up" if is_moving else "down"})
    field["u"].attrs["coordinates"] = "z_of_cells"
    field.to_netcdf(tmp_path / "field.nc")
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    assert read_field([str(tmp_path / "field.nc")], area, "field.nc").depth == pytest.approx([0.0, 1.2 * 40.0])


def test_levels_of_columns_that_neither_rise_nor_fall_are_refused(tmp_path):
    field = opened_field(tmp_path / "plain.nc").rename(lev="k").drop_vars("k")
    depth = np.broadcast_to(DEPTHS[[0, 2, 1, 3, 4], None, None], field["u"].shape[1:])
    field["z"] = (("k", "lat", "lon"), depth, DOWN)
    field.to_netcdf(tmp_path / "field.nc")
    with pytest.raises(InputError, match=r"z has depths above the surface .* or that neither rise nor fall"):
        drift(tmp_path / "field.nc")


@pytest.mark.parametrize("filled", [(-9.99, 9.99), (-9.0, -8.0), (3.2767, -3.2768)])
def test_numbers_that_stand_for_none_may_differ(tmp_path, filled):
    write(tmp_path / "a.nc")
    with netcdf.Dataset(tmp_path / "a.nc", "a") as file:
        for name, value in zip("uv", filled, strict=True):
            file[name][:, 2:, 3, 4] = value
    with pytest.raises(InputError, match=f"u and v are {filled[0]:g} and {filled[1]:g} at many places, which is no"):
        drift(tmp_path / "a.nc")


def test_a_stream_to_and_fro_is_no_number_that_stands_for_none():
    """The same everywhere, so that both components are greatest at the same places and times."""
    tide = np.cos(np.linspace(0.0, 6.0, 50))[:, None] * np.ones(30)
    assert np.isnan(undeclared_fill(3.0 * tide, 2.0 * tide)).all()
    assert undeclared_fill(np.where(tide > 0.9, 9.0, tide), np.where(tide > 0.9, -8.0, tide)) == (9.0, -8.0)


@pytest.mark.parametrize("name", ["member", "Ensemble", "n_ens", "ens_mem", "realisation", "number", "k"])
def test_members_lie_along_any_of_their_names_and_in_any_place(tmp_path, plain, name):
    xarray = pytest.importorskip("xarray")
    path, field = tmp_path / "field.nc", opened_field(tmp_path / "plain.nc")
    members = xarray.concat([field.assign(u=field["u"] + 0.1 * k) for k in range(3)], name, data_vars="all")
    said = {"standard_name": "realization"} if name == "k" else {}
    members = members.assign_coords({name: (name, [7, 8, 9], said)}).transpose("lev", name, ...)
    members.to_netcdf(path)
    assert member_count([str(path)], "field") == 3
    area = Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))
    t = np.arange(0.0, 18_000.0, 600.0)
    for k in range(3):
        current = read_field([str(path)], area, "field", k)
        way = 600.0 * sum(current.velocity(each, 8.0, np.array([[700.0], [-900.0]]))[:, 0] for each in t)
        assert way == pytest.approx(plain[0] + [1800.0 * k, 0.0], rel=2e-5)


def test_depths_are_no_members_whatever_their_axis_is_called(tmp_path, plain):
    opened_field(tmp_path / "plain.nc").rename(lev="number").to_netcdf(tmp_path / "field.nc")
    assert member_count([str(tmp_path / "field.nc")], "field") == 1
    assert drift(tmp_path / "field.nc") == pytest.approx(plain, rel=2e-5)


@pytest.mark.parametrize("turned", ["lat", "lon"])
def test_places_of_nodes_stand_in_either_order(tmp_path, turned):
    """On as many rows as columns, where the shapes do not tell them apart."""
    xarray = pytest.importorskip("xarray")
    east, north = np.meshgrid(-124.0 + np.linspace(-0.2, 0.2, 9), 45.0 + np.linspace(-0.2, 0.2, 9))
    speed = (("time", "j", "i"), np.stack([east + 124.0] * HOURS.size))
    field = xarray.Dataset({"u": speed, "v": speed, "lat": (("j", "i"), north), "lon": (("j", "i"), east)})
    for name, way in (("u", "eastward"), ("v", "northward")):
        field[name].attrs.update(units="m s-1", standard_name=f"{way}_sea_water_velocity")
    field = field.assign_coords(time=("time", HOURS, {"units": "hours since 2026-06-01"}))
    for name, each in (("plain", field), ("turned", field.assign({turned: field[turned].transpose()}))):
        each.to_netcdf(tmp_path / f"{name}.nc")
    plain, other = (
        read_field([str(path)], Area(ORIGIN, np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1))), path.name)
        for path in (tmp_path / "plain.nc", tmp_path / "turned.nc")
    )
    place = np.array([[3000.0], [-8000.0]])
    assert other.velocity(0.0, 0.5, place) == pytest.approx(plain.velocity(0.0, 0.5, place))
    assert plain.velocity(0.0, 0.5, place)[0, 0] == pytest.approx(3000.0 / 78_850.0, rel=0.01)
