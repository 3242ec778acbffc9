"""Times by ISO 8601 or as seconds."""

import math

import pandas as pd
import pytest

from missionplan.moments import epoch_of, epoch_seconds


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("1970-01-01T00:00:10Z", 10.0),
        ("1970-01-01 00:00:10", 10.0),
        ("1970-01-01T02:00:10+02:00", 10.0),
        ("12.5", 12.5),
        ("1212-02-01", -23_917_507_200.0),  # before what nanoseconds in 64 bits reach
    ],
)
def test_times_are_read(text, seconds):
    assert epoch_of(text) == seconds
    assert epoch_seconds(pd.Series([text])).tolist() == [seconds]


def test_what_is_no_time_is_none():
    assert all(math.isnan(value) for value in epoch_seconds(pd.Series(["", "noon", "2026-13-01", "10000-01-01"])))
