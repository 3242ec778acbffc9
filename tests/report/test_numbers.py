"""Rounding and units of numbers that people read."""

import math

import pytest

from missionplan.montecarlo.statistics import Probability, Statistic, wilson
from missionplan.report.quantities import (
    Unit,
    in_reader_units,
    length_in_words,
    reading_in,
    span,
    time_in_words,
    unit_for,
    with_error,
)
from missionplan.report.wording import (
    in_words,
    number,
    percent,
    phase_in_words,
    phases_named,
    portion_in_words,
    rounded_down,
    rounded_up,
    split_key,
)

MISSION = {
    "site": {"depth": "40 ft"},
    "vehicle": {"energy": {"capacity": "60 W*h"}},
    "phases": [
        {"transit": {"name": "ingress", "to": ["1 nmi", "0 m"], "speed": "1.5 kn", "arrival_radius": "15 m"}},
        {"moor": {"radius": {"mean": "75 ft", "sd": "1 ft"}}},
    ],
    "requirements": [
        {"quantity": "moor.lowest_altitude", "at_least": "0.3 m", "probability": 0.99},
        {"quantity": "total.duration", "at_most": "2 h", "probability": 0.9},
    ],
}


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (21.34567, 0.04, "21.35"),
        (21.34567, 0.014, "21.346"),
        (21.34567, 0.4, "21.3"),
        (21.34567, 0.196, "21.3"),  # an error that would be shown as 0.20
        (21.34567, 3.0, "21"),
        (1234.5, 30.0, "1230"),
        (123456.0, 30.0, "123\u202f460"),
        (-0.001, 0.4, "0.0"),
        (-3.21, 0.4, "−3.2"),
        (9.96, 0.2, "10.0"),
        (1600.0, 0.0, "1600"),
        (0.30480, math.nan, "0.3048"),
        (math.nan, 1.0, "–"),
        (0.0, 0.0, "0"),
        (1.49815360427, 2e-16, "1.498"),
    ],
)
def test_numbers_have_the_digits_that_their_error_supports(value, error, text):
    assert number(value, error) == text


@pytest.mark.parametrize(
    ("successes", "trials", "text"),
    [
        (8700, 10_000, "87.0\u00a0±\u00a00.7\u00a0%"),
        (5000, 10_000, "50.0\u00a0±\u00a01.0\u00a0%"),
        (87, 100, "87\u00a0% (79 to 92\u00a0%)"),
        (9997, 10_000, "99.97\u00a0% (99.91 to 99.99\u00a0%)"),
        (1, 1000, "0.10\u00a0% (0.02 to 0.56\u00a0%)"),  # what was seen is not said to be impossible
        (10_000, 10_000, "100\u00a0% (at least 99.96\u00a0%)"),
        (0, 1000, "0\u00a0% (at most 0.4\u00a0%)"),
        (0, 1197, "0\u00a0% (at most 0.4\u00a0%)"),  # 0.32 %: a bound is never rounded inwards
        (1197, 1197, "100\u00a0% (at least 99.6\u00a0%)"),
        (0, 0, "–"),
    ],
)
def test_probabilities_carry_their_interval(successes, trials, text):
    assert percent(wilson(successes, trials)) == text


def test_errors_are_rounded_with_their_value():
    assert with_error(6.5038, 0.0411, Unit("ft", 0.3048)) == "21.34\u00a0±\u00a00.13\u00a0ft"
    assert with_error(6.5038, 0.0, Unit("m", 1.0)) == "6.504\u00a0m"


def test_percentiles_of_few_trials_have_few_digits():
    many = Statistic(mean=85.0, sd=1.6, p05=82.9438, p50=85.3811, p95=88.1572, standard_error=0.025, count=4000)
    few = Statistic(mean=85.0, sd=1.6, p05=82.9438, p50=85.3811, p95=88.1572, standard_error=0.7, count=5)
    assert span(many, Unit("min", 1.0)) == ("82.9", "85.4", "88.2")
    assert span(few, Unit("min", 1.0)) == ("82.9", "85.4", "88.2")
    assert span(few, Unit("s", 1.0 / 60.0)) == ("4980", "5120", "5290")


@pytest.mark.parametrize(
    ("sd", "trials", "digits"),
    [
        (4.5, 9, "12"),  # the mean's error of 1.5 would support a decimal, 2.1 times as much does not
        (2.52, 9, "12.3"),  # 2.1 times 0.84 does, 2.4 times as much would not
        (11.0, 400, "12"),  # of many trials a fifth of the spread decides: 2.2
        (9.0, 400, "12.3"),  # 1.8
    ],
)
def test_an_outer_point_has_the_error_of_the_five_percent_point_of_a_normal_sample(sd, trials, digits):
    error = sd / math.sqrt(trials)
    few = Statistic(mean=14.0, sd=sd, p05=12.34, p50=14.0, p95=16.0, standard_error=error, count=trials)
    assert span(few, Unit("m", 1.0))[0] == digits
    density = math.exp(-0.5 * 1.6449**2) / math.sqrt(2.0 * math.pi)
    assert math.sqrt(0.05 * 0.95) / density == pytest.approx(2.1, abs=0.05)  # its standard error over the mean's


