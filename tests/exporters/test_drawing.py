"""The drawing of a plan's states: all of them, every guard, and no text over another or over a line."""

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest
from made_plans import PLANS
from matplotlib.textpath import TextPath

from missionplan.exporters.drawing import files
from missionplan.results.plan_states import ACTIONS, amount_in_si, states_of

SVG = "{http://www.w3.org/2000/svg}"


def around(plan):
    """By points on the way, with a battery, a name that is as long as names may be and numbers of many digits."""
    there, moor, home = plan.phases
    start, one, two, goal = there.waypoints
    by_points = replace(there, name="x" * 120, waypoints=(start, replace(one, is_via=True), two, goal))
    late = replace(moor, hold=9_876_543.0, galvanic_release=1_234_567.0, water_depth=math.nan)
    return replace(plan, phases=(by_points, late, home), capacity=123_456.789)


MADE = {**PLANS, "around": around(PLANS["west"])}


@pytest.fixture(params=MADE)
def drawn(request):
    plan = MADE[request.param]
    return plan, ElementTree.fromstring(files(plan, "trip")["trip.svg"])


@cache
def width_of(text, weight):
    """Width of a text, as a wide font sets it."""
    return TextPath((0, 0), text, size=12, prop={"weight": weight, "family": "DejaVu Sans"}).get_extents().width


def extent(text):
    """Left, top, right and bottom of a text."""
    x, y = float(text.get("x")), float(text.get("y"))
    width = width_of(text.text, text.get("font-weight", "normal"))
    left = x - width if text.get("text-anchor") == "end" else x
    return left, y - 9.0, left + width, y + 3.0


def over(one, two):
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


def test_no_text_lies_over_another_or_over_a_line(drawn):
    _, root = drawn
    texts = [text for text in root.iter(f"{SVG}text") if text.get("transform") is None]
    extents = [extent(text) for text in texts]
    assert not [
        (texts[i].text, texts[j].text) for i, j in combinations(range(len(texts)), 2) if over(extents[i], extents[j])
    ]
    lines = []
    for line in root.iter(f"{SVG}polyline"):
        points = [tuple(map(float, point.split(","))) for point in line.get("points").split()]
        for (x0, y0), (x1, y1) in pairwise(points):
            assert x0 == x1 or y0 == y1
            lines.append((min(x0, x1), min(y0, y1), max(x0, x1) + 0.1, max(y0, y1) + 0.1))
    assert not [text.text for text, each in zip(texts, extents, strict=True) for line in lines if over(each, line)]
    width, height = map(float, root.get("viewBox").split()[2:])
    assert all(left >= 0.0 and right <= width and bottom <= height for left, _, right, bottom in extents)


def test_every_state_is_drawn_with_what_it_does_and_every_guard(drawn):
    plan, root = drawn
    said = " ".join(text.text for text in root.iter(f"{SVG}text"))
    states = states_of(plan)
    for kind, does in ACTIONS.items():
        if any(state.kind == kind for state in states):
            assert does in said
    for state in states:
        for transition in state.transitions:
            assert " and ".join(guard.words for guard in transition.guards) in said
    boxes = [each for each in root.iter(f"{SVG}rect") if each.get("stroke") == "#222222"]
    assert len(boxes) == len(states) - 1  # abort is the bar at the right


def test_boxes_frames_and_the_bar_hold_what_is_theirs_and_arrows_go_between_them(drawn):
    plan, root = drawn
    rects = {"#222222": [], "#dddddd": [], "#D55E00": []}
    for each in root.iter(f"{SVG}rect"):
        x, y, width, height = (float(each.get(key)) for key in ("x", "y", "width", "height"))
        rects[each.get("stroke")].append((x, y, x + width, y + height))
    boxes, frames, (bar,) = rects.values()
    assert not [pair for each in (boxes, frames) for pair in combinations([*each, bar], 2) if over(*pair)]

    def holds(outer, inner):
        return outer[0] <= inner[0] and outer[1] <= inner[1] and inner[2] <= outer[2] and inner[3] <= outer[3]

    assert len(frames) == len({state.name.rpartition("-")[0] for state in states_of(plan) if state.phase})
    assert all(any(holds(frame, box) for box in boxes) for frame in frames)
    assert bar[1] <= min(box[1] for box in boxes)
    assert bar[3] >= max(box[3] for box in boxes)
    (turned,) = [each for each in root.iter(f"{SVG}text") if each.get("transform")]
    x, y = float(turned.get("x")), float(turned.get("y"))
    half = 0.5 * width_of(turned.text, "bold")
    assert holds(bar, (x - 9.0, y - half, x + 3.0, y + half))
    assert turned.get("transform") == f"rotate(90 {x:.1f} {y:.1f})"
    bold = [each for each in root.iter(f"{SVG}text") if each.get("font-weight") == "bold" and each is not turned]
    assert all(any(holds(rect, extent(each)) for rect in boxes + frames) for each in bold)
    ends = [
        [tuple(map(float, point.split(","))) for point in each.get("points").split()]
        for each in root.iter(f"{SVG}polyline")
    ]
    sides = {(side, y) for box in boxes + frames for side in (box[0], box[2]) for y in (box[1], box[3])}
    for (x0, y0), *_, (x1, y1) in ends:
        to_bar, down = x1 == bar[0], x0 == x1 and len({x0, x1}) == 1 and y1 > y0
        within = [box for box in boxes if box[1] <= y1 <= box[3]]
        assert to_bar or (down and any(y1 == box[1] for box in boxes)) or (within and x1 == within[0][0])
        assert not to_bar or any(x0 == side for side, _ in sides)
    groups = {}
    for state in states_of(plan)[:-1]:
        groups.setdefault(state.name.rpartition("-")[0], []).append(
            {each for each in state.transitions if each.to == "abort"}
        )
    drawn_once = sum(
        len(set.intersection(*group)) + sum(len(each - set.intersection(*group)) for each in group)
        for group in groups.values()
    )
    assert len([each for each in ends if each[-1][0] == bar[0]]) == drawn_once


def test_a_head_lies_at_the_end_of_its_line_and_points_along_it(drawn):
    _, root = drawn

    def points(each):
        return np.array([tuple(map(float, point.split(","))) for point in each.get("points").split()])

    lines, heads = (list(root.iter(f"{SVG}{kind}")) for kind in ("polyline", "polygon"))
    for line, head in zip(lines, heads, strict=True):
        tip, *base = points(head)
        last = points(line)[-1] - points(line)[-2]
        assert tip == pytest.approx(points(line)[-1])
        assert tip - np.mean(base, axis=0) == pytest.approx(6.0 * last / np.hypot(*last), abs=0.11)
        assert np.ptp(base, axis=0) @ np.abs(last) == pytest.approx(
            0.0, abs=0.11 * np.hypot(*last)
        )  # upright on the line
        assert np.hypot(*np.ptp(base, axis=0)) == pytest.approx(6.0, abs=0.21)
        assert line.get("stroke") == head.get("fill")


def test_long_times_are_in_minutes_and_hours():
    written = [amount_in_si(value, "s") for value in (90.0, 119.0, 150.0, 7200.0, 123456.0, 9_876_543.0)]
    assert written == ["90\u00a0s", "119\u00a0s", "2.5\u00a0min", "2\u00a0h", "34.29\u00a0h", "114.3\u00a0days"]
    assert amount_in_si(60.0, "Wh") == "60\u00a0W\u202fh"
