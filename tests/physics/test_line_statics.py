"""A body on its line: closed forms, the numbers of an independent estimate, and an independent shooting solution."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, fsolve

from missionplan.physics.drag import Hull, QuadraticDrag, Sail, VehicleDrag
from missionplan.physics.held_line import (
    CROSSFLOW_COEFFICIENT,
    LINE_MATERIALS,
    Float,
    HeldBody,
    HeldLine,
    hang,
    line_drag_factor,
)
from missionplan.physics.line_statics import held_pose, laid, line_shape, settling_nose
from missionplan.physics.seafloor import LayersAbove, ProfileAbove
from missionplan.physics.water import sea_water

KNOT = 0.514444
WATER = sea_water(20.0, 15.0)
LENGTH, DIAMETER, BUOYANCY = 1.1176, 0.12065, 0.88964
DRAG = VehicleDrag(Hull(LENGTH, DIAMETER), Sail(0.1016, 0.1016, 0.01524), 1.25, WATER)
"""Of Chesapeake's vehicle."""


FRICTION = 0.02 / 1.2
"""Drag along a line over that across it."""


def rope(length, diameter=0.0, **more):
    return HeldLine(length, line_drag_factor(diameter, WATER.density), **more)


def body(**changes):
    given = {
        "length": LENGTH,
        "diameter": DIAMETER,
        "net_buoyancy": BUOYANCY,
        "raising_moment": 0.5 * LENGTH * changes.get("net_buoyancy", BUOYANCY),
        "righting_moment": 0.0,
        "crossflow_coefficient": CROSSFLOW_COEFFICIENT,
        "axial_drag": DRAG,
        "density": WATER.density,
    }
    return HeldBody(**{**given, **changes})


def uniform(speed, toward=0.5 * np.pi):
    speed = np.atleast_1d(np.asarray(speed, dtype=float))
    velocity = np.stack([speed * np.sin(toward), speed * np.cos(toward)])
    return LayersAbove(np.full((1, speed.size), np.inf), velocity[None])


def stacked(tops, speeds):
    """Layers for one trial, east."""
    velocity = np.stack([np.array([[speed], [0.0]]) for speed in speeds])
    return LayersAbove(np.array([*tops, np.inf])[:, None], velocity)


@pytest.mark.parametrize(
    ("speed", "altitude", "downstream"), [(0.2 * KNOT, 4.0, 2.9), (0.4 * KNOT, 2.5, 4.4), (0.9, 0.6, 5.0)]
)
def test_the_independent_estimate(speed, altitude, downstream):
    """Two estimates made before this code; each gives the nose to a decimetre."""
    pose = held_pose(body(), HeldLine(5.0), uniform(speed))
    assert pose.nose[2, 0] == pytest.approx(altitude, abs=0.06)
    assert pose.excursion[0] == pytest.approx(downstream, abs=0.06)


def test_four_millimetres_of_line_lower_the_nose_by_four_decimetres():
    thin, thick = (held_pose(body(), rope(5.0, width), uniform(0.4 * KNOT)) for width in (0.0, 0.004))
    assert thin.nose[2, 0] - thick.nose[2, 0] == pytest.approx(0.4, abs=0.06)


def test_without_a_current_it_stands_above_the_anchor():
    pose = held_pose(body(), rope(5.0, 0.01), uniform(0.0))
    assert pose.nose[:, 0] == pytest.approx([0.0, 0.0, 5.0], abs=1e-6)
    assert pose.pitch[0] == pytest.approx(0.5 * np.pi, abs=1e-6)
    assert pose.tension_at_anchor[:, 0] == pytest.approx([0.0, 0.0, BUOYANCY])


@given(speed=st.floats(0.01, 2.0), buoyancy=st.floats(0.1, 50.0))
@settings(max_examples=30, deadline=None)
def test_uniform_current_has_a_closed_form(speed, buoyancy):
    """With the buoyancy at mid-length B cos θ = D sin² θ, and the line is the body's prolongation."""
    pose = held_pose(body(net_buoyancy=buoyancy), HeldLine(5.0), uniform(speed))
    ratio = buoyancy / (0.5 * WATER.density * CROSSFLOW_COEFFICIENT * LENGTH * DIAMETER * speed**2)
    pitch = np.arccos((np.sqrt(ratio**2 + 4.0) - ratio) / 2.0)
    assert pose.pitch[0] == pytest.approx(pitch, abs=1e-6)
    assert pose.nose[:, 0] == pytest.approx([5.0 * np.cos(pitch), 0.0, 5.0 * np.sin(pitch)], abs=1e-5)
    pull = buoyancy * np.sin(pitch) + DRAG(speed * np.cos(pitch))
    assert pose.tension[0] == pytest.approx(pull, rel=1e-5)


