"""The pitch-over after the snatch, against an integration by Lagrange's equations that shares no code with it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from missionplan.effects.dive_forces import BroadsideStart
from missionplan.phases.currents import layers
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.forces import DescentHooks, Dive, LoneFall
from missionplan.phases.mooring.motion import CrossFlowBody, Integration, Stop, TiedBodies, integrate_stage
from missionplan.phases.mooring.pitch_over import NOSE_DOWN, _Motion, pitch_over
from missionplan.physics.drag import QuadraticDrag
from missionplan.physics.vehicle_dynamics import PitchingBody
from tests.depth_readings import simulate_readings

BODY = PitchingBody(
    lateral_mass=20.0,
    inertia=20.0 * 1.12**2 / 12.0,
    length=1.12,
    centre=0.57,
    ahead=0.004,
    below=-0.006,
    buoyancy=101.0,
    drag_per_length=68.0,
)
DIVE = Dive(
    wet_weight=11.7,
    anchor_mass=2.8,
    anchor_added_mass=0.5,
    anchor_drag=QuadraticDrag(1.17),
    vehicle_mass=10.2,
    vehicle_added_mass=0.24,
    net_buoyancy=0.89,
    vehicle_drag=QuadraticDrag(3.3),
    line_length=5.0,
    site_depth=30.0,
    pitching=BODY,
)
NONE = DescentHooks()


def lone_fall(dive):
    rest = np.zeros(1)
    return integrate_stage(LoneFall(dive, NONE), rest, rest, Stop(deepest=dive.line_length), Integration(100.0))


def turned(dive, body=BODY, step=0.1):
    return pitch_over(dive, body, NONE, lone_fall(dive), np.full(1, 25.0), Integration(60.0, step, keep=True))


class Heavier(DescentEffect):
    """All that moves has twice the mass."""

    def mass_factor(self):
        return 2.0


def test_twice_the_mass_comes_to_half_the_acceleration_and_the_same_speed_after_the_snatch():
    at_rest = np.array([5.0, 0.3, 0.0, 0.0, 0.0])[:, None]
    one, two = (_Motion(DIVE, BODY, hooks, np.zeros(1)) for hooks in (NONE, DescentHooks((Heavier(),))))
    np.testing.assert_allclose(two.rate(0.0, at_rest)[2:], 0.5 * one.rate(0.0, at_rest)[2:])
    lone = SimpleNamespace(speed=np.ones(1))
    np.testing.assert_allclose(two.snatched(lone), 0.5 * one.snatched(lone))


def reference(dive, body, speed):
    """Way to nose down: places of the centre and pitch, from the kinetic energy of body and anchor, by differences."""
    masses = np.array([dive.free_mass, body.lateral_mass])
    places = np.linspace(body.centre - body.length, body.centre, 401)

    def axes(pitch):
        return np.array([[np.cos(pitch), np.sin(pitch)], [-np.sin(pitch), np.cos(pitch)]])

    def mass_matrix(pitch):  # of x and z of the centre of mass, and the pitch; the anchor shares the nose's fall
        along, across = axes(pitch)
        matrix = np.zeros((3, 3))
        matrix[:2, :2] = masses[0] * np.outer(along, along) + masses[1] * np.outer(across, across)
        matrix[2, 2] = body.inertia
        nose = np.array([0.0, 1.0, body.centre * across[1]])
        return matrix + dive.lone_mass * np.outer(nose, nose)

    def forces(pitch, rates):
        along, across = axes(pitch)
        flow = rates[:2] @ across + places * rates[2]
        drag = -body.drag_per_length * flow * np.abs(flow)
        axial = -dive.vehicle_drag(rates[:2] @ along)
        sinking = rates[1] + body.centre * across[1] * rates[2]
        pull = dive.wet_weight - dive.anchor_drag(sinking)
        force = along * axial + across * trapezoid(drag, places) + np.array([0.0, pull - dive.net_buoyancy])
        buoyant = (body.ahead * along + body.below * across)[0] * body.buoyancy
        moment = trapezoid(places * drag, places) - buoyant + body.centre * across[1] * pull
        return np.array([*force, moment])

    def rate(_, y):
        place, rates = y[:3], y[3:]
        small = 1e-6
        slope = (mass_matrix(place[2] + small) - mass_matrix(place[2] - small)) / (2.0 * small)
        own = np.array([0.0, 0.0, 0.5 * rates @ slope @ rates]) - slope @ rates * rates[2]
        return [*rates, *np.linalg.solve(mass_matrix(place[2]), forces(place[2], rates) + own)]

    def down(_, y):
        return y[2] - NOSE_DOWN

    down.terminal = True
    begun = np.linalg.solve(mass_matrix(0.0), dive.lone_mass * speed * np.array([0.0, 1.0, body.centre]))
    return solve_ivp(rate, (0.0, 20.0), [0.0, 0.0, 0.0, *begun], events=down, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize(
    ("centre", "ahead", "below", "weight", "line"),
    [
        (0.56, 0.0, 0.0, 11.7, 5.0),
        (0.57, 0.01, -0.008, 11.7, 5.0),
        (0.45, -0.005, -0.005, 8.0, 3.0),
        (0.65, 0.0, -0.01, 25.0, 10.0),
    ],
)
def test_time_and_depth_against_lagranges_equations(centre, ahead, below, weight, line):
    body = replace(BODY, centre=centre, ahead=ahead, below=below)
    dive = replace(DIVE, wet_weight=weight, line_length=line)
    found = turned(dive, body, step=0.02)
    way = reference(dive, body, lone_fall(dive).speed[0])
    _, z, pitch = way.y_events[0][0][:3]
    assert found.stage.time[0] == pytest.approx(way.t_events[0][0], abs=5e-3)
    assert found.stage.depth[0] == pytest.approx(z + centre * np.sin(pitch), abs=5e-3)


@pytest.mark.parametrize(("weight", "drag"), [(11.7, 68.0), (11.7, 200.0), (6.0, 68.0), (25.0, 68.0)])
def test_the_effect_that_stands_for_it_turns_alike(weight, drag):
    """From the time at which the hull is at 30° to its way, its angle at all others."""
    dive = replace(DIVE, wet_weight=weight)
    way = reference(dive, replace(BODY, drag_per_length=drag), lone_fall(dive).speed[0])
    across = np.cos(way.y[2])
    time = np.interp(-0.5, -across, way.t) / np.arccosh(2.0)
    sine = np.cbrt(BroadsideStart(1.0, time).drag_factor(way.t, 1.0) - 1.0)
    assert np.abs(sine - across).max() < 0.12


def test_the_default_step_is_fine_enough():
    coarse, fine = turned(DIVE), turned(DIVE, step=0.01)
    assert coarse.stage.time == pytest.approx(fine.stage.time, abs=1e-3)
    assert coarse.stage.depth == pytest.approx(fine.stage.depth, abs=1e-3)


def test_the_vehicle_turns_over_in_one_to_five_seconds():
    found = turned(DIVE)
    assert found.turned.all()
    assert 1.0 < found.stage.time[0] < 5.0
    assert found.pitch == pytest.approx(NOSE_DOWN)


def test_buoyancy_ahead_keeps_the_nose_up_longer():
    times = [float(turned(DIVE, replace(BODY, ahead=ahead)).stage.time[0]) for ahead in (-0.01, 0.0, 0.01, 0.02)]
    assert times == sorted(times)


def test_a_vehicle_that_cannot_be_turned_goes_down_all_the_same():
    dive = replace(DIVE, pitching=replace(BODY, ahead=0.5), site_depth=60.0)
    record = run(dive)
    assert np.isnan(record.nose_down_time).all()
    assert np.isfinite(record.descent_time).all()


def run(dive, current=None, trials=1, **options):
    return descend(
        dive,
        release_time=np.zeros(trials),
        current=current or layers([1000.0], [0.0], [0.0]),
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
        **options,
    )


def test_the_dive_takes_longer_and_says_how_much_depth_it_lost():
    at_once, pitched = run(replace(DIVE, pitching=None)), run(DIVE)
    assert np.isnan(at_once.nose_down_time).all()
    assert 0.05 < pitched.descent_time[0] - at_once.descent_time[0] < 1.0
    assert 0.0 < pitched.depth_lost[0] < 0.5
    assert pitched.terminal_velocity == pytest.approx(at_once.terminal_velocity)
    assert pitched.payout_time == at_once.payout_time


def test_tied_bodies_pitch_over_too():
    tied = TiedBodies(CrossFlowBody(7.5, 4.0), CrossFlowBody(76.0, 20.0, 0.56))
    still = run(replace(DIVE, tied=tied))
    assert still.descent_time == pytest.approx(run(DIVE).descent_time, abs=1e-4)
    uniform = layers([1000.0], [0.7], [1.1])
    for dive in (DIVE, replace(DIVE, tied=tied)):
        record = run(dive, uniform)
        assert record.offset_distance == pytest.approx(0.7 * record.descent_time, rel=1e-9)


def test_a_log_shows_the_pitch_over_without_a_jump():
    times = np.linspace(0.0, 12.0, 241)[:, None]
    depth = simulate_readings(DIVE, times)[:, 0]
    assert np.abs(np.diff(depth, n=2)).max() < 0.07
    at_once = simulate_readings(replace(DIVE, pitching=None), times)[:, 0]
    late = times[:, 0] > run(DIVE).payout_time[0] + 2.0
    assert (depth[late] < at_once[late]).all()


def test_trials_do_not_touch_each_other():
    weights = np.array([9.0, 11.7, 20.0])
    together = run(replace(DIVE, wet_weight=weights), trials=3)
    for index, weight in enumerate(weights):
        alone = run(replace(DIVE, wet_weight=weight))
        for name in ("nose_down_time", "depth_lost", "descent_time", "lowest_altitude"):
            assert getattr(together, name)[index] == pytest.approx(getattr(alone, name)[0], rel=1e-9), name


class Neutral(DescentEffect):
    def drag_factor(self, since_taut, speed):
        return 1.0 + 0.0 * np.asarray(since_taut)


def test_a_neutral_effect_changes_nothing():
    plain, same = run(DIVE), run(DIVE, effects=(Neutral(),))
    assert same.descent_time == pytest.approx(plain.descent_time, rel=1e-12)
