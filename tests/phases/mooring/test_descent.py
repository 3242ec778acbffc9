import itertools
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from missionplan.arrays import Scalars
from missionplan.effects.dive_forces import BroadsideStart, SlowFlooding, TrappedGas, VerticalCurrent
from missionplan.effects.dive_log import LinePayout
from missionplan.phases.currents import layers
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import DescentRecord, descend
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.profile import simulate_profile
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.physics.drag import Hull, QuadraticDrag, Sail, VehicleDrag, anchor_drag
from missionplan.physics.water import Water
from tests.depth_readings import simulate_readings

INCH, FOOT = 0.0254, 0.3048
WATER = Water(1026.02, 1.1892e-6)
PROTOTYPE = Dive(
    wet_weight=11.6974,
    anchor_mass=2.7935,
    anchor_added_mass=0.536,
    anchor_drag=anchor_drag(4.75 * INCH, 0.2, WATER.density),
    vehicle_mass=10.2,
    vehicle_added_mass=0.240,
    net_buoyancy=0.8896,
    vehicle_drag=VehicleDrag(Hull(44 * INCH, 4.75 * INCH), Sail(4 * INCH, 4 * INCH, 0.6 * INCH), 1.25, WATER),
    line_length=5.0,
    site_depth=100 * FOOT,
)
QUADRATIC = replace(PROTOTYPE, vehicle_drag=QuadraticDrag(3.3), anchor_drag=QuadraticDrag(1.17))
STILL = layers([1000.0], [0.0], [0.0])


def run(dive, trials=1, *, current=STILL, release=0.0, **options) -> DescentRecord:
    return descend(
        dive,
        release_time=np.full(trials, release),
        current=current,
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
        **options,
    )


def fall_under_drag(distance, terminal, tau, start=0.0):
    """Time and speed at the end of a fall under constant drag coefficient, from below or above terminal velocity."""
    share = start / terminal
    grown = np.exp(distance / (terminal * tau))
    if share < 1.0:
        begun = np.arctanh(share)
        end = np.arccosh(grown * np.cosh(begun))
        return tau * (end - begun), terminal * np.tanh(end)
    begun = np.arctanh(1.0 / share)
    end = np.arcsinh(grown * np.sinh(begun))
    return tau * (end - begun), terminal / np.tanh(end)


def closed_form(dive):
    """Lone fall, snatch, pull-down and coasting with quadratic drag, by hand."""
    k_a, k_v = dive.anchor_drag.factor, dive.vehicle_drag.factor
    line, bottom = dive.line_length, dive.site_depth
    v_lone = np.sqrt(dive.wet_weight / k_a)
    tau_lone = dive.lone_mass * v_lone / dive.wet_weight
    t_taut, fast = fall_under_drag(line, v_lone, tau_lone)
    shared = dive.lone_mass * fast / dive.joint_mass
    pull = dive.wet_weight - dive.net_buoyancy
    v_joint = np.sqrt(pull / (k_a + k_v))
    tau = dive.joint_mass * v_joint / pull
    t_joint, v_end = fall_under_drag(bottom - line, v_joint, tau, shared)
    stopping = dive.free_mass / (2 * k_v) * np.log(1 + k_v * v_end**2 / dive.net_buoyancy)
    return t_taut, t_taut + t_joint, v_joint, line - stopping


def test_constant_drag_gives_the_closed_forms():
    record = run(QUADRATIC)
    t_taut, t_down, v_joint, altitude = closed_form(QUADRATIC)
    assert record.payout_time == pytest.approx(t_taut, rel=1e-5)
    assert record.descent_time == pytest.approx(t_down, rel=1e-5)
    assert record.terminal_velocity == pytest.approx(v_joint, rel=1e-10)
    assert record.lowest_altitude == pytest.approx(altitude, rel=1e-5)


DESIGNS = st.tuples(
    st.floats(5.0, 40.0), st.floats(1.0, 15.0), st.floats(20.0, 60.0), st.floats(2.0, 8.0), st.floats(0.3, 3.0)
)


def designed(weight, line, depth, vehicle, buoyancy):
    return replace(
        QUADRATIC,
        wet_weight=weight,
        line_length=line,
        site_depth=depth,
        vehicle_drag=QuadraticDrag(vehicle),
        net_buoyancy=buoyancy,
    )


