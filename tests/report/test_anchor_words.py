"""What the page of an anchor says of doubts, of the anchor to build and of one that drags, of sizings made by hand."""

from types import SimpleNamespace
from typing import Any

import pytest

from missionplan.montecarlo.statistics import Probability
from missionplan.report.anchor import page
from missionplan.report.anchor.page import _drags_in_words, explanation_in_words, explanation_section


def plain(words):
    return words.replace("\u00a0", " ").replace("\u202f", " ")


def under(cause, low, value, high, needed=None, probability=0.25):
    return SimpleNamespace(
        causes=(cause,), good=Probability(value, low, high), needed=needed, probability=probability, trials=100
    )


def sizing(*explanations, probable=None, held=None) -> Any:
    return SimpleNamespace(explanations=explanations, probable=probable, held=held)


@pytest.mark.parametrize(
    ("explanations", "probable", "words"),
    [
        ((), None, ""),
        (
            (under("drag-bias", 0.84, 0.9, 0.95), under("lift-bias", 0.3, 0.4, 0.5)),
            None,
            " It depends on which explanation holds: 40 % with lift bias, 90 % with drag bias.",
        ),
        (
            (under("drag-bias", 0.45, 0.55, 0.65), under("lift-bias", 0.4, 0.5, 0.6)),
            None,
            " Whichever explanation holds, it does as well, as far as the trials can tell.",
        ),
        (
            (under("drag-bias", 0.84, 0.9, 0.95, 11.0), under("lift-bias", 0.3, 0.4, 0.5, 11.2)),
            True,
            " Whichever explanation holds, the same anchor is best, to 2 %.",
        ),
        (
            (under("drag-bias", 0.84, 0.9, 0.95, 11.0), under("lift-bias", 0.3, 0.4, 0.5, 11.3)),
            True,
            " The doubt changes the choice: with drag bias 11.00 N would do, with lift bias it takes 11.30 N. First find "
            "out which holds.",
        ),
        (
            (under("drag-bias", 0.84, 0.9, 0.95, 11.0), under("lift-bias", 0.3, 0.4, 0.5)),
            True,
            " It depends on which explanation holds: 40 % with lift bias, 90 % with drag bias.",
        ),
    ],
)
def test_a_doubt_is_told_where_it_changes_the_choice_or_how_often_a_dive_succeeds(explanations, probable, words):
    assert plain(explanation_in_words(sizing(*explanations, probable=probable))) == words


@pytest.mark.parametrize(
    ("needed", "last"), [((11.0, None), ("11.00", "–")), ((None, None), ("", "")), ((11.0, 12.5), ("11.00", "12.50"))]
)
def test_a_row_has_its_explanation_s_probability_success_and_anchor(needed, last):
    one, two = under("drag-bias", 0.84, 0.9, 0.95, needed[0], 0.75), under("lift-bias", 0.3, 0.4, 0.5, needed[1])
    (section,) = explanation_section(sizing(one, two))
    assert [tuple(map(plain, row)) for row in section.blocks[0].rows] == [
        ("drag bias", "75.0 %", "90 % (84 to 95 %)", last[0]),
        ("lift bias", "25.0 %", "40 ± 10 %", last[1]),
    ]
    assert explanation_section(sizing()) == []


@pytest.mark.parametrize(
    ("margins", "given", "words"),
    [
        ((0.2, 0.0), False, ""),
        ((0.2, -0.1), True, ""),
        (
            (0.2, -0.1, -0.3),
            False,
            " With an assumed holding factor of 0.4 the anchor to build would drag in the current 1, 0.51 m/s, which is "
            "not counted.",
        ),
    ],
)
def test_the_first_current_in_which_it_drags_is_told_where_its_holding_is_assumed(margins, given, words):
    states = [
        SimpleNamespace(holding_margin=each, current=f"current {k}", speed=0.5 + 0.01 * k)
        for k, each in enumerate(margins)
    ]
    held = SimpleNamespace(states=states, friction=0.4, friction_assumed=not given)
    assert plain(_drags_in_words(sizing(held=held))) == words
    assert _drags_in_words(sizing()) == ""


def test_the_heaviest_of_the_anchors_that_turn_out_otherwise_is_told_where_it_misses(monkeypatch):
    monkeypatch.setattr(page, "_hangs", lambda _: False)
    for name in ("_which", "judged_in_words", "_drags_in_words"):
        monkeypatch.setattr(page, name, lambda *_: "")
    margins = [SimpleNamespace(weight=11.0, misses=("x",)), SimpleNamespace(weight=13.2, misses=("90 %", "95 %"))]
    found = SimpleNamespace(
        explanations=(), probable=SimpleNamespace(margins=margins), held=None, members=(), judged=None, succeeds=False,
        phase="moor", others=("again", "third"),
    )  # fmt: skip
    assert plain(page.answer(found)) == (
        " Built heavier, with 13.20 N, it would miss 90 %, 95 %. It is sized for moor alone, not for again and third."
    )
    margins[1].misses = ()
    assert plain(page.answer(found)) == " It is sized for moor alone, not for again and third."