def test_much_buoyancy_or_no_drag_stands_it_up():
    for held in (body(net_buoyancy=1e6), body(crossflow_coefficient=1e-9, axial_drag=QuadraticDrag(0.0))):
        pose = held_pose(held, HeldLine(5.0), uniform(0.5))
        assert pose.nose[2, 0] == pytest.approx(5.0, abs=1e-4)


def test_centres_turn_the_body_in_still_water():
    """5 mm between the centres turn it as much as the whole net buoyancy: tan θ = raising / righting moment."""
    weight = 10.2 * 9.80665
    pose = held_pose(body(righting_moment=0.005 * weight), HeldLine(5.0), uniform(0.0))
    assert pose.pitch[0] == pytest.approx(np.arctan2(0.5 * LENGTH * BUOYANCY, 0.005 * weight), abs=1e-6)
    assert np.degrees(pose.pitch[0]) == pytest.approx(45.0, abs=1.0)
    heavy_tail = held_pose(body(raising_moment=-0.5), HeldLine(5.0), uniform(0.0))
    assert heavy_tail.pitch[0] == pytest.approx(-0.5 * np.pi, abs=1e-6)
    assert heavy_tail.nose[2, 0] == pytest.approx(5.0)


def test_a_body_that_sinks_lies_on_the_seafloor():
    pose = held_pose(body(net_buoyancy=-0.5), HeldLine(5.0), uniform(0.1))
    assert pose.nose[2, 0] == pytest.approx(0.0, abs=1e-5)


def shot(held, line, speed):
    """The same statics by shooting: the line integrated up from the anchor, the body by quadrature, in one plane.

    `speed` is a function of the altitude. Returns the nose's place, the pitch and the pull at the anchor.
    """
    across = 0.5 * held.density * held.crossflow_coefficient * held.diameter

    def on_body(pitch, altitude):
        def normal(s):
            return across * speed(altitude + s * np.sin(pitch)) ** 2 * np.sin(pitch) * abs(np.sin(pitch))

        mean = quad(lambda s: speed(altitude + s * np.sin(pitch)), 0.0, held.length, limit=200)[0] / held.length
        force, moment = (quad(lambda s, k=k: s**k * normal(s), 0.0, held.length, limit=200)[0] for k in (0, 1))
        along = float(held.axial_drag(mean * np.cos(pitch)))
        pull = np.array(
            [
                along * np.cos(pitch) + force * np.sin(pitch),
                along * np.sin(pitch) - force * np.cos(pitch) + held.net_buoyancy,
            ]
        )
        return pull, held.raising_moment * np.cos(pitch) - held.righting_moment * np.sin(pitch) - moment

    def slope(_, state):
        _, up, horizontal, vertical = state
        along = np.array([horizontal, vertical]) / np.hypot(horizontal, vertical)
        water = np.array([speed(up), 0.0])
        past = water @ along
        normal = water - past * along
        drag = line.drag_factor * np.hypot(*normal) * normal + FRICTION * line.drag_factor * abs(past) * past * along
        return [*along, -drag[0], -drag[1]]

    def miss(guess):
        path = solve_ivp(slope, (0.0, line.length), [0.0, 0.0, *guess], rtol=1e-9, atol=1e-10)
        east, up, *tension = path.y[:, -1]
        pitch = brentq(lambda angle: on_body(angle, up)[1], -1.5, 1.5707)
        return np.array(tension) - on_body(pitch, up)[0], (east, up, pitch)

    start, _ = on_body(1.0, 0.8 * line.length)
    load = fsolve(lambda guess: miss(guess)[0], [start[0] + 0.1, max(start[1], 0.2)], xtol=1e-10)
    return *miss(load)[1], load