@settings(max_examples=3)
@given(st.lists(DESIGNS, min_size=12, max_size=12))
def test_closed_forms_over_the_range_of_designs(designs):
    record = run(designed(*np.array(designs).T), len(designs))
    t_taut, t_down, _, altitude = np.transpose([closed_form(designed(*each)) for each in designs])
    line = np.array(designs)[:, 1]
    assert record.payout_time == pytest.approx(t_taut, rel=1e-4)
    assert record.descent_time == pytest.approx(t_down, rel=1e-4)
    assert line - record.lowest_altitude == pytest.approx(line - altitude, rel=1e-4)


def test_velocity_and_depth_from_rest_follow_tanh_and_ln_cosh():
    heavy_line = replace(QUADRATIC, line_length=1e-6, net_buoyancy=0.5)
    times = np.linspace(0.2, 12.0, 60)[:, None]
    depth = simulate_readings(heavy_line, times, step=0.01)[:, 0]
    terminal = np.sqrt(11.1974 / 4.47)
    tau = heavy_line.joint_mass * terminal / 11.1974
    late = times[:, 0] - run(heavy_line, step=0.01).payout_time[0]
    assert depth == pytest.approx(terminal * tau * np.log(np.cosh(late / tau)), abs=2e-3)


def test_halving_the_step_divides_the_error_by_sixteen():
    exact = np.array(closed_form(QUADRATIC))[[1, 3]]
    errors = []
    for step in (0.4, 0.2, 0.1):
        record = run(QUADRATIC, step=step)
        errors.append(np.abs([record.descent_time[0], record.lowest_altitude[0]] - exact))
    for coarse, fine in itertools.pairwise(errors):
        assert (np.log2(coarse / fine) > 3.5).all()


def test_prototype_against_an_adaptive_integrator():
    dive, record = PROTOTYPE, run(PROTOTYPE)
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}

    def stage(force, mass, state, event):
        event.terminal = True
        found = solve_ivp(lambda _, y: [y[1], force(y[1]) / mass], (0, 500), state, events=event, **options)
        return found.t_events[0][0], found.y_events[0][0]

    t_taut, (_, fast) = stage(
        lambda v: dive.wet_weight - dive.anchor_drag(v), dive.lone_mass, [0, 0], lambda _, y: y[0] - dive.line_length
    )
    pull = dive.wet_weight - dive.net_buoyancy
    t_down, state = stage(
        lambda v: pull - dive.vehicle_drag(v) - dive.anchor_drag(v),
        dive.joint_mass,
        [0, fast * dive.lone_mass / dive.joint_mass],
        lambda _, y: y[0] - (dive.site_depth - dive.line_length),
    )
    _, (deepest, _) = stage(
        lambda v: -dive.net_buoyancy - dive.vehicle_drag(v), dive.free_mass, state, lambda _, y: y[1] + 1e-14
    )
    assert record.payout_time == pytest.approx(t_taut, abs=1e-5)
    assert record.descent_time == pytest.approx(t_taut + t_down, abs=1e-5)
    assert record.lowest_altitude == pytest.approx(dive.site_depth - deepest, abs=1e-5)


def test_prototype_in_the_words_of_a_field_engineer():
    current = layers([50 * FOOT, 100 * FOOT], [1.0, 0.9], np.radians([90.0, 120.0]))
    record = run(PROTOTYPE, current=current, release=2.0)
    assert record.descent_time == pytest.approx(19.2, abs=0.1)
    assert record.offset_distance == pytest.approx(19.6, abs=0.1)
    assert record.lowest_altitude == pytest.approx(1.67, abs=0.01)
    assert not record.struck.any()


def test_anchor_drifts_with_the_layer_that_it_is_in():
    deep = 20.0
    current = layers([deep, 100.0], [1.0, 0.5], [np.pi / 2, 0.0])
    record = run(PROTOTYPE, current=current, release=3.0)
    profile = simulate_profile(PROTOTYPE, release_time=3.0, current=current, position=np.zeros(2))
    crossed = np.interp(deep, profile.anchor_depth, profile.time)
    down = record.release_time[0] + record.descent_time[0]
    assert record.offset[:, 0] == pytest.approx([crossed, 0.5 * (down - crossed)], abs=0.06)
    assert profile.anchor_track[:, profile.time <= down][:, -1] == pytest.approx(record.offset[:, 0], abs=0.15)


