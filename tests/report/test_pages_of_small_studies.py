"""Numbers of the pages of `tide`, `identify` and `simulate --rare`, read back from results made by hand."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from missionplan.montecarlo.statistics import Probability
from missionplan.report.quantities import reading_in
from missionplan.studies.identification import page as identified
from missionplan.studies.identification.fits import (
    FitCurve,
    FitPanel,
    FittedModel,
    Identification,
    IdentifiedParameter,
)
from missionplan.studies.rare_failure import Cause, FailureMode, RareFailure, WayDriven
from missionplan.studies.rare_failure import page as rare
from missionplan.studies.tide import page as tidal
from missionplan.studies.tide.result import Constituent, DepthTide, HeldOut, TideResult

NAN = math.nan


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def rows(table):
    return [[plain(cell) for cell in row] for row in table.rows]


# tide: M2 toward 60°, and an inferred K2

M2 = Constituent(
    "M2", 0.4567, -0.1234, math.radians(60.0), math.radians(200.0), 0.01, 0.02, math.radians(1.5), math.radians(2.5)
)
K2 = Constituent("K2", 0.0321, 0.0045, math.radians(61.0), math.radians(210.0), inferred_from="S2")
DEEP = DepthTide(30.0, 900, -0.05, 0.02, 0.003, (), 0.0987, 300.0, 0.0, None)
SHALLOW = DepthTide(7.5, 1000, 0.11, -0.22, 0.004, (M2, K2), 0.0543, 5400.0, 0.876, HeldOut(250, 0.874, 0.06))


def tide(*depths, shown=7.5, days=31.4):
    provenance = SimpleNamespace(mission="a.csv", file="a b.csv", options={"latitude_deg": 48.5, "start": ""})
    time = 1.7e9 + 3600.0 * np.arange(3)
    measured, fitted = np.array([[0.1, 0.2, NAN], [0.3, 0.4, 0.5]]), np.array([[0.05, 0.1, 0.2], [0.1, 0.2, 0.3]])
    return TideResult(
        provenance, depths, math.radians(48.5), 1.7e9, days, time, measured, fitted, shown, ("too short for S2",)
    )


def test_the_tide_s_headline_says_its_share_the_largest_and_how_well_it_forecasts():
    assert plain(tidal.answer(tide(SHALLOW, DEEP))) == (
        "The tide is 88 % of the current's variance at 7.5 m, M2 the largest with 0.457 m/s. A forecast should be within 0.089 m/s "
        "of a component 9 times in 10: the last quarter of the record, forecast from the rest, was so 87 times in 100."
    )
    assert plain(tidal.answer(tide(SHALLOW, DEEP, shown=30.0))).startswith(
        "No tide stands out of this record at 30 m: the current scatters by 0.099 m/s"
    )
    short = replace(SHALLOW, held_out=None)
    assert "31.4 days are too few to test it" in tidal.answer(tide(short, DEEP))
    told = {name: plain(value) for name, value in tidal._numbers(SHALLOW)}
    assert told == {
        "Mean, east and north": "0.110 and −0.220 m/s, each ± 0.004",
        "What is left, each component": "0.054 m/s",
        "What is left lasts": "1.5 h",
    }
    assert dict(tidal._numbers(DEEP))["What is left lasts"] == "less than 0.1 h"


def test_the_tables_of_a_tide():
    table, short = tidal._how_far(tide(SHALLOW, DEEP)).blocks
    assert rows(table) == [
        ["7.5", "1000", "88", "0.110", "−0.220", "0.054", "1.5", "87"],
        ["30", "900", "0", "−0.050", "0.020", "0.099", "< 0.1", "–"],
    ]
    assert table.caption.startswith("31.4 days from 2023-11-14 22:13 UTC, at latitude 48.50°.")
    assert short == "The record is too short for S2."
    (table,) = tidal._constituents(SHALLOW).blocks
    assert rows(table) == [
        ["M2", "0.457 ± 0.010", "−0.12 ± 0.02", "60.0 ± 1.5", "200 ± 2"],
        ["K2 (from S2)", "0.0321", "0.00450", "61.0", "210"],
    ]
    lines = tidal._in_a_mission(tide(SHALLOW, DEEP)).blocks[1].text
    assert "error: {sigma: 0.0987 m/s, time: 0.08 h}" in lines  # of the depth where it is largest
    assert lines.endswith("outside: hold")  # nothing was measured at the surface
    with reading_in("nautical"):
        (table,) = tidal._constituents(SHALLOW).blocks
    assert float(table.rows[0][1].partition("\u00a0")[0]) == pytest.approx(0.4567 / (1852.0 / 3600.0), abs=0.01)


def test_the_fragment_has_the_tide_s_numbers():
    import yaml

    deep = tide(SHALLOW, DEEP)
    held = yaml.safe_load(deep.fragment())["depths"]
    assert [each["depth"] for each in held] == ["7.5 m", "30 m"]
    assert (held[0]["east"], held[0]["north"]) == ("0.1100 m/s", "-0.2200 m/s")
    assert held[0]["constituents"][0] == {
        "name": "M2",
        "major": "0.4567 m/s",
        "minor": "-0.1234 m/s",
        "toward": "60.00 deg",
        "phase": "200.00 deg",
    }
    frame = deep.to_frame()
    assert frame.loc[0, ["depth_m", "toward_deg", "phase_deg", "toward_error_deg"]].tolist() == pytest.approx(
        [7.5, 60.0, 200.0, 1.5]
    )
    assert frame["inferred_from"].tolist() == ["", "S2"]


def test_ellipses_and_the_record_are_drawn_where_they_are():
    axes = Figure().add_subplot()
    tidal.draw_ellipses(axes, tide(SHALLOW, DEEP))
    drawn = {line.get_label(): np.array(line.get_data()) for line in axes.get_lines()}
    turned = np.exp(1j * math.radians(60.0)) * (
        drawn["M2"][1] + 1j * drawn["M2"][0]
    )  # north + i east, turned back below
    along = drawn["M2"][0] * math.sin(math.radians(60.0)) + drawn["M2"][1] * math.cos(math.radians(60.0))
    assert np.abs(along).max() == pytest.approx(0.4567, rel=1e-3)
    assert np.abs(turned).max() == pytest.approx(0.4567, rel=1e-3)
    assert np.abs(turned).min() == pytest.approx(0.1234, rel=2e-3)
    assert drawn["mean"].tolist() == [[0.0, 0.11], [0.0, -0.22]]
    for component, row in (("east", 0), ("north", 1)):
        axes = Figure().add_subplot()
        tidal.draw_record(axes, tide(SHALLOW, DEEP), component)
        measured, fitted = (np.array(line.get_data(), dtype=float) for line in axes.get_lines())
        np.testing.assert_array_equal(measured[1], tide(SHALLOW, DEEP).measured[row])
        np.testing.assert_array_equal(fitted[1], tide(SHALLOW, DEEP).fitted[row])
        assert measured[0][0] == pytest.approx(1.7e9 / 86_400.0)


# identification


def parameter(name, value, sd, low, high, unit="kg", symbol="m (mass)"):
    return IdentifiedParameter(name, symbol, value, sd, low, high, unit)


MASS, DRAG = parameter("added_mass", 12.345, 0.234, 11.96, 12.73), parameter("drag", 0.8, NAN, NAN, NAN, "", "C_d")
AREA = parameter("area", 1234.0, 56.0, 1142.0, 1326.0, "cm²", "A")


def model(name, *estimates, does_not_fit=False):
    return FittedModel(name, estimates, 3.0, 4, does_not_fit, 1.0, np.zeros(3), 0.1, np.eye(len(estimates)))


def identification(*fits):
    x, y = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.5, 6.0])
    panel = FitPanel(
        "fit",
        "x",
        "y",
        x,
        y,
        np.array([2.1, 4.4, 6.2]),
        (FitCurve("line", x, 2.0 * x), FitCurve("others", x, 3.0 * x, dots=True)),
        "alt",
        y_sd=np.full(3, 0.1),
    )
    provenance = SimpleNamespace(file="data set", mission="")
    return Identification(
        "so it is",
        fits,
        (panel,),
        ("a remark",),
        {"hull": {"a": 1}},
        (AREA,),
        provenance=provenance,
        kind="drag",
        name="tank",
        source="a tank",
    )


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (12.345, 0.234, "12.35"),
        (12.345, 2.34, "12.3"),
        (1234.0, 56.0, "1234"),
        (1234.0, 560.0, "1230"),
        (0.8, NAN, "0.8"),
        (0.8, 0.0, "0.8"),
    ],
)
def test_values_have_two_figures_of_their_error(value, sd, text):
    assert identified.significant(value, sd) == text


def test_parameters_of_each_model_and_those_derived():
    found = identification(model("constant", MASS, DRAG), model("linear", MASS))
    assert rows(identified.parameter_table(found)) == [
        ["added mass (m)", "constant", "12.35", "0.23", "11.96 to 12.73", "kg"],
        ["drag (C_d)", "constant", "0.8", "not known", "none", ""],
        ["added mass (m)", "linear", "12.35", "0.23", "11.96 to 12.73", "kg"],
        ["area (A)", "derived", "1234", "56", "1142 to 1326", "cm²"],
    ]
    assert identified._cells(found)[1][0] == ("added mass", "12.35", "0.23", "11.96 to 12.73", "kg")
    assert identified._numbers(found) == [("Area", "1234 ± 56 cm²")]
    assert identified.estimate_in_words(MASS) == "12.35 ± 0.23 kg"
    assert identified.estimate_in_words(DRAG) == "0.8"
    headings = [
        identified._sections(replace(found, fits=fits))[0].heading
        for fits in (found.fits, found.fits[:1], (model("x", MASS, does_not_fit=True), *found.fits))
    ]
    assert headings == [
        "Model that the data support: constant, not linear",
        "Model of the data: constant",
        "Best, but not good: x",
    ]
    frame = found.to_frame()
    assert frame["model"].tolist() == ["constant", "constant", "linear", "derived"]
    assert frame["value"].tolist() == [12.345, 0.8, 12.345, 1234.0]
    assert found.residuals()["residual"].tolist() == pytest.approx([-0.1, 0.1, -0.2])
    assert MASS.in_words == "12.35 kg (90 % interval 11.96 to 12.73 kg)"
    assert (
        replace(MASS, low=12.3445, high=12.3455, sd=0.0003).in_words
        == "12.34500 kg (90 % interval 12.34450 to 12.34550 kg)"
    )
    assert DRAG.in_words == "0.8"
    assert [each.note for each in (MASS, DRAG, parameter("a", 1.0, 0.1, NAN, NAN))] == [
        "",
        "the data state no error",
        "the model does not fit: no interval",
    ]


def test_a_fit_is_drawn_over_its_data_with_what_is_left_below():
    (panel,) = identification(model("constant", MASS)).panels
    axes = Figure().add_subplot()
    identified.draw_fit(axes, panel)
    drawn = {line.get_label(): np.array(line.get_data()) for line in axes.get_lines()}
    assert drawn["line"].tolist() == [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]
    assert drawn["others"].tolist() == [[1.0, 2.0, 3.0], [3.0, 6.0, 9.0]]
    (bars,) = axes.containers
    assert np.array(bars.lines[0].get_data()).tolist() == [[1.0, 2.0, 3.0], [2.0, 4.5, 6.0]]
    segments = np.array(bars.lines[2][0].get_segments())
    assert segments[:, :, 1] == pytest.approx(np.array([[1.9, 2.1], [4.4, 4.6], [5.9, 6.1]]))
    axes = Figure().add_subplot()
    identified._draw_residuals(axes, panel)
    assert np.array(axes.containers[0].lines[0].get_data())[1] == pytest.approx([-0.1, 0.1, -0.2])


# rare failures


CAUSES = (
    Cause("moor.release_time", 9.0, 2.0, 1.4, "s"),
    Cause("ingress.heading", math.radians(-4.0), 0.0, math.radians(2.0), "rad"),
)
MODES = (FailureMode("moor: anchor outside the radius", 0.77, CAUSES), FailureMode("out: out of energy", 0.23, ()))
WAYS = (
    WayDriven("out: out of energy", 2e-7, 1.0, 1e-5),
    WayDriven("moor: anchor outside the radius", 9e-7, 1.0, 1e-5),
    WayDriven("moor: did not surface", 0.0, 3e-4, 2e-5),
    WayDriven("", 0.0, 1.0, 1e-5),
)


def failure(**changes):
    provenance = SimpleNamespace(
        trials=40_000, mission="made", file="m.yaml", seed=5, options={"trials": 40_000, "precision": None}
    )
    given = {"provenance": provenance, "event": "not total.success", "probability": Probability(1.23e-6, 0.9e-6, 1.7e-6), "variation": 0.123,
             "repetitions": 6, "levels": 5, "reached": True, "nearest": 1.0, "ways": WAYS, "modes": MODES, "sample": pd.DataFrame()}  # fmt: skip
    return RareFailure(**{**given, **changes})


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0456, "0.046"),
        (1.234e-6, "1.2·10⁻⁶"),
        (3.44e8, "3.4·10⁸"),
        (1234.0, "1234"),
        (0.0, "0"),
        (math.inf, "∞"),
        (9.99e-4, "1.0·10⁻³"),
        (1e-3, "0.001"),
        (99.4, "99"),
    ],
)
def test_small_and_large_numbers_in_two_digits(value, text):
    assert rare._power(value) == text


def test_how_probable_a_failure_is_and_how_it_comes_about():
    words = plain(rare.answer(failure()))
    assert words.startswith(
        "This mission fails with probability 1.2·10⁻⁶ (9.0·10⁻⁷ to 1.7·10⁻⁶): about one mission in 810 000."
    )
    assert "77 % of these are" in words
    assert (
        "high release time (moor) (9.00 s where 2.00 s is usual), low heading (ingress) (−4.00° where 0.00° is usual)"
        in words
    )
    often = rare.answer(failure(probability=Probability(0.6, 0.5, 0.7)))
    assert "more often than not" in often
    unmet = plain(rare.answer(failure(reached=False, probability=Probability(0.0, 0.0, 9e-5))))
    assert unmet.startswith("No failure was found, in 40000 trials")
    assert unmet.endswith("at most 9.0·10⁻⁵.")
    events = [
        plain(rare.event_in_words(each))
        for each in ("moor.offset > 30 m", "moor.offset < 3 m", "not out.arrived", "out.arrived")
    ]
    assert events == [
        "offset of the anchor (moor) above 30 m",
        "offset of the anchor (moor) below 3 m",
        "failure of “arrival (out)”",
        "arrival (out)",
    ]


def test_the_tables_of_a_rare_failure():
    (section,) = rare._how(failure())
    table = section.blocks[2]
    assert [row[1:] for row in rows(table)] == [
        ["release time (moor)", "9.00 s", "2.00 s", "+5.0"],
        ["heading (ingress)", "−4.00°", "0.00°", "-2.0"],
    ]
    (section,) = rare._driven(failure())
    assert section.heading == "Not met: 1 of 3 ways to fail"
    assert [row[1:] for row in rows(section.blocks[0])] == [
        ["9.0·10⁻⁷", "", ""],
        ["2.0·10⁻⁷", "", ""],
        ["none found", "3.0·10⁻⁴", "2.0·10⁻⁵"],
    ]
    assert failure().plain_trials == pytest.approx((1.0 - 1.23e-6) / (1.23e-6 * 0.123**2))
    (section,) = rare._precision(failure())
    assert section.heading == "Known to 12 % from 40000 trials"
    assert "5.4·10⁷ trials" in section.blocks[0]
    assert not list(rare._precision(failure(reached=False)))
    assert dict(rare._numbers(failure())) == {
        "Probability": "1.2·10⁻⁶",
        "95 % interval": "9.0·10⁻⁷ to 1.7·10⁻⁶",
        "Coefficient of variation": "12.3 %",
    }
    assert (
        rare.page(failure()).rerun == "missionplan simulate m.yaml --rare 'not total.success' --seed 5 --trials 40000"
    )
    frame = failure().to_frame()
    assert frame[["share", "mean", "usual", "shift"]].to_numpy()[0].tolist() == pytest.approx([0.77, 9.0, 2.0, 5.0])
    axes = Figure().add_subplot()
    rare.failures(axes, failure())
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([23.0, 77.0])
