"""The page of `sweep-transition` by hand: its tables and figures have the runs' own numbers."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from missionplan.studies import sweep_transition
from missionplan.studies import transition_page as pages
from missionplan.studies.sweep_transition import FORCE, PAIR, SUCTION, TimeHistory, TransitionSweep

SPEEDS, STEEPNESSES, DECELERATIONS = (0.4, 0.7, 1.0), (0.05, 0.1, 0.2), (0.01, 0.02)


def run(number, variant, deceleration, steepness, speed):
    return {"variant": variant, "deceleration_m_s2": deceleration, "steepness_m_s": steepness, "mid_speed_m_s": speed,
            "depth_excursion_m": 0.1 + 0.01 * number, "pitch_excursion_rad": 0.02 + 0.001 * number, "hover_time_s": 100.0 + number,
            "hover_pitch_rad": 0.001 * number, "energy_common_wh": 5.0 + abs(number - 31.0), "energy_to_hover_wh": 3.0 + number,
            "energy_out_of_range": 0.0002 * number}  # fmt: skip


RUNS = [
    run(number, *values)
    for number, values in enumerate(
        (v, d, s, u) for v in (FORCE, SUCTION, PAIR) for d in DECELERATIONS for s in STEEPNESSES for u in SPEEDS
    )
]
OWN = [each for each in RUNS if each["variant"] == FORCE and each["deceleration_m_s2"] == 0.02]


def history(label):
    t = np.arange(-30.0, 300.0, 10.0)
    return TimeHistory(label, t, np.maximum(1.5 - 0.005 * (t + 30.0), 0.0), 0.001 * t, -0.01 * t, -0.002 * t)


@pytest.fixture
def result():
    shuffled = pd.DataFrame(RUNS).sample(frac=1.0, random_state=3)
    hover = {"thrust_n": 9.0, "revolutions_per_s": 12.345, "power_w": 87.6, "pair_power_w": 140.4}
    return TransitionSweep(SimpleNamespace(file="m.yaml", options={"phase": "slow"}), shuffled, 0.02, history("none"), 0.8321,
                           tuple(history(f"{u}") for u in SPEEDS), tuple(history(f"{s}") for s in STEEPNESSES),
                           tuple(history(v) for v in (FORCE, SUCTION, PAIR)), hover)  # fmt: skip


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def test_energies_are_of_the_variant_the_deceleration_and_the_option(result):
    for option, key in (("a", "energy_common_wh"), ("b", "energy_to_hover_wh")):
        table = result.energy(FORCE, option)
        for each in OWN:
            assert table.loc[each["mid_speed_m_s"], each["steepness_m_s"]] == each[key]
    least = min(OWN, key=lambda each: each["energy_common_wh"])
    assert result.best["mid_speed_m_s"] == least["mid_speed_m_s"]
    assert result.best["energy_common_wh"] == least["energy_common_wh"]
    assert (result.runs, len(result.rows)) == (54, 54)
    table = pages.energy_table(result)
    assert [plain(each) for each in table.columns] == ["mid-transition speed", "0.05 m/s", "0.1 m/s", "0.2 m/s"]
    assert [plain(row[0]) for row in table.rows] == ["0.4 m/s", "0.7 m/s", "1 m/s"]
    assert [[float(each) for each in row[1:]] for row in table.rows] == result.energy(FORCE, "a").to_numpy().tolist()


def test_energy_until_all_hover_is_none_where_one_of_a_set_never_does(result, monkeypatch):
    """A thruster draws to the end of a run that never hovers: that is no energy of a transition."""
    monkeypatch.setattr(sweep_transition, "energy_until", lambda history, until: 3600.0 * until)
    runs = object.__new__(sweep_transition.GridRuns)
    rest = dict.fromkeys(("depth_excursion", "pitch_excursion", "hover_pitch", "energy_to_hover", "out_of_range"), 0.0)
    hover = np.array([10.0, 20.0, 30.0, np.nan])
    runs._shape, runs._points = (1, 2, 2), np.zeros((3, 4))
    runs._record = SimpleNamespace(hover_time=hover, end_time=99.0, history=None, **rest)
    np.testing.assert_equal(runs.table(FORCE)["energy_common_wh"].to_numpy(), [20.0, 20.0, np.nan, np.nan])
    late = result.cells.assign(
        energy_common_wh=result.cells["energy_common_wh"].where(result.cells["steepness_m_s"] > 0.15)
    )
    some = TransitionSweep(**{**vars(result), "cells": late})
    assert some.best["steepness_m_s"] == 0.2
    assert {row[3] for row in pages._cells(some)[1]} == {"never"}
    assert {row[1] for row in pages.energy_table(some).rows} == {"–"}


def test_words_and_tables(result):
    best = min(OWN, key=lambda each: each["energy_common_wh"])
    words = plain(pages.answer(result))
    assert words.startswith("Without thrusters the vehicle cannot hold depth below 0.83 m/s.")
    assert f"{best['energy_common_wh']:.1f} W h, at a mid-transition speed of {best['mid_speed_m_s']:g} m/s" in words
    assert words.endswith(f"by up to {best['depth_excursion_m']:.2f} m.")
    never = TransitionSweep(**{**vars(result), "saturation_speed": math.nan})
    assert "holds depth at all speeds tried" in pages.answer(never)
    late = result.cells.assign(hover_time_s=result.cells["hover_time_s"].where(result.cells["mid_speed_m_s"] > 0.5))
    sinks = TransitionSweep(**{**vars(result), "cells": late})
    assert pages.answer(sinks).endswith("With one tunnel thruster it hovers in 6 of 9 runs.")
    even = TransitionSweep(**{**vars(result), "cells": result.cells[result.cells["steepness_m_s"] < 0.15]})
    assert len(pages._cells(even)[1]) == len(SPEEDS)
    told = {name: plain(value) for name, value in pages._numbers(result)}
    depths = [each["depth_excursion_m"] for each in OWN]
    assert told == {
        "Hover": "12.35 rev/s, 88 W",
        "Hover with a pair": "140 W",
        "Depth excursion": f"{min(depths):.2f} to {max(depths):.2f} m",
    }
    for row, variant in zip(pages.variant_table(result).rows, (FORCE, SUCTION, PAIR), strict=True):
        own = (
            pd.DataFrame([each for each in RUNS if each["variant"] == variant and each["deceleration_m_s2"] == 0.02])
            .drop(columns="variant")
            .mean()
        )
        numbers = [float(plain(cell).split()[0].rstrip("°")) for cell in row[1:]]
        assert row[0] == variant
        expected = [
            own["depth_excursion_m"],
            math.degrees(own["pitch_excursion_rad"]),
            math.degrees(own["hover_pitch_rad"]),
            own["energy_common_wh"],
        ]
        assert numbers == pytest.approx(expected, abs=0.051)
    rows = pages._cells(result)[1]
    middle = sorted((each for each in OWN if each["steepness_m_s"] == 0.1), key=lambda each: each["mid_speed_m_s"])
    for row, each in zip(sorted(rows), middle, strict=True):
        assert [plain(cell) for cell in row] == [
            f"{each['mid_speed_m_s']:g} m/s", f"{each['depth_excursion_m']:.2f} m", f"{math.degrees(each['pitch_excursion_rad']):.1f}°",
            f"{each['energy_common_wh']:.1f} W h", f"{each['energy_to_hover_wh']:.1f} W h",
        ]  # fmt: skip
    assert f"At most {100.0 * max(each['energy_out_of_range'] for each in RUNS):.1f} %" in pages._limits(result)


def test_histories_rise_and_pitch_against_time(result):
    shown = [t for t in history("").time if 0.0 <= t <= 260.0]
    for draw, factor in ((pages.rise, 0.01), (pages.pitch, math.degrees(0.001))):
        for by_steepness, labels in ((False, SPEEDS), (True, STEEPNESSES)):
            axes = Figure().add_subplot()
            draw(axes, result, by_steepness=by_steepness)
            assert [line.get_label() for line in axes.get_lines()] == [f"{each}\u00a0m/s" for each in labels]
            for line in axes.get_lines():
                assert np.array(line.get_data()) == pytest.approx(np.array([shown, factor * np.array(shown)]))
    axes = Figure().add_subplot()
    pages.draw_energy(axes, result, "b")
    for line, steepness in zip(axes.get_lines(), STEEPNESSES, strict=True):
        own = {each["mid_speed_m_s"]: each["energy_to_hover_wh"] for each in OWN if each["steepness_m_s"] == steepness}
        assert np.array(line.get_data()).tolist() == [list(own), list(own.values())]


def test_the_run_without_thrusters_is_marked_where_its_sternplane_is_at_its_limit(result, monkeypatch):
    seen = {}
    monkeypatch.setattr(pages, "to_figure", lambda figure, *words: seen.update(figure=figure))
    pages.unassisted_figure(result)
    angles, depth = seen["figure"].axes
    track = history("")
    shown = (track.time >= -20.0) & (track.speed > 0.2)
    pitch, sternplane, mark = (np.array(line.get_data(), dtype=float) for line in angles.get_lines())
    assert pitch == pytest.approx(np.array([track.time[shown], np.degrees(track.pitch[shown])]))
    assert sternplane[1] == pytest.approx(np.degrees(track.sternplane[shown]))
    assert mark[0][0] == min(t for t, speed in zip(track.time, track.speed, strict=True) if speed < 0.8321)
    assert np.array(depth.get_lines()[0].get_data())[1] == pytest.approx(-track.depth[shown])
    pages.pitch_by_variant(result)
    (axes,) = seen["figure"].axes
    assert [line.get_label() for line in axes.get_lines()] == [FORCE, SUCTION, PAIR]
    t = track.time[track.time >= 0.0]
    assert np.array(axes.get_lines()[2].get_data()) == pytest.approx(np.array([t, np.degrees(0.001 * t)]))
