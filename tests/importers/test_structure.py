"""Logs of one voyage in many writings: what a sample happens to have (order, case, clock, unit, gaps) changes no leg."""

import gzip

import numpy as np
import pytest
from made_tracks import made

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.geodesy import displacement

VOYAGE = made(legs=4, duration=2400.0, pause=600.0, step=20.0)
ENDS = ("lat_start", "lon_start", "lat_dr_end", "lon_dr_end", "lat_end", "lon_end", "t_start_s", "t_end_s")
LOGGED = {"speed_m_s": 0.01, "heading_deg": 0.5, "depth_m": 0.5, "max_depth_m": 0.1, "fix_sd_m": 0.01, "rpm": 0.1}
"""What else a leg has, and how far two writings of it may differ."""


def ends(result):
    return result.table[list(ENDS)].to_numpy()


def agree(one, other, metres=0.5, seconds=1.0):
    a, b = ends(one), ends(other)
    assert a.shape == b.shape
    for k in (0, 2, 4):
        away = np.hypot(*displacement(a[:, k], a[:, k + 1], b[:, k], b[:, k + 1]))
        assert away.max() <= metres
    np.testing.assert_allclose(a[:, 6:], b[:, 6:], rtol=0.0, atol=seconds)
    for name, alike in LOGGED.items() if one.format == other.format else ():
        off = one.table[name].to_numpy() - other.table[name].to_numpy()
        off = (off + 180.0) % 360.0 - 180.0 if name == "heading_deg" else off
        assert np.isfinite(off).all() or np.isnan(off).all()
        assert np.nan_to_num(np.abs(off)).max() <= alike * max(1.0, metres), name


# --- Seaglider, OG1: NetCDF -------------------------------------------------------------------------------------------


def dives(voyage):
    """Of each dive: fixes, clock of displacements with east and north steps, clock of readings with depths."""
    track = voyage.track
    for k, (start, end) in enumerate(zip(voyage.starts, voyage.ends, strict=True)):
        own = track.reckoned.within(start, end)
        begin = np.searchsorted(track.fixes.t, start)
        place = track.fixes.latitude[begin], track.fixes.longitude[begin]
        lat, lon = np.append(place[0], own.latitude[1:]), np.append(place[1], own.longitude[1:])
        steps = displacement(lat[:-1], lon[:-1], lat[1:], lon[1:])
        at = [begin - 1, begin, np.searchsorted(track.fixes.t, end)]
        yield k + 1, track.fixes[np.array(at)], (own.t[1:], *steps), track.depth.within(start, end)


def seaglider(folder, *, ctd="ctd_data_point", upper=False, order=1, transposed=False, mission="made up", number=561,
              in_cm=False, later=0.0):  # fmt: skip
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    folder.mkdir(exist_ok=True)
    for dive, fixed, (t, east, north), depth in dives(VOYAGE):
        with netcdf.Dataset(folder / f"p{number}{dive:04d}.nc", "w") as file:
            file.setncatts({"glider": number, "dive_number": dive, "platform_id": f"SG{number}",
                            "title": f"data of SG{number} during {mission} deployed on 2023-11-{13 + dive}"})  # fmt: skip
            for name, size in (("gps_info", 3), ("sg_data_point", len(depth)), ("one", 1), (ctd, len(t))):
                if name not in file.dimensions:
                    file.createDimension(name, size)

            def put(name, along, values, units="", file=file, **attributes):
                dims = ("one", along) if transposed else (along,)
                variable = file.createVariable(name.upper() if upper else name, "f8", dims)
                variable[:] = np.reshape(values, (1, -1)) if transposed else values
                variable.setncatts({"units": units, **attributes})

            since = "seconds since 1970-1-1 00:00:00"
            size, unit = (100.0, "cm") if in_cm else (1.0, "meters")
            columns = [
                ("log_gps_time", "gps_info", fixed.t + later, since), ("log_gps_lat", "gps_info", fixed.latitude),
                ("log_gps_lon", "gps_info", fixed.longitude), ("log_gps_hdop", "gps_info", [1.0, 1.0, 1.0]),
                ("time", "sg_data_point", depth.t + later, since),
                ("depth", "sg_data_point", depth.values * size, unit),
                ("ctd_time", ctd, t + later, since), ("east_displacement", ctd, east * size, unit),
                ("north_displacement", ctd, north * size, unit), ("horz_speed", ctd, 30.0 + 0.0 * t, "cm/s"),
            ]  # fmt: skip
            for column in columns[::order]:
                put(*column)
    return folder


