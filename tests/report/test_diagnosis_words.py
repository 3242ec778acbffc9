"""What a diagnosis's page says of evidence, of trends and of several data sets, number by number, of ones made by hand."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.mission.includes import hash_of
from missionplan.report.diagnosis import campaign, evidence, findings, kind_report, page, scoring
from missionplan.results.learned.evidence import (
    Alias,
    Coverage,
    ExplanationOdds,
    HeldOutGain,
    ParameterEstimate,
    RankedSet,
    TakenAsExact,
)
from missionplan.results.learned.levels import Level, ParameterLevels

GAIN = HeldOutGain(5.0, 1.5, 3, 4, 0.2, 0.1, 0.71, 0.88)


def plain(words: str) -> str:
    return words.replace("\u00a0", " ").replace("\u202f", " ")


def ranked(*causes: str, score: float = 4.0, posterior: float | None = 0.75) -> RankedSet:
    return RankedSet(causes, score + 1.0, score, posterior, (), GAIN, 0.25)


def diagnosed(best: RankedSet | None, **given: Any) -> Any:
    usual = {"kind": "transit", "best": best, "causes": best.causes if best else (), "ranking": (best,) if best else (), "none_of_these": 0.123, "nothing": 0.8,
             "verdict": "explained", "coverage": None, "scores": (), "indistinguishable": (), "untestable": {}, "learned_from": ("a",), "suspect_labels": "",
             "readings": SimpleNamespace(wrong_fixes=()), "discrepancy": SimpleNamespace(axis=None), "exact": ()}  # fmt: skip
    return SimpleNamespace(**{**usual, **given})


@pytest.mark.parametrize(
    ("diagnosis", "words"),
    [
        (diagnosed(None), "Nothing of the catalogue could be fitted to these data."),
        (diagnosed(None, learned_from=()), "Nothing of the catalogue was fitted: these data count once."),
        (
            diagnosed(ranked("drag-bias", score=0.9), causes=(), nothing=0.4),
            "Of the explanations tried none is claimed: the likeliest, drag bias, has a probability of 75.0 %, and that "
            "there is some cause 60.0 %, of the 95 % that it needs. In doubt, that none of these is behind it has a "
            "probability of 12.3 %.",
        ),
        (
            diagnosed(ranked("drag-bias")),
            "Among the explanations tried, drag bias has a probability of 75.0 %; that none of these is behind it has a "
            "probability of 12.3 %.",
        ),
        (
            diagnosed(ranked("drag-bias", posterior=None)),
            "Among the explanations tried, drag bias fits best; that none of these is behind it has a probability of "
            "12.3 %.",
        ),
        (
            diagnosed(ranked("drag-bias", score=1.1), causes=()),
            "Of the explanations tried none is claimed: the likeliest, drag bias, has a probability of 75.0 %, and that "
            "there is some cause 20.0 %, of the 95 % that it needs. In doubt, that none of these is behind it has a "
            "probability of 12.3 %.",
        ),
        (
            diagnosed(ranked("drag-bias", score=0.9), causes=()),
            "Of the explanations tried none is needed: the data look as the mission expects. In doubt, that none of "
            "these is behind it has a probability of 12.3 %.",
        ),
        (
            diagnosed(ranked("drag-bias"), causes=(), verdict="unexplained"),
            "Of the explanations tried none fits what the data show; that none of these is behind it has a probability "
            "of 12.3 %.",
        ),
    ],
)
def test_what_was_tried_is_told_with_how_probable_it_is(diagnosis, words):
    first, *more = findings.how_sure(diagnosis)
    assert plain(first) == words
    held_out = "from the others. Predicted better with what was found than without: 3 of 4 parts."
    assert [each.endswith(held_out) for each in more] == [True] * bool(diagnosis.causes)


@pytest.mark.parametrize(("scale", "off"), [(1.25, "narrow"), (0.8, "wide"), (1.0, None)])
def test_intervals_that_do_not_hold_what_they_should_are_too_narrow_or_too_wide(scale, off):
    coverage = Coverage(62, 80, scale, 73)
    words = f"Its 90 % intervals are too {off}: they hold 78 % of what was held out." if off else ""
    assert plain(findings.intervals_that_miss(coverage)) == words
    _, *told = findings.how_sure(diagnosed(None, coverage=coverage))
    assert [plain(each).partition(", as in")[0] for each in told] == [
        f"90 % intervals hold 78 % of what was held out. With random errors {scale:.2f} times as large"
    ] * bool(off)
    assert all("they hold 91 %: " in plain(each) for each in told)
    assert findings.intervals_that_miss(None) == ""


def test_a_jump_and_a_trend_are_told_with_their_own_values() -> None:
    missions = tuple(
        Level(name, None, value, 0.002, jumped)
        for name, value, jumped in (("a", 0.01, 0.0), ("b", 0.02, 0.49), ("c", 0.065, 0.51))
    )
    found = ParameterLevels("speed-scale", "fraction", "", missions, -0.02, 0.002, 0.95, 0.09, 0.004, 16)
    _, jump = findings.ageing_in_words([found], {"c": "the third"})
    assert plain(jump) == "Fraction of speed scale jumped before the third, to 6.5 ± 0.2 %."
    (trend,) = map(plain, findings.trends_in_words([found], simulated=True))
    assert "2.0 ± 0.2 %" in trend
    assert trend.endswith("The next mission is planned with 9.0 ± 0.4 %. In 16 missions it costs success.")
    assert (
        "with each mission fraction of speed scale changes by −2.0 ± 0.2 %: clean the hull" in trend
    )  # yet it is fast
    (trend,) = map(plain, findings.trends_in_words([replace(found, next_value=-0.05)], simulated=True))
    assert "with each mission the vehicle goes 2.0 ± 0.2 % slower than it reckons" in trend
    assert not list(findings.trends_in_words([replace(found, trend_sd=0.007)], simulated=True))


def test_what_is_left_is_told_with_its_least_p_values_and_both_bayes_factors(monkeypatch) -> None:
    monkeypatch.setattr(evidence, "discrepancy_figure", lambda found, shape: shape)
    tests = tuple(SimpleNamespace(name=f"test {k}", p_value=0.5 / (k + 1)) for k in range(10))
    left: Any = SimpleNamespace(
        by_axis=(("time", 4.25), ("heading", -1.0)), shape="a figure", log_bayes_factor=4.5, tests=tests, axis="time", resembles=None
    )  # fmt: skip
    section = evidence.discrepancy_section(
        diagnosed(None, discrepancy=left, base_discrepancy=SimpleNamespace(log_bayes_factor=17.0))
    )
    assert section.heading == "What is left is structured along time"
    figure, words, axes, least = section.blocks
    assert figure == "a figure"
    assert "ln BF = 4.5 " in words
    assert words.endswith("alone: 17.0.")
    assert [list(row) for row in axes.rows] == [["time", "4.2"], ["heading", "-1.0"]]
    assert [list(row) for row in least.rows] == [[f"test {k}", f"{0.5 / (k + 1):.2g}"] for k in (9, 8, 7, 6, 5)]
    assert least.caption.endswith("of 10 tests; by chance alone the least would be about 0.1.")
    left.resembles = "a drift"
    assert evidence.resemblance(left) == "looks like a drift"


def test_shares_inside_intervals_are_those_of_the_model_that_is_named(monkeypatch) -> None:
    monkeypatch.setattr(evidence, "held_out_figure", lambda found: "")
    score = SimpleNamespace(group="a", log_score_base=0.0, log_score_extended=1.0, rmse_base=0.2, rmse_extended=0.1)
    (section,) = evidence.held_out_section(diagnosed(ranked("drag-bias"), scores=(score,)))
    assert plain(section.blocks[-1]) == (
        "90 % prediction intervals hold 71 % of the values with the mission's model and 88 % with the extended one."
    )


@pytest.mark.parametrize(
    ("causes", "others", "pairs", "heading"),
    [
        ((), (), (), "What these data could not show"),
        ((), (ranked("lift-bias", posterior=0.04),), (), "No cause comes near"),
        (("drag-bias",), (), (), "Nothing else comes near"),
        (("drag-bias",), (ranked("lift-bias", posterior=0.04),), (), "Nothing else comes near"),
        (
            ("drag-bias",),
            (ranked("lift-bias", posterior=0.06),),
            (),
            "What these data cannot distinguish, and what would",
        ),
        (("drag-bias",), (ranked("drag-bias", "lift-bias", posterior=0.2),), (), "Nothing else comes near"),
        (("drag-bias",), (), ((("drag-bias",), ("lift-bias",)),), "What these data cannot distinguish, and what would"),
    ],
)
def test_what_cannot_be_distinguished_is_likely_and_lacks_a_cause(causes, others, pairs, heading):
    first = (ranked(*causes),) if causes else ()
    readings = SimpleNamespace(aliases=(Alias("drag-bias", "lift-bias", 2500.0, "a dive"),))
    found = diagnosed(
        None, causes=causes, ranking=(*first, *others), indistinguishable=pairs, readings=readings,
        credible_set=[("drag-bias",)] * 10, untestable={"lift-bias": "no wing"},
    )  # fmt: skip
    section = evidence.distinction_section(found)
    assert section.heading == heading
    held = (
        "95 % of the probability lies with: drag bias, " if first or others else "No cause was compared with another."
    )
    assert section.blocks[0].startswith(held)
    assert section.blocks[0].endswith(", drag bias and 2 more in diagnosis.json.") == bool(first or others)
    *_, aliases, untestable = section.blocks
    assert [tuple(map(plain, row)) for row in aliases.rows] == [("drag bias", "lift bias", "2.50 km", "a dive")]
    assert [tuple(row) for row in untestable.rows] == [("lift bias", "no wing")]


def test_residuals_are_told_with_their_root_mean_squares_before_and_after(monkeypatch) -> None:
    monkeypatch.setattr(kind_report, "to_figure", lambda figure, name, *, alt, caption: caption)
    left = kind_report.ResidualSeries(
        [np.array([3.0, -3.0]), np.array([4.0, 4.0])], [np.array([1.0, 1.0]), np.array([0.0, 0.0])], "m"
    )
    words: Any = kind_report.against_axes([("Time (h)", np.arange(2.0))], left)
    assert plain(words).endswith("3.54 m rms before and 0.707 m after.")


def test_the_autocorrelation_of_a_series_that_alternates_and_the_band_of_independent_errors(monkeypatch) -> None:
    seen: list[Figure] = []
    monkeypatch.setattr(kind_report, "to_figure", lambda figure, *words, **more: seen.append(figure))
    up_and_down = 5.0 + np.tile([1.0, -1.0], 20)
    assert kind_report._correlation([up_and_down], 1) == pytest.approx(-39.0 / 40.0)
    assert kind_report._correlation([up_and_down, up_and_down - 7.0], 2) == pytest.approx(38.0 / 40.0)
    still = np.tile([1.0, 1.0, -1.0, -1.0], 10)
    kind_report.autocorrelation(kind_report.ResidualSeries([up_and_down] * 2, [still] * 2, ""), "Legs")
    before, after = seen[0].axes[0].collections
    assert [part[1, 1] for part in before.get_segments()[:2]] == pytest.approx([-39.0 / 40.0, 38.0 / 40.0])
    assert after.get_segments()[1][1, 1] == pytest.approx(-38.0 / 40.0)
    assert len(before.get_segments()) == 12  # a third of a series' length, less one
    (band,) = seen[0].axes[0].patches
    assert [band.get_y(), band.get_height()] == pytest.approx([-1.96 / 80.0**0.5, 2.0 * 1.96 / 80.0**0.5])


def test_probabilities_of_explanations_are_told_beside_what_they_were() -> None:
    odds = (
        ExplanationOdds(("drag-bias",), 0.5, 0.8), ExplanationOdds(("lift-bias",), None, 0.15), ExplanationOdds((), 0.5, 0.05),
    )  # fmt: skip
    (words,) = kind_report.explanations_in_words(diagnosed(None, explanations=odds))
    assert plain(words).endswith(
        " are now: drag bias 80.0 % (was 50.0 %), lift bias 15.0 %, none of them 5.0 % (was 50.0 %)."
    )
    assert not list(kind_report.explanations_in_words(diagnosed(None, explanations=odds[1:2])))
    assert [plain(kind_report.percent(each)) for each in (0.9995, 0.998, 0.002, 0.0005)] == [
        "> 99.9 %",
        "99.8 %",
        "0.2 %",
        "< 0.1 %",
    ]


@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        ("compass-bias", "compass-bias", "Second."),
        ("compass-bias", "speed-scale", "First. Second."),
        ("mean-current", "mean-current", "First. Second."),
    ],
)
def test_what_two_data_sets_find_of_the_vehicle_is_told_once(first, second, told, monkeypatch) -> None:
    """The second began with what the first had found; a current is another elsewhere."""
    monkeypatch.setattr(findings, "finding_in_words", lambda each: each.words)
    pair = tuple(
        diagnosed(None, words=words, causes=(cause,), changed=(), borne_out=(), learned_from=(words,), levels=())
        for words, cause in (("First.", first), ("Second.", second))
    )
    found: Any = SimpleNamespace(
        provenance=SimpleNamespace(options={"plan": True}), diagnoses=pair, names=("a", "b"), informed_by={first: ("a",)}, shared=(),
        extended={"posterior": {"summary": {first: {"probability": 1.0}}}},
    )  # fmt: skip
    assert campaign.answer(found).startswith(f"{told} Together 2 data sets tell of")


def test_several_data_sets_are_told_with_what_they_share_and_what_stays_in_doubt(monkeypatch) -> None:
    monkeypatch.setattr(findings, "finding_in_words", lambda each: each.words)
    one, two = (
        diagnosed(
            None, words=words, causes=causes, changed=("drag-bias",), borne_out=confirmed, learned_from=new, levels=()
        )
        for words, causes, confirmed, new in (
            ("Same.", ("drag-bias", "lift-bias"), (), ("1", "2")),
            ("Same.", (), ("fix-error",), ("3",)),
        )
    )
    missions = tuple(Level(hash_of(each.learned_from), None, 0.0, 0.01, 0.9 * (each is two)) for each in (one, two))
    two.levels = (ParameterLevels("speed-scale", "fraction", "", missions, 0.0, 0.01, 0.1, 0.0, 0.01),)
    chances = {"drag-bias": 0.94, "lift-bias": 0.96, "fix-error": 0.04, "leeway": 0.06}
    found: Any = SimpleNamespace(
        provenance=SimpleNamespace(options={"plan": True}), diagnoses=(one, two), names=("a", "b"), informed_by={"drag-bias": ("a", "b"), "leeway": ("b",)}, shared=("drag-bias",),
        extended={"posterior": {"summary": {name: {"probability": chance} for name, chance in chances.items()}}},
    )  # fmt: skip
    assert plain(campaign.answer(found)) == (
        "Same. Together 2 data sets tell of drag bias, leeway; one extended mission carries it all. More than one of them "
        "bore on drag bias. Fraction of speed scale jumped before b, to 0.0 ± 1.0 %. Still in doubt: drag bias 94.0 %, "
        "leeway 6.0 %."
    )
    assert campaign._rows(found) == [
        ["a", "transit", "explained", "drag bias (changed), lift bias", "–"], ["b", "transit", "explained", "–", "fix error"],
    ]  # fmt: skip
    found.shared = ()
    assert " No two of them bore on the same effect." in campaign.answer(found)
    found.informed_by = {"tidal-current": ("a",), "leeway": ("b",)}
    assert "the extended mission carries all but tidal current, which" in campaign.answer(found)
    found.informed_by, two.levels = {}, ()
    two.verdict = "unexplained"
    assert campaign.answer(found) == "No cause of the catalogue explains what is left in b."
    two.verdict = "adequate"
    assert campaign.answer(found).endswith("adequate for both data sets: none asks for a cause.")
    one.suspect_labels = "Dives 1 and 2 look exchanged."
    assert campaign.answer(found).startswith("a: Dives 1 and 2 look exchanged. The mission's model is adequate")
    one.learned_from = two.learned_from = ()
    assert campaign.answer(found).endswith(
        "Nothing new: the mission has learned from all of these data, which count once."
    )
    assert [row[2] for row in campaign._rows(found)] == ["nothing new"] * 2
    one.learned_from, one.nothing, one.verdict = ("1",), 0.2, "adequate"
    assert [row[2] for row in campaign._rows(found)] == ["open", "nothing new"]
    assert "that one asks for a cause has a probability of 80.0 %, too little to claim a cause" in campaign.answer(
        found
    )


def test_a_mission_that_is_adequate_is_planned_on_with_what_is_known_of_it(monkeypatch) -> None:
    for name in ("_plan_on", "next_trial_pointer"):
        monkeypatch.setattr(page, name, lambda _: [])
    found = diagnosed(
        None, learned_from=("a",), next_trial=None, next_measurements=(), outlying_groups=(("leg 3", 0.0012),),
        verdict="adequate",
    )  # fmt: skip
    check, keep = page._next_words(found)
    assert "does not predict: leg 3 (p = 0.001)." in check
    assert keep == page._KEEP
    found.verdict = "unexplained"
    assert page._next_words(found)[1].startswith("Look for what changed; on this evidence")
    found.discrepancy = SimpleNamespace(axis="heading")
    assert page._next_words(found)[1].startswith("Look for what changed along heading; on this evidence")
    found.suspect_labels = "Dives 1 and 2 look exchanged."
    assert len(page._next_words(found)) == 1
    found.learned_from = ()
    assert page._next_words(found)[0].startswith("Plan on with the mission as it is")


def test_a_current_s_deviation_is_that_of_its_length() -> None:
    east, north = (
        ParameterEstimate("mean-current", name, value, sd, 0.0, 0.0, "m/s")
        for name, value, sd in (("east", 0.3, 0.01), ("north", 0.0, 0.1))
    )
    finding = findings.CATALOGUE["mean-current"].finding
    assert "0.300 ± 0.010 m/s toward 90°" in plain(findings.sized_clause(finding, {"east": east, "north": north}))


def test_what_is_exact_has_no_deviation_and_little_is_not_said_to_be_nothing() -> None:
    exact = ParameterEstimate("compass-bias", "angle", 0.05, 0.0, 0.05, 0.05, "rad")
    assert plain(evidence.sized(exact)) == "2.865°"
    assert plain(evidence.sized(replace(exact, sd=0.01))) == "2.9° ± 0.6°"
    assert plain(evidence.sized(replace(exact, unit="m/s"))) == "0.05 m/s"
    assert [plain(kind_report.part(each)) for each in (0.0, 0.004, 0.006, 1.0)] == [
        "0 %",
        "< 1 %",
        "1 %",
        "> 99 %",
    ]


@pytest.mark.parametrize(
    ("skill", "words"),
    [
        (0.998, "> 99 % better than the last dive would"),
        (-0.9, "90 % worse than the last dive would"),
        (-1.0, "2.0 times the error that the last dive would give"),
    ],
)
def test_a_skill_is_told_as_what_it_is(skill, words) -> None:
    assert plain(scoring._against(skill, "dive")) == words


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ((), "drag bias and added mass"),
        (("drag-bias",), "drag bias and added mass"),
        (("drag-bias", "added-mass", "speed-scale"), "a change of drag bias and added mass"),
    ],
)
def test_a_change_is_claimed_where_the_mission_has_each_of_the_causes(monkeypatch, changed, what) -> None:
    monkeypatch.setattr(page, "finding_in_words", lambda _: "")
    readings = SimpleNamespace(families=((("drag-bias", "added-mass"), ("speed-scale",)),))
    found = diagnosed(ranked("drag-bias", "added-mass"), changed=changed, readings=readings)
    assert plain(page._claim(found)) == f"The misfit is explained by {what}."
    found.ranking = (*found.ranking, ranked("speed-scale", posterior=0.2))
    turns = " Whether this current turns, the record cannot show: drag bias and added mass 75.0 %, speed scale 20.0 %."
    assert plain(page._claim(found)) == f"The misfit is explained by {what}.{turns}"


ANGLE = ParameterEstimate("compass-bias", "angle", -0.0349, 0.01, -0.0349, -0.0349, "rad")
TURNED = TakenAsExact("the headings are true", "2° more", ANGLE, (), True)
MOVED = replace(TURNED, likeliest=("compass-bias",), turns=False)
SLOW = replace(MOVED, what="the clock runs right", moves=replace(ANGLE, value=0.001))
UNCLAIMED = replace(SLOW, moves=None)


@pytest.mark.parametrize(
    ("exact", "heading", "headline"),
    [
        ((), None, ""),
        ((SLOW, UNCLAIMED), "None of what this takes as exact could turn it", ""),
        (
            (MOVED, SLOW),
            "This takes as exact that the headings are true: 2° more moves the angle of compass bias by 2.00°",
            "",
        ),
        (
            (TURNED, MOVED, SLOW),
            "1 of what this takes as exact could turn it",
            " But this takes as exact that the headings are true: with 2° more no cause is likelier.",
        ),
    ],
)
def test_what_is_taken_as_exact_stands_beside_what_it_is_worth(exact, heading, headline) -> None:
    shown = diagnosed(ranked("compass-bias"), exact=exact)
    assert evidence.exact_in_words(shown) == headline
    assert [plain(section.heading) for section in evidence.exact_section(shown)] == ([heading] if heading else [])
    for (section,) in [evidence.exact_section(shown)] if exact else []:
        told = {row[0]: [plain(cell) for cell in row[1:]] for row in section.blocks[0].rows}
        assert told["the clock runs right"][1] in ("angle of compass bias by 0.057°", "")
        assert told.get("the headings are true", ["", "", "3.5"])[2] == "3.5"