def test_a_uniform_current_carries_by_its_speed_times_the_time():
    record = run(PROTOTYPE, 3, current=layers([100.0], [0.7], [1.1]), release=4.0)
    expected = 0.7 * (4.0 + record.descent_time) * np.array([[np.sin(1.1)], [np.cos(1.1)]])
    assert record.offset == pytest.approx(expected)


def test_a_current_that_grows_with_time_carries_by_its_integral():
    """Of a current a·t east: a(t₁² − t₀²)/2, through the release, the pay-out of the line and both stages of the dive."""
    growth, begun = 0.01, 100.0
    current = SeriesCurrent(
        np.array([0.0, 1000.0]), np.zeros(1), np.array([[0.0], [1000.0 * growth]]), np.zeros((2, 1))
    )
    record = descend(
        PROTOTYPE,
        effects=(LinePayout(0.2),),
        release_time=np.full(1, 4.0),
        current=current,
        position=np.zeros((2, 1)),
        t_start=np.full(1, begun),
    )
    ended = begun + 4.0 + record.descent_time
    assert record.offset[0] == pytest.approx(0.5 * growth * (ended**2 - begun**2), rel=1e-9)


def test_trials_do_not_touch_each_other():
    weights = np.array([9.0, 11.0, 14.0, 20.0])
    together = run(replace(PROTOTYPE, wet_weight=weights), 4)
    for index, weight in enumerate(weights):
        alone = run(replace(PROTOTYPE, wet_weight=weight))
        for name in ("payout_time", "descent_time", "terminal_velocity", "lowest_altitude"):
            assert getattr(together, name)[index] == pytest.approx(getattr(alone, name)[0], rel=1e-12)


@settings(max_examples=3)
@given(st.lists(st.tuples(st.floats(6.0, 30.0), st.floats(1.02, 1.5)), min_size=16, max_size=16))
def test_a_heavier_anchor_is_faster_and_stops_lower(anchors):
    weight, factor = np.array(anchors).T
    light, heavy = (run(replace(PROTOTYPE, wet_weight=each), len(anchors)) for each in (weight, weight * factor))
    assert np.all(heavy.descent_time < light.descent_time)
    assert np.all(heavy.terminal_velocity > light.terminal_velocity)
    assert np.all(heavy.lowest_altitude < light.lowest_altitude)


def test_an_anchor_lighter_than_the_buoyancy_never_comes_down():
    record = run(replace(PROTOTYPE, wet_weight=np.array([0.5, 11.7]), site_depth=15.0), 2)
    assert record.touched_down.tolist() == [False, True]
    assert np.isnan(record.descent_time[0])
    assert not record.struck[0]


def test_a_short_line_lets_the_vehicle_strike():
    record = run(replace(PROTOTYPE, line_length=np.array([2.0, 5.0])), 2)
    assert record.struck.tolist() == [True, False]
    assert record.lowest_altitude[0] < 0.0


def test_a_vehicle_that_just_touches_the_seafloor_has_struck():
    def ended(line):
        return run(replace(PROTOTYPE, line_length=line, site_depth=line + 32.0))

    line = 3.0
    for _ in range(20):  # lengthen the line by what is missing, until nothing is
        missing = float(ended(line).lowest_altitude[0])
        line -= missing
        if missing == 0.0:
            break
    assert missing == 0.0
    assert [ended(line + more).struck.tolist() for more in (-1e-6, 0.0, 1e-6)] == [[True], [True], [False]]


def test_without_buoyancy_the_vehicle_sinks_to_the_seafloor():
    record = run(replace(PROTOTYPE, net_buoyancy=-0.2))
    assert record.struck.all()


def test_a_line_longer_than_the_water_is_deep_leaves_the_vehicle_at_the_surface():
    record = run(replace(PROTOTYPE, line_length=40.0))
    assert not record.touched_down.any()
    assert np.isnan(record.descent_time).all()
    assert record.lowest_altitude == pytest.approx(PROTOTYPE.site_depth)


def test_line_payout_only_moves_time():
    plain, late = run(PROTOTYPE), run(PROTOTYPE, effects=(LinePayout(0.2),))
    assert late.payout_time - plain.payout_time == pytest.approx(1.0)
    assert late.descent_time - plain.descent_time == pytest.approx(1.0)
    assert late.lowest_altitude == pytest.approx(plain.lowest_altitude)