@pytest.mark.parametrize(
    ("low", "shear", "width", "righting"),
    [(0.1, 0.0, 0.003, 0.0), (0.05, 0.03, 0.0, 0.0), (0.1, 0.04, 0.004, 0.0), (0.25, -0.02, 0.002, 0.2)],
)
def test_shooting_from_the_anchor_gives_the_same(low, shear, width, righting):
    held, line = body(righting_moment=righting, net_buoyancy=2.0), rope(5.0, width)
    heights = np.linspace(0.0, 6.5, 14)
    east = low + shear * heights
    profile = ProfileAbove(heights[:, None], np.stack((east, 0.0 * east), axis=1)[..., None])
    pose = held_pose(held, line, profile)
    east, up, pitch, load = shot(held, line, lambda altitude: low + shear * altitude)
    assert pose.nose[[0, 2], 0] == pytest.approx([east, up], abs=5e-3)
    assert pose.pitch[0] == pytest.approx(pitch, abs=2e-3)
    assert pose.tension_at_anchor[[0, 2], 0] == pytest.approx(load, rel=2e-3)


def test_what_the_line_adds_is_its_drag():
    pose = held_pose(body(), rope(5.0, 0.004), uniform(0.3))
    added = pose.tension_at_anchor - pose.tension_at_nose
    assert added[0, 0] > 0.0
    chord = line_drag_factor(0.004, WATER.density) * 5.0 * 0.3**2
    assert 0.0 < added[0, 0] < chord


@given(
    speeds=st.lists(st.floats(0.0, 1.5), min_size=3, max_size=3),
    tops=st.tuples(st.floats(0.2, 3.0), st.floats(3.1, 6.0)),
    width=st.sampled_from([0.0, 0.003]),
)
@settings(max_examples=30, deadline=None)
def test_the_line_is_as_long_as_it_is(speeds, tops, width):
    pose = held_pose(body(), rope(5.0, width), stacked(tops, speeds))
    assert -1e-9 <= pose.nose[2, 0] <= 5.0 + 1e-9
    assert np.all(np.isfinite(pose.tension_at_anchor))
    assert pose.excursion[0] <= 5.0 + 1e-6


def test_turning_the_current_turns_everything():
    east, other = (held_pose(body(), rope(5.0, 0.002), uniform(0.2, toward)) for toward in (0.5 * np.pi, 0.3))
    assert other.nose[2] == pytest.approx(east.nose[2])
    assert other.nose[:2, 0] == pytest.approx(east.excursion[0] * np.array([np.sin(0.3), np.cos(0.3)]), abs=1e-6)


def test_each_trial_of_a_block_stands_as_it_would_alone():
    speeds = np.random.default_rng(3).uniform(0.0, 0.6, (2, 50))
    velocity = np.stack([np.stack([speed, 0.2 * speed]) for speed in speeds])
    tops = np.stack([np.full(50, 2.0), np.full(50, np.inf)])
    held = body(axial_drag=QuadraticDrag(np.linspace(1.0, 3.0, 50)), net_buoyancy=np.linspace(0.5, 3.0, 50))
    block = held_pose(held, rope(np.linspace(2.0, 6.0, 50), 0.002), LayersAbove(tops, velocity))
    for trial in (0, 17, 49):
        alone = body(axial_drag=QuadraticDrag(1.0 + 2.0 * trial / 49), net_buoyancy=0.5 + 2.5 * trial / 49)
        pose = held_pose(
            alone,
            rope(2.0 + 4.0 * trial / 49, 0.002),
            LayersAbove(tops[:, trial : trial + 1], velocity[..., trial : trial + 1]),
        )
        assert pose.nose[:, 0] == pytest.approx(block.nose[:, trial], abs=1e-5)


def test_a_profile_is_linear_between_its_altitudes_and_held_above_them():
    tops = np.array([[0.0, 0.0], [2.0, 3.0], [4.0, 6.0]])
    velocity = np.random.default_rng(5).normal(size=(3, 2, 2))
    altitude = np.array([[0.0, 0.5], [1.7, 3.0], [4.0, 9.0]])
    found = ProfileAbove(tops, velocity).at(altitude)
    for trial in range(2):
        for axis in range(2):
            theory = np.interp(altitude[:, trial], tops[:, trial], velocity[:, axis, trial])
            assert found[axis, :, trial] == pytest.approx(theory, abs=1e-10)


def sheared(low, shear):
    heights = np.linspace(0.0, 8.0, 17)
    east = low + shear * heights
    return ProfileAbove(heights[:, None], np.stack((east, 0.0 * east), axis=1)[..., None])


