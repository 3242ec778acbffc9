"""What a page says of the assumptions that it rests on, of a ledger made by hand."""

import math

import pytest

from missionplan.report.explained import with_assumptions
from missionplan.report.page import Page, PageSection
from missionplan.results.decision import Assumption

CALM = Assumption("it is calm", "a swell", 0.03, 0.93, is_required=True)
STILL = Assumption("the water is still", "0.1 m/s", -0.104, 0.796, is_required=True)
EXACT = Assumption("the log is exact", "2 % more", 0.0, 0.9, is_required=True)
CHARTED = Assumption("the chart holds", "1 m less", math.nan, math.nan)
SLOW = Assumption("it is fast", "half as fast", -0.5, 0.4, is_required=True)
SINKS = Assumption("it floats", "it sinks", -1.0, 0.0, is_required=True)
ALMOST = Assumption("it is light", "a stone more", -0.4, 0.4975, is_required=True)
LATE = Assumption("it is in time", "an hour late", -0.2, 0.7, ("out.arrived", "total.duration_s"), is_required=True)


def told(assumed, verdict="good"):
    """The page of an answer that rests on these assumptions."""
    return with_assumptions(Page("", "So it is.", (), lambda: [], lambda: ((), ()), verdict=verdict), assumed)


@pytest.mark.parametrize(
    ("assumed", "heading"),
    [
        ([CALM, STILL, EXACT, CHARTED], "Of its assumptions, that the water is still matters most: -10.4 % otherwise"),
        ([CHARTED, CALM], "Of its assumptions, that it is calm matters most: +3 % otherwise"),
        ([EXACT], "None of these assumptions alone could turn this"),
        ([EXACT, CHARTED], "None of these assumptions alone, of those that could be tried, could turn this"),
        ([SLOW, STILL, LATE], "2 of its assumptions could turn this"),
    ],
)
def test_the_heading_names_what_matters_most_for_better_or_worse(assumed, heading):
    (section,) = told(assumed).sections
    assert section.heading.replace("\u00a0", " ") == heading


@pytest.mark.parametrize("summaries", [0, 1, 2])
def test_they_stand_after_what_sums_the_answer_up_and_before_the_rest(summaries):
    headings = [f"{number}" for number in range(3)]
    sections = [PageSection(heading, [], is_summary=int(heading) < summaries) for heading in headings]
    page = with_assumptions(Page("", "So it is.", (), lambda: sections, lambda: ((), ())), [EXACT])
    headings.insert(summaries, "None of these assumptions alone could turn this")
    assert [section.heading for section in page.sections] == headings


def test_each_assumption_has_a_row_with_success_then_and_its_change():
    (section,) = told([STILL, EXACT, CHARTED, SLOW, SINKS]).sections
    assert [[cell.replace("\u00a0", " ") for cell in row] for row in section.blocks[0].rows] == [
        ["the water is still", "0.1 m/s", "79.6 %", "-10.4 %", ""],
        ["the log is exact", "2 % more", "90 %", "none", ""],
        ["the chart holds", "1 m less", "", "could not be run", ""],
        ["it is fast", "half as fast", "40 %", "-50 %", "could turn the answer"],
        ["it floats", "it sinks", "0 %", "-100 %", "could turn the answer"],
    ]


@pytest.mark.parametrize(
    ("assumed", "words"),
    [
        ([STILL], ""),
        (
            [STILL, SLOW],
            " But this assumes that it is fast: with half as fast it fails more often than not: it succeeds 40 % of the "
            "time.",
        ),
        (
            [ALMOST],
            " But this assumes that it is light: with a stone more it fails more often than not: it succeeds 49.8 % of "
            "the time.",
        ),
        (
            [LATE, SLOW],
            " But this assumes that it is in time: with an hour late it succeeds 70 % of the time and misses what is "
            "required of arrival (out) and total duration; 1 more such assumption below.",
        ),
    ],
)
def test_the_first_that_could_turn_the_answer_is_told_and_how_many_more(assumed, words):
    shown = told(assumed)
    assert shown.answer.replace("\u00a0", " ") == f"So it is.{words}"
    assert shown.verdict == ("undecided" if words else "good")


FOUL = Assumption("the tide is foul", "a fair one", 0.3, 0.6, is_required=True)


def test_what_fails_already_turns_by_that_alone_without_which_it_would_not():
    """A requirement missed for want of it, or more failures, are nothing new to a mission that fails."""
    for assumed in ([LATE, SLOW], [STILL]):
        fails = told(assumed, "bad")
        assert (fails.answer, fails.verdict) == ("So it is.", "bad")
        assert "turn" not in " ".join(fails.sections[0].blocks[0].rows[0])
        assert "could turn" not in fails.sections[0].heading
    mended = told([LATE, FOUL], "bad")
    assert mended.answer.endswith(
        "But this assumes that the tide is foul: with a fair one it succeeds 60 % of the time."
    )
    assert (mended.verdict, mended.sections[0].heading) == ("bad", "1 of its assumptions could turn this")
