"""Moments at every door: aware, UTC, and the same whatever the zone of the computer."""

import ast
import time
from datetime import UTC, date, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pydantic import BaseModel

import missionplan
from missionplan.datasets.legs import _epoch
from missionplan.errors import InputError
from missionplan.moments import clock, epoch_of, moment_of, other_zone

PACKAGE = Path(missionplan.__file__).parent
FOUR = datetime(2026, 6, 1, 4, tzinfo=UTC)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        *[("local time", "local time"), ("Time [local_standard_time]", "local_standard_time"), ("local", "local")],
        *[("hours (PDT)", "PDT"), ("Eastern time, EST (UTC-5)", "EST"), ("in UTC+8", "UTC+8"), ("GMT -3", "GMT -3")],
        *[(text, "") for text in ("time", "UTC", "UTC, once of local time", "computed locally each time", "UTC+00:00")],
        *[(text, "") for text in ("west coast", "best estimate", "GPS time", "GMT (EST + 5)")],
    ],
)
def test_texts_that_name_another_zone(text, words):
    assert other_zone(text) == words


@pytest.mark.parametrize("name", ["long_name", "Comment", "description"])
def test_a_text_beside_times_that_names_another_zone_is_asked_for_its_offset(name):
    units = "hours since 2026-06-01 04:00"
    with pytest.raises(ValueError, match=r"a text beside it says 'PST', its units UTC; an attribute time_zone"):
        clock({"units": units, name: "time in PST"})
    said = ({"units": units, "time_zone": "-08:00"}, {"units": f"{units} -08:00"})
    assert [clock({**each, name: "time in PST"})[0] for each in said] == [(FOUR + 8 * HOUR).timestamp()] * 2


@pytest.mark.parametrize(
    "written",
    [
        "2026-06-01T04:00", "2026-06-01T04:00Z", "2026-06-01 04:00:00.000 UTC", "2026-06-01T06:00:00+02:00", "2026-6-1 4:0:0",
        "2026-05-31T23:00-0500", "2026-06-01 13:00 +9", "20260601T040000Z", "2026-06-01t04:00:00z", datetime(2026, 6, 1, 4),  # noqa: DTZ001
        datetime(2026, 6, 1, 6, tzinfo=timezone(timedelta(hours=2))),
    ],
)  # fmt: skip
def test_one_moment_is_written_in_many_ways(written):
    found = moment_of(written)
    assert found == FOUR
    assert found.tzinfo is UTC


def test_a_date_is_its_midnight():
    assert moment_of(date(2026, 6, 1)) == moment_of("2026-06-01") == moment_of("2026-05-31T24:00") == FOUR - 4 * HOUR


HOUR = timedelta(hours=1)


@pytest.mark.parametrize(
    "written",
    [
        "20260601",
        20260601,
        2026.5,
        True,
        "",
        "noon",
        "2026-06-01 04:00 EST",
        "2026-06-01T04:00 Europe/Berlin",
        "2026-06-31",
    ],
)
def test_what_is_no_moment_is_refused(written):
    with pytest.raises(ValueError, match=r"."):
        moment_of(written)


@pytest.mark.parametrize("kind", ["standard", "gregorian", "proleptic_gregorian", ""])
@pytest.mark.parametrize(
    "zero", ["2026-06-01", "1950-01-01", "1858-11-17", "1582-10-15", "1500-03-01", "0001-01-01", "1300-12-31"]
)
@pytest.mark.parametrize("unit", ["seconds", "minutes", "hours", "days", "milliseconds"])
def test_units_of_times_are_those_of_cftime(unit, zero, kind):
    cftime = pytest.importorskip("cftime")
    begun, length = clock({"units": f"{unit} since {zero}", "calendar": kind})
    whole = round(1.75e9 - begun)
    theirs = cftime.num2date(int(whole / length), f"{unit} since {zero}", kind or "standard")
    ours = datetime.fromtimestamp(begun + int(whole / length) * length, UTC)
    assert theirs.isoformat()[:19] == ours.isoformat()[:19]


@pytest.mark.parametrize("unit", ["seconds", "msec", "milliseconds", "µs", "microsecond", "ns", "min", "hours", "days"])
def test_every_unit_is_as_long_as_elsewhere(unit):
    _, length = clock({"units": f"{unit} since 1970-01-01"})
    assert length == pd.Timedelta(1, {"msec": "ms", "µs": "us"}.get(unit, unit)).total_seconds()


