"""The box of what a probability holds: from the mission, on the page and in the summary."""

import re
from pathlib import Path

import pytest

import missionplan
from missionplan.mission import load
from missionplan.studies.coverage import checked_ranges, coverage_of, probability_holds

MISSIONS = Path(__file__).parents[2] / "missions"
TOPICS = ["ground", "coast", "wind", "waves", "traffic", "equipment", "biofouling", "operators"]


def box(mission):
    return {each.what: each for each in probability_holds(mission)}


def test_the_box_has_its_topics_and_says_why_each_matters_here(transit_mission):
    found = box(transit_mission)
    assert list(found) == TOPICS
    assert not any(each.held for each in found.values())
    assert found["coast"].why == "straight ways cross whatever lies between (site.land)"
    assert "27 m" in found["wind"].why  # 3 % of 10 m/s for 90 s
    assert "8 times" in found["traffic"].why


def test_time_under_way_has_its_surfacings_in_it(transit_mission):
    """As many of 90 s as there are legs."""
    whole = transit_mission.with_(d_max="100 km")
    times = [
        float(re.search(r"fail in (\d+\.?\d*) h, in still water", box(each)["equipment"].why)[1])
        for each in (whole, whole.with_({"navigation.surfacing_time": "3 h"}))
    ]
    assert times[1] - times[0] == pytest.approx(3.0, abs=0.1)


def test_a_mission_of_moorings_alone_has_words_of_its_own():
    """Without a transit and a time afloat nothing is said of zero metres, seconds or hours."""
    found = box(missionplan.load(MISSIONS / "anchor-design.yaml"))
    assert list(found) == TOPICS
    for each in found.values():
        assert not re.search(r"(^|[ (])0(\.0\d*)? ", each.why), each
        assert "running" not in each.why
    assert "30.5 m wherever the anchor comes down" in found["ground"].why
    assert "50 % of deep gliders do in 90 days" in found["equipment"].why
    held = missionplan.load(MISSIONS / "anchor-design.yaml").with_({"moor.hold": "14 days"})
    assert "10 % fail in 14 days" in box(held)["equipment"].why
    assert "in 14 days growth slows" in box(held)["biofouling"].why


def test_what_the_mission_gives_is_in(mission, transit_mission):
    raw = dict(transit_mission.raw)
    raw["vehicle"] = {
        "hull": {"length": "1 m", "diameter": "0.1 m"},
        "reliability": [{"per": "hour", "rate": "1e-4 1/h"}, {"per": "dive", "rate": 0.001}],
    }
    found = box(mission(raw))
    assert found["equipment"].held
    assert "hour, dive" in found["equipment"].why


def test_page_and_summary_have_it_and_the_headline_says_of_what_it_is(transit_mission, tmp_path):
    outcome = missionplan.simulate(transit_mission, trials=50)
    summary = outcome.summary()
    assert [each["what"] for each in summary["probability_holds"]] == TOPICS
    assert summary["decision"]["not_in_this_probability"] == TOPICS
    page = (outcome.save(tmp_path / "out") / "report.html").read_text()
    assert "What this answer does not hold" in page
    assert "of navigation and physics" in page


def test_a_mission_without_phases_has_none(tmp_path):
    (tmp_path / "m.yaml").write_text("name: nothing\n")
    assert probability_holds(load(tmp_path / "m.yaml")) == ()


def test_a_mission_is_held_against_the_ranges_in_which_the_models_were_checked(mission, transit_mission, tmp_path):
    found = {each.quantity: each for each in checked_ranges(transit_mission)}
    error = found["velocity error over speed"]
    assert error.is_inside
    assert error.least == error.greatest
    raw = dict(transit_mission.raw)
    raw["navigation"] = {**raw["navigation"], "velocity_error": {"sigma": "0.9 m/s"}}
    outcome = missionplan.simulate(mission(raw), trials=20)
    summary = outcome.summary()
    (outside,) = [each for each in summary["checked_ranges"] if not each["inside"]]
    assert outside["quantity"] == "velocity error over speed"
    assert "closed.transit-loop" in summary["rests_on"]
    page = (outcome.save(tmp_path / "out") / "report.html").read_text()
    assert "Where the model was checked: outside for velocity error over speed" in page


def test_missions_compared_share_a_box_and_differ_under_their_names(mission, transit_mission):
    raw = dict(transit_mission.raw)
    raw["vehicle"] = {
        "hull": {"length": "1 m", "diameter": "0.1 m"},
        "reliability": [{"per": "hour", "rate": "1e-4 1/h"}],
    }
    summary = missionplan.simulate(transit_mission, trials=50).summary()
    found = {each.what: each.held for each in coverage_of({"a": summary, "b": mission(raw)})}
    assert found["ground"] is False
    assert (found["equipment (a)"], found["equipment (b)"]) == (False, True)
    assert "equipment" not in found


def test_ranges_are_of_the_missions_numbers_by_hand():
    """Two ways of 1600 m at 1.5 m/s, each of legs of 350 m into a circle of 15 m; a mooring in 40 ft of two layers."""
    found = {each.quantity: (each.least, each.greatest) for each in checked_ranges(load(MISSIONS / "chesapeake.yaml"))}
    knot = 1852.0 / 3600.0
    assert found == {
        "velocity error over speed": pytest.approx((0.035 / 1.5, 0.035 / 1.5)),
        "longest leg over arrival radius": pytest.approx((350.0 / 15.0, 350.0 / 15.0)),
        "length of a transit": pytest.approx((1600.0, 1600.0)),
        "depth of a mooring": pytest.approx((12.192, 12.192)),
        "length of the line": (5.0, 5.0),
        "diameter of the line": (0.002, 0.002),
        "current during a dive": pytest.approx((0.2 * knot, 0.4 * knot)),
        "current at the seafloor": pytest.approx((0.2 * knot, 0.2 * knot)),
    }
    words = box(load(MISSIONS / "chesapeake.yaml"))
    assert "at the surface 10 times or more for 90 s" in words["traffic"].why  # 3200 m of 350 m each
    assert "running 2 m deep" in words["ground"].why
