"""What the page's script reads off a figure is what was drawn: numbers, units, names, and the place on earth."""

import json
import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.mission.schema.place import Geographic, to_geographic
from missionplan.report.axes import draw_in_units, name_axis
from missionplan.report.readings import Shown, Slider, name_series, readings


def read(figure, series=None, shown=None):
    (panel, *_), found = (told := json.loads(readings(figure, series or {}, shown or Shown())))["axes"], told
    return panel, found


def test_each_corner_of_a_large_map_lies_where_it_is_on_earth():
    figure = Figure()
    axes = figure.add_subplot(aspect=1.0)
    axes.set(xlim=(-3000.0, 12000.0), ylim=(5000.0, 9000.0))
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    draw_in_units([axes])
    origin = math.radians(37.0), math.radians(-76.0)
    panel, _ = read(figure, shown=Shown(origin=origin))
    assert panel["x"] == {"lim": [-3.0, 12.0], "log": False, "label": "east (km)"}
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    for east in axes.get_xlim():
        for north in axes.get_ylim():
            told = [zero + dx * east / 1e3 + dy * north / 1e3 for zero, dx, dy in panel["earth"]]
            assert told == pytest.approx(np.degrees(to_geographic(east, north, place)), abs=2e-4)


def test_bars_tell_what_they_are_long_and_bins_their_ends_and_height():
    figure = Figure(figsize=(4.0, 2.0))
    axes = figure.add_axes((0.25, 0.1, 0.5, 0.3))
    axes.barh([0, 1], [30.0, -45.5], left=[10.0, 60.0], height=0.8)
    axes.set_yticks([0, 1], ["lost", "left\nover"])
    axes.set(xlim=(0.0, 100.0), xlabel="share (%)")
    axes.stairs([2.0, 3.0], [0.0, 1.5, 4.0])
    panel, _ = read(figure)
    assert panel["box"] == pytest.approx([72.0, 0.6 * 144.0, 144.0, 0.3 * 144.0], abs=0.06)
    told = [bar["text"].replace("\u00a0", " ") for bar in panel["bars"]]
    assert told == ["lost: 30 %", "left over: −45.5 %", "0 to 1.5 %: 2", "1.5 to 4 %: 3"]
    assert panel["bars"][0]["ends"] == [10.0, 40.0, -0.4, 0.4]
    assert panel["bars"][1]["ends"] == [14.5, 60.0, 0.6, 1.4]


def test_named_curves_and_points_are_told_and_series_switched_by_their_ids():
    figure = Figure()
    axes = figure.add_subplot(xlabel="leg (m)", ylabel="time", yscale="log")
    axes.plot([1.0, 2.0, np.nan, 4.0], [1.0, 2.0, 3.0, 4.0], label="mean")
    axes.plot([1.0, 2.0, 3.0], [5.0, 5.0, 5.0], label="goal")
    axes.plot([1.0, 2.0, 3.0], [6.0, 6.0, 6.0])  # of no name, beside named ones
    axes.plot([7.0], [8.0], "o")
    series = name_series(figure)
    slider = Slider("leg", [1.0, 2.0], ["short", "long"], 1)
    panel, found = read(figure, series, Shown(slider))
    assert [(line["name"], line["points"]) for line in panel["lines"]] == [
        ("mean", [[1.0, 1.0], [2.0, 2.0], [4.0, 4.0]]),
        ("goal", [[1.0, 5.0], [2.0, 5.0], [3.0, 5.0]]),
        ("", [[7.0, 8.0]]),
    ]
    assert (panel["x"]["log"], panel["y"]["log"]) == (False, True)
    assert [each["name"] for each in found["series"]] == ["mean", "goal"]
    assert found["series"][1]["ids"] == [axes.lines[1].get_gid()]
    assert found["slider"] == {"label": "leg", "x": [1.0, 2.0], "text": ["short", "long"], "start": 1}


def test_long_curves_are_thinned_evenly():
    figure = Figure()
    axes = figure.add_subplot(xlabel="t", ylabel="x")
    axes.plot(np.arange(601.0), np.arange(601.0))
    panel, _ = read(figure)
    assert panel["lines"][0]["points"][:3] == [[0.0, 0.0], [4.0, 4.0], [8.0, 8.0]]
    assert len(panel["lines"][0]["points"]) == 151
