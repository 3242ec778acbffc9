"""What is read back from plain data is of the kind expected, or empty."""

import math

import pytest

from missionplan.results.entries import mapping, mappings, real, whole

OTHERS = [None, "text", 1.5, [], [1, "a"]]


def test_what_is_of_the_kind_expected_is_returned() -> None:
    assert mapping({"a": 1}) == {"a": 1}
    assert mappings([{"a": 1}, "b", None, {}]) == mappings(({"a": 1}, {})) == [{"a": 1}, {}]
    assert whole(3) == 3
    assert real(3) == 3.0


@pytest.mark.parametrize("value", OTHERS)
def test_of_anything_else_nothing_is(value: object) -> None:
    assert mapping(value) == {}
    assert mappings(value) == []
    assert whole(value) == 0
    assert value == 1.5 or math.isnan(real(value))