def test_each_variable_of_a_seaglider_is_on_its_own_dimensions_clock(tmp_path):
    plain = import_logs([seaglider(tmp_path / "a")])
    assert plain.counted == 4
    np.testing.assert_allclose(plain.table["t_start_s"], VOYAGE.starts, rtol=0.0)
    way = displacement(
        *(plain.table[name].to_numpy() for name in ("lat_start", "lon_start", "lat_dr_end", "lon_dr_end"))
    )
    np.testing.assert_allclose(np.hypot(*way), 0.3 * (2400.0 - 20.0), rtol=0.01)
    changes = ({"upper": True, "order": -1}, {"transposed": True, "in_cm": True}, {"ctd": "nav"})
    for k, change in enumerate(changes):
        agree(plain, import_logs([seaglider(tmp_path / str(k), **change)]))


def test_two_gliders_or_two_deployments_are_no_one_track(tmp_path):
    both = [seaglider(tmp_path / "a"), seaglider(tmp_path / "b", number=180, later=86400.0)]
    with pytest.raises(InputError, match=r"SG180 \(4 files\), SG561 \(4 files\).*--vehicle"):
        import_logs(both)
    agree(import_logs(both[:1]), import_logs(both, vehicle="sg561"))
    with pytest.raises(InputError, match="no vehicle 'SG5'"):
        import_logs(both, vehicle="SG5")
    again = [both[0], seaglider(tmp_path / "c", mission="another", later=86400.0)]
    with pytest.raises(InputError, match=r"another.*made up.*--deployment"):
        import_logs(again)
    agree(import_logs(both[:1]), import_logs(again, deployment="made up"))
    agree(import_logs(again[1:]), import_logs(again, deployment="another"))
    agree(import_logs(both[1:]), import_logs(both, vehicle="sg180"))


def test_a_dive_that_two_files_hold_is_summed_once(tmp_path):
    plain = import_logs([seaglider(tmp_path / "a")])
    twice = import_logs([tmp_path / "a", seaglider(tmp_path / "b", order=-1)])
    agree(plain, twice)
    assert sum("again" in each for each in twice.passed_over) == 4