def test_a_vertical_current_carries_both_bodies_once_taut():
    plain = run(PROTOTYPE)
    carried = run(PROTOTYPE, effects=(VerticalCurrent(0.1),))
    assert carried.payout_time == pytest.approx(plain.payout_time)
    assert carried.terminal_velocity == pytest.approx(plain.terminal_velocity)
    assert carried.descent_time < plain.descent_time


def test_moving_water_carries_nothing_that_it_does_not_drag_along():
    """Without drag a vertical current changes neither depth nor time: the snatch shares momentum over the ground."""
    slippery = replace(PROTOTYPE, vehicle_drag=QuadraticDrag(1e-9), anchor_drag=QuadraticDrag(1e-9))
    plain, carried = run(slippery), run(slippery, effects=(VerticalCurrent(0.1),))
    assert carried.descent_time == pytest.approx(plain.descent_time, rel=1e-6)


@dataclass(frozen=True)
class Float(DescentEffect):
    force: Scalars = 0.0

    def lift(self, depth: Scalars) -> Scalars:
        return self.force


def test_a_lift_takes_from_the_weight_of_the_pair():
    lifted = run(PROTOTYPE, effects=(Float(2.0),))
    light = run(replace(PROTOTYPE, net_buoyancy=PROTOTYPE.net_buoyancy + 2.0))
    assert lifted.descent_time == pytest.approx(light.descent_time)
    assert lifted.terminal_velocity == pytest.approx(light.terminal_velocity)
    assert lifted.lowest_altitude == pytest.approx(light.lowest_altitude)


def test_lifts_of_two_effects_add():
    two = run(PROTOTYPE, effects=(Float(0.5), Float(1.5)))
    assert two.descent_time == pytest.approx(run(PROTOTYPE, effects=(Float(2.0),)).descent_time)


def test_a_broadside_start_delays_and_fades():
    plain, broadside = run(PROTOTYPE), run(PROTOTYPE, effects=(BroadsideStart(5.0, 1.5),))
    assert broadside.payout_time == pytest.approx(plain.payout_time)
    assert broadside.descent_time > plain.descent_time + 0.3
    assert broadside.terminal_velocity == pytest.approx(plain.terminal_velocity, rel=1e-4)


@dataclass(frozen=True)
class Heavier(DescentEffect):
    factor: Scalars = 1.0

    def mass_factor(self) -> Scalars:
        return self.factor


def test_mass_enters_the_snatch_too():
    record = run(replace(QUADRATIC, net_buoyancy=1e-9), effects=(Heavier(1.3),))
    scaled = replace(QUADRATIC, vehicle_mass=1.3 * QUADRATIC.joint_mass - QUADRATIC.lone_mass, net_buoyancy=1e-9)
    expected = run(replace(scaled, vehicle_added_mass=0.0))
    assert record.descent_time == pytest.approx(expected.descent_time)


def test_neutral_effects_change_nothing():
    neutral = (BroadsideStart(0.0), LinePayout(0.0), SlowFlooding(0.0), TrappedGas(0.0), VerticalCurrent(0.0))
    plain, same = run(PROTOTYPE), run(PROTOTYPE, effects=neutral)
    assert same.descent_time == pytest.approx(plain.descent_time, rel=1e-12)
    assert same.lowest_altitude == pytest.approx(plain.lowest_altitude, rel=1e-12)


def test_profile_agrees_with_the_record():
    profile = simulate_profile(PROTOTYPE, release_time=2.0, current=STILL, position=np.zeros(2))
    marks, record = profile.stages, profile.record
    assert marks["separation"] == 2.0
    assert marks["touchdown"] - marks["separation"] == pytest.approx(record.descent_time[0])
    assert PROTOTYPE.site_depth - profile.vehicle_depth.max() == pytest.approx(record.lowest_altitude[0], abs=1e-3)
    assert profile.vehicle_depth[-1] == pytest.approx(PROTOTYPE.site_depth - PROTOTYPE.line_length)
    assert profile.anchor_depth[-1] == pytest.approx(PROTOTYPE.site_depth)
    assert (profile.anchor_depth >= profile.vehicle_depth).all()
    assert np.nanmax(profile.vehicle_speed) == pytest.approx(record.terminal_velocity[0], rel=1e-2)
