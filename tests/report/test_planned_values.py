"""Values of a mission file in words: no error bears more digits than it has itself, and a range keeps its own."""

from types import SimpleNamespace

import pytest

from missionplan.report import planned
from missionplan.report.planned import _current, changed, value_in_words, where_checked


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"mean": "10 s", "sd": "3 s", "low": "0 s"}, "10 ± 3 s, at least 0 s"),
        ({"mean": "10 s", "sd": "2.5 s"}, "10.0 ± 2.5 s"),
        ({"mean": "0.25 m", "sd": "0.1 m"}, "0.25 m, sd 0.1 m"),
        ({"mean": "1e3 m", "sd": "2.5 m"}, "1e3 ± 2.5 m"),
        ({"mean": "20 min", "sd": "5 s"}, "20 min ± 5 s"),
        ({"mean": "-4 deg", "sd": "0.5 deg"}, "-4.0 ± 0.5°"),
        ({"mean": "-1 m", "sd": "0.5 m", "high": "2 m"}, "-1.0 ± 0.5 m, at most 2 m"),
        ({"mean": "-2.161e-05 1/s", "sd": "3.605e-05 1/s"}, "-2.161e-05 ± 3.605e-05 1/s"),
        ({"mean": "0.2 m", "sd": "3.6e-05 m"}, "0.2 ± 3.6e-05 m"),
        ({"low": "1 m", "high": "2.25 m"}, "1 to 2.25 m"),
        ({"low": "1.25 m", "high": "2 m"}, "1.25 to 2 m"),
        ({"low": 0.5, "high": 2}, "0.5 to 2"),
        ({"median": "0.05 m/s", "factor": 1.5}, "0.05 m/s, × or ÷ 1.5"),
        ({"choices": ["1 m", "2 m"]}, "1 m or 2 m"),
        ({"choices": list("abcdef")}, "a or b or c or d or e or f"),
        ({"choices": list("abcdefg")}, "one of 7 values, from a to g"),
        (["1 m", "2 m"], "(1 m, 2 m)"),
        ([True, False], "(yes, no)"),
    ],
)
def test_values_are_written_as_they_are_known(value, words):
    assert value_in_words(value) == words


def test_what_changes_is_shown_as_was_and_now():
    data = {"phases": [{"transit": {"name": "ingress", "d_max": "4 nmi"}}, {"moor": {"anchor_wet_weight": "12 N"}}]}
    values = {
        "ingress.d_max": {"table": [["0 m", "10 m"], ["500 m", "300 m"]]},
        "moor.anchor_wet_weight": "12 N",
        "moor.line_length": "5 m",
    }
    (section,) = changed(data, values)
    assert [list(row) for row in section.blocks[0].rows] == [
        ["ingress.d_max", "4 nmi", "a table of 2 rows"],
        ["moor.line_length", "not given", "5 m"],
    ]
    assert section.is_summary
    assert changed(data, {"moor.anchor_wet_weight": "12 N"}) == []


def test_a_layer_of_a_current_begins_where_the_one_above_ends():
    layers = [{"speed": "0.2 m/s", "toward": "90 deg", "down_to": edge} for edge in ("10 m", "25 m", "40 m")]
    assert [name for name, _ in _current(layers)] == [
        "current, surface to 10 m",
        "current, 10 m to 25 m",
        "current, 25 m to 40 m",
    ]


def test_what_the_mission_has_is_told_before_what_was_checked():
    checked = SimpleNamespace(quantity="speed", least=1.0, greatest=1.5, low=0.5, high=2.5, unit="m/s", is_inside=True)
    (section,) = where_checked(SimpleNamespace(rests_on=("row",), checked=(checked,)))
    (row,) = next(block.rows for block in section.blocks if hasattr(block, "rows"))
    assert [cell.replace("\u00a0", " ") for cell in row] == [
        "speed",
        "1 m/s to 1.5 m/s",
        "0.5 m/s to 2.5 m/s",
        "inside",
    ]


@pytest.mark.parametrize(
    ("mapped", "site", "is_drawn"), [(False, {}, True), (True, {}, False), (True, {"chart": {}}, True)]
)
def test_a_page_with_a_map_of_its_own_has_none_of_the_site_but_for_its_chart(mapped, site, is_drawn, monkeypatch):
    monkeypatch.setattr(planned, "site_map", lambda data: "the map")
    made = SimpleNamespace(
        data={"phases": [], "site": {"depth": "12 m", **site}}, command="simulate", holds=(), rests_on=(), checked=()
    )
    (section,) = planned.planned_sections(made, mapped=mapped)
    assert ("the map" in section.blocks) is is_drawn
