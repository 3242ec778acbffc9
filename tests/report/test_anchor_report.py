from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from missionplan.mission import load
from missionplan.phases.mooring import descent
from missionplan.report.anchor import drawing, figures, sections
from missionplan.report.anchor.figures import draw_drag
from missionplan.report.anchor.page import answer, page
from missionplan.report.anchor.sections import drag
from missionplan.report.page import draw, drawing_by
from missionplan.report.render import terminal_view
from missionplan.report.wording import percent
from missionplan.results.anchor_sizing import ExplainedAnchor, ProbableAnchor
from missionplan.studies.anchor import size_anchor

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.fixture(scope="module")
def sizing(sized):
    return sized.result


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
    first = "Nothing to build yet: first pull such an anchor over the site's bottom (vehicle.anchor.holding_factor); "
    assert words.startswith(
        f"{first}as the mission stands, an anchor of {probable.wet_weight:.1f} N wet, {probable.design.dry_mass:.2f} kg dry, "
    )
    assert "of dives stay within 22.9 m and clear of the bottom. The worst-case anchor of Eq. 1, 11.7 N" in words
    worst = answer(replace(sizing, probable=None, judged=None)).replace("\u00a0", " ")
    assert worst.startswith(
        "An anchor of 11.7 N wet, 1.60 kg dry, 183 mm long, ring of 0.39 kg at 107 mm: at the seafloor 19 s after "
        "separation, 20 m from the last fix; the vehicle stops 1.7 m above the bottom. "
    )
    assert worst.endswith(
        "of dives stay within 22.9 m and clear of the bottom. With an assumed holding factor of 0.4 the anchor to build "
        "would drag in the mean current, 0.90 m/s, which is not counted."
    )


@pytest.mark.parametrize(("heavier", "verdict"), [(1.3, "undecided"), (1.01, "good")])
def test_an_anchor_that_another_explanation_would_have_heavier_is_none_to_build_yet(sizing, heavier, verdict):
    good, weight = sizing.to_build.probabilities.good, sizing.to_build.wet_weight
    doubts = tuple(ExplainedAnchor((), 0.5, good, needed) for needed in (weight, heavier * weight))
    found = replace(sizing, explanations=doubts, judged=None, held=None)
    assert page(found).verdict == verdict
    assert answer(found).startswith("Nothing to build yet: first find out which explanation holds;") == (
        verdict != "good"
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
    assert page(replace(sizing, held=replace(sizing.held, friction_assumed=False))).verdict == "good"
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


def test_an_anchor_lighter_than_the_buoyancy_is_told_and_drawn_without_a_dive(tmp_path, monkeypatch):
    monkeypatch.setattr(descent, "MIN_MEAN_SPEED", 1.0)  # it never comes down, and need not be waited for
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


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def test_the_table_has_the_numbers_of_each_anchor_in_its_units(sizing):
    columns, rows = sections.numbers_table(sizing)
    assert columns == ["", "Worst case", "90 %"]
    told = {label: [plain(cell) for cell in cells] for label, *cells in rows}
    for number, anchor in enumerate((sizing.anchor, sizing.probable.anchor)):
        design, record = anchor.design, anchor.profile.record
        expected = {
            "Wet weight": f"{anchor.wet_weight:.2f} N", "Terminal velocity sized for": f"{anchor.terminal_velocity:.3f} m/s",
            "Dry mass = displaced mass": f"{design.dry_mass:.4f} kg", "Flooded mass": f"{design.flooded_mass:.3f} kg",
            "Length": f"{1e3 * design.length:.1f} mm", "Tube length C": f"{1e3 * design.cylinder_length:.2f} mm",
            "Trim ring's mass": f"{design.trim_mass:.4f} kg", "Trim ring from the tip": f"{1e3 * design.trim_position:.1f} mm",
            "Centre of gravity from the tip": f"{1e3 * design.centre_of_gravity:.1f} mm",
            "Centre of buoyancy from the tip": f"{1e3 * design.centre_of_buoyancy:.1f} mm",
            "Separation to touchdown": f"{record.descent_time[0]:.2f} s", "of which until the line is taut": f"{record.payout_time[0]:.2f} s",
            "Terminal velocity of the dive": f"{record.terminal_velocity[0]:.3f} m/s", "Speed at touchdown": f"{record.touchdown_speed[0]:.3f} m/s",
            "Anchor from the last fix": f"{record.offset_distance[0]:.2f} m", "Vehicle's lowest altitude": f"{record.lowest_altitude[0]:.2f} m",
            "Dives that succeed": plain(percent(anchor.probabilities.good)),
        }  # fmt: skip
        assert {label: told[label][number] for label in expected} == expected


def test_the_dive_s_stages_are_told_at_their_times(sizing):
    profile, frame = sizing.anchor.profile, sizing.descent_frame()
    stages = profile.stages
    assert sizing.anchor.nominal.time == pytest.approx(
        stages["touchdown"] - sizing.anchor.nominal.release_time, abs=1e-6
    )
    for t, name in zip(frame["t_s"], frame["stage"], strict=True):
        ended = [each for each, end in stages.items() if end <= t]
        names = ["release", "pay-out wait", "free fall", "pull-down", "coasting", "rise to the line's length"]
        assert name == names[len(ended)]
    down = frame[frame["t_s"] <= stages["touchdown"]].iloc[-1]
    assert down["anchor_depth_m"] == pytest.approx(sizing.depth, abs=0.2)
    assert np.hypot(down["anchor_east_m"], down["anchor_north_m"]) == pytest.approx(
        sizing.anchor.nominal.offset, abs=0.2
    )
    numbers = sizing.to_frame().set_index("quantity")
    assert numbers.loc["wet_weight_n"].tolist() == [sizing.anchor.wet_weight, sizing.probable.anchor.wet_weight]
    assert numbers.loc["drag_total_n", "worst_case"] == float(sizing.anchor.drag.total)
    assert numbers.loc["descent_offset_m", "probable"] == sizing.probable.anchor.nominal.offset


def test_bars_of_the_drag_stand_beside_each_other_and_add_up(sizing):
    axes, anchor = Figure().add_subplot(), sizing.anchor
    draw_drag(axes, anchor)
    spans = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in axes.patches]
    assert spans[0][0] == 0.0
    assert all(before[1] == pytest.approx(after[0]) for before, after in pairwise(spans))
    assert spans[-1][1] == pytest.approx(float(anchor.drag.total)) == pytest.approx(anchor.wet_weight, rel=1e-3)
    widths = dict(zip([label.get_text() for label in axes.get_yticklabels()], [b - a for a, b in spans], strict=True))
    assert widths["Anchor"] == pytest.approx(float(anchor.drag.anchor))
    assert widths["Hull"] == pytest.approx(float(anchor.drag.body))
    built = sizing.to_build.drag
    part = float(built.anchor / built.total)
    assert (
        plain(drag(sizing).heading)
        == f"The vehicle makes {100 * (1 - part):.0f} % of the drag, the anchor {100 * part:.0f} %"
    )