@pytest.mark.parametrize(
    ("units", "hours"),
    [
        ("hours since 2026-06-01 00:00 +02:00", -2),
        ("hours since 2026-06-01T00:00:00Z", 0),
        ("h since 2026-06-01 00:00 -5", 5),
    ],
)
def test_zones_in_units_are_honoured(units, hours):
    assert clock({"units": units}) == ((FOUR + (hours - 4) * HOUR).timestamp(), 3600.0)


@pytest.mark.parametrize(
    ("units", "calendar"),
    [
        ("hours since 2026-06-01 00:00 EST", ""), ("months since 2026-06-01", ""), ("hours", ""), ("m", ""),
        ("days since 2026-06-01", "noleap"), ("days since 2026-06-01", "360_day"), ("days since 2026-06-01", "julian"),
    ],
)  # fmt: skip
def test_other_units_of_times_are_refused(units, calendar):
    with pytest.raises(ValueError, match=r"EST|expected|calendar"):
        clock({"units": units, "calendar": calendar})


@pytest.mark.parametrize(
    "line",
    [
        "2026-06-01T04:00",
        "'2026-06-01T04:00'",
        "2026-06-01T06:00:00+02:00",
        "2026-06-01 04:00:00",
        "'2026-06-01 04:00 UTC'",
    ],
)
def test_the_start_of_a_mission_file(tmp_path, line):
    (tmp_path / "mission.yaml").write_text(f"name: dated\nstart: {line}\n")
    assert missionplan.load(tmp_path / "mission.yaml").start == FOUR


@pytest.mark.parametrize("line", ["20260601", "'20260601'", "1.7e9", "true", "2026-06-01T04:00 EST", "[2026, 6, 1]"])
def test_a_start_that_is_no_moment_is_refused_with_an_example(tmp_path, line):
    (tmp_path / "mission.yaml").write_text(f"name: dated\nstart: {line}\n")
    with pytest.raises(InputError, match=r"start.*given .*2026-06-01T04:00Z|start.*given .*-05:00"):
        missionplan.load(tmp_path / "mission.yaml")


@pytest.fixture
def computer_in(monkeypatch):
    """Set the zone of the computer."""

    def put(zone):
        monkeypatch.setenv("TZ", zone)
        time.tzset()

    yield put
    monkeypatch.undo()
    time.tzset()


@pytest.mark.skipif(not hasattr(time, "tzset"), reason="this system has no zone a process may change")
@pytest.mark.parametrize("zone", ["UTC", "Asia/Tokyo", "America/St_Johns"])
def test_the_zone_of_the_computer_does_not_count(computer_in, zone):
    computer_in(zone)
    mission = missionplan.Mission.from_data({"start": "2026-06-01T04:00"})
    epoch = epoch_of("2026-06-01T04:00:00")
    assert mission.start == FOUR
    assert (_epoch(np.array([epoch]), mission, []), epoch) == (FOUR.timestamp(), FOUR.timestamp())


def test_moments_are_made_in_one_place():
    """What ruff's DTZ does not see: `fromisoformat` and `combine` give naive moments, so does pandas without a zone."""
    naive = ("fromisoformat", "combine", "utcnow", "utcfromtimestamp", "mktime")
    found = []
    for path in PACKAGE.rglob("*.py"):
        text = path.read_text()
        if path.name == "moments.py" or not any(name in text for name in (*naive, "to_datetime", "Timestamp")):
            continue
        calls = [each for each in ast.walk(ast.parse(text)) if isinstance(each, ast.Call)]
        made = [each for each in calls if getattr(each.func, "id", "") in ("utc", "moment_of")]
        inside = {id(inner) for call in made for inner in ast.walk(call)}
        for call in calls:
            name = getattr(call.func, "attr", "")
            zoned = any(word.arg in ("utc", "tz") for word in call.keywords) or "moment_of(" in ast.unparse(call)
            is_naive = name in naive or (name in ("to_datetime", "Timestamp") and not zoned)
            if is_naive and id(call) not in inside:
                found.append(f"{path.relative_to(PACKAGE)}:{call.lineno} {name}")
    assert not found


def test_no_section_reads_a_moment_by_itself():
    import missionplan.datasets.dives  # noqa: F401  (its sections, too)

    def sections(kind):
        return [kind, *(each for child in kind.__subclasses__() for each in sections(child))]

    naive = [
        (section.__name__, name)
        for section in sections(BaseModel)
        if section.__module__.startswith("missionplan")
        for name, field in section.model_fields.items()
        if field.annotation in (datetime, datetime | None)
        and not field.metadata
        and "ReadBy" not in str(section.__annotations__.get(name))
    ]
    assert not naive
