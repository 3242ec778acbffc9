"""Quantities with units."""

import functools
import math
import re
from typing import Any

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from missionplan.mission.schema.quantity_parser import CoordinateParser, QuantityParser
from missionplan.mission.units import FACTORS, QuantityError, parse_number_with_unit
from missionplan.montecarlo.distributions import Choices, LogNormal, Normal, TruncatedNormal, Uniform
from tests.fixtures import any_text


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("75 ft", "m", 22.86),
        ("0.4 kn", "m/s", 0.4 * 1852 / 3600),
        ("10 min", "s", 600.0),
        ("11.8 N", "N", 11.8),
        ("0.2 lbf", "N", 0.8896443230521),
        ("20 degC", "degC", 20.0),
        ("68 degF", "degC", 20.0),
        ("4 nmi", "m", 7408.0),
        ("60 W*h", "J", 216000.0),
        ("4.75 in", "m", 0.12065),
        ("0.3 L", "m^3", 3e-4),
        ("1.02e-6 m^2/s", "m^2/s", 1.02e-6),
        ("90 deg", "rad", math.pi / 2),
        ("1010 kg/m^3", "kg/m^3", 1010.0),
        ("-.5 m", "m", -0.5),
    ],
)
def test_units_are_converted(text: str, unit: str, value: float) -> None:
    assert parse_number_with_unit(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "given_", [75, 75.0, "75", "", "m", "5 lightbulbs", "5 s", None, True, [1], "nan m", "1e999 m", "5 m; 6", "9" * 99]
)
def test_what_is_no_length_is_refused(given_: Any) -> None:
    with pytest.raises(QuantityError):
        parse_number_with_unit(given_, "m")


@functools.cache
def pint_registry() -> Any:
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


@pytest.mark.parametrize(("unit", "name"), [(unit, name) for unit, names in FACTORS.items() for name in names])
def test_the_table_agrees_with_pint(unit: str, name: str) -> None:
    registry = pint_registry()
    if name in ("kn", "kt") and name not in registry:
        name = "knot"  # pint before 0.25.1
    assert FACTORS[unit].get(name) == pytest.approx(registry.Quantity(1.0, name).to(unit).magnitude, rel=1e-14)


def test_a_foot_is_exact() -> None:
    assert parse_number_with_unit("75 ft", "m") == 75 * 0.3048


def test_units_beyond_the_table_are_known_too() -> None:
    assert parse_number_with_unit("2 furlong", "m") == pytest.approx(402.336, rel=1e-5)
    assert parse_number_with_unit("3 hectometer / minute", "m/s") == pytest.approx(5.0)


def test_a_known_unit_of_another_dimension_is_refused_without_pint() -> None:
    with pytest.raises(QuantityError, match="given 3 kn, expected a quantity in m or a unit like it"):
        parse_number_with_unit("3 kn", "m")


def test_what_is_no_expression_of_units_is_said_to_be_none() -> None:
    for text in ("3 m^", "3 (m", "3 m m)", "3 4 m", "3 m**m"):
        with pytest.raises(QuantityError, match=r"which is not (a unit|known)"):
            parse_number_with_unit(text, "m")


def test_spread_of_a_temperature_is_a_difference() -> None:
    assert QuantityParser("degC")({"mean": "68 degF", "sd": "1.8 degF"}) == Normal(
        pytest.approx(20.0), pytest.approx(1.0)
    )


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ({"mean": "10 s", "sd": "3 s"}, Normal(10.0, 3.0)),
        ({"mean": "10 s", "sd": "3 s", "low": "0 s"}, TruncatedNormal(10.0, 3.0, 0.0)),
        ({"mean": "10 s", "sd": "3 s", "low": "0 s", "high": "1 min"}, TruncatedNormal(10.0, 3.0, 0.0, 60.0)),
        ({"low": "1 s", "high": "2 s"}, Uniform(1.0, 2.0)),
        ({"median": "10 s", "factor": 2}, LogNormal(10.0, 2.0)),
        ({"choices": ["1 s", "2 min"]}, Choices((1.0, 120.0))),
    ],
)
def test_distributions(value: dict[str, Any], expected: object) -> None:
    assert QuantityParser("s")(value) == expected


def test_all_problems_of_a_distribution_are_reported() -> None:
    with pytest.raises(PydanticCustomError) as caught:
        QuantityParser("s")({"mean": 10, "sd": "3 m"})
    assert [problem.path for problem in (caught.value.context or {})["problems"]] == [("mean",), ("sd",)]


