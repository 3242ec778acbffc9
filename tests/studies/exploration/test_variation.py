"""What `--vary` says: ranges with units, times with their own colons, lists."""

import itertools
import math
import string
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import missionplan
from missionplan.errors import InputError
from missionplan.mission.mission import with_values
from missionplan.moments import moment_of
from missionplan.studies.exploration import known_key, known_keys, read_axes, read_axis, steps

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.fixture(scope="module")
def estuary():
    return missionplan.load(MISSIONS / "estuary.yaml")


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        ("start=04:00:05:00:30 min", ("04:00", "04:30", "05:00")),
        ("start=2026-06-01T04:00:2026-06-01T05:00:30 min", ("04:00", "04:30", "05:00")),
        ("start=04:00:00:05:00:00:30 min", ("04:00", "04:30", "05:00")),
        ("start=0 h:1 h:30 min", ("11:30", "12:00", "12:30")),
        ("start=2026-06-01T23:00:2026-06-02T00:00:1 h", ("01 Jun 23:00", "02 Jun 00:00")),
        ("start=04:00,05:15", ("04:00", "05:15")),
        ("ingress.speed=0.5:1.5:0.5 m/s", ("0.5", "1", "1.5")),
        ("ingress.speed=1 kn:2 kn:1 kn", ("1", "2")),
        ("moor.hold=1 min, 120 s", ("60", "120")),
        ("navigation.max_legs=100:300:100", ("100", "200", "300")),
        ("moor.release_time.mean=5:15:5 s", ("5", "10", "15")),
    ],
)
def test_values_are_read(estuary, text, labels):
    assert read_axis(estuary, text).labels == labels


@pytest.mark.parametrize(
    ("text", "numbers", "values", "unit"),
    [
        ("ingress.speed=1 kn:2 m/s:0.5 m/s", (0.514444444, 1.014444444, 1.514444444), "{} m/s", "m/s"),
        ("moor.hold=1 min, 120, 1 h", (1 / 60, 120.0, 1.0), "{} h", "h"),
        ("moor.hold=2 h:1 h:-30 min", (120.0, 90.0, 60.0), "{} min", "min"),
        ("navigation.max_legs=100:310:100", (100.0, 200.0, 300.0), "{}", ""),
        ("start=-1 h:1 h:1 h", (-5400.0, -1800.0, 1800.0), None, "UTC"),
        ("start=04:00:05,2026-06-01T04:00:00+02:00,30 min", (-28_795.0, -36_000.0, 0.0), None, "UTC"),
        ("start=05:00:04:00:-30 min", (-25_200.0, -27_000.0, -28_800.0), None, "UTC"),
    ],
)
def test_numbers_values_and_units_say_the_same(estuary, text, numbers, values, unit):
    """A bare number has the unit of the next; starts here count from noon, half an hour after the mission's own."""
    found = read_axis(estuary, text)
    assert found.unit == unit
    if values is None:
        noon = datetime(2026, 6, 1, 12, tzinfo=UTC)
        assert [each - noon.timestamp() for each in found.numbers] == pytest.approx(numbers)
        assert [(moment_of(str(each)) - noon).total_seconds() for each in found.values] == pytest.approx(numbers)
        return
    assert found.numbers == pytest.approx(numbers)
    assert [str(each) for each in found.values] == [values.format(label) for label in found.labels]
    assert [float(label) for label in found.labels] == pytest.approx(numbers)


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        ([], "given 0 times, expected once or twice"),
        (["moor.hold=1,2 h"] * 3, "given 3 times"),
        (["moor.hold=1,2 h", "moor.hold=3,4 h"], "varies moor.hold twice"),
        (["ingress.speed=1:2:0.01 m/s", "moor.hold=1:50:1 h"], "makes 5050 cells, expected at most 5000"),
        (["moor.hold=1:5001:1 s"], "makes 5001 cells, expected at most 5000"),
        (["moor.hold=1:2:-1 s"], "never lead from 1 to 2"),
        (["moor.hold=2:1:1 s"], "never lead from 2 to 1"),
        (["moor.hold=1:2:0 s"], "never lead"),
        (["moor.hold=1:2 s"], "expected FROM:TO:STEP"),
        (["moor.hold="], "expected KEY=FROM:TO:STEP or KEY=A,B,C"),
        (["moor.hold"], "expected KEY=FROM:TO:STEP or KEY=A,B,C"),
        (["start=05:00:04:00:30 min"], "the last time is before the first"),
        (["start=noon,04:00"], "expected times, such as"),
    ],
)
def test_variations_that_cannot_be_are_said(estuary, texts, words):
    with pytest.raises(InputError, match=words):
        read_axes(estuary, texts)
    assert len(read_axes(estuary, ["ingress.speed=1:2:0.02 m/s", "moor.hold=1:98:1 h"])) == 2  # 4998 cells


@given(st.floats(-1e3, 1e3), st.floats(1e-2, 1e3), st.integers(0, 200))
def test_steps_begin_at_the_first_and_end_at_the_last(first, step, count):
    found = steps(first, first + count * step, step)
    assert len(found) in (count, count + 1)  # where rounding takes the last away it is within a step
    assert found[0] == first
    assert all(math.isclose(b - a, step, rel_tol=1e-6, abs_tol=1e-9) for a, b in itertools.pairwise(found))


ESTUARY = missionplan.load(MISSIONS / "estuary.yaml")


@given(st.text(string.printable + "µ°–äß\N{NO-BREAK SPACE}\N{MINUS SIGN}", max_size=40))
def test_nonsense_is_refused_in_words(text):
    try:
        read_axis(ESTUARY, text)
    except InputError as error:
        assert str(error)


def test_every_known_key_can_be_set_where_its_section_is_written(estuary):
    for key in known_keys(estuary):
        changed = with_values(estuary.raw, {key: "x"})
        assert changed != estuary.raw
    assert "start" in known_keys(estuary)
    assert estuary.raw["phases"][0]["transit"]["speed"] == "1.5 m/s"


def test_a_parameter_of_an_explanation_is_varied_by_the_path_that_reports_give_it(estuary):
    explanations = [
        {"probability": 0.7, "effects": [{"fix-error": {"sd": "5 m"}}, {"compass-bias": {"angle": "3 deg"}}]}
    ]
    doubtful = estuary.with_(effects=[{"one-of": explanations}])
    key = "effects[0].one-of[0].compass-bias.angle"
    assert key in known_keys(doubtful)
    known_key(doubtful, key, "--vary")
    changed = doubtful.with_(with_values(doubtful.raw, {key: "0.1 rad"}))
    assert changed.quantities()[key] == 0.1
    with pytest.raises(InputError, match=r"did you mean effects\[0\]\.one-of\[0\]\.compass-bias\.angle"):
        known_key(doubtful, "effects[0].one-of[0].compas-bias.angle", "--vary")


@pytest.mark.parametrize(
    "values", ["1e308:1e309:1e307 m/s", "1:inf:1 m/s", "-1.7e308:1.7e308:1e300 m/s", "1:2:1e-320 m/s"]
)
def test_steps_beyond_all_numbers_are_refused(estuary, values):
    with pytest.raises(InputError, match="expected"):
        read_axis(estuary, f"ingress.speed={values}")


@pytest.mark.parametrize(
    "key", ["monte_carlo.seed", "monte_carlo.trials", "sweep.phase", "requirements[0].probability", "name"]
)
def test_how_a_mission_is_computed_is_no_choice(estuary, key):
    with pytest.raises(InputError, match="says how the mission is computed"):
        read_axis(estuary, f"{key}=1,2,3")
