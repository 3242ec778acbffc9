"""What the page says of an outcome, and that it says it safely."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure
from outcome_example import MAPPED, example

from missionplan.mission import load
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.report.page import Figure, draw, drawing_by, style
from missionplan.report.render import render_report, terminal_view
from missionplan.report.simulation import figures, quantities
from missionplan.report.simulation import page as simulation
from missionplan.report.simulation.quantities import judged
from missionplan.report.wording import percent
from missionplan.results.simulation import Attrition, MooringAnchor, Outcome, RequirementOutcome, Sensitivity
from missionplan.studies.simulation.simulate import simulate

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return example()


@pytest.fixture(scope="module")
def page(outcome):
    with style():
        return simulation.page(outcome)


def with_success(outcome: Outcome, successes: int, trials: int, attrition=()) -> Outcome:
    total = replace(outcome.total, events={"success": wilson(successes, trials)})
    return replace(outcome, total=total, attrition=tuple(attrition))


def test_the_verdict_comes_first_in_plain_words(page, outcome):
    share = 100.0 * outcome.total.events["success"].value
    assert page.answer.startswith(f"This mission does not do what is required of it; it succeeds {share:.1f}")
    assert "most failures are missed arrivals (ingress)" in page.answer
    assert "3 of its 4 requirements are met" in page.answer
    assert page.verdict == "bad"


def test_a_mission_that_never_failed_says_so(outcome):
    sure = with_success(outcome, 1000, 1000)
    assert (
        "none of 4000 trials failed, so that P(success) is 100\u00a0% (at least 99.6\u00a0%)"
        in terminal_view(sure).sentence
    )


def test_a_mission_is_not_said_to_work_that_misses_what_it_requires(outcome):
    sure = with_success(outcome, 4000, 4000)
    for successes, words in ((100, "does not do what is required of it, though none"), (450, "is undecided, though")):
        one = requirement(outcome, successes, 500)
        said = terminal_view(replace(sure, requirements=(one,))).sentence
        assert words in said
        assert "works" not in said


def test_a_mission_that_never_succeeds_fails(outcome):
    steps = [Attrition("ingress: not arrived", wilson(100, 100), wilson(0, 100))]
    lost = replace(with_success(outcome, 0, 100, steps), requirements=())
    assert terminal_view(lost).sentence.startswith("This mission fails: none of 4000 trials succeeded; most failures")
    assert terminal_view(lost).verdict == "bad"


def test_a_mission_that_seldom_succeeds_is_not_said_to_work(outcome):
    steps = [Attrition("ingress: not arrived", wilson(960, 1000), wilson(40, 1000))]
    seldom = replace(with_success(outcome, 40, 1000, steps), requirements=())
    assert terminal_view(seldom).sentence.startswith("This mission fails more often than not: it succeeds 4.0")
    assert terminal_view(seldom).verdict == "bad"


def test_a_trial_that_fails_does_not_show_that_a_mission_does(outcome):
    one = replace(with_success(outcome, 0, 1, outcome.attrition), provenance=replace(outcome.provenance, trials=1))
    assert simulation.answer(one).startswith("None of 1 trial succeeded, too few to say that the mission fails; ")


@pytest.mark.parametrize(
    ("rank_correlation", "makes"), [(-0.6, "smaller"), (0.6, "larger"), (0.1, "larger or smaller")]
)
def test_a_larger_input_is_said_to_make_more_or_less_where_that_tells_most_of_it(rank_correlation, makes):
    found = Sensitivity("moor.offset_m", "ingress.fix_error.along", rank_correlation, 0.5, 0.02)
    assert quantities._direction(found) == makes


def test_a_few_trials_do_not_show_that_a_mission_works(outcome):
    few = replace(with_success(outcome, 10, 10), requirements=(), provenance=replace(outcome.provenance, trials=10))
    assert terminal_view(few).sentence.startswith("None of 10 trials failed, too few to say that the mission works: ")


def test_an_anchor_that_is_sized_is_told_with_what_it_achieves(outcome):
    free = replace(outcome, requirements=())
    sized = replace(free, anchors=(MooringAnchor("moor", 11.7, True),))
    within = percent(outcome.phases[1].events["within_radius"])
    words = f"The anchor sized for the worst case of Eq. 1 (moor), 11.7\u00a0N wet, comes down within the radius in {within}"
    assert words in terminal_view(sized).sentence
    assert terminal_view(sized).verdict == ""
    impossible = replace(free, anchors=(MooringAnchor("moor", 0.13, True, ("the tube would have no length",)),))
    said = terminal_view(impossible)
    assert said.sentence.startswith("This mission cannot be carried out, as its anchor cannot be built; it succeeds")
    assert "0.13\u00a0N wet (moor) cannot be built from its parts: the tube would have no length." in said.sentence
    assert said.verdict == "bad"
    assert not impossible.can_be_built
    assert impossible.summary()["anchors"][0]["feasible"] is False


def test_durations_of_those_that_end_say_of_how_many(outcome):
    duration = replace(outcome.total.quantities["duration_s"], count=3040, missing=960)
    part = replace(
        outcome, total=replace(outcome.total, quantities={**outcome.total.quantities, "duration_s": duration})
    )
    shown = simulation.page(part)
    assert ("Duration of nine missions in ten, of the 76.0\u00a0% that end") in dict(shown.numbers)
    headings = [section.heading for section in shown.sections]
    assert any(heading.startswith("Half of the 76.0\u00a0% that end need") for heading in headings)
    assert any(heading.startswith("Half of the 76.0\u00a0% that end need") for heading in headings)


def test_a_few_trials_are_not_nine_missions_in_ten(outcome):
    """Between the least and the greatest of 44 nine in ten lie in less than nine cases of ten."""
    assert 0.95**simulation.FEW < 0.1 < 0.95 ** (simulation.FEW - 1)

    def ended(count):
        few = replace(outcome.total.quantities["duration_s"], count=count, p05=3600.0, p50=3600.0, p95=3600.0)
        total = replace(outcome.total, quantities={**outcome.total.quantities, "duration_s": few})
        shown = simulation.page(replace(outcome, total=total))
        return dict(shown.numbers), " ".join(section.heading for section in shown.sections)

    numbers, headings = ended(1)
    assert numbers["Duration of the 1 trial that ends"] == "60.0\u00a0min"
    assert "The one trial that ends needs 60" in headings
    numbers, headings = ended(44)
    assert "Duration of the 44 trials that end" in numbers
    assert "Half of the 44 trials that end need no more than 60" in headings


def test_the_commonest_of_many_failures_is_named_as_such(outcome):
    steps = [Attrition(f"leg {i}: not arrived", wilson(30 + i, 100), wilson(70, 100)) for i in range(2)]
    assert (
        "the commonest failures are missed arrivals (leg 1)"
        in terminal_view(with_success(outcome, 10, 100, steps)).sentence
    )


def test_requirements_are_judged_in_words(outcome):
    verdicts = [judged(item) for item in outcome.requirements]
    assert verdicts[2] == "not met"


def requirement(outcome: Outcome, successes: int, trials: int, required: float = 0.9) -> RequirementOutcome:
    found = wilson(successes, trials)
    met, undecided = found.value >= required, found.low <= required <= found.high
    asked = outcome.requirements[0]
    return replace(asked, required=required, probability=found, met=met, undecided=undecided, trials=trials)


@pytest.mark.parametrize(
    ("needed", "words"),
    [
        ((3458, 120), "about 3500 trials would decide, if the share stays as it is"),
        ((120, 31), "about 120 trials would decide, if the share stays as it is"),
        ((3458, None), "what is reached is what is required, so that no number of trials decides"),
        ((None,), "what is reached is what is required, so that no number of trials decides"),
    ],
)
def test_the_requirement_that_needs_most_trials_says_how_many_would_decide(needed, words):
    undecided = [SimpleNamespace(trials_to_decide=each) for each in needed]
    assert quantities._remedy(undecided).replace("\u202f", "") == words


@pytest.mark.parametrize("successes", [455, 445])
def test_an_undecided_requirement_is_called_so_with_the_trials_that_would_decide(outcome, successes):
    """1.96² · 0.9 · 0.1/0.01² = 3458 trials."""
    one = requirement(outcome, successes, 500)
    assert one.undecided
    assert one.trials_to_decide == 3458
    assert one.summary()["undecided"]
    assert one.summary()["trials_to_decide"] == 3458
    seen = replace(outcome, requirements=(one,))
    shown = terminal_view(seen)
    assert "Whether its requirement is met is undecided; about 3500 trials would decide" in shown.sentence
    assert shown.verdict == simulation.page(seen).verdict == "undecided"
    assert judged(one).startswith("undecided: about 3500 trials")
    assert next(part for part in simulation.page(seen).sections if part.heading.startswith("Undecided: "))


def test_requirements_that_are_met_not_met_and_undecided_are_counted_apart(outcome):
    items = (requirement(outcome, 500, 500), requirement(outcome, 100, 500), requirement(outcome, 450, 500))
    sentence = terminal_view(replace(outcome, requirements=items)).sentence
    assert "Of its 3 requirements 1 is met, 1 is not met and 1 is undecided; what is reached" in sentence
    open_ = terminal_view(replace(outcome, requirements=items[2:] * 2)).sentence
    assert "Both requirements are undecided; what is reached" in open_
    assert items[2].trials_to_decide is None
    assert terminal_view(replace(outcome, requirements=items)).verdict == "bad"


def test_the_tightest_requirement_is_that_whose_limit_is_nearest_to_what_is_reached(outcome):
    """A limit of 100 m of which 95 of 100 trials stay within 12 m is not tight, however many trials are within it."""
    loose = replace(requirement(outcome, 500, 500), bound="at_most", limit=100.0, reached=12.0)
    tight = replace(requirement(outcome, 500, 500), bound="at_most", limit=100.0, reached=91.0)
    assert (loose.slack, tight.slack) == (pytest.approx(0.88), pytest.approx(0.09))
    least = replace(loose, bound="at_least", limit=8.0, reached=10.0)
    assert (least.slack, replace(least, reached=6.0).slack) == (pytest.approx(0.2), pytest.approx(-0.25))
    event = replace(requirement(outcome, 480, 500), bound=None, limit=None)
    assert event.slack == pytest.approx((0.96 - 0.9) / 0.1)
    headings = [part.heading for part in simulation.page(replace(outcome, requirements=(loose, tight))).sections]
    assert "; the tightest is " in headings[0]
    assert ": 90 of 100 missions reach at most " in headings[0]
    assert not any("tightest" in heading for heading in headings[1:])
    alone = simulation.page(replace(outcome, requirements=(loose,)))
    assert alone.sections[0].heading == "Every requirement is met"


def test_limits_are_in_the_units_of_the_mission(page):
    (table,) = next(section for section in page.sections if section.heading.startswith("Not met")).blocks
    requirements = [row[0] for row in table.rows]
    assert "offset of the anchor (moor) at most 75\u00a0ft" in requirements
    assert "total energy at most 45\u00a0W\u202fh" in requirements


def test_every_figure_has_its_own_name_an_alternative_text_and_units(outcome):
    with style(), drawing_by(draw):  # figures are drawn when they are asked for
        page = simulation.page(outcome)
        figures = [
            page.figure,
            *(block for part in page.sections for block in part.blocks if isinstance(block, Figure)),
        ]
    names = [figure.name for figure in figures]
    assert len(set(names)) == len(names)
    assert {"mission", "waterfall", "histograms"} <= set(names)
    assert all(len(figure.alt) > 40 and figure.caption for figure in figures)
    for figure in figures:
        labels = re.findall(r"<text[^>]*>([^<]+)</text>", figure.svg)
        assert any(re.search(r"\((m|min|%|ft|W\u202fh)\)|\d\u00a0m\b", label) for label in labels), figure.name


def test_a_quantity_that_does_not_vary_is_told_and_not_drawn(outcome):
    moor = outcome.phases[1]
    fixed = replace(moor.quantities["lowest_altitude_m"], mean=1.498, p50=1.498, sd=2e-13, standard_error=3e-15)
    phases = (outcome.phases[0], replace(moor, quantities={**moor.quantities, "lowest_altitude_m": fixed}))
    rounding = Sensitivity("moor.lowest_altitude_m", "site.current[0].speed", 0.1, 0.4, 0.02)
    rendered = render_report(replace(outcome, phases=phases, sensitivities=(rounding,)))
    assert "The lowest altitude of the nose (moor) is 1.498\u00a0m in every trial" in rendered.html
    assert "moor-lowest-altitude-m" not in rendered.figures
    assert "matters most" not in rendered.html  # of what differs by rounding alone nothing is explained


def test_the_heading_names_what_matters_for_a_quantity_that_varies(outcome):
    def shown(*found: Sensitivity) -> str:
        return render_report(replace(outcome, sensitivities=found)).html

    release = Sensitivity("moor.offset_m", "moor.release_time", 0.6, 0.4, 0.02)
    member = Sensitivity("moor.lowest_altitude_m", "site.current.member", 0.1, 0.9, 0.02)
    assert "Which member of the current&#39;s ensemble matters most" in shown(release, member)
    altitude = outcome.phases[1].quantities["lowest_altitude_m"]
    altitude = replace(altitude, sd=5e-3 * altitude.mean)
    quantities = {**outcome.phases[1].quantities, "lowest_altitude_m": altitude}
    phases = (outcome.phases[0], replace(outcome.phases[1], quantities=quantities), outcome.phases[2])
    steady = render_report(replace(outcome, phases=phases, sensitivities=(release, member))).html
    assert "Release time (moor) matters most: it accounts for 40\u00a0% of the variance of the offset" in steady
    (row,) = [each for each in re.findall(r"<tr>(.*?)</tr>", steady) if "member of the current" in each]
    assert not re.search("larger<|smaller<", row)  # a member has a number, which is neither large nor small
    assert "; grey: neither" not in shown(release)


@pytest.mark.parametrize("keep", [0, 1])
def test_trials_that_went_nowhere_and_a_mission_that_asks_nothing_leave_a_page(outcome, keep):
    tracks = replace(outcome.tracks, position=np.where(np.arange(MAPPED) < keep, outcome.tracks.position, np.nan))
    arrivals = {name: np.full((2, 5), np.nan) for name in outcome.arrivals}
    poor = replace(outcome, tracks=tracks, arrivals=arrivals, sensitivities=(), requirements=())
    ended = {"duration_s": replace(outcome.total.quantities["duration_s"], p50=np.nan, count=0)}
    rendered = render_report(replace(poor, total=replace(outcome.total, quantities=ended)))
    assert "mission" in rendered.figures
    assert "<h2>No mission comes to its end</h2>" in rendered.html
    assert '<h1 class="">' in rendered.html
    assert not re.search("<h2>[^<]*(requirement|matters most)", rendered.html)


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[tuple[str, dict]] = []

    def handle_starttag(self, tag, attributes):
        self.seen.append((tag, dict(attributes)))


def test_failed_blocks_are_told_first_and_what_files_say_is_escaped():
    evil = "<script>alert(1)</script>\" onload='x' & {{ 7*7 }}"
    rendered = render_report(replace(example(name=evil), failed_blocks=(f"block 3, seed 1: {evil}",)))
    assert re.findall("<h2>(.*?)</h2>", rendered.html)[0] == "1 block of trials failed numerically"
    tags = Tags()
    tags.feed(rendered.html)
    assert [tag for tag, _ in tags.seen].count("script") == 1
    assert "alert(1)" not in rendered.html.partition("<script>")[2]
    assert not [key for _, attributes in tags.seen for key in attributes if key.startswith("on")]
    assert "49" not in re.findall(r'<p class="title">(.*?)</p>', rendered.html)[0]


def test_the_folder_holds_what_the_contract_names_and_the_page_asks_for_nothing_from_elsewhere(outcome, tmp_path):
    outcome.save(tmp_path / "report")
    names = {path.name for path in (tmp_path / "report").iterdir()}
    wanted = {"report.html", "summary.json", "mission.yaml", "quantities.csv", "track.geojson", "track.kml", "figures"}
    assert wanted <= names
    assert json.loads((tmp_path / "report/summary.json").read_text())["total"]["events"]["success"]["value"] > 0.9
    html = (tmp_path / "report/report.html").read_text()
    links = re.findall(r'(?:src|href)="([^"#][^"]*)"', html)
    assert all(link.startswith("data:") for link in links)
    assert "@import" not in html


def test_without_an_origin_there_is_no_place_on_earth():
    assert render_report(example(origin=False)).files == {}


def test_the_sheet_tells_the_hour_in_utc_and_in_the_zone_of_the_mission():
    def sheet(start):
        found = simulate(load(MISSIONS / "fig8.yaml").with_({"start": start}), trials=60, assumptions=False)
        return next(section for section in simulation.page(found).sections if section.is_sheet)

    west, utc = sheet("2026-06-01T22:00-05:00"), sheet("2026-06-02T03:00Z")
    local = re.search(r"\((.*)\)", west.heading)[1]
    assert local.startswith(re.search(r"\((.*)\)", utc.heading)[1])
    assert re.fullmatch(r"02 Jun \d\d:\d\d UTC, 0[12] Jun \d\d:\d\d -05:00", local)
    there, here = (int(hour) for hour in re.findall(r"Jun (\d\d):", local))
    assert (there - here) % 24 == 5
    assert any("nothing of it (energy.capacity)" in block for block in west.blocks if isinstance(block, str))


def test_bars_of_the_waterfall_stand_on_one_another_from_all_trials_down(outcome):
    axes = MatplotlibFigure().add_subplot()
    figures.draw_waterfall(axes, outcome)
    tops = [bar.get_x() + bar.get_width() for bar in axes.patches]
    assert tops == pytest.approx([100.0, *(bar.get_x() for bar in axes.patches[:-1])])
    assert (axes.patches[-1].get_x(), tops[-1]) == (0.0, pytest.approx(100.0 * outcome.total.events["success"].value))
    lost, left = Probability(0.1234, 0.1134, 0.1334), Probability(0.8766, 0.8666, 0.8866)
    axes = MatplotlibFigure().add_subplot()
    figures.draw_waterfall(axes, replace(outcome, attrition=(Attrition("phases[0]: not arrived", lost, left),)))
    assert axes.get_yticklabels()[0].get_text().split() == ["missed", "arrivals", "(phase", "1)"]
    assert axes.texts[0].get_text() == "−12.3 %"  # give or take 1.0


def test_a_histogram_has_the_trials_the_band_the_median_and_the_limit_in_the_mission_s_unit(outcome):
    moor, foot = outcome.phases[1], 0.3048
    axes, values = MatplotlibFigure().add_subplot(), moor.quantities["offset_m"]
    figures.draw_histogram(axes, outcome, moor, "offset_m")
    stairs, band = axes.patches
    heights, edges, _ = stairs.get_data()
    assert (heights.sum(), edges[-1]) == pytest.approx((100.0, moor.histograms["offset_m"].edges[-1] / foot))
    assert (heights > 2.0 * 100.0 / 40).any()
    ends = band.get_window_extent().transformed(axes.transData.inverted())
    assert (ends.x0, ends.x1) == pytest.approx((values.p05 / foot, values.p95 / foot))
    median, limit = (line.get_xdata()[0] for line in axes.get_lines())
    assert (median, limit) == pytest.approx((values.p50 / foot, 75.0))


def test_tracks_and_depths_of_trials_that_fail_are_orange_with_a_cross_where_they_end(outcome):
    tracks = outcome.tracks
    last = [np.flatnonzero(np.isfinite(tracks.time[:, trial]))[-1] for trial in range(MAPPED)]
    failed = np.flatnonzero(~tracks.success)
    assert 0 < len(failed) < MAPPED
    for draw_it, ends in (
        (figures.draw_tracks, [tracks.position[last[trial], :, trial] for trial in failed]),
        (figures.draw_profile, [tracks.profile[:, last[trial], trial] / (60.0, 1.0) for trial in failed]),
    ):
        axes = MatplotlibFigure().add_subplot()
        draw_it(axes, outcome)
        good, bad = (each for each in axes.collections if isinstance(each, LineCollection))
        assert [each.get_color()[0, 0] > 0.5 for each in (good, bad)] == [False, True]
        assert [len(each.get_segments()) for each in (good, bad)] == [MAPPED - len(failed), len(failed)]
        crosses = [np.ravel(line.get_data()) for line in axes.get_lines() if line.get_marker() == "x"]
        assert np.array(crosses) == pytest.approx(np.array(ends))
        for segment, end in zip(bad.get_segments(), ends, strict=True):
            assert segment[np.isfinite(segment).all(axis=1)][-1] == pytest.approx(end)
