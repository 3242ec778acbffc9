"""Variables of a NetCDF file: flags, units, clocks and names, each against what its convention says."""

from datetime import UTC, datetime

import numpy as np
import pytest

from missionplan.importers.mapping import mapped
from missionplan.importers.readers.netcdf import Variables, mapped_parts

xarray = pytest.importorskip("xarray")


def variables(**given):
    """Variables by name: values and attributes along a dimension of their length."""
    return Variables(
        xarray.Dataset(
            {
                name: ((f"n{np.size(values)}",), np.atleast_1d(values), attributes)
                for name, (values, attributes) in given.items()
            }
        )
    )


@pytest.mark.parametrize("kind", [float, "i1", "S1"])
def test_quality_flags_are_those_of_oceansites(kind):
    """Reference table 2: 1 good, 2 probably good, 3 and 4 bad, 5 changed, 8 interpolated, 9 missing; others: neither."""
    flags = np.array(range(10)).astype(kind)
    file = variables(DEPTH=(np.arange(10.0), {}), DEPTH_QC=(flags, {}))
    nan = np.nan
    np.testing.assert_array_equal(file.validity("DEPTH"), [nan, 1, 1, 0, 0, 1, nan, nan, 1, 0])
    assert np.isnan(variables(DEPTH=(np.arange(3.0), {})).validity("DEPTH")).all()


@pytest.mark.parametrize(
    ("unit", "wanted", "one"),
    [
        *[("m", "m", 1.0), ("cm", "m", 0.01), ("km", "m", 1000.0), ("cm s-1", "m/s", 0.01), ("m s -1", "m/s", 1.0)],
        *[("rad", "deg", 180.0 / np.pi), ("degrees", "rad", np.pi / 180.0), ("", "m", 1.0), ("1", "deg", 1.0)],
        *[
            ("FEET", "m", 0.3048),
            ("cm.s-1", "m/s", 0.01),
            ("degrees_true", "deg", 1.0),
            ("degrees_east", "deg", 1.0),
            ("0.1 m", "m", 0.1),
        ],
        *[(f"degrees{way}", "deg", -1.0) for way in ("_west", "_south", "W", " s")],
        *[("kPa", "m", 0.1)],
    ],
)
def test_numbers_come_in_the_unit_that_is_wanted(unit, wanted, one):
    file = variables(v=([1.0, -2.0], {"units": unit}))
    assert file.in_unit("v", wanted) == pytest.approx([one, -2.0 * one])
    assert file.in_unit(None, wanted).size == 0


def test_a_unit_of_something_else_is_refused():
    for unit in ("counts", "m s-1", "db"):
        with pytest.raises(ValueError, match=f"^v: given the unit '{unit}', expected one such as m$"):
            variables(v=([1.0], {"units": unit})).in_unit("v", "m")


def test_a_variable_that_a_user_names_without_its_unit_is_in_the_files():
    file = variables(time=([0.0, 9.0], {"units": "seconds since 2010-01-01"}), z=([1.0, 200.0], {"units": "cm"}),
                     lat=([4839.12, -12315.0], {}), lon=([0.1, 0.2], {"units": "radian"}))  # fmt: skip
    names = {"time": "time", "depth": "z", "lat": "lat[ddmm]", "lon": "lon"}
    (part,) = mapped_parts(file, {key: mapped(key, name) for key, name in names.items()})
    assert part["depth"] == pytest.approx([0.01, 2.0])
    assert part["lat"] == pytest.approx([48.652, -123.25])
    assert part["lon"] == pytest.approx(np.degrees([0.1, 0.2]))
    (part,) = mapped_parts(file, {key: mapped(key, name) for key, name in {**names, "depth": "z[dbar]"}.items()})
    assert part["depth"] == pytest.approx([1.0, 200.0])


@pytest.mark.parametrize(
    ("unit", "second"), [("seconds", 1.0), ("minutes", 60.0), ("hours", 3600.0), ("days", 86_400.0)]
)
def test_clocks_count_from_their_moment_in_its_zone(unit, second):
    began = datetime(2010, 1, 1, 3, tzinfo=UTC).timestamp()
    for zero in ("2010-01-01 03:00:00", "2010-01-01T03:00:00Z", "2010-01-01 05:00:00 +02:00"):
        file = variables(time=([0.0, 2.0], {"units": f"{unit} since {zero}"}), depth=([4.0, 5.0], {"units": "m"}))
        assert file.epoch("time") == pytest.approx([began, began + 2.0 * second])
        found = file.series("depth", "m")
        assert (found.t.tolist(), found.values.tolist()) == ([began, began + 2.0 * second], [4.0, 5.0])


def test_the_clock_of_a_variable_is_the_one_of_its_name_else_of_the_shortest():
    ticks = "seconds since 1970-01-01"
    clocks = {
        f"{name}time{end}": ([float(k)] * 2, {"units": ticks})
        for k, (name, end) in enumerate((("ctd_", ""), ("", ""), ("", "_gps"), ("", "_longer")))
    }
    file = variables(ctd_depth=([1.0, 1.0], {}), lat_gps=([1.0, 1.0], {}), other=([1.0, 1.0], {}), **clocks)
    assert [file.clock(name)[0] for name in ("ctd_depth", "lat_gps", "other")] == [0.0, 2.0, 1.0]
    with pytest.raises(LookupError, match="no time lies along"):
        variables(a=([1.0, 2.0], {}), t=([1.0, 2.0, 3.0], {"units": ticks})).clock("a")
    assert variables(a=([1.0, 2.0], {})).series("a", "m").t.size == 0


def test_a_variable_is_found_by_its_name_before_its_standard_name():
    depth = {"standard_name": "depth"}
    file = variables(ctd_depth=([1.0, 2.0], depth), Depth=([3.0, 4.0], depth), depth0=([5.0], depth))
    assert file.find("DEPTH") == "Depth"
    assert file.find("z", "CTD_depth", standard=("depth",)) == "ctd_depth"
    assert file.find("z", standard=("depth",)) == "Depth"  # the shortest; one value is no column
    assert file.find("z", standard=("altitude",)) is None


@pytest.mark.parametrize(
    "bad",
    [
        {"valid_max": 50.0},
        {"valid_range": np.array([0.0, 50.0])},
        {"QC": [1, 4, 1]},
        {"QC": [1, 0, 1], "flag_values": np.array([0, 1], "i1"), "flag_meanings": "fail pass"},
    ],
)
def test_readings_beyond_the_valid_ones_and_flagged_ones_are_none(bad):
    bad = dict(bad)
    flags = {"depth_qc": (bad.pop("QC"), bad)} if "QC" in bad else {}
    file = variables(
        depth=([1.0, 1500.0, 3.0], {} if flags else bad),
        time=([0.0, 1.0, 2.0], {"units": "seconds since 1970-01-01"}),
        **flags,
    )
    assert file.series("depth", "m").t.tolist() == [0.0, 2.0]


def test_a_clock_that_cannot_be_read_is_named_and_not_passed_by():
    said = {"units": "seconds since 1970-01-01", "calendar": "noleap"}
    with pytest.raises(ValueError, match="the calendar 'noleap'"):
        variables(depth=([1.0, 2.0], {}), time=([0.0, 1.0], said)).series("depth", "m")