def test_the_drift_ends_at_the_anchor_within_the_radius(sizing, monkeypatch):
    seen = {}
    monkeypatch.setattr(figures, "to_figure", lambda figure, *words, **more: seen.update(figure=figure))
    figures.drift_figure(sizing)
    (plan,) = seen["figure"].axes
    record, profile = sizing.to_build.profile.record, sizing.to_build.profile
    (circle,) = (patch for patch in plan.patches if hasattr(patch, "radius"))
    assert circle.radius == sizing.radius
    anchor, vehicle, cross = (np.array(line.get_data(), dtype=float) for line in plan.get_lines()[1:4])
    assert cross.ravel() == pytest.approx(record.offset[:, 0])
    until = np.count_nonzero(profile.time <= profile.stages["touchdown"])
    assert anchor == pytest.approx(profile.anchor_track[:, :until])
    assert vehicle == pytest.approx(profile.vehicle_track[:, :until])


def test_tube_back_and_ring_are_drawn_as_thick_as_their_masses_make_them(sizing):
    """Hollow cylinders cut lengthwise, in mm: the tube out to the anchor's radius, what is in it out to its wall."""
    design, axes = sizing.to_build.design, Figure().add_subplot()
    drawing._draw_parts(axes, design)
    made, radius = design.problem.construction, design.problem.radius
    spans = [patch.get_bbox().extents for patch in axes.patches if isinstance(patch, Rectangle)]
    upper, lower = 1e-3 * np.array(spans[::2]), 1e-3 * np.array(spans[1::2])
    long, (inner, outer) = upper[:, 2] - upper[:, 0], np.sort(upper[:, [1, 3]].T, axis=0)
    assert np.sort(lower[:, [1, 3]].T, axis=0) == pytest.approx(np.stack((-outer, -inner)))
    assert outer == pytest.approx([radius, inner[0], inner[0]])
    densities = np.array([made.tube_density, made.back.density, made.trim_density])
    masses = [made.tube_mass_per_length * long[0], made.back.mass, design.trim_mass]
    assert densities * 2.0 * np.pi * outer * (outer - inner) * long == pytest.approx(masses)


@pytest.mark.parametrize(
    ("tied", "words"), [(None, "each body drifts with its layer"), ("tied", "the line ties the drift of both bodies")]
)
def test_the_drift_is_said_to_be_tied_where_the_line_ties_it(sizing, tied, words):
    anchor = sizing.to_build
    built = SimpleNamespace(profile=anchor.profile, nominal=anchor.nominal, dive=SimpleNamespace(tied=tied))
    figure = figures.drift_figure(SimpleNamespace(to_build=built, radius=sizing.radius))
    assert figure.caption.startswith(f"The nominal dive from above, with the mean currents: {words}.")


def test_words_of_the_worst_case_and_of_why_none_does(sizing):
    layers = plain(sections._layers_in_words(sizing))
    for layer in sizing.layers:
        assert f"{layer.thickness:.1f} m at {layer.speed:.2f} m/s" in layers
    assert f"requires {sizing.required_velocity:.3f} m/s downward" in layers
    none = ProbableAnchor(0.99, None, "the line is too short", 12.0, 0.5, line_length=7.25, line_anchor_weight=13.46)
    (section,) = sections.probable(replace(sizing, probable=none))
    assert [plain(each) for each in section.blocks] == [
        "The line is too short.",
        f"A line of 7.2 m, instead of {sizing.line_length:.1f} m, with an anchor of 13.5 N would do.",
    ]
    worst, found = sizing.anchor, replace(sizing.anchor, wet_weight=sizing.anchor.wet_weight - 1.26)
    heavier = replace(worst, wet_weight=worst.wet_weight + 1.26)
    for anchor, than in ((found, "1.3 N lighter"), (heavier, "1.3 N heavier")):
        (section,) = sections.probable(replace(sizing, probable=replace(none, anchor=anchor)))
        assert f"{than} than the worst-case anchor" in plain(section.blocks[0])