def shot_from_the_nose(line, speed, buoyancy=BUOYANCY):
    """Nose's place and pull at the anchor, in one plane, of a line integrated from the nose down to where it is level.

    `speed` is a function of the altitude. The body is a quadrature of its own: B at mid-length, drag across and along.
    """
    along_body = (np.arange(400) + 0.5) / 400 * LENGTH
    lift = [(float(item.distance), float(item.buoyancy)) for item in line.floats]

    def pull_of(altitude):
        def moment(pitch):
            u = speed(altitude + along_body * np.sin(pitch))
            drag = 0.5 * WATER.density * 1.1 * DIAMETER * (u * np.abs(u) * along_body).mean() * LENGTH
            return 0.5 * LENGTH * buoyancy * np.cos(pitch) - drag * np.sin(pitch) ** 2

        pitch = brentq(moment, 1e-9, 0.5 * np.pi)
        u = speed(altitude + along_body * np.sin(pitch))
        normal = 0.5 * WATER.density * 1.1 * DIAMETER * (u * np.abs(u)).mean() * LENGTH * np.sin(pitch) ** 2
        axial, direction = float(DRAG(u.mean() * np.cos(pitch))), np.array([np.cos(pitch), np.sin(pitch)])
        return axial * direction + normal * np.array([np.sin(pitch), -np.cos(pitch)]) + np.array([0.0, buoyancy])

    def follow(altitude):
        """Lowest places of the line: how far below the nose, the state there, and the line down to there."""

        def slope(_, state):
            _, down, horizontal, vertical = state
            tension = np.hypot(horizontal, vertical)
            across, up = horizontal / tension, vertical / tension
            u = float(speed(altitude - down))
            drag = line.drag_factor * abs(u * up) * u * up  # along (up, -across)
            along = FRICTION * line.drag_factor * abs(u * across) * u * across
            stretch = 1.0 + line.compliance * tension
            load = [drag * up + along * across, -drag * across - line.wet_weight + along * up]
            return [across * stretch, up * stretch, *load]

        def level(_, state):
            return state[3]

        level.terminal, level.direction = True, -1
        state, begun, lows = np.array([0.0, 0.0, *pull_of(altitude)]), 0.0, []
        for until, lifts in [*lift, (float(line.length), 0.0)]:
            while begun < until:
                path = solve_ivp(slope, (begun, until), state, events=level, rtol=1e-8, atol=1e-10)
                state, begun = path.y[:, -1], path.t[-1]
                if path.status == 1:
                    lows.append((state[1], state.copy(), begun))
                    if not any(place > begun for place, _ in lift):
                        return lows
                    state = state - np.array([0.0, 0.0, 0.0, 1e-9])
            state = state + np.array([0.0, 0.0, 0.0, lifts])
        return [*lows, (state[1], state, begun)]

    altitude = brentq(lambda z: max(low[0] for low in follow(z)) - z, 1e-6, 1.5 * line.length, xtol=1e-7)
    _, state, begun = max(follow(altitude), key=lambda low: low[0])
    lying = (line.length - begun) * (1.0 + line.compliance * state[2])
    return (state[0] + lying, altitude), state[2:]


LINES = [
    (0.004, 0.046, 0.0, 5.0),
    (0.002, 0.15, 0.0, 5.0),
    (0.004, 0.55, 0.0, 4.0),
    (0.0, 0.1, 0.0, 6.0),
    (0.006, -0.03, 0.0, 5.0),
    (0.004, 0.046, 4.0, 5.0),
    (0.003, 0.2, 2.0, 3.0),
    (0.008, 0.0, 8.0, 5.0),
]
"""Diameter [m], wet weight [N/m], stiffness [N/m] and length [m]; stiffness 0 does not stretch."""


@pytest.mark.parametrize(("low", "shear"), [(0.05, 0.0), (0.1, 0.03), (0.2, 0.0), (0.25, -0.02), (0.5, 0.0)])
@pytest.mark.parametrize(("width", "weight", "stiffness", "length"), LINES)
def test_an_independent_solution_puts_the_nose_in_the_same_place(low, shear, width, weight, stiffness, length):
    compliance = 1.0 / (stiffness * length) if stiffness else 0.0
    line = rope(length, width, wet_weight=weight, compliance=compliance)
    pose = held_pose(body(), line, sheared(low, shear))
    place, load = shot_from_the_nose(line, lambda altitude: low + shear * np.asarray(altitude))
    assert pose.nose[[0, 2], 0] == pytest.approx(place, abs=4e-3 * length)
    assert pose.tension_at_anchor[[0, 2], 0] == pytest.approx(load, abs=0.01 * np.hypot(*load) + 1e-3)


