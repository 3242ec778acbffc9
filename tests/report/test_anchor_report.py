from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from missionplan.mission import load
from missionplan.report.anchor.page import answer, page
from missionplan.report.anchor.sections import drag
from missionplan.report.drawn import draw, drawing_by
from missionplan.report.render import terminal_view
from missionplan.results.anchor_sizing import ProbableAnchor
from missionplan.studies.anchor.size_anchor import size_anchor

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def sizing():
    return size_anchor(load(MISSIONS / "anchor-design.yaml"), trials=100, probability=0.9)


def altered(tmp_path, mission=(), vehicle=()):
    (tmp_path / "vehicles").mkdir()
    for name, pairs in (("anchor-design.yaml", mission), ("vehicles/vt475-self-mooring.yaml", vehicle)):
        text = (MISSIONS / name).read_text()
        for old, new in pairs:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / name).write_text(text)
    return load(tmp_path / "anchor-design.yaml")


def test_the_sentence_that_a_field_engineer_wants(sizing):
    words, probable = answer(sizing).replace("\u00a0", " "), sizing.probable.anchor
    assert words.startswith(f"An anchor of {probable.wet_weight:.1f} N wet, {probable.design.dry_mass:.2f} kg dry, ")
    assert "of dives stay within 22.9 m and clear of the bottom. The worst-case anchor of Eq. 1, 11.7 N" in words
    worst = answer(replace(sizing, probable=None)).replace("\u00a0", " ")
    assert worst.startswith(
        "An anchor of 11.7 N wet, 1.60 kg dry, 183 mm long, ring of 0.39 kg at 107 mm: at the seafloor 19 s after "
        "separation, 20 m from the last fix; the vehicle stops 1.7 m above the bottom. "
    )
    assert worst.endswith(
        "of dives stay within 22.9 m and clear of the bottom. With an assumed holding factor of 0.4 the anchor to build "
        "would drag in the mean current, 0.90 m/s, which is not counted."
    )


def test_an_anchor_that_misses_the_radius_is_no_good_news(sizing):
    wide = replace(sizing, radius=10.0)
    assert page(wide).verdict == terminal_view(wide).verdict == "bad"


def test_a_requirement_that_no_anchor_meets_is_told(sizing):
    missed = replace(sizing, probable=ProbableAnchor(0.99, None, "the line is too short", 12.0, 0.5))
    assert not missed.succeeds
    assert answer(missed).startswith(
        "No anchor does 99\u00a0% of dives that succeed: the line is too short. An anchor of 11.7\u00a0N wet"
    )


def test_the_page_has_its_figures(sizing, tmp_path):
    sizing.save(tmp_path / "report")
    names = {path.stem for path in (tmp_path / "report" / "figures").iterdir()}
    assert names == {"anchor", "drag", "descent", "drift", "hold"}
    assert page(sizing).verdict == "undecided"  # it drags with a holding factor that is assumed
    assert page(replace(sizing, held=replace(sizing.held, friction_given=True))).verdict == "good"
    assert {"anchor.csv", "descent.csv"} <= {path.name for path in (tmp_path / "report").iterdir()}
    assert sizing.files()["anchor.csv"].splitlines()[0] == "quantity,worst_case,probable"
    frame = sizing.descent_frame()
    assert list(frame.columns[:2]) == ["t_s", "vehicle_depth_m"]
    assert set(frame["stage"]) == {"release", "free fall", "pull-down", "coasting", "rise to the line's length"}


def test_both_anchors_stand_in_the_table(sizing):
    columns, rows = page(sizing).table()
    assert list(columns) == ["", "Worst case", "90 %"]
    assert all(len(row) == 3 for row in rows)


def test_an_anchor_that_cannot_be_built_says_so_first(tmp_path):
    mission = altered(tmp_path, vehicle=[("mass: 0.7 kg", "mass: 0.9 kg")])
    shown = page(size_anchor(mission, trials=10))
    assert shown.verdict == "bad"
    assert "cannot be built" in shown.answer
    assert shown.sections[0].heading.startswith("Why it cannot be built")


def test_a_short_line_is_bad_news(tmp_path):
    shown = page(size_anchor(altered(tmp_path, mission=[("line_length: 5 m", "line_length: 2 m")]), trials=10))
    assert shown.verdict == "bad"
    assert "strikes the bottom" in shown.answer


def test_an_anchor_lighter_than_the_buoyancy_is_told_and_drawn_without_a_dive(tmp_path):
    light = [("design_current: [1.3 m/s, 1.13 m/s]", "design_current: [0.1 m/s, 0.1 m/s]")]
    sizing = size_anchor(altered(tmp_path, mission=light), trials=10)
    shown = page(sizing)
    assert shown.verdict == "bad"
    assert "carry_net_buoyancy" in sizing.notes[0]
    with drawing_by(draw):
        assert any(section.heading == "The anchor does not reach the seafloor" for section in shown.sections)
    assert sizing.summary()["descent"]["offset_m"] != sizing.summary()["descent"]["offset_m"]  # nan


def test_an_anchor_as_light_as_the_vehicle_is_buoyant_has_no_shares_of_a_drag():
    neutral = SimpleNamespace(to_build=SimpleNamespace(drag=SimpleNamespace(anchor=0.0, total=0.0)), notes=("a note",))
    section = drag(neutral)
    assert "no drag" in section.heading
    assert section.blocks == ["a note"]
