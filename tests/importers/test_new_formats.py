"""CF trajectories, Iver logs and ROS 2 bags in mcap: files made here after the formats' descriptions, by other code."""

import struct
from datetime import UTC, datetime

import numpy as np
import pytest
from made_tracks import made
from test_structure import agree

from missionplan.errors import InputError
from missionplan.importers import import_logs

VOYAGE = made(legs=4, duration=1800.0, pause=300.0, step=20.0)


def one_position():
    """Rows of the vehicle's one position with depth and heading: fixes at the surface, dead-reckoned under water."""
    track = VOYAGE.track
    t = track.depth.t
    at = np.isin(t, track.fixes.t)
    place = [np.where(at, np.interp(t, track.fixes.t, getattr(track.fixes, axis)),
                      np.interp(t, track.reckoned.t, getattr(track.reckoned, axis)))
             for axis in ("latitude", "longitude")]  # fmt: skip
    return t, *place, track.depth.values, track.heading.values


def cf(path, form="one", *, pressure=False, names=("lat", "lon"), up=False, comment="", upper=False, heading_name=""):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    t, lat, lon, depth, heading = one_position()
    other = 40  # rows of another vehicle, before this one's
    with netcdf.Dataset(path, "w") as file:
        file.featureType = "trajectory"
        many = form != "one"
        rows = {
            "time": (t, {"units": "hours since 2023-01-01", "standard_name": "time"}),
            names[0]: (lat, {"units": "degrees_north", "standard_name": "Latitude" if upper else "latitude",
                             "comment": comment}),
            names[1]: (lon, {"units": "degrees_east", "standard_name": "longitude"}),
            "z": (-depth if up else depth, {"units": "dbar" if pressure else "m", "positive": "up" if up else "down",
                                            "standard_name": "sea_water_pressure" if pressure else "depth"}),
            "heading": (heading, {"units": "degree", "standard_name": "platform_orientation",
                                  "long_name": heading_name}),
        }  # fmt: skip
        rows["time"] = ((t - 1672531200.0) / 3600.0, rows["time"][1])
        file.createDimension("obs", len(t) + (other if form in ("contiguous", "indexed") else 0))
        if many:
            file.createDimension("trajectory", 2)
            name = file.createVariable("vehicle", str, ("trajectory",))
            name.cf_role = "trajectory_id"
            name[:] = np.array(["another", "this"], dtype=object)
        for key, (values, attributes) in rows.items():
            dims = ("trajectory", "obs") if form == "matrix" else ("obs",)
            variable = file.createVariable(key, "f8", dims)
            variable.setncatts(attributes)
            if form == "matrix":
                variable[:] = np.stack([values + 0.1, values])
            elif form == "contiguous":
                variable[:] = np.append(values[:other] + 0.1, values)
            elif form == "indexed":
                variable[:] = np.insert(values, np.arange(other) * 2, values[:other] + 0.1)
            else:
                variable[:] = values
        if form == "contiguous":
            size = file.createVariable("row_size", "i4", ("trajectory",))
            size.sample_dimension = "obs"
            size[:] = [other, len(t)]
        if form == "indexed":
            index = file.createVariable("index", "i4", ("obs",))
            index.instance_dimension = "trajectory"
            index[:] = np.insert(np.ones(len(t), dtype=int), np.arange(other) * 2, 0)
    return path


def test_a_trajectory_is_read_by_its_standard_names_in_each_form(tmp_path):
    plain = import_logs([cf(tmp_path / "a.nc")])
    assert plain.counted == 4
    np.testing.assert_allclose(plain.table["t_end_s"], VOYAGE.ends, rtol=0.0, atol=0.01)
    np.testing.assert_allclose(plain.table["t_start_s"], VOYAGE.starts, rtol=0.0, atol=20.1)  # the first row of a dive
    for k, change in enumerate(({"pressure": True}, {"names": ("a", "b")}, {"up": True}, {"upper": True})):
        changed = import_logs([cf(tmp_path / f"{k}.nc", **change)])
        agree(plain, changed)
        assert not any("heights" in notice for notice in changed.provenance.notices)
    headings = [
        import_logs([cf(tmp_path / "h.nc", heading_name=each)]).table["heading_deg"] for each in ("", "Magnetic")
    ]
    assert (headings[1] - headings[0]).to_numpy() == pytest.approx(np.full(4, 16.0), abs=2.0)  # its declination
    for form in ("matrix", "contiguous", "indexed"):
        path = cf(tmp_path / f"{form}.nc", form)
        agree(plain, import_logs([path], vehicle="this"))
        with pytest.raises(InputError, match="several trajectories: another, this"):
            import_logs([path])