@pytest.mark.parametrize(
    ("floats", "weight", "speed"),
    [
        ([(2.0, 0.6)], 0.2, 0.1),
        ([(1.0, 0.8)], 0.55, 0.15),
        ([(1.0, 0.5), (3.0, 0.5)], 0.2, 0.2),
        ([(2.5, 2.0)], 0.55, 0.05),
        ([(0.5, 1.5)], 0.55, 0.3),
        ([(2.5, 3.0)], 0.55, 0.3),
    ],
)
def test_floats_carry_a_heavy_line(floats, weight, speed):
    line = rope(5.0, 0.004, wet_weight=weight, floats=tuple(Float(*item) for item in floats))
    pose = held_pose(body(), line, uniform(speed))
    place, _ = shot_from_the_nose(line, lambda altitude: speed + 0.0 * np.asarray(altitude))
    assert pose.nose[[0, 2], 0] == pytest.approx(place, abs=0.02)


def arch(across, weight, lift, before, after, give):
    """Heights and horizontal length of the elastic line that a float lifts, so much of it before and after the float."""
    ends = np.array([-weight * before, lift - weight * before, lift - weight * (before + after)])
    stretched = give / 2.0 * ends**2
    high = (np.hypot(across, ends[0]) - across + stretched[0]) / weight
    fall = (np.hypot(across, ends[1]) - np.hypot(across, ends[2]) + stretched[1] - stretched[2]) / weight
    spans = np.arcsinh(-ends[0] / across) + np.arcsinh(ends[1] / across) - np.arcsinh(ends[2] / across)
    return high, fall, across / weight * spans


@given(
    weight=st.floats(0.1, 2.0),
    across=st.floats(0.02, 3.0),
    hangs=st.floats(0.2, 3.0),
    lift=st.floats(0.1, 1.9),
    beyond=st.floats(0.05, 4.0),
    give=st.sampled_from([0.0, 0.05]),
)
@settings(max_examples=30, deadline=None)
def test_what_a_float_lifts_from_the_seafloor_is_an_arch_of_catenaries(weight, across, hangs, lift, beyond, give):
    """It hangs, lies, rises to the float and comes down: to the seafloor as far from the float, or to the anchor."""
    lift, length = lift * weight, hangs + 3.0 + beyond
    before = 0.5 * lift / weight
    if before > beyond:  # down to the anchor: as high before the float as after it
        before = brentq(lambda x: np.subtract(*arch(across, weight, lift, x, beyond, give)[:2]), 0.0, before)
    after = min(before, beyond)
    line = HeldLine(length, wet_weight=weight, compliance=give, floats=(Float(hangs + 3.0, lift),))
    up = weight * hangs
    found = laid(line, uniform(0.0), np.array([5.0]), np.array([[across], [0.0], [up]]))
    level = across / weight * np.arcsinh(up / across) + (3.0 - before) + (beyond - after)
    expected = level + arch(across, weight, lift, before, after, give)[2] + across * give * length
    assert found.fallen[-1, 0, 0] == pytest.approx(expected, rel=1e-5)
    if not give:
        left = lift - weight * (before + beyond)
        assert found.load[:, 0] == pytest.approx([across, 0.0, max(left, 0.0)], abs=1e-4)
        assert found.fallen[-1, 2, 0] == pytest.approx(found.deepest[0], abs=1e-5)


def test_a_line_that_touches_between_two_floats_does_so_alone_and_in_a_block():
    floats = (Float(3.0, 0.9), Float(6.0, 1.5))
    line = rope(8.0, 0.003, wet_weight=0.8, floats=floats)
    speeds = np.array([0.02, 0.1, 0.25, 0.5])
    block = held_pose(body(net_buoyancy=np.array([0.5, 0.9, 20.0, 0.9])), line, uniform(speeds))
    for trial, speed, buoyancy in ((0, 0.02, 0.5), (2, 0.25, 20.0)):
        alone = held_pose(body(net_buoyancy=buoyancy), line, uniform(speed))
        assert alone.nose[:, 0] == pytest.approx(block.nose[:, trial], abs=2e-4)
        points = line_shape(line, uniform(speed), alone)[:, 2, 0]
        assert points.min() > -0.02
        assert points[[0, -1]] == pytest.approx([0.0, alone.nose[2, 0]], abs=1e-3)


