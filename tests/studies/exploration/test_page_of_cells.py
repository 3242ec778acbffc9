"""The page of an exploration by hand: words, tables, curves, maps and the front say and draw the cells' own numbers."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.montecarlo.statistics import Statistic, wilson
from missionplan.results.decision import Axis
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration import figures
from missionplan.studies.exploration import page as pages
from missionplan.studies.exploration.result import Cell, Exploration, Window

NAN = math.nan
LINE = Axis(
    ("moor.line_length",), tuple(f"{k} m" for k in range(2, 8)), tuple("234567"), tuple(map(float, range(2, 8))), "m"
)
SPEED = Axis(("out.speed", "back.speed"), ("1 m/s", "1.5 m/s"), ("1", "1.5"), (1.0, 1.5), "m/s")
DATA = {
    "vehicle": {"energy": {"capacity": "60 W*h"}},
    "requirements": [{"quantity": "total.duration", "at_most": "3 h", "probability": 0.9}],
}


def statistic(mean, sd=2.0):
    return Statistic(mean, sd, mean - 1.6 * sd, mean, mean + 1.7 * sd, sd / 10.0, 100)


def cell(place, successes, energy, hours, met=True, **given):
    requirement = RequirementOutcome("out.arrived", None, None, "", 0.9, wilson(successes, 1000), met, undecided=False)
    quantities = {"total.energy_wh": statistic(energy), "total.duration_s": statistic(3600.0 * hours, 60.0)}
    return Cell(place, success=wilson(successes, 1000), requirements=(requirement,), quantities=quantities,
                events={"out.arrived": wilson(successes + 10, 1000)}, trials=1000, **given)  # fmt: skip


CELLS = (
    cell((0,), 800, 20.0, 2.0, met=False, on_front=True),
    cell((1,), 960, 24.0, 2.25, as_good=True, on_front=True),
    cell((2,), 970, 26.0, 2.5, as_good=True, on_front=True),
    cell((3,), 940, 27.0, 2.75),
    cell((4,), 700, 40.0, 2.6, met=False),
    Cell((5,), "the line is too long"),
)


def exploration(cells=CELLS, axes=(LINE,), best=2, aim="success", **given):
    provenance = SimpleNamespace(
        data=DATA, trials=1000, seed=4, mission="made", options={"vary": ["a=1:2:1 m"], "quantity": ["moor.offset"]}
    )
    return Exploration(provenance, axes, tuple(cells), aim, best, **{"constrained": True, **given})


GRID = tuple(
    cell(
        (row, column),
        900 + 10 * row + column,
        20.0 + row + 5.0 * column,
        2.0 + 0.1 * column,
        met=row > 0,
        as_good=row == column == 1,
    )
    for row in range(6)
    for column in range(2)
)


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def test_the_headline_names_the_best_what_is_as_good_and_where_all_is_met():
    words = plain(pages.answer(exploration()))
    assert words == (
        "The best line length (moor) is 4 m: the mission succeeds in 97.0 % (95.7 to 97.9 %) of the trials, takes 26.0 ± 0.2 W h and lasts "
        "2.5000 ± 0.0017 h. Any line length (moor) tried from 3 to 4 m succeeds as often, as far as 1000 trials tell. All requirements are "
        "met from 3 to 5 m. 1 of the 6 choices cannot be run; the report says why."
    )
    last = replace(CELLS[3], requirements=(replace(CELLS[3].requirements[0], undecided=True),))
    doubtful = plain(pages._windows(exploration([*CELLS[:3], last, *CELLS[4:]])))
    assert doubtful == "All requirements are met from 3 to 4 m; at 5 m it takes more trials to be sure."
    first = [replace(each, requirements=(replace(each.requirements[0], undecided=True),)) for each in CELLS[1:3]]
    none_sure = plain(pages._windows(exploration([CELLS[0], *first, last, *CELLS[4:]])))
    assert none_sure == "All requirements are met from 3 to 5 m; it takes more trials to be sure of it."
    unmet = plain(
        pages.answer(
            exploration(
                [
                    replace(each, requirements=tuple(replace(item, met=False) for item in each.requirements))
                    for each in CELLS
                ],
                constrained=False,
            )
        )
    )
    assert unmet.startswith(
        "No line length (moor) tried meets all requirements; even the best misses the arrival (out) (97.0 % (95.7 to 97.9 %), 90 % required)."
    )
    assert "All requirements are met" not in unmet
    alone = plain(
        pages.answer(exploration([replace(each, as_good=each.place == (2,)) for each in CELLS], aim="energy"))
    )
    assert alone.startswith("For the least energy the best line length (moor) is 4 m")
    assert "Every other one tried misses a requirement or takes more energy, as far as 1000 trials tell." in alone
    raced = plain(pages.answer(exploration([replace(each, dropped=each.place == (0,)) for each in CELLS])))
    assert raced.endswith("With fewer trials were run those that cannot be the best: 1 of the choices.")
    assert "All requirements are met" not in raced
    assert "none of the choices can be compared" in pages.answer(exploration(best=None))


def test_of_two_keys_the_choices_are_counted():
    words = plain(pages.answer(exploration(GRID, (LINE, SPEED), best=3)))
    assert "The best line length (moor) and speed (out, back) are 3 m and 1.5 m/s" in words
    assert "All requirements are met with 10 of the 12 choices." in words
    assert "Every other one tried misses a requirement or succeeds less often" in words


def test_ranges_beyond_the_first_few_are_counted():
    windows = [Window(0, 1), Window(3, 3)]
    assert plain(pages.ranges_in_words(LINE, windows)) == "from 2 to 3 m and at 5 m"
    assert plain(pages.ranges_in_words(LINE, [Window(0, 0)] * 6)).endswith("at 2 m and in 2 more ranges")


def test_tables_have_each_cell_s_numbers():
    table = pages._table(exploration(), CELLS)
    rows = [[plain(each) for each in row] for row in table.rows]
    assert table.columns == [
        "line length (moor)",
        "requirements",
        "P(success)",
        "total energy",
        "total duration",
        "arrival (out)",
        "as good",
    ]
    assert rows[0] == ["2 m", "not met", "80 ± 2 %", "20.0 ± 0.2 W h", "2.0000 ± 0.0017 h", "81 %", ""]
    assert [row[-1] for row in rows] == ["", "yes", "best", "", "", "–"]
    assert rows[5] == ["7 m", "cannot be run", "–", "–", "–", "–", "–"]
    (window, good) = pages._good(exploration())
    assert [plain(each) for each in window.blocks[0].rows[0]] == ["3 to 5 m", "3", "94.0 ± 1.5 %"]  # the least of them
    assert good.heading == "4 m is the best; 1 more is as good"
    *_, invalid = pages._others(exploration())
    assert invalid.blocks[0].rows == [("7 m", "1", "the line is too long")]
    _, narrow = pages._cells(exploration())
    assert [plain(each) for each in narrow[2]] == ["4 m", "best", "97.0 %", "26.0 W h", "2.5000 h", "98.0 %"]
    assert [row[1] for row in narrow] == ["not met", "as good", "best", "met", "not met", "cannot be run"]
    assert pages._verdict(exploration()) == "good"
    assert pages._verdict(exploration([CELLS[0], CELLS[4]])) == "bad"
    best = CELLS[2]
    unsure = replace(best, requirements=tuple(replace(each, undecided=True) for each in best.requirements))
    assert pages._verdict(exploration([*CELLS[:2], unsure, *CELLS[3:]])) == "undecided"  # another is sure
    hopeless = replace(best, success=wilson(0, 1000))
    assert pages._verdict(exploration([*CELLS[:2], hopeless, *CELLS[3:]])) == "bad"  # whatever else it meets
    assert "Every other" not in pages.answer(exploration([best], best=0))
    assert pages.page(exploration()).numbers[1:] == [("Choices tried", "6"), ("Trials of each", "1000")]
    assert (
        pages.page(exploration()).rerun
        == "missionplan explore mission.yaml --vary 'a=1:2:1 m' --quantity moor.offset --aim success --trials 1000 --seed 4"
    )


@pytest.mark.parametrize(
    ("key", "scale", "middle"),
    [
        ("success", 1.0, [80.0, 96.0, 97.0, 94.0, 70.0, NAN]),
        ("total.energy_wh", 1.0, [20.0, 24.0, 26.0, 27.0, 40.0, NAN]),
        ("total.duration_s", 1.0, [2.0, 2.25, 2.5, 2.75, 2.6, NAN]),
        ("out.arrived", 1.0, [81.0, 97.0, 98.0, 95.0, 71.0, NAN]),
    ],
)
def test_a_curve_goes_through_the_cells_and_marks_those_as_good(key, scale, middle):
    axes = Figure().add_subplot()
    figures.draw_exploration(axes, exploration(), key)
    line, good, best = axes.get_lines()[0], axes.get_lines()[-2], axes.get_lines()[-1]
    np.testing.assert_allclose(np.array(line.get_data(), dtype=float), [LINE.numbers, middle])
    np.testing.assert_allclose(np.array(good.get_data(), dtype=float), [[3.0, 4.0], middle[1:3]])
    np.testing.assert_allclose(np.array(best.get_data(), dtype=float).ravel(), [4.0, middle[2]])
    band = axes.collections[0].get_paths()[0].vertices
    if key == "total.energy_wh":
        assert (band[:, 1].min(), band[:, 1].max()) == pytest.approx((20.0 - 3.2, 40.0 + 3.4))
    elif key == "success":
        spans = [wilson(n, 1000) for n in (700, 970)]
        assert (band[:, 1].min(), band[:, 1].max()) == pytest.approx((100.0 * spans[0].low, 100.0 * spans[1].high))
    (window,) = (each for each in axes.patches if each.get_alpha() == 0.15)
    assert (window.get_x(), window.get_x() + window.get_width()) == (3.0, 5.0)


def test_of_what_has_no_number_each_cell_is_drawn_with_its_own_ends():
    axes = Figure().add_subplot()
    words = Axis(("vehicle",), ({},) * 6, tuple("abcdef"))
    figures.draw_exploration(axes, replace(exploration(), axes=(words,)), "success")
    ends = [part[:, 1].tolist() for part in axes.collections[0].get_segments()[:5]]
    spans = [wilson(n, 1000) for n in (800, 960, 970, 940, 700)]
    assert ends == [pytest.approx([100.0 * each.low, 100.0 * each.high]) for each in spans]


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("success", lambda row, column: 90.0 + row + 0.1 * column),
        ("total.energy_wh", lambda row, column: 20.0 + row + 5.0 * column),
    ],
)
def test_a_map_has_the_first_key_upward_and_the_second_across(key, values):
    found = exploration(GRID, (LINE, SPEED), best=3)
    axes = Figure().add_subplot()
    figures.draw_exploration(axes, found, key)
    drawn = np.array(axes.collections[0].get_array()).reshape(6, 2)
    assert drawn == pytest.approx(np.array([[values(row, column) for column in range(2)] for row in range(6)]))
    star = axes.get_lines()[-1]
    assert np.array(star.get_data(), dtype=float).ravel().tolist() == [1.5, 3.0]
    dots = axes.get_lines()[-2]
    assert np.array(dots.get_data(), dtype=float).ravel().tolist() == [1.5, 3.0]
    outline = {tuple(map(tuple, np.array(line.get_data(), dtype=float).tolist())) for line in axes.get_lines()[:-2]}
    assert ((0.75, 1.25), (2.5, 2.5)) in outline  # between 2 m, which misses, and 3 m
    assert ((1.25, 1.75), (7.5, 7.5)) in outline
    assert not any(y == (1.5, 1.5) for _, y in outline)
    assert plain(axes.get_xlabel()).startswith("Speed (out, back)")


def test_places_of_an_axis_are_days_numbers_or_their_order():
    moments = [datetime(2026, 6, day, 12, tzinfo=UTC) for day in (1, 2)]
    start = Axis(("start",), ("a", "b"), ("a", "b"), tuple(each.timestamp() for each in moments), "UTC")
    assert figures.positions(start).tolist() == [each.timestamp() / 86_400.0 for each in moments]
    assert figures.positions(SPEED).tolist() == [1.0, 1.5]
    assert figures.positions(Axis(("vehicle",), ({}, {}, {}), ("a", "b", "c"))).tolist() == [0.0, 1.0, 2.0]
    assert pages.tried(exploration(axes=(start,))) == "starts"
    assert figures._edges(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]


def test_the_front_is_drawn_at_energy_and_success_in_the_colour_of_its_time(monkeypatch):
    seen = {}
    with monkeypatch.context() as patch:
        patch.setattr(figures, "to_figure", lambda figure, *words, **more: seen.update(figure=figure))
        figures.front_figure(exploration())
    others, front = seen["figure"].axes[0].collections
    assert np.array(front.get_offsets()).tolist() == [[20.0, 80.0], [24.0, 96.0], [26.0, 97.0]]
    assert np.array(front.get_array()).tolist() == [2.0, 2.25, 2.5]
    assert np.array(others.get_offsets()).tolist() == [[27.0, 94.0], [40.0, 70.0]]
    assert figures.front_figure(exploration(CELLS[:1])) is None
    section, *_ = pages._others(exploration())
    assert section.heading == "3 choices trade success, energy and duration against each other"
    assert [plain(row[0]) for row in section.blocks[1].rows] == ["4 m", "3 m", "2 m"]
