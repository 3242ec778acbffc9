"""Reports in the units of the reader: quantities, columns, axes, a whole page, and files that stay in SI."""

import html
import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.report.axes import draw_in_units, name_axis, round_length
from missionplan.report.page import to_figure
from missionplan.report.quantities import (
    as_written,
    in_unit_of,
    quantity,
    reader_unit,
    reading_in,
    span_of,
    using_units,
)
from missionplan.report.render import render_report, terminal_view
from missionplan.studies.anchor import size_anchor
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.validate import validate

pytestmark = pytest.mark.usefixtures("drawn", "unassumed")

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.mark.parametrize(
    ("value", "unit", "form", "system", "expected"),
    [
        (350.0, "m", ".0f", "imperial", "1148\u00a0ft"),
        (75.0, "ft", ".0f", "metric", "22.9\u00a0m"),
        (7.41, "km", ".2f", "nautical", "4.001\u00a0nmi"),
        (1.5, "m/s", ".1f", "nautical", "2.9\u00a0kn"),
        (11.8, "N", ".1f", "imperial", "2.65\u00a0lbf"),
        (40.0, "m", ".0f", "nautical", "40\u00a0m"),
        (-3.0, "m", ".0f", "imperial", "−10\u00a0ft"),
        (20.0, "mm", ".0f", "imperial", "20\u00a0mm"),
        (0.3, "N", "+.2f", "", "+0.30\u00a0N"),
        (float("nan"), "m", ".1f", "imperial", "–"),
    ],
)
def test_a_quantity_is_written_once_in_the_units_of_the_reader(value, unit, form, system, expected):
    with reading_in(system):
        assert quantity(value, unit, form) == expected


@given(st.floats(0.1, 9000.0), st.integers(0, 3), st.sampled_from(["imperial", "nautical", "metric"]))
def test_a_converted_length_is_the_same_length(metres, decimals, system):
    written = f"{metres:.{decimals}f}"
    with reading_in(system):
        words = as_written(written, "m")
    number, unit = words.replace("\u202f", "").replace("\u00a0", " ").split()
    size = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "mi": 1609.344, "nmi": 1852.0}[unit]
    last = size * 10.0 ** -len(number.partition(".")[2])
    assert abs(float(number) * size - float(written)) <= 0.5001 * last + 1e-9
    assert last <= 2.1 * 10.0**-decimals + 1e-9 or size > 900.0


def test_a_range_and_a_column_have_one_unit():
    with reading_in("imperial"):
        assert span_of(0.0, 700.0, "m", ".0f") == "0 to 2297\u00a0ft"
        unit = reader_unit("m", 15.0)
        assert [unit.axis, *(unit.cell(each, ".2f") for each in (15.0, 4.25, None))] == [" (ft)", "49.21", "13.94", "–"]


def test_names_of_missions_and_phases_are_no_quantities():
    data = dict(load(MISSIONS / "anchor-design.yaml").raw)
    data |= {"name": "Dive 30 m at 2 kn", "units": "imperial"}
    (entry,) = data["phases"]
    data["phases"] = [{"moor": {**entry["moor"], "name": "5 m line"}}]
    found = size_anchor(Mission.from_data(data), trials=50)
    page = html.unescape(re.sub(r"<pre.*?</pre>", "", render_report(found).html, flags=re.DOTALL)).replace(
        "\u00a0", " "
    )
    assert "Dive 30 m at 2 kn" in page
    assert "5 m line" in page
    assert not re.search(r"98 ft at|16 ft line", page)
    assert " lbf wet" in terminal_view(found).sentence.replace("\u00a0", " ")


@pytest.fixture(scope="module")
def plain():
    """A sweep of a mission that asks for no units."""
    return sweep_dmax(few_points(), trials=20)


def few_points(**changes) -> Mission:
    return load(MISSIONS / "fig8.yaml").with_({"sweep.d_max.points": 5, **changes})


def test_a_mission_or_the_run_chooses_the_units_and_the_summary_stays_in_si(plain):
    chosen = sweep_dmax(few_points(units="nautical"), trials=20)
    assert "nmi" not in terminal_view(plain).sentence
    assert "nmi" in terminal_view(chosen).sentence
    unlike = ("created_utc", "elapsed_s", "identity", "identity_parts")  # units are a part of the file
    assert {k: v for k, v in chosen.summary().items() if k not in unlike} == {
        k: v for k, v in plain.summary().items() if k not in unlike
    }
    with using_units("imperial"):
        page = render_report(plain).html
    assert "\u00a0mi" in page
    assert "--units imperial" in page
    assert "nmi" in json.dumps(plain.provenance.data)


