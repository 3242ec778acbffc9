"""Reports in the units of the crew: texts, columns, a whole page, and files that stay in SI."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.report.crew.conversion import column_in_units, drawing_in, in_units, row_in_units, using_units
from missionplan.report.crew.drawing import draw_in_units, round_length
from missionplan.report.page import to_figure
from missionplan.report.render import render_report, terminal_view
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.mark.parametrize(
    ("text", "system", "expected"),
    [
        ("350\u00a0m", "imperial", "1148\u00a0ft"),
        ("75 ft", "metric", "22.9\u00a0m"),
        ("7.41\u00a0km", "nautical", "4.001\u00a0nmi"),
        ("0.4 ± 0.1\u00a0kn", "metric", "0.21 ± 0.05\u00a0m/s"),
        ("1.5 m/s", "nautical", "2.9\u00a0kn"),
        ("11.8\u00a0N wet", "imperial", "2.65\u00a0lbf wet"),
        ("−3 to 12 m", "imperial", "−10 to 39\u00a0ft"),
        ("40 m", "nautical", "40 m"),
        ("3 min, 20 mm, 4 m², 0.5 N m, 8 kg/m³, 12 W h", "imperial", "3 min, 20 mm, 4 m², 0.5 N m, 8 kg/m³, 12 W h"),
        ("(0 m, 700 m)", "imperial", "(0\u00a0ft, 2297\u00a0ft)"),
    ],
)
def test_quantities_of_a_text(text, system, expected):
    assert in_units(text, system) == expected


@given(st.floats(0.1, 9000.0), st.integers(0, 3), st.sampled_from(["imperial", "nautical", "metric"]))
def test_a_converted_length_is_the_same_length(metres, decimals, system):
    written = f"{metres:.{decimals}f}"
    number, unit = in_units(f"{written} m", system).replace("\u202f", "").replace("\u00a0", " ").split()
    size = {"m": 1.0, "km": 1000.0, "ft": 0.3048, "mi": 1609.344, "nmi": 1852.0}[unit]
    last = size * 10.0 ** -len(number.partition(".")[2])
    assert abs(float(number) * size - float(written)) <= 0.5001 * last + 1e-9
    assert last <= 2.1 * 10.0**-decimals + 1e-9 or size > 900.0


def test_a_column_is_converted_whole_or_not_at_all():
    assert column_in_units("radius (m)", ["15", "4.25 ± 0.10", "–"], "imperial") == (
        "radius (ft)", ["49", "13.94 ± 0.33", "–"],
    )  # fmt: skip
    assert column_in_units("half axes (m)", ["18 (circle)", "5"], "imperial")[0] == "half axes (m)"


def test_spread_and_points_of_a_row_have_the_unit_of_its_quantity():
    heads = ["quantity", "mean", "sd", "5\u00a0%", "trials"]
    assert row_in_units(heads, ["offset", "30.5 ± 0.3\u00a0m", "3.05", "–", "12"], "imperial") == [
        "offset", "30.5 ± 0.3\u00a0m", "10.01", "–", "12",
    ]  # fmt: skip
    assert row_in_units(heads, ["duration", "30.5\u00a0s", "3.05", "1", "12"], "imperial")[2] == "3.05"


def test_a_mission_or_the_run_chooses_the_units_and_the_summary_stays_in_si():
    data = dict(load(MISSIONS / "fig8.yaml").raw)
    plain = sweep_dmax(Mission.from_data(data), trials=20)
    chosen = sweep_dmax(Mission.from_data({**data, "units": "nautical"}), trials=20)
    assert "nmi" not in terminal_view(plain).sentence
    assert "nmi" in terminal_view(chosen).sentence
    unlike = ("created_utc", "elapsed_s")
    assert {k: v for k, v in chosen.summary().items() if k not in unlike} == {
        k: v for k, v in plain.summary().items() if k not in unlike
    }
    with using_units("imperial"):
        html = render_report(plain).html
    assert "\u00a0mi" in html
    assert "--units imperial" in html
    assert "nmi" in json.dumps(plain.provenance.data)


def drawn(system: str, *, highest: float, aspect: str = "auto"):
    figure = Figure(layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0.0, 700.0, 1400.0], [0.0, highest / 2.0, highest], label="to 300 m")
    axes.set(xlabel="east (m)", ylabel="north (m)", xlim=(0.0, 1852.0), ylim=(0.0, highest), aspect=aspect)
    axes.legend()
    with drawing_in(system):
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
    assert axes.get_legend().get_texts()[0].get_text() == "to 984\u00a0ft"


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
    axes.set(xscale="log", xlim=(1.0, 1000.0), xlabel="leg (m)", ylabel="mean (m/s)")
    axes.set_yticks([0.0, 1.0], ["slow", "fast"])
    with drawing_in("imperial"):
        draw_in_units([axes])
    assert axes.get_xlabel() == "leg (ft)"
    assert {5.0, 10.0, 20.0, 1000.0} <= set(ticks(axes.xaxis))
    assert [text.get_text() for text in axes.get_yticklabels()] == ["slow", "fast"]
    assert json.loads(to_figure(figure, "figure", "").plot)["axes"][0]["y"] is None


@pytest.mark.parametrize(
    ("system", "length", "words"),
    [("", 1200.0, "1 km"), ("", 380.0, "200 m"), ("nautical", 1200.0, "0.5 nmi"), ("imperial", 380.0, "1000 ft")],
)
def test_a_scale_bar_has_a_round_length(system, length, words):
    with drawing_in(system):
        metres, written = round_length(length)
    assert written == words
    assert 0.4 * length <= metres <= length


def test_the_page_for_scripts_is_in_the_units_of_the_crew():
    found = sweep_dmax(load(MISSIONS / "fig8.yaml"), trials=20)
    with using_units("nautical"):
        html = render_report(found).html
    assert "σ_v 0.035\u00a0m/s" not in html
    assert "σ_v 0.068\u00a0kn" in html
    assert found.plot().get_xlabel()


def test_unknown_units_are_refused_with_what_is_known():
    with pytest.raises(InputError, match=r"units.*nautical"):
        Mission.from_data({"units": "naval"})
