"""Navigation logs: units, order, outliers, and every problem of a file at once."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from missionplan.datasets.legs import read_transit
from missionplan.errors import InputError

KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def problems(excinfo):
    return "\n".join(str(problem) for problem in excinfo.value.problems)


def test_reads_legs(folder, transit_mission, legs):
    data = read_transit(folder(KIND, legs()), transit_mission)
    assert data.n == 48
    assert data.fix_sd == 3.0
    assert data.latitude == pytest.approx(np.radians(37.0))
    assert np.sqrt(np.mean(data.velocity_error**2)) == pytest.approx(0.03, rel=0.2)
    assert not data.has_surface_time


def test_latitude_and_longitude_become_the_same_metres(folder, transit_mission, legs):
    from missionplan.mission.schema.place import to_geographic

    table = legs()
    origin = transit_mission.site.origin
    geographic = table[["leg", "t_start_s", "t_end_s"]].copy()
    for name, ending in (("start", "start"), ("dr", "dr_end"), ("end", "end")):
        latitude, longitude = to_geographic(table[f"x_{name}_m"].to_numpy(), table[f"y_{name}_m"].to_numpy(), origin)
        geographic[f"lat_{ending}"], geographic[f"lon_{ending}"] = np.degrees(latitude), np.degrees(longitude)
    plane = read_transit(folder(KIND, table), transit_mission)
    sphere = read_transit(folder(KIND, geographic), transit_mission)
    np.testing.assert_allclose(sphere.end, plane.end, atol=1e-3)


def test_bad_cells_are_all_named(folder, transit_mission, legs):
    table = legs().astype(object)
    table.loc[3, "t_end_s"], table.loc[8, "x_dr_m"] = "late", "12,5"
    table.loc[12, "t_start_s"] = table.loc[11, "t_start_s"]
    with pytest.raises(InputError) as excinfo:
        read_transit(folder(KIND, table), transit_mission)
    assert "rows.csv:5: t_end_s: given 'late'" in problems(excinfo)
    assert "rows.csv:10: x_dr_m: given '12,5'" in problems(excinfo)
    assert "rows.csv:14: t_start_s: two legs start at the same time" in problems(excinfo)


def test_missing_column_comes_with_its_nearest(folder, transit_mission, legs):
    with pytest.raises(InputError, match="t_start_s: the column is missing") as excinfo:
        read_transit(folder(KIND, legs().rename(columns={"t_start_s": "t_strt_s"})), transit_mission)
    assert len(excinfo.value.problems) == 1


def test_legs_that_end_before_they_begin_overlap_or_repeat(folder, transit_mission, legs):
    table = legs()
    table.loc[4, "t_end_s"] = table.loc[4, "t_start_s"] - 5.0
    table.loc[9, "t_start_s"] = table.loc[8, "t_start_s"]
    with pytest.raises(InputError) as excinfo:
        read_transit(folder(KIND, table), transit_mission)
    assert "ends before it has begun" in problems(excinfo)
    assert "two legs start at the same time" in problems(excinfo)


@pytest.mark.parametrize(("early", "is_refused"), [(0.9, False), (1.1, True)])
def test_a_leg_may_begin_a_second_before_the_last_one_ends(folder, transit_mission, legs, early, is_refused):
    table = legs()
    table.loc[9, "t_start_s"] = table.loc[8, "t_end_s"] - early
    refused = pytest.raises(InputError, match=r"rows\.csv:11: t_start_s: the leg starts before")
    with refused if is_refused else nullcontext():
        assert read_transit(folder(KIND, table), transit_mission).n == len(table)


def test_legs_of_one_name_are_each_checked_and_the_same_numbers_of_two_names_once(folder, transit_mission, legs):
    table = legs().assign(leg="again")
    twice = pd.concat([table, table.assign(leg="copied")], ignore_index=True)
    assert read_transit(folder(KIND, twice), transit_mission).n == len(table)
    table.loc[4, "t_end_s"] = table.loc[4, "t_start_s"] - 5.0
    with pytest.raises(InputError, match=r"rows\.csv:6: t_end_s: the leg ends before it has begun"):
        read_transit(folder(KIND, table), transit_mission)


def test_a_leg_takes_more_time_than_it_lies_at_the_surface(folder, transit_mission, legs):
    table = legs().assign(surface_s=60.0)
    table.loc[4, "t_end_s"] = table.loc[4, "t_start_s"] + 60.5  # half a second under way
    read_transit(folder(KIND, table), transit_mission)
    table.loc[4, "t_end_s"] = table.loc[4, "t_start_s"] + 60.0
    with pytest.raises(InputError, match=r"rows\.csv:6: t_end_s: the leg ends before it has begun"):
        read_transit(folder(KIND, table), transit_mission)


def test_too_few_legs_says_how_many_are_needed_for_what(folder, transit_mission, legs):
    with pytest.raises(InputError, match="8 legs are needed to tell a constant error from chance"):
        read_transit(folder(KIND, legs(5)), transit_mission)


def test_blank_and_marked_rows_are_left_out_with_a_notice(folder, transit_mission, legs):
    table = legs().assign(ok=1)
    table.loc[:2, "ok"] = 0
    table.loc[10, "x_end_m"] = np.nan
    data = read_transit(folder(KIND, table), transit_mission)
    assert data.n == 44
    assert any("rows.csv: 3 rows left out as marked" in notice for notice in data.notices)
    assert any("rows.csv: 1 row left out without x_end_m" in notice for notice in data.notices)
    unmarked = read_transit(folder(KIND, legs().assign(ok=1)), transit_mission)
    assert not any("left out" in notice for notice in unmarked.notices)


def test_legs_out_of_order_are_sorted_aloud(folder, transit_mission, legs):
    data = read_transit(folder(KIND, legs().sample(frac=1.0, random_state=1)), transit_mission)
    assert np.all(np.diff(data.t_start) > 0.0)
    assert any("sorted" in notice for notice in data.notices)


def test_a_wrong_fix_is_left_out_by_name(folder, transit_mission, legs):
    table = legs()
    table.loc[20, "x_end_m"] += 40_000.0
    data = read_transit(folder(KIND, table), transit_mission)
    assert "21" not in data.labels
    assert any("wrong fixes" in notice and "21" in notice for notice in data.notices)


def test_a_wrong_fix_is_one_that_is_far_from_what_carries_all(folder, transit_mission, legs):
    """A current of 2 m/s is no wrong fix; a single leg that it seems to carry the other way is one."""
    table = legs(error=lambda t, heading: np.stack([np.full(len(t), 2.0), np.zeros(len(t))]))
    assert read_transit(folder(KIND, table), transit_mission).n == len(table)
    turning = legs(error=lambda t, heading: 4.0 * np.stack([np.cos(np.arange(len(t))), np.sin(np.arange(len(t)))]))
    assert read_transit(folder(KIND, turning), transit_mission).n == len(turning), "no leg is far from all others"
    calm = legs()
    calm.loc[20, "x_end_m"] += 2.5 * (calm.loc[20, "t_end_s"] - calm.loc[20, "t_start_s"])
    assert read_transit(folder(KIND, calm), transit_mission).n == len(calm), "water can be as fast"
    table.loc[20, "x_end_m"] -= 4.0 * (table.loc[20, "t_end_s"] - table.loc[20, "t_start_s"])
    assert set(table["leg"].astype(str)) - set(read_transit(folder(KIND, table), transit_mission).labels) == {"21"}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"kind": "drag"}, "given 'drag', expected transit"),
        ({"kind": "transits"}, "did you mean transit"),
        ({"kind": "transit", "nois": {}}, "did you mean noise"),
        ({"kind": "transit", "noise": {"fix": 3}}, "expected a unit too"),
        ({"kind": "transit", "noise": {"fix": "-3 m"}}, "expected more than 0"),
        ({"kind": "transit", "file": "../rows.csv"}, "outside the data set's folder"),
        ({"kind": "transit", "file": "other.csv"}, "no such file"),
    ],
)
def test_bad_dataset_yaml(folder, transit_mission, legs, keys, words):
    with pytest.raises(InputError, match=words):
        read_transit(folder(keys, legs()), transit_mission)


@pytest.mark.parametrize(("text", "words"), [("", "is empty"), ("leg,t_start_s\n1,2,3,4\n5,6,7\n", "missing|table")])
def test_a_file_that_is_no_table(folder, transit_mission, text, words):
    with pytest.raises(InputError, match=words):
        read_transit(folder(KIND, text), transit_mission)


def test_a_file_that_is_no_text(folder, transit_mission, legs):
    place = folder(KIND, legs())
    (place / "rows.csv").write_bytes(b"leg,t_start_s\n\xff\xfe1,2\n")
    with pytest.raises(InputError, match="not UTF-8"):
        read_transit(place, transit_mission)


def test_seconds_since_1970_count_from_the_first_fix(folder, transit_mission, legs):
    table = legs()
    table[["t_start_s", "t_end_s"]] += 1.6e9
    data = read_transit(folder(KIND, table), transit_mission)
    assert data.t_start[0] == 0.0
    assert data.epoch == 1.6e9


def test_a_start_of_the_data_set_is_the_zero_of_its_seconds_whatever_the_mission_starts_at(
    folder, transit_mission, legs
):
    table = legs()
    place = folder({**KIND, "start": "2026-05-01T10:00:00+02:00"}, table)
    for start in ("2026-05-01T06:00:00Z", "2026-06-01T06:00:00Z"):
        data = read_transit(place, transit_mission.with_(start=start))
        began = np.datetime64(start[:-1]) + (data.t_start[0] * 1e9).astype("timedelta64[ns]")
        assert began == np.datetime64("2026-05-01T08:00:00") + np.timedelta64(
            round(table["t_start_s"].min() * 1e9), "ns"
        )
    table[["t_start_s", "t_end_s"]] += 1.6e9
    dated = read_transit(folder({**KIND, "start": "2026-05-01T10:00:00+02:00"}, table), transit_mission)
    assert dated.epoch == 1.6e9 + legs()["t_start_s"].min()
    assert "start of the data set is not used: its times are dates" in dated.notices


def test_the_accuracy_of_each_fix_is_read(folder, transit_mission, legs):
    table = legs().assign(fix_sd_m=5.0)
    table.loc[3, "fix_sd_m"] = 20.0
    table.loc[4, "fix_sd_m"] = np.nan
    data = read_transit(folder(KIND, table), transit_mission)
    assert data.typical_fix_sd == 5.0
    np.testing.assert_allclose(data.fix_scale[:6], [1.0, 1.0, 1.0, 4.0, 1.0, 1.0])
    assert data.subset(np.arange(3, 20)).fix_scale[0] == 4.0
    assert np.all(read_transit(folder(KIND, legs()), transit_mission).fix_scale == 1.0)
    with pytest.raises(InputError, match="fix_sd_m: expected more than 0 m"):
        read_transit(folder(KIND, legs().assign(fix_sd_m=0.0)), transit_mission)


@pytest.mark.parametrize("names", [("t_start", "t_end"), ("t_start_s", "t_end_s")])
@pytest.mark.parametrize("zone", ["Z", "", "+02:00"])
def test_times_may_be_iso_8601(folder, transit_mission, legs, names, zone):
    table = legs()
    shift = 7200.0 if zone == "+02:00" else 0.0
    stamps = table.drop(columns=["t_start_s", "t_end_s"])
    for name, seconds in zip(names, ("t_start_s", "t_end_s"), strict=True):
        moments = pd.to_datetime(table[seconds] + 1.7e9 + shift, unit="s")
        stamps[name] = moments.dt.strftime("%Y-%m-%dT%H:%M:%S.%f") + zone
    plain, iso = (read_transit(folder(KIND, each), transit_mission) for each in (table, stamps))
    assert iso.epoch == pytest.approx(1.7e9 + table["t_start_s"].min(), abs=1e-3)
    np.testing.assert_allclose(np.diff(iso.t_start), np.diff(plain.t_start), atol=1e-4)
    np.testing.assert_allclose(iso.under_way, plain.under_way, atol=1e-4)


def test_a_time_that_is_none_is_said(folder, transit_mission, legs):
    table = legs().astype({"t_start_s": str})
    table.loc[2, "t_start_s"] = "yesterday"
    with pytest.raises(InputError, match="given 'yesterday', expected seconds, or a time such as 2026-05-01T10:20:30Z"):
        read_transit(folder(KIND, table), transit_mission)


def test_the_mean_depth_of_each_leg_is_read(folder, transit_mission, legs):
    table = legs().assign(depth_m=12.5)
    table.loc[4, "depth_m"] = np.nan
    data = read_transit(folder(KIND, table), transit_mission)
    assert np.nanmedian(data.depth) == 12.5
    assert np.isnan(data.depth[4])
    assert len(data.subset(np.arange(3)).depth) == 3
    assert read_transit(folder(KIND, legs()), transit_mission).depth is None
    table.loc[3, "depth_m"] = 20_000.0
    with pytest.raises(InputError, match="depth_m"):
        read_transit(folder(KIND, table), transit_mission)


def test_a_leg_is_known_by_its_triangle_wherever_it_lies_and_whenever_it_began(folder, transit_mission, legs):
    """Moved, turned and later it is the same leg; its mirror image, a longer or a shorter one is another."""
    data = read_transit(folder(KIND, legs()), transit_mission)

    def placed(matrix, moved=0.0, **changes):
        corners = {name: matrix @ getattr(data, name) + moved for name in ("start", "dead_reckoned", "end")}
        return replace(data, **corners, **changes).identities

    turned = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    assert len(set(data.identities)) == data.n
    assert placed(turned, 1234.5, t_start=data.t_start + 1e6) == data.identities
    others = [placed(np.diag([-1.0, 1.0])), placed(1.01 * np.eye(2)), placed(np.eye(2), under_way=1.1 * data.under_way)]
    assert all(set(data.identities).isdisjoint(other) for other in others)


def test_what_follows_from_the_legs_of_a_log(folder, transit_mission, legs):
    """Middle of each, date of all, error over the time under way without that at the surface, and the fix's error."""
    table = legs().assign(surface_s=20.0)
    assert np.isnan(read_transit(folder(KIND, table), transit_mission).date)
    dated = table.assign(t_start_s=table["t_start_s"] + 1.6e9, t_end_s=table["t_end_s"] + 1.6e9)
    data = read_transit(folder(KIND, dated), transit_mission)
    under_way = dated["t_end_s"] - dated["t_start_s"] - 20.0
    assert data.under_way == pytest.approx(under_way.to_numpy())
    assert data.middle + data.epoch == pytest.approx((dated["t_start_s"] + 0.5 * under_way).to_numpy(), rel=1e-12)
    assert data.date == pytest.approx((dated["t_start_s"] + 0.5 * under_way).mean(), rel=1e-12)
    errors = (
        table[["x_end_m", "y_end_m"]].to_numpy() - table[["x_dr_m", "y_dr_m"]].to_numpy()
    ).T / under_way.to_numpy()
    assert data.velocity_error == pytest.approx(errors)
    assert (data.typical_fix_sd, data.has_surface_time) == (3.0, True)
    assert replace(data, leg_fix_sd=np.linspace(1.0, 9.0, data.n)).typical_fix_sd == pytest.approx(5.0)
    assert np.isnan(replace(data, origin=None).latitude)
