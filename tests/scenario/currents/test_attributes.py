"""What the attributes of a variable mean, by the CF conventions: case by case, each with the sentence it stands for."""

import numpy as np
import pytest

from missionplan.scenario.currents.attributes import (
    FieldAttributeError,
    clocks_along,
    depths,
    factor,
    is_degrees,
    is_vertical,
    moments,
)

xarray = pytest.importorskip("xarray", reason="xarray is not installed")


def variable(values=(0.0,), dim="k", **attrs):
    return xarray.DataArray(np.asarray(values), dims=(dim,), name="it", attrs=attrs)


@pytest.mark.parametrize(
    ("values", "attrs", "expected"),
    [
        ((1.0, 20.0), {"positive": "down"}, (1.0, 20.0)),
        ((1.0, -20.0), {"positive": "UP"}, (-1.0, 20.0)),
        ((-20.0, -1.0), {}, (20.0, 1.0)),  # by their sign
        ((0.0, 20.0), {}, (0.0, 20.0)),
        ((0.0, -20.0), {}, (0.0, 20.0)),
        ((0.0,), {}, (0.0,)),
        ((1.0, np.nan), {}, (1.0, np.nan)),
        ((-1.0, 5.0), {"standard_name": "depth"}, (-1.0, 5.0)),
        ((-1.0, 5.0), {"standard_name": "depth_below_geoid"}, (-1.0, 5.0)),
        ((-1.0, 5.0), {"standard_name": "sea_floor_depth_below_sea_surface"}, (-1.0, 5.0)),
        ((-1.0, 5.0), {"standard_name": "height_above_mean_sea_level"}, (1.0, -5.0)),
        ((-1.0, 5.0), {"standard_name": "Altitude"}, (1.0, -5.0)),
        ((-1.0, 5.0), {"standard_name": "height", "positive": "down"}, (-1.0, 5.0)),  # `positive` goes first
        ((1.0, 20.0), {"units": "km", "positive": "down"}, (1e3, 2e4)),
        ((1.0, 20.0), {"units": "cm", "positive": "up"}, (-0.01, -0.2)),
    ],
)
def test_depths_are_positive_down_and_in_metres(values, attrs, expected):
    found = depths(variable(values, **{"units": "m", **attrs}), np.array(values))
    np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize(
    ("values", "attrs", "words"),
    [
        ((-1.0, 5.0), {}, "values of both signs"),
        ((1.0,), {"positive": "east"}, "expected up or down"),
        ((1.0,), {"units": "dbar"}, "of pressures give the depths"),
        ((1.0,), {"units": ""}, "no attribute `units`"),
        ((1.0,), {"standard_name": "height_above_sea_floor"}, "is a height_above_sea_floor; expected depths below"),
        ((-0.5,), {"standard_name": "ocean_sigma_coordinate"}, "is a ocean_sigma_coordinate; expected depths"),
        ((-0.5,), {"formula_terms": "s: s"}, "coordinate with formula_terms; expected depths"),
    ],
)
def test_what_is_no_depth_is_refused(values, attrs, words):
    with pytest.raises(FieldAttributeError, match=words):
        depths(variable(values, **{"units": "m", **attrs}), np.array(values))


@pytest.mark.parametrize(
    ("attrs", "expected"),
    [
        *[({"axis": "z"}, True), ({"positive": "up"}, True), ({"formula_terms": "s: s"}, True)],
        *[({"standard_name": "Depth"}, True), ({"standard_name": "ocean_s_coordinate_g2"}, True)],
        *[({"units": "m"}, True), ({"units": "dbar"}, True), ({"units": "hPa"}, True)],
        *[({}, False), ({"axis": "T"}, False), ({"units": "m s-1"}, False), ({"units": "1"}, False)],
        *[({"standard_name": "sea_water_temperature", "units": "K"}, False), ({"long_name": "depth"}, False)],
    ],
)
def test_a_vertical_axis_is_known_by_any_of_its_attributes(attrs, expected):
    assert is_vertical(variable(**attrs)) == expected


