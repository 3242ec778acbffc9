"""What the report of an import says of its legs and dives, read back from tables made by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from missionplan.report import imported
from missionplan.report.imported import leg_basis
from missionplan.report.quantities import reading_in
from missionplan.results.imported import Basis, LegPicture, LogFigures

NAN = math.nan
BASIS = Basis(5.0, 2.5, 0.7, "fixes", "true north, declination added", "logged", 900.0, 120.0)
DIVES = pd.DataFrame(
    [
        {
            "leg": 1, "ok": 1, "reason": "", "t_start": "2023-11-14T22:13:20Z", "t_end": "2023-11-14T22:43:20Z",
            "t_start_s": 1000.0, "t_end_s": 2800.0, "fix_before_by": "flag", "fix_before_sd_m": 3.6, "fix_after_by": "quality",
            "fix_after_sd_m": 7.4, "dr_by": "made", "dr_sd_m": 41.0, "dr_positions": 88, "lag_dr_end_s": 35.0, "covered": 0.876,
            "depth_readings": 77, "heading_readings": 66, "speed_readings": 55, "surface_s": 62.0, "depth_m": 12.4, "max_depth_m": 30.6,
            "gap_s": 24.0, "heading_deg": 123.4, "speed_m_s": 0.456, "error_m_s": 0.0321,
        },
        {
            "leg": 2, "ok": 0, "reason": "a gap in the log (300 s)", "t_start": "b", "t_end": "e", "t_start_s": 3000.0, "t_end_s": 6600.0,
            "fix_before_by": "neighbours", "fix_before_sd_m": NAN, "fix_after_by": "place", "fix_after_sd_m": NAN, "dr_by": "none",
            "dr_sd_m": NAN, "dr_positions": 0, "lag_dr_end_s": NAN, "covered": 0.0, "depth_readings": 0, "heading_readings": 0,
            "speed_readings": 0, "surface_s": 0.0, "depth_m": NAN, "max_depth_m": NAN, "gap_s": 300.0, "heading_deg": NAN,
            "speed_m_s": NAN, "error_m_s": NAN,
        },
    ]
)  # fmt: skip


def picture(row, reasons=()):
    t = np.array([-60.0, 0.0, 1800.0, 1860.0])
    places = np.array([[-3.0, 0.0, 500.0, 510.0], [1.0, 0.0, 300.0, 305.0]])
    return LegPicture(row, t, places, t[:1], places[:, :1], reasons, np.array([20.0, 1765.0]), np.array([[5.0, 480.0], [4.0, 350.0]]),
                      np.array([0.0, 900.0, 1740.0]), np.array([0.0, 30.0, 2.0]))  # fmt: skip


def result(dives=DIVES, kind="transit", **figures):
    ends = np.array([[[480.0, 9.0], [350.0, 9.0]], [[500.0, 8.0], [300.0, 8.0]]])
    lines = SimpleNamespace(
        leg_starts=np.zeros((2, 2)), leg_ends=ends, fixes=np.array([[0.0, 500.0], [0.0, 300.0]]),
        rejected=np.array([[600.0, 900.0], [100.0, 100.0]]), reckoned=(np.array([[0.0, 480.0], [0.0, 350.0]]), np.empty((2, 0))),
        depth_t=np.array([1000.0, 1900.0, 2740.0, 99_999.0]), depth=np.array([0.0, 30.0, 2.0, 7.0]),
    )  # fmt: skip
    numbers = {"max_depth": 30.6, "made_reckoning_sd": NAN, "velocity_error_mean_east": 0.0123, "velocity_error_mean_north": -0.0456,
               "velocity_error_sigma": 0.0789, "leg_length": 747.0, "leg_duration": 1740.0, "fix_sd": 3.54}  # fmt: skip
    return SimpleNamespace(
        kind=kind, dives=dives, basis=BASIS if kind == "transit" else None, reckoning="made from heading", counted=int(dives["ok"].sum()),
        lines=lines, figures=LogFigures(**{**numbers, **figures}), is_of_legs=kind == "transit", durations=(dives["t_end_s"] - dives["t_start_s"]).to_numpy(),
        sources=[1, 2, 3], format="moos", rejected_fixes=[1, 2], rejected_reasons={"no flag": 2}, passed_over=("x: y",),
    )  # fmt: skip


def plain(text):
    return text.replace("\u00a0", " ")


def test_the_table_of_all_legs():
    one, two = ([plain(cell) for cell in row] for row in leg_basis.basis_rows(DIVES, BASIS))
    assert one == ["1", "yes", "flag, 4 m", "quality, 7 m", "made ± 41 m", "depth", "12 m", "123 deg", "0.46 m/s"]
    assert two == ["2", "a gap in the log (300 s)", "neighbours", "no jump", "none", "the fix", "none", "none", "none"]
    with reading_in("imperial"):
        assert plain(leg_basis.basis_rows(DIVES, BASIS)[0][6]) == "41 ft"
    assert plain(leg_basis.common_words(BASIS)) == (
        "The surface is 2.5 m below what the gauge reads there, 0.7 m (by its depth at the fixes); a dive reaches 5.0 m. "
        "Headings: from true north, declination added. Speeds: logged. A leg lasts 15 min at least, with no gap in the log "
        "under water above 120 s."
    )


def test_what_one_leg_rests_on():
    told = {name: plain(words) for name, words in leg_basis.explained_rows(result(), picture(0, ("a", "b", "a")))}
    assert told == {
        "counts?": "yes",
        "fix before": "2023-11-14T22:13:20Z: valid by its flag; 3.6 m each axis",
        "fix after": "2023-11-14T22:43:20Z: good by its stated quality; 7.4 m each axis",
        "fixes left out near it": "2: a; 1: b",
        "dead reckoning": "made (made from heading): 88 positions, the last 35 s before the fix; in doubt by 41 m",
        "share of its time covered": "88 %",
        "surfaced": "62 s before the fix, where it came above the surface's depth",
        "depth": "mean 12.4 m, greatest 30.6 m, 77 readings",
        "longest gap under water": "24 s (120 s at most)",
        "heading": "123 deg on average, 66 readings, true north, declination added",
        "speed": "0.46 m/s by logged",
        "from fix to fix": "30.0 min (15 min at least)",
        "error": "58 m, 0.032 m/s over that time",
    }
    bare = {name: plain(words) for name, words in leg_basis.explained_rows(result(), picture(1))}
    assert bare["counts?"] == "no: a gap in the log (300 s)"
    assert bare["fix before"].endswith("confirmed by a good fix near in time; its accuracy is not stated")
    assert bare["dead reckoning"] == "none (made from heading): 0 positions"
    assert bare["surfaced"] == "at the fix: no depth was logged"
    assert bare["from fix to fix"] == "60.0 min (15 min at least)"
    assert not {"fixes left out near it", "depth", "heading", "speed", "error"} & set(bare)


def lines_by_label(axes):
    return {line.get_label(): np.array(line.get_data()) for line in axes.get_lines()}


def test_the_picture_of_a_leg_has_its_error_between_its_end_and_the_fix_after():
    axes = Figure().add_subplot()
    leg_basis.draw_places(axes, result(), picture(0))
    drawn = lines_by_label(axes)
    assert drawn["error"].tolist() == [[480.0, 500.0], [350.0, 300.0]]
    assert drawn["fix after"].tolist() == [[500.0], [300.0]]
    assert drawn["fix before"].tolist() == [[0.0], [0.0]]
    assert drawn["fixes left out"].tolist() == [[-3.0], [1.0]]
    axes = Figure().add_subplot()
    leg_basis.draw_times(axes, result(), picture(0))
    data = [np.array(line.get_data(), dtype=float) for line in axes.get_lines()]
    assert data[0].tolist() == [[0.0, 15.0, 29.0], [0.0, 30.0, 2.0]]
    assert data[1][1].tolist() == [2.5, 2.5]
    upright = sorted(float(each[0][0]) for each in data[2:] if each.shape == (2, 2) and each[0][0] == each[0][1])
    assert upright == pytest.approx([(1800.0 - 62.0) / 60.0, 1765.0 / 60.0])
    assert axes.yaxis_inverted()


def test_the_map_has_an_arrow_from_each_end_to_its_fix_in_the_map_s_unit():
    for factor, unit, word in ((1.0, 1.0, "m"), (20.0, 1000.0, "km")):
        found = result()
        for name in ("fixes", "rejected", "leg_ends"):
            setattr(found.lines, name, factor * getattr(found.lines, name))
        found.lines.reckoned = tuple(factor * each for each in found.lines.reckoned)
        axes = Figure().add_subplot()
        imported.draw_track(axes, found)
        (arrows,) = (each for each in axes.collections if hasattr(each, "U"))
        found_arrow = np.array([arrows.X, arrows.Y, arrows.U, arrows.V])
        assert found_arrow == pytest.approx(np.array([[480.0], [350.0], [20.0], [-50.0]]) * factor / unit)
        drawn = lines_by_label(axes)
        assert drawn["fixes"] == pytest.approx(found.lines.fixes / unit)
        assert drawn["fixes rejected"] == pytest.approx(found.lines.rejected[:, :1] / unit)  # the other is too far away
        assert axes.get_xlabel().endswith(f"({word})")


def test_rose_and_lengths_are_of_the_legs_that_count(monkeypatch):
    seen = {}
    monkeypatch.setattr(imported, "to_figure", lambda figure, *words, **more: seen.update(figure=figure, words=words))
    imported.histograms(result())
    left, right = seen["figure"].axes
    assert sum(bar.get_height() for bar in left.patches) == 1
    length = math.hypot(480.0, 350.0)
    (bar,) = (bar for bar in left.patches if bar.get_height())
    assert bar.get_x() <= length <= bar.get_x() + bar.get_width()
    (petal,) = (each for each in right.patches if each.get_height())
    assert petal.get_x() <= math.atan2(480.0, 350.0) <= petal.get_x() + petal.get_width()
    assert right.get_theta_direction() == -1
    assert right.get_theta_offset() == pytest.approx(math.pi / 2.0)
    imported.depth_figure(result())
    (axes,) = seen["figure"].axes
    drawn = np.array(axes.get_lines()[0].get_data())
    assert drawn == pytest.approx(np.array([[0.0, 0.25, 1740.0 / 3600.0], [0.0, 30.0, 2.0]]))
    assert seen["words"][1] == "Depth against time over 1.6 h."
    assert seen["words"][2].startswith("1 readings more than an hour")


def test_headlines_and_numbers_of_an_import():
    assert imported.answer(result()) == "1 of 2 dives between fixes count as legs; dead reckoning: made from heading."
    words = imported.answer(result(made_reckoning_sd=41.4))
    assert words.replace("\u00a0", " ").startswith(
        "The logs hold no dead reckoning: it was made from heading, and is in doubt by 41 m a leg (median)."
    )
    told = {name: plain(value) for name, value in imported._numbers(result())}
    assert told == {
        "Velocity error, each axis": "0.079 m/s about 0.012, −0.046 m/s",
        "Leg, median": "747 m in 29 min",
        "Fix, each axis": "3.5 m",
    }
    assert imported._dives_heading(result()) == "Every dive: 1 of 2 left out"
    assert imported._dives_heading(result(DIVES.assign(ok=1))) == "All 2 dives count"


def test_dives_of_a_depth_record_have_their_times_and_depths():
    dives = pd.DataFrame({"run": ["dive-1", "dive-2"], "t_start": ["2023-11-14T22:15:00.000+00:00"] * 2, "t_start_s": [0.0, 100.0],
                          "t_end_s": [44.5, 190.0], "max_depth_m": [20.04, 30.0], "ok": [1, 0], "reason": ["", "a gap"]})  # fmt: skip
    found = result(dives, "descent")
    table = imported._dives_table(found)
    assert [tuple(plain(cell) for cell in row) for row in table.rows] == [
        ("dive-1", "2023-11-14 22:15:00", "yes", "0.7", "20.0"),
        ("dive-2", "2023-11-14 22:15:00", "a gap", "1.5", "30.0"),
    ]
    assert imported.answer(found) == "1 of 2 dives count."
    with reading_in("imperial"):
        table = imported._dives_table(found)
        assert table.columns[-1] == "greatest depth (ft)"
        assert [float(row[-1]) for row in table.rows] == pytest.approx([20.04 / 0.3048, 30.0 / 0.3048], abs=0.6)


def test_points_are_shown_within_what_is_drawn_and_as_far_again():
    shown = np.array([[100.0, 104.0], [-7.0, -5.0]])
    points = np.array([[96.0, 95.9, 108.0, 108.1, 102.0, 102.0], [-9.0, -6.0, -3.0, -6.0, -9.1, -6.0]])
    assert leg_basis.inside(points, shown).tolist() == [[96.0, 108.0, 102.0], [-9.0, -3.0, -6.0]]
    assert leg_basis.inside(points, shown, margin=0.0).tolist() == [[102.0], [-6.0]]
    assert leg_basis.inside(points, np.empty((2, 0))).shape == (2, 0)