@pytest.mark.parametrize(("units", "speed"), [(None, "1.50 m/s"), ("nautical", "2.92 kn"), ("imperial", "4.92 ft/s")])
def test_what_was_checked_is_told_in_the_units_of_the_mission(units, speed):
    mission = load(MISSIONS / "chesapeake.yaml").with_({"units": units} if units else {})
    (checked,) = validate(mission)
    assert any(f"Reynolds number is 150\u202f000 at {speed}" in plain_text(notice) for notice in checked.notices)


def plain_text(words: str) -> str:
    return words.replace("\u00a0", " ")


def drawn(system: str, *, highest: float, aspect: str = "auto"):
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0.0, 700.0, 1400.0], [0.0, highest / 2.0, highest], label="to 300 m")
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    axes.set(xlim=(0.0, 1852.0), ylim=(0.0, highest), aspect=aspect)
    axes.legend()
    with reading_in(system):
        return axes, to_figure(figure, "figure", "")


def ticks(axis) -> list[float]:
    return [float(text.get_text().replace("−", "-")) for text in axis.get_ticklabels()]


def test_axes_have_round_numbers_in_the_units_of_the_crew_and_so_has_the_script():
    axes, figure = drawn("imperial", highest=300.0)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("east (mi)", "north (ft)")
    feet = ticks(axes.yaxis)
    assert feet == [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0]  # the last is outside and not drawn
    assert axes.yaxis.get_majorticklocs() == pytest.approx([0.3048 * tick for tick in feet])
    panel = json.loads(figure.plot)["axes"][0]
    assert panel["x"] == {"lim": [0.0, 1.1508], "log": False, "label": "east (mi)"}
    assert panel["y"]["lim"] == pytest.approx([0.0, 300.0 / 0.3048], rel=1e-4)
    assert panel["lines"][0]["points"][-1] == pytest.approx([1400.0 / 1609.344, 300.0 / 0.3048], rel=1e-4)
    assert axes.get_legend().get_texts()[0].get_text() == "to 300\u00a0m"  # a text is no quantity


def test_a_map_has_one_unit_and_axes_stay_where_no_units_are_chosen():
    axes, _ = drawn("nautical", highest=300.0, aspect="equal")
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("east (nmi)", "north (nmi)")
    axes, _ = drawn("nautical", highest=300.0)
    assert axes.get_ylabel() == "north (m)"
    axes, figure = drawn("", highest=300.0)
    assert axes.get_xlabel() == "east (m)"
    assert json.loads(figure.plot)["axes"][0]["x"]["lim"] == [0.0, 1852.0]


def test_a_logarithmic_axis_and_words_on_an_axis():
    figure = Figure()
    axes = figure.add_subplot()
    axes.set(xscale="log", xlim=(1.0, 1000.0))
    name_axis(axes.xaxis, "leg", "m")
    name_axis(axes.yaxis, "mean", "m/s")
    axes.set_yticks([0.0, 1.0], ["slow", "fast"])
    with reading_in("imperial"):
        draw_in_units([axes])
    assert axes.get_xlabel() == "leg (ft)"
    assert {5.0, 10.0, 20.0, 1000.0} <= set(ticks(axes.xaxis))
    assert [text.get_text() for text in axes.get_yticklabels()] == ["slow", "fast"]
    assert json.loads(to_figure(figure, "figure", "").plot)["axes"][0]["y"].keys() == {"lim"}


@pytest.mark.parametrize(
    ("system", "length", "words"),
    [("", 1200.0, "1 km"), ("", 380.0, "200 m"), ("nautical", 1200.0, "0.5 nmi"), ("imperial", 380.0, "1000 ft")],
)
def test_a_scale_bar_has_a_round_length(system, length, words):
    with reading_in(system):
        metres, written = round_length(length)
    assert written == words
    assert 0.4 * length <= metres <= length


def test_the_page_for_scripts_is_in_the_units_of_the_crew(plain):
    with using_units("nautical"):
        page = render_report(plain).html
    assert "σ_v 0.035\u00a0m/s" not in page
    assert "σ_v 0.068\u00a0kn" in page
    assert plain.plot().get_xlabel()


def test_unknown_units_are_refused_with_what_is_known():
    with pytest.raises(InputError, match=r"units.*nautical"):
        Mission.from_data({"units": "naval"})


@pytest.mark.parametrize(
    ("was", "now", "told"),
    [
        ("4 nmi", "6741.3 m", " (3.64\u00a0nmi)"),
        ("2 kn", "1.5 m/s", " (2.916\u00a0kn)"),
        ("350 m", "1232 m", ""),
        ("sized", "11.697 N", ""),
        (None, "3 m", ""),
        ({"mean": "3 m", "sd": "1 m"}, "3 m", ""),
        ("4 nmi", "11.7 N", ""),
    ],
)
def test_what_a_key_becomes_is_told_in_the_unit_that_it_had_too(was, now, told):
    assert in_unit_of(was, now) == told