@pytest.mark.parametrize(
    ("units", "east", "north"),
    [
        *[("", None, None), ("degrees", True, True), ("Degree", True, True), ("m", False, False)],
        *[("km", False, False), ("degrees_east", True, ...), ("degree_E", True, ...), ("degE", True, ...)],
        *[("degrees_north", ..., True), ("degree_N", ..., True), ("degrees north", ..., True), ("rad", ..., ...)],
    ],
)
def test_degrees_east_are_no_latitudes_nor_degrees_north_longitudes(units, east, north):
    for is_east, expected in ((True, east), (False, north)):
        if expected is ...:
            with pytest.raises(FieldAttributeError, match="expected degrees"):
                is_degrees(variable(units=units), east=is_east)
        else:
            assert is_degrees(variable(units=units), east=is_east) is expected


def test_times_along_a_dimension_are_no_others():
    since = {"units": "hours since 2026-05-01"}
    others = {
        "age": variable(dim="time", units="hours"),
        "issued": variable(dim="time", standard_name="forecast_reference_time", **since),
        "run": variable(dim="run", **since),
    }
    assert clocks_along(xarray.Dataset(others), "time") == []
    assert clocks_along(xarray.Dataset({**others, "valid": variable(dim="time", **since)}), "time") == ["valid"]
    valid, axis = (variable(dim="time", **since) for _ in range(2))
    assert clocks_along(xarray.Dataset({**others, "valid": valid}, coords={"time": axis}), "time") == ["time"]
    assert clocks_along(xarray.Dataset({"t": variable(dim="time", standard_name=" TIME ", **since)}), "time") == ["t"]


@pytest.mark.parametrize(
    ("value", "attrs", "expected"),
    [
        (1.5, {"units": "hours since 2026-05-01"}, "2026-05-01T01:30:00"),
        (-2.0, {"units": "days since 2026-05-01 06:00:00"}, "2026-04-29T06:00:00"),
        (90.0, {"units": "minutes since 2026-05-01T00:00:00Z", "time_zone": "UTC"}, "2026-05-01T01:30:00"),
        (0.0, {"units": "seconds since 2026-05-01 00:00:00 +02:00"}, "2026-04-30T22:00:00"),
        (12.0, {"units": "hours since 2026-05-01", "time_zone": "+02:00"}, "2026-05-01T10:00:00"),
        (0.2504, {"units": "seconds since 1970-01-01"}, "1970-01-01T00:00:00.250"),
        (61041.25, {"units": "days since 1858-11-17 00:00:00", "time_zone": "UTC"}, "2026-01-01T06:00:00"),  # MJD
    ],
)
def test_moments_are_utc(value, attrs, expected):
    found = moments(variable((value, np.nan), **attrs))
    assert found[0] == np.datetime64(expected)
    assert np.isnat(found[1])


def test_moments_beyond_64_bits_of_nanoseconds_are_refused():
    with pytest.raises(FieldAttributeError, match="beyond the years 1678 to 2262"):
        moments(variable((400.0 * 365.25,), units="days since 1970-01-01"))


@pytest.mark.parametrize(
    ("units", "si", "expected"),
    [
        *[("m s-1", "m/s", 1.0), ("cm s-1", "m/s", 0.01), ("cm.s-1", "m/s", 0.01), ("m s^-1", "m/s", 1.0)],
        *[("m s**-1", "m/s", 1.0), ("km h-1", "m/s", 1.0 / 3.6), ("knots", "m/s", 1852.0 / 3600.0)],
        *[("Meters", "m", 1.0), ("m", "m/s", None), ("dbar", "m", None), ("nonsense", "m", None)],
    ],
)
def test_factors_of_units_as_udunits_writes_them(units, si, expected):
    assert factor(units, si) == (expected if expected is None else pytest.approx(expected, rel=1e-12))