@pytest.mark.parametrize(
    "value",
    [
        {"mean": "1 s"},
        {"mean": "1 s", "sd": "-1 s"},
        {"low": "2 s", "high": "1 s"},
        {"median": "1 s", "factor": 0.5},
        {"median": "1 s", "factor": "2 s"},
        {"choices": []},
        {"choices": "1 s"},
        {"mean": "1 s", "sd": "0 s", "low": "0 s"},
        {},
    ],
)
def test_impossible_distributions(value: dict[str, Any]) -> None:
    with pytest.raises(PydanticCustomError):
        QuantityParser("s")(value)


def test_physical_range() -> None:
    parser = QuantityParser("m", low=0.0, open_low=True)
    with pytest.raises(PydanticCustomError, match="more than 0 m"):
        parser("0 m")
    with pytest.raises(PydanticCustomError, match="mean"):
        parser({"mean": "-5 m", "sd": "1 m"})
    cut = parser({"mean": "1 m", "sd": "1 m"})
    assert not isinstance(cut, float)
    assert cut.mass_cut == pytest.approx(0.158655, rel=1e-4)


@given(st.floats(-1e12, 1e12).filter(lambda x: abs(x) > 1e-12), st.sampled_from(["m", "km", "ft", "in", "nmi", "cm"]))
def test_round_trip_through_text(value: float, unit: str) -> None:
    metres = parse_number_with_unit(f"{value!r} {unit}", "m")
    one = parse_number_with_unit(f"1 {unit}", "m")
    assert metres == pytest.approx(value * one, rel=1e-12)


@given(any_text(40))
def test_any_text_is_read_or_refused_in_words(text: str) -> None:
    try:
        assert math.isfinite(parse_number_with_unit(text, "m"))
    except QuantityError as error:
        assert str(error).startswith("given")


def test_the_ends_of_a_range_belong_to_it_unless_it_is_open():
    assert QuantityParser("m", low=0.0, high=5.0)("5 m") == 5.0
    assert QuantityParser("m", low=0.0, high=5.0)("0 m") == 0.0
    with pytest.raises(PydanticCustomError, match="at most 5 m"):
        QuantityParser("m", low=0.0, high=5.0)("5.000001 m")
    with pytest.raises(PydanticCustomError, match="more than 0 m"):
        QuantityParser("m", low=0.0, high=5.0, open_low=True)("0 m")


def test_bounds_that_leave_nothing_between_them_are_refused():
    for form in ({"low": "2 m", "high": "2 m"}, {"mean": "2 m", "sd": "1 m", "low": "2 m", "high": "2 m"}):
        with pytest.raises(PydanticCustomError, match="expected low below high"):
            QuantityParser("m")(form)


@pytest.mark.parametrize(
    ("text", "signs", "degrees"),
    [
        ("60 06.0 N", "NS", 60.1),
        ("60° 06.0' N", "NS", 60.1),
        ("37 15 30 S", "NS", -(37.0 + 15.0 / 60.0 + 30.0 / 3600.0)),
        ("076 22.8 W", "EW", -76.38),
        ("60.1 deg", "NS", 60.1),
    ],
)
def test_positions_are_read_as_charts_have_them(text, signs, degrees):
    assert math.degrees(CoordinateParser("rad", fixed=True, signs=signs).parse(text)) == pytest.approx(degrees)


@pytest.mark.parametrize("text", ["60 61.0 N", "60 06.0 E", "91 00 N", "30 s", "60 N 6"])
def test_what_is_no_latitude_is_refused(text):
    with pytest.raises(QuantityError):
        CoordinateParser("rad", low=-math.pi / 2, high=math.pi / 2, fixed=True).parse(text)


@pytest.mark.parametrize(
    ("text", "unit", "near"),
    [
        ("20 mni", "s", "min"),
        ("5 knn", "m/s", "kn"),
        ("1 m^2/ss", "m^2/s", "m^2/s"),
        ("2 Kg", "kg", "kg"),
        ("2 KM", "m", "km"),
        ("2 KN", "N", "kN"),
        ("2 M", "m", "m"),
        ("2 RPM", "1/s", "rpm"),
    ],
)
def test_a_mistyped_unit_is_likened_to_units_of_its_kind(text, unit, near):
    with pytest.raises(QuantityError, match=f"did you mean {re.escape(near)}\\?"):
        parse_number_with_unit(text, unit)


@pytest.mark.parametrize(
    ("text", "unit", "usual"), [("2 fthom", "m", "m, km, cm"), ("2 m s-1", "m/s", "m/s, km/h, cm/s")]
)
def test_a_unit_that_is_like_none_gets_the_usual_ones(text, unit, usual):
    with pytest.raises(QuantityError, match=f"expected one such as {usual}"):
        parse_number_with_unit(text, unit)