def test_a_broken_file_is_named_and_passed_over_but_not_with_strict(tmp_path):
    folder = seaglider(tmp_path / "a")
    plain = import_logs([folder])
    whole = (folder / "p5610001.nc").read_bytes()
    (folder / "p5610009.nc").write_bytes(whole[: len(whole) // 2])
    found = import_logs([folder], format="seaglider")
    agree(plain, found)
    assert any("p5610009.nc" in each for each in found.passed_over)
    (folder / "p5610009.nc").unlink()
    (folder / "p5610002.nc").write_bytes((folder / "p5610001.nc").read_bytes() + b"\0")
    with pytest.raises(InputError, match=r"p5610002.nc"):
        import_logs([folder], is_strict=True)


def og1(path, *, upper=True, gps_dimension=False, shuffled=False, flagged=False):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    rows = [(t, np.nan, np.nan, la, lo, np.nan, np.nan, np.nan) for t, la, lo in
            zip(VOYAGE.track.fixes.t, VOYAGE.track.fixes.latitude, VOYAGE.track.fixes.longitude, strict=True)]  # fmt: skip
    rows += [(t, np.nan, np.nan, np.nan, np.nan, d, np.nan, np.nan) for _, _, _, depth in dives(VOYAGE)
             for t, d in zip(depth.t, depth.values, strict=True)]  # fmt: skip
    if flagged:
        own = VOYAGE.track.reckoned
        rows += [(t, np.nan, np.nan, np.nan, np.nan, np.nan, la, lo) for t, la, lo in
                 zip(own.t, own.latitude, own.longitude, strict=True)]  # fmt: skip
    else:
        rows += [(t, e, n, np.nan, np.nan, np.nan, np.nan, np.nan) for _, _, ways, _ in dives(VOYAGE)
                 for t, e, n in zip(*ways, strict=True)]  # fmt: skip
    table = np.array(sorted(rows, key=lambda row: row[0]))
    if shuffled:
        table = np.random.default_rng(1).permutation(table)
    with netcdf.Dataset(path, "w") as file:
        file.setncatts({"id": "sg033_20231114T000000_delayed"})
        file.createDimension("N_MEASUREMENTS", len(table))

        def put(name, values, along="N_MEASUREMENTS", **attributes):
            variable = file.createVariable(name if upper else name.lower(), "f8", (along,))
            variable[:] = values
            variable.setncatts(attributes)

        put("TIME", table[:, 0], units="seconds since 1970-01-01T00:00:00Z")
        along, kept = "N_MEASUREMENTS", slice(None)
        if gps_dimension:
            along, kept = "N_GPS", np.isfinite(table[:, 3])
            file.createDimension(along, int(kept.sum()))
            put("TIME_GPS", table[kept, 0], along, units="seconds since 1970-01-01T00:00:00Z")
        put("LATITUDE_GPS", table[kept, 3], along)
        put("LONGITUDE_GPS", table[kept, 4], along)
        put("DEPTH", table[:, 5], units="m")
        if flagged:
            put("LATITUDE", np.where(np.isfinite(table[:, 6]), table[:, 6], table[:, 3]), standard_name="latitude")
            put("LONGITUDE", np.where(np.isfinite(table[:, 7]), table[:, 7], table[:, 4]), standard_name="longitude")
            put("DEAD_RECKONING", np.isfinite(table[:, 6]).astype(float))
        else:
            put("EAST_DISPLACEMENT", table[:, 1], units="meters")
            put("NORTH_DISPLACEMENT", table[:, 2], units="meters")
    return path


def test_og1_in_small_letters_in_any_order_and_with_a_dimension_of_its_own_for_fixes(tmp_path):
    plain = import_logs([og1(tmp_path / "a.nc")])
    assert plain.counted == 4
    agree(plain, import_logs([seaglider(tmp_path / "seaglider")]))
    for k, change in enumerate(({"upper": False}, {"gps_dimension": True}, {"shuffled": True}, {"flagged": True})):
        agree(plain, import_logs([og1(tmp_path / f"{k}.nc", **change)]), metres=8.0 if "flagged" in change else 0.5)


# --- SeaExplorer ------------------------------------------------------------------------------------------------------


def gli(path, *, gauge=0.0, flag=False, separator=";", upper=False, comma=False, packed=False, backwards=False):
    names = ["Timestamp", "NavState", "Heading", "Declination", "Pitch", "Depth", "Lat", "Lon"]
    names += ["DeadReckoning"] if flag else []
    track, last, rows = VOYAGE.track, (np.nan, np.nan), []
    for k, t in enumerate(track.depth.t):
        at = np.flatnonzero(track.fixes.t == t)
        reckoned = 0
        if len(at):
            last = track.fixes.latitude[at[0]], track.fixes.longitude[at[0]]
        elif flag:
            own = track.reckoned
            last, reckoned = (np.interp(t, own.t, own.latitude), np.interp(t, own.t, own.longitude)), 1
        words = [f"{np.sign(x) * (np.floor(abs(x)) * 100 + abs(x) % 1 * 60):.5f}" for x in last]
        stamp = np.datetime64(round(t), "s").astype(object).strftime("%d/%m/%Y %H:%M:%S")
        state = 116 if track.depth.values[k] == 0.0 else 100
        cells = [stamp, str(state), f"{track.heading.values[k]:.2f}", "0", f"{track.pitch.values[k]:.2f}",
                 f"{track.depth.values[k] + gauge:.2f}", *words, *([str(reckoned)] if flag else [])]  # fmt: skip
        rows.append([cell.replace(".", ",") if comma else cell for cell in cells])
    if backwards:
        names, rows = [names[0], names[1], *names[:1:-1]], [[row[0], row[1], *row[:1:-1]] for row in rows]
    head = [name.upper() if upper else name for name in names]
    text = "\n".join(separator.join(row) for row in [head, *rows]) + "\n"
    path.write_bytes(gzip.compress(text.encode()) if packed else text.encode())
    return path


def test_a_seaexplorers_gauge_may_read_anything_at_the_surface(tmp_path):
    plain = import_logs([gli(tmp_path / "sea001.1.gli.sub.1")])
    assert plain.counted == 4
    for k, change in enumerate(({"gauge": 6.2}, {"gauge": 3.0}, {"gauge": -4.0}, {"separator": "\t"}, {"upper": True},
                                {"comma": True}, {"packed": True}, {"backwards": True})):  # fmt: skip
        path = tmp_path / f"sea001.1.gli.sub.{k + 2}{'.gz' if 'packed' in change else ''}"
        agree(plain, import_logs([gli(path, **change)]), metres=3.0)


def test_made_dead_reckoning_is_told_first_and_carries_its_doubt(tmp_path):
    found = import_logs([gli(tmp_path / "sea001.1.gli.sub.1")])
    assert repr(found).splitlines()[1].startswith("The logs hold no dead reckoning: it was made from heading")
    assert (found.table["dr_sd_m"] > 0.05 * 0.3 * 2400.0).all()
    assert 0.05 < found.dataset["noise"]["reckoned_speed"] < 0.9
    own = import_logs([gli(tmp_path / "sea001.1.gli.sub.2", flag=True)])
    assert own.reckoning.startswith("the vehicle's own")
    assert own.table["dr_sd_m"].isna().all()
    assert [*own.dataset["noise"]] == ["fix"]
    assert len(own.lines.fixes.T) == len(VOYAGE.track.fixes)  # dead-reckoned positions are no fixes
    agree(found, own, metres=40.0)


def test_missions_of_two_gliders_are_asked_for(tmp_path):
    gli(tmp_path / "sea001.1.gli.sub.1")
    gli(tmp_path / "sea002.7.gli.sub.1", gauge=1.0)
    with pytest.raises(InputError, match=r"SEA001 \(1 file\), SEA002 \(1 file\)"):
        import_logs([tmp_path])
    assert import_logs([tmp_path], vehicle="sea002").name == "SeaExplorer SEA002, mission 7"


# --- MOOS -------------------------------------------------------------------------------------------------------------


def alog(path, *, start=1_700_000_000.0, opened="Tue Nov 14 22:13:20 2023", shuffled=False, repeated=False,
         community="alpha"):  # fmt: skip
    track = VOYAGE.track
    lines = [(0.0, "DB_EVENT", f"MOOSDB_{community}", "connected=pLogger")]
    for names, part in ((("GPS_LATITUDE", "GPS_LONGITUDE"), track.fixes), (("NAV_LAT", "NAV_LONG"), track.reckoned)):
        for name, values in zip(names, (part.latitude, part.longitude), strict=True):
            lines += [(t, name, "iNav", f"{value:.7f}") for t, value in zip(part.t - 1.7e9, values, strict=True)]
    lines += [
        (t, "NAV_DEPTH", "iNav", f"{d:.2f}") for t, d in zip(track.depth.t - 1.7e9, track.depth.values, strict=True)
    ]
    lines = lines if shuffled else sorted(lines, key=lambda line: line[0])
    if shuffled:
        lines = [lines[0], *(lines[k] for k in np.random.default_rng(2).permutation(len(lines)))]
    lines += lines[:40] if repeated else []
    head = f"%% LOG FILE:  ./{path.name}\n%% FILE OPENED ON  {opened}\n%% LOGSTART  {start:.3f}\n"
    path.write_text(head + "".join(f"{t:.5f}  {name}  {src}  {value}\n" for t, name, src, value in lines))
    return path


def test_lines_of_moos_in_any_order_repeated_and_under_warp(tmp_path):
    plain = import_logs([alog(tmp_path / "a.alog")])
    assert plain.counted == 4
    agree(plain, import_logs([alog(tmp_path / "b.alog", shuffled=True, repeated=True)]))
    warped = import_logs([alog(tmp_path / "c.alog", start=14 * 1_700_000_000.0)])
    agree(plain, warped, seconds=2.0)
    assert any("time warp of 14" in notice for notice in warped.provenance.notices)
    unknown = import_logs([alog(tmp_path / "d.alog", start=14 * 1.7e9, opened="Thu Jan  1 00:00:00 1970")])
    np.testing.assert_allclose(unknown.table["t_start_s"], plain.table["t_start_s"] - 1.7e9, rtol=0.0, atol=0.01)


def test_what_counts_as_short_comes_from_the_helms_plan(tmp_path):
    alog(tmp_path / "a.alog")
    assert import_logs([tmp_path]).counted == 4
    (tmp_path / "helm._bhv").write_text(
        "Behavior = BHV_PeriodicSurface\n{\n  // period = 2\n  name = up\n  period = 6000 // s\n}\n"
    )
    assert import_logs([tmp_path]).reasons == {"shorter than 50 min": 4}
    exported = "  name = interval_1_out_leg\n  pwt = 100\n  duration = 5940.0\n"
    (tmp_path / "helm._bhv").write_text(
        "Behavior = BHV_PeriodicSurface\n{\n  name = fix_clock\n  period = 1000000\n}\n"
        f"Behavior = BHV_Timer\n{{\n{exported}}}\nBehavior = BHV_Timer\n{{\n  name = other\n  duration = 3\n}}\n"
    )
    assert import_logs([tmp_path]).reasons == {"shorter than 49.5 min": 4}


def test_two_communities_are_asked_for(tmp_path):
    alog(tmp_path / "a.alog")
    alog(tmp_path / "b.alog", community="bravo", repeated=True)
    with pytest.raises(InputError, match=r"alpha \(1 file\), bravo \(1 file\)"):
        import_logs([tmp_path])


def test_deployments_years_apart_are_asked_for_by_their_date(tmp_path):
    alog(tmp_path / "a.alog")
    alog(tmp_path / "b.alog", start=1_500_000_000.0, opened="Fri Jul 14 02:40:00 2017")
    with pytest.raises(InputError, match=r"2017-07-14 .*2023-11-14"):
        import_logs([tmp_path])
    assert import_logs([tmp_path], deployment="2017-07-14").counted == 4
    with pytest.raises(InputError, match="no deployment '2020-01-01'"):
        import_logs([tmp_path], deployment="2020-01-01")