def test_a_trajectory_that_is_interpolated_is_refused(tmp_path):
    with pytest.raises(InputError, match="interpolated between the fixes"):
        import_logs([cf(tmp_path / "a.nc", comment="Linearly interpolated between surface fixes")])


def iver(path, *, upper=False, order=1, decimals=True):
    t, lat, lon, depth, heading = one_position()
    names = ["Latitude", "Longitude", "Time", "Date", "Number of Sats", "HDOP", "C True Heading", "Pitch Angle",
             "DFS Depth (m)", "Vehicle Speed (kn)"][::order]  # fmt: skip
    lines = [";".join(name.upper() if upper else name for name in names)]
    for row in zip(t, lat, lon, depth, heading, strict=True):
        moment = datetime.fromtimestamp(row[0], UTC)
        cells = [f"{row[1]:.7f}", f"{row[2]:.7f}", f"{moment:%H:%M:%S}" + (".00" if decimals else ""),
                 f"{moment.month}/{moment.day}/{moment.year}", "9" if row[3] == 0 else "0", "1.0", f"{row[4]:.1f}", "0",
                 f"{row[3]:.2f}", "0.58"]  # fmt: skip
        lines.append(";".join(cells[::order]))
    path.write_text("\r\n".join(lines) + "\r\n")
    return path


def test_an_ivers_legs_are_those_of_the_voyage_in_any_order_of_columns(tmp_path):
    plain = import_logs([iver(tmp_path / "20231114_221320_UTC_0_box_IVER2-135.log")])
    assert plain.counted == 4
    assert plain.name == "Iver IVER2-135"
    np.testing.assert_allclose(plain.table["t_start_s"], VOYAGE.starts, rtol=0.0, atol=0.01)
    for k, change in enumerate(({"upper": True}, {"order": -1}, {"decimals": False})):
        agree(plain, import_logs([iver(tmp_path / f"{k}.log", **change)]))


def mcap(folder):
    """Write an mcap file by the library that the format's makers recommend for bags; messages are packed here."""
    rosbags = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    t, lat, lon, depth, heading = one_position()
    from missionplan.importers.geodesy import displacement

    east, north = displacement(lat[0], lon[0], lat, lon)
    with rosbags.Writer(folder, version=9, storage_plugin=rosbags.StoragePlugin.MCAP) as bag:
        fix = bag.add_connection("/fix", "sensor_msgs/msg/NavSatFix", typestore=store)
        odometry = bag.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=store)

        def head(moment, frame=b"map\0"):
            sec, nanosec = int(moment), int(moment % 1 * 1e9)
            return b"\0\1\0\0" + struct.pack("<iII", sec, nanosec, len(frame)) + frame

        for row in zip(t, lat, lon, depth, heading, east, north, strict=True):
            yaw = np.radians(90.0 - row[4])
            pose = struct.pack("<7d", row[5], row[6], -row[3], 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))
            body = head(row[0]) + struct.pack("<I", 5) + b"base\0"
            body += b"\0" * (-(len(body) - 4) % 8) + pose + b"\0" * (36 * 8 + 6 * 8 + 36 * 8)
            bag.write(odometry, int(row[0] * 1e9), body)
            if row[0] in VOYAGE.track.fixes.t:
                body = head(row[0]) + struct.pack("<bxH", 0, 1)
                body += b"\0" * (-(len(body) - 4) % 8)
                body += struct.pack("<3d9dB", row[1], row[2], 0.0, *([4.0, 0, 0, 0, 4.0, 0, 0, 0, 4.0]), 2)
                bag.write(fix, int(row[0] * 1e9), body)
    return folder


def test_an_mcap_bag_says_the_same(tmp_path):
    found = import_logs([mcap(tmp_path / "bag")])
    assert found.counted == 4
    agree(found, import_logs([iver(tmp_path / "a.log")]))
