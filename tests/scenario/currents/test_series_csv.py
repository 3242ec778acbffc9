"""A current or a wind against time, and depth, as a CSV says it: rows in any order, none twice, none missing, none absurd."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest

from missionplan.errors import InputError
from missionplan.scenario.currents.reading import CURRENT_LIMITS, WIND_LIMITS, read_series_csv

START = datetime(2026, 5, 1, 6, tzinfo=UTC)
ROWS = pd.DataFrame(
    [(t, z, 0.1 * k + 0.01 * z, -0.2 * k) for k, t in enumerate((0.0, 600.0, 1800.0)) for z in (2.0, 10.0)],
    columns=list(CURRENT_LIMITS),
)


def read(tmp_path, rows, limits=CURRENT_LIMITS, **options):
    path = tmp_path / "series.csv"
    rows.to_csv(path, index=False)
    return read_series_csv(path, limits, **options)


def same(found, lead=0.0):
    np.testing.assert_allclose(found.time, lead + np.array([0.0, 600.0, 1800.0]), atol=1e-3)
    np.testing.assert_allclose(found.depth, [2.0, 10.0])
    np.testing.assert_allclose(found.east, [[0.02, 0.1], [0.12, 0.2], [0.22, 0.3]])
    np.testing.assert_allclose(found.north, [[0.0, 0.0], [-0.2, -0.2], [-0.4, -0.4]])


def test_rows_in_any_order_by_seconds_or_by_dates(tmp_path):
    same(read(tmp_path, ROWS))
    same(read(tmp_path, ROWS.iloc[::-1]))
    same(read(tmp_path, ROWS.sample(frac=1.0, random_state=3)[list(CURRENT_LIMITS)[::-1]]))
    marked = pd.concat([ROWS.assign(ok=1), ROWS.assign(ok=0, east_m_s=99.0)])
    same(read(tmp_path, marked))  # what is marked is left out unseen, as of data sets
    dated = ROWS.assign(t_s=[(START + timedelta(seconds=t)).isoformat() for t in ROWS["t_s"]])
    same(read(tmp_path, dated, start=START))
    since_1970 = ROWS.assign(t_s=ROWS["t_s"] + START.timestamp())
    same(read(tmp_path, since_1970, start=START))
    for rows in (dated, since_1970):
        same(read(tmp_path, rows, start=START + timedelta(hours=1)), -3600.0)
    same(read(tmp_path, ROWS, start=START, epoch=START + timedelta(minutes=5)), 300.0)
    for options, words in (({}, "its times are of the day"), ({"start": START, "epoch": START}, "its times are dates")):
        for rows in (dated, since_1970):
            with pytest.raises(InputError, match=words):
                read(tmp_path, rows, **options)
    with pytest.raises(InputError, match="the mission needs its `start`"):
        read(tmp_path, ROWS, epoch=START)


def test_a_wind_has_no_depth_and_may_be_faster(tmp_path):
    rows = ROWS[ROWS["depth_m"] == 2.0].drop(columns="depth_m").assign(east_m_s=[20.0, -90.0, 0.0])
    found = read(tmp_path, rows, WIND_LIMITS)
    assert found.depth.tolist() == [0.0]
    np.testing.assert_allclose(found.east, [[20.0], [-90.0], [0.0]])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: pd.concat([r, r.iloc[[3]]]), r"series\.csv:8: this row has the time and depth of an earlier one"),
        (lambda r: r.drop(index=3), "every depth must be given at every time"),
        (lambda r: r.assign(east_m_s=r["east_m_s"].where(r.index != 2, np.nan)), r"series\.csv:4: expected 4 numbers"),
        (lambda r: r.assign(north_m_s=r["north_m_s"].where(r.index != 5, 12.1)), r"series\.csv:7: is impossible"),
        (lambda r: r.assign(north_m_s=r["north_m_s"].where(r.index != 0, -12.1)), r"series\.csv:2: is impossible"),
        (
            lambda r: r.assign(depth_m=r["depth_m"] * 1200.0),
            r"series\.csv:3: is impossible; expected .*depth_m at most 11",
        ),
        (lambda r: pd.concat([r[:3], r[3:].assign(east_m_s=9.99, north_m_s=9.99)]), r"series\.csv:5: is impossible"),
        (lambda r: r.assign(depth_m=-r["depth_m"]), r"series\.csv:2: is impossible; .*depths positive down"),
    ],
)
def test_a_row_twice_missing_or_absurd_is_named_by_its_line(change, message, tmp_path):
    with pytest.raises(InputError, match=message):
        read(tmp_path, change(ROWS))


def test_what_is_just_possible_is_read(tmp_path):
    found = read(tmp_path, ROWS.assign(east_m_s=12.0, north_m_s=-12.0))
    assert (found.east == 12.0).all()
    assert (found.north == -12.0).all()