@pytest.mark.parametrize(
    ("material", "altitude"),
    [("nylon", 1.85), ("polyester", 1.34), ("aramid", 1.20), ("steel-wire", 0.14), (None, 2.10)],
)
def test_what_five_metres_of_four_millimetres_hold_in_four_tenths_of_a_knot(material, altitude):
    """An estimate made elsewhere by shooting, from which MoorDyn differs by 0.15 % of the line."""
    weight = LINE_MATERIALS[material].wet_weight(0.004, WATER.density) if material else 0.0
    pose = held_pose(body(), rope(5.0, 0.004, wet_weight=weight), uniform(0.4 * KNOT))
    assert pose.nose[2, 0] == pytest.approx(altitude, abs=0.02)


@given(weight=st.floats(0.01, 2.0), across=st.floats(0.05, 5.0), up=st.floats(0.05, 5.0), give=st.floats(0.0, 0.2))
@settings(max_examples=40, deadline=None)
def test_without_drag_it_is_the_elastic_catenary_of_the_books(weight, across, up, give):
    """x = H/w (asinh(V/H) − asinh((V − wL)/H)) + HL/EA, of the part above the seafloor, in one piece."""
    length = 5.0
    hanging = min(length, up / weight)
    low = up - weight * hanging
    hung = hang(
        HeldLine(length, wet_weight=weight, compliance=give),
        uniform(0.0),
        np.array([5.0]),
        np.array([[across], [0.0], [up]]),
    )
    x = across / weight * (np.arcsinh(up / across) - np.arcsinh(low / across)) + across * give * length
    z = (np.hypot(across, up) - np.hypot(across, low)) / weight + give * (up**2 - low**2) / (2.0 * weight)
    assert hung.fallen[-1, :, 0] == pytest.approx([x + length - hanging, 0.0, z], rel=1e-8, abs=1e-8)
    assert hung.load[:, 0] == pytest.approx([across, 0.0, max(up - weight * length, 0.0)], abs=1e-9)


def test_in_still_water_a_heavy_line_hangs_straight_down_and_the_rest_of_it_lies_by_the_anchor():
    pose = held_pose(body(), rope(5.0, 0.004, wet_weight=0.55), uniform(0.0))
    assert pose.nose[:, 0] == pytest.approx([0.0, 0.0, BUOYANCY / 0.55], abs=1e-3)
    assert pose.tension_at_anchor[:, 0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_more_weight_never_raises_the_nose():
    weights = np.linspace(0.0, 1.0, 60)
    pose = held_pose(body(), rope(5.0, 0.004, wet_weight=weights), uniform(np.full(60, 0.15)))
    assert np.all(np.diff(pose.nose[2]) < 1e-6)


@pytest.mark.parametrize("knots", [0.1, 0.2, 0.4])
def test_it_settles_as_a_pendulum_with_mass_does(knots):
    """A rigid pendulum of line and body with its added mass, by `solve_ivp`: within 6 % of the line from 20 s on."""
    speed, mass, reach = knots * KNOT, 20.4, 5.0 + 0.5 * LENGTH
    drag = 0.5 * WATER.density * 1.1 * LENGTH * DIAMETER
    pose = held_pose(body(), HeldLine(5.0), uniform(speed))

    def motion(_, state):
        past = speed * np.cos(state[0]) - state[1] * reach
        return [state[1], (drag * past * abs(past) - BUOYANCY * np.sin(state[0])) / (mass * reach)]

    path = solve_ivp(motion, (0.0, 400.0), [0.0, 0.0], max_step=0.2, dense_output=True)
    for time in (20.0, 40.0, 60.0, 90.0, 150.0, 300.0):
        angle = path.sol(time)[0]
        nose = settling_nose(pose, 5.0, np.array([speed]), time)
        assert nose[[0, 2], 0] == pytest.approx([5.0 * np.sin(angle), 5.0 * np.cos(angle)], abs=0.3)
    nose = settling_nose(pose, 5.0, np.array([speed]), 90.0)
    assert nose[[0, 2], 0] == pytest.approx(pose.nose[[0, 2], 0], abs=0.4)