@pytest.mark.parametrize(
    ("phase", "key", "name", "size"),
    [
        ("moor", "offset_m", "ft", 0.3048),
        ("moor", "lowest_altitude_m", "m", 1.0),
        ("ingress", "arrival_error_m", "m", 1.0),
        ("ingress", "distance_m", "nmi", 1852.0),
        ("moor", "terminal_velocity_m_s", "m/s", 1.0),
        ("total", "energy_wh", "W\u202fh", 1.0),
        ("total", "duration_s", "h", 3600.0),
        ("ingress", "surfacings", "", 1.0),
    ],
)
def test_units_are_the_missions(phase, key, name, size):
    assert unit_for(phase, key, MISSION) == Unit(name, pytest.approx(size))


def test_times_without_a_requirement_choose_a_readable_unit():
    assert unit_for("moor", "duration_s", MISSION, typical=12.0).name == "s"
    assert unit_for("moor", "duration_s", MISSION, typical=1200.0) == Unit("min", 60.0)
    assert unit_for("moor", "duration_s", {}, typical=1e6).name == "d"
    assert unit_for("slow down", "pitch_excursion_rad", {}) == Unit("°", pytest.approx(math.pi / 180.0))


def test_a_unit_of_another_kind_is_not_taken():
    assert unit_for("moor", "offset_m", {"phases": [{"moor": {"radius": "75 s"}}]}) == Unit("m", 1.0)


def test_keys_are_split_at_their_longest_unit():
    assert split_key("terminal_velocity_m_s") == ("terminal_velocity", "m/s")
    assert split_key("surfacings") == ("surfacings", "")


@pytest.mark.parametrize(
    ("system", "words"),
    [
        ("", "winds of 0 to 12 m/s, 0.1 m/s off, carry it 24 m, 2 mm, 1.50 km, 18.2 cm/s"),
        ("nautical", "winds of 0 to 23 kn, 0.2 kn off, carry it 24 m, 2 mm, 0.810 nmi, 0.354 kn"),
        ("imperial", "winds of 0 to 39 ft/s, 0.3 ft/s off, carry it 79 ft, 2 mm, 4921 ft, 0.597 ft/s"),
    ],
)
def test_quantities_within_words_are_in_the_readers_units(system, words):
    with reading_in(system):
        told = in_reader_units("winds of 0 to 12 m/s, 0.1 m/s off, carry it 24 m, 2 mm, 1.50 km, 18.2 cm/s")
    assert told.replace("\u00a0", " ") == words


def test_times_are_in_minutes_from_a_minute_and_a_half():
    assert [time_in_words(seconds) for seconds in (89.0, 96.0, 1090.0)] == [
        "89\u00a0s",
        "1.6\u00a0min",
        "18.2\u00a0min",
    ]


def test_a_probability_that_is_certain_has_no_interval() -> None:
    """As in a sweep by the integral equation alone, where no trial may fail to arrive."""
    assert percent(Probability(1.0, 1.0, 1.0)) == "100\u00a0%"
    assert percent(Probability(0.0, 0.0, 0.0)) == "0\u00a0%"


def test_within_three_half_intervals_of_0_or_100_a_probability_has_its_interval_itself() -> None:
    told = {0.07: "7\u00a0±\u00a02\u00a0%", 0.05: "5\u00a0% (3 to 7\u00a0%)", 0.95: "95\u00a0% (93 to 97\u00a0%)"}
    assert [percent(Probability(value, value - 0.02, value + 0.02)) for value in told] == list(told.values())


@pytest.mark.parametrize(
    ("value", "down", "up"),
    [
        (20.67, 20.6, 20.7),
        (20.6, 20.6, 20.6),
        (20.600001, 20.6, 20.7),
        (9.999, 9.99, 10.0),
        (12345.0, 12300.0, 12400.0),
        (-0.30017, -0.301, -0.3),
        (0.0, 0.0, 0.0),
    ],
)
def test_a_bound_is_rounded_to_three_digits_on_its_safe_side(value, down, up):
    assert rounded_down(value) == down
    assert rounded_up(value) == up


def test_a_phase_is_called_what_the_mission_calls_it_where_that_reads_well():
    names = {"phases[0]": "leg 1.5 km, north", "phases[1]": "in$^$", "phases[2]": "<b>x</b>"}
    with phases_named(names):
        assert in_words("phases[0].arrival_time_s") == "arrival time (leg 1.5 km, north)"
        assert in_words("phases[1].arrival_time_s") == "arrival time (phase 2)"
        assert phase_in_words("phases[2]") == "phase 3"
    assert in_words("phases[0].arrival_time_s") == "arrival time (phase 1)"


@pytest.mark.parametrize(
    ("metres", "words"), [(746.6, "747 m"), (999.0, "999 m"), (1000.0, "1.00 km"), (1264.0, "1.26 km")]
)
def test_a_length_is_in_kilometres_from_one_on(metres, words):
    assert length_in_words(metres).replace("\u00a0", " ") == words


@pytest.mark.parametrize(
    ("portion", "decimals", "words"),
    [
        (0.0, 0, "0 %"),
        (0.004, 0, "< 1 %"),
        (0.76, 0, "76 %"),
        (0.9962, 0, "> 99 %"),
        (0.9999, 1, "> 99.9 %"),
        (1, 1, "100.0 %"),
    ],
)
def test_a_portion_is_rounded_neither_to_nothing_nor_to_all(portion: float, decimals: int, words: str) -> None:
    assert portion_in_words(portion, decimals).replace("\u00a0", " ") == words
