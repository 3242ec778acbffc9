"""Drift of anchor and vehicle tied by a taut line, against an independent integration, limits and symmetries."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from missionplan.phases.currents import layers
from missionplan.phases.mooring.descent import DescentRecord, descend
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.motion import CrossFlowBody, TiedBodies
from missionplan.phases.mooring.profile import simulate_profile
from missionplan.phases.mooring.tied_pull_down import TiedWater
from missionplan.physics.drag import QuadraticDrag
from tests.phases.mooring.tied_reference import Case, tied, varied_case


def dive_of(case: Case) -> Dive:
    anchor, vehicle = case.anchor, case.vehicle
    return Dive(
        wet_weight=case.weight,
        anchor_mass=anchor.along,
        anchor_added_mass=0.0,
        anchor_drag=QuadraticDrag(anchor.drag_along),
        vehicle_mass=vehicle.along,
        vehicle_added_mass=0.0,
        net_buoyancy=case.buoyancy,
        vehicle_drag=QuadraticDrag(vehicle.drag_along),
        line_length=case.line,
        site_depth=case.depth,
        tied=TiedBodies(*(CrossFlowBody(body.drag_across, body.across, body.middle) for body in (anchor, vehicle))),
    )


def run(dive: Dive, down_to, speed, toward=None, *, release=0.0, **options) -> DescentRecord:
    return descend(
        dive,
        release_time=np.full(1, release),
        current=layers(down_to, speed, [np.pi / 2] * len(speed) if toward is None else toward),
        position=np.zeros((2, 1)),
        t_start=np.zeros(1),
        **options,
    )


def check_against_reference(number: int) -> None:
    case = varied_case(number)
    expected = tied(case)
    record = run(dive_of(case), case.down_to, case.speed, release=case.release)
    # a layer's edge is met to a quarter of a step, 5 cm of depth: a centimetre where the layers' drifts cancel
    assert record.offset[0, 0] == pytest.approx(expected.offset, rel=0.01, abs=0.01)
    assert record.descent_time[0] == pytest.approx(expected.time, rel=0.002)


@pytest.mark.parametrize("number", range(6))
def test_offset_within_a_percent_of_an_independent_integration(number):
    check_against_reference(number)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(6, 50))
def test_more_cases(number):
    check_against_reference(number)


CASE = varied_case(0)
DIVE = dive_of(CASE)


def sheared(dive: Dive, **options) -> DescentRecord:
    return run(dive, CASE.down_to, CASE.speed, **options)


def with_bodies(anchor: dict[str, float], vehicle: dict[str, float]) -> Dive:
    assert DIVE.tied is not None
    return replace(DIVE, tied=TiedBodies(replace(DIVE.tied.anchor, **anchor), replace(DIVE.tied.vehicle, **vehicle)))


def test_in_still_water_the_line_hangs_straight_and_nothing_changes():
    tied_dive, alone = (run(dive, (100.0,), (0.0,)) for dive in (DIVE, replace(DIVE, tied=None)))
    assert tied_dive.offset_distance == 0.0
    for name in ("payout_time", "descent_time", "terminal_velocity", "lowest_altitude"):
        assert getattr(tied_dive, name) == pytest.approx(getattr(alone, name), abs=1e-5)


@given(st.floats(-1.5, 1.5), st.floats(0.0, 2.0 * np.pi))
@settings(max_examples=6)
def test_a_uniform_current_carries_both_bodies_by_its_speed(speed, toward):
    record = run(DIVE, (100.0,), (speed,), (toward,), release=4.0)
    reach = speed * (4.0 + record.descent_time)
    assert record.offset == pytest.approx(reach * np.array([[np.sin(toward)], [np.cos(toward)]]), abs=1e-9)


@given(st.floats(0.0, 2.0 * np.pi))
@settings(max_examples=3)
def test_turning_all_layers_turns_the_offset(turn):
    straight = np.array([0.3, 1.0, 2.5, 4.0])
    first, turned = (sheared(DIVE, toward=straight + more) for more in (0.0, turn))
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    assert turned.offset == pytest.approx(rotation @ first.offset, abs=1e-6)
    assert turned.lowest_altitude == pytest.approx(first.lowest_altitude, abs=1e-7)


def test_an_anchor_that_the_water_holds_goes_with_its_layer():
    """The paper's way is the limit in which the line cannot pull the anchor through the water, and hardly leans."""
    gentle = 0.2 * np.array(CASE.speed)
    dives = with_bodies({"drag": 1e6}, {}), replace(DIVE, tied=None)
    held, alone = (run(dive, CASE.down_to, gentle, step=0.01) for dive in dives)
    assert held.offset == pytest.approx(alone.offset, rel=0.01)
    assert run(DIVE, CASE.down_to, gentle).offset[0] < 0.9 * alone.offset[0]


def test_bodies_that_the_water_cannot_hold_keep_the_velocity_of_the_surface():
    """Without drag across the flow, momentum is conserved: the line only swings the bodies about each other."""
    record = sheared(with_bodies({"drag": 0.0}, {"drag": 0.0}))
    assert record.offset[0] == pytest.approx(CASE.speed[0] * record.descent_time, rel=1e-6)


def test_an_anchor_without_drag_is_towed_by_the_vehicle():
    """It lags the vehicle, which stays behind in the upper layers: the offset is greater the less the water holds it."""
    halves = (15.0, 30.0), (1.0, 0.2)
    dives = [with_bodies({"drag": k}, {}) for k in (1e6, 10.0, 1.0)]
    offsets = [float(run(replace(dive, site_depth=30.0), *halves).offset[0, 0]) for dive in dives]
    assert offsets == sorted(offsets)
    assert offsets[-1] > 1.1 * offsets[0]


def test_trials_do_not_touch_each_other():
    weights = np.array([0.8, 1.0, 1.7]) * DIVE.wet_weight
    current = layers(CASE.down_to, CASE.speed, [np.pi / 2] * len(CASE.speed))
    starts = {"position": np.zeros((2, 3)), "t_start": np.zeros(3), "release_time": np.zeros(3)}
    together = descend(replace(DIVE, wet_weight=weights), current=current, **starts)
    for index, weight in enumerate(weights):
        alone = sheared(replace(DIVE, wet_weight=weight))
        assert together.offset[:, index] == pytest.approx(alone.offset[:, 0], rel=1e-12)
        assert together.lowest_altitude[index] == pytest.approx(alone.lowest_altitude[0], rel=1e-12)


def test_a_light_anchor_and_a_long_line_leave_the_vehicle_at_the_surface():
    for dive in (replace(DIVE, wet_weight=0.5 * DIVE.net_buoyancy, site_depth=12.0), replace(DIVE, line_length=40.0)):
        record = sheared(dive)
        assert not record.touched_down.any()
        assert np.isnan(record.descent_time).all()
        assert np.isfinite(record.offset).all()


@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(1.0, 15.0), st.floats(0.05, 0.4))
@settings(max_examples=10)
def test_the_strongest_shear_gives_numbers(upper, lower, line, step):
    record = run(replace(DIVE, line_length=line), (12.0, 40.0), (upper, lower), step=step)
    fastest = max(abs(upper), abs(lower))
    assert abs(record.offset[0, 0]) <= fastest * record.descent_time[0] + 1e-6
    assert record.lowest_altitude <= DIVE.site_depth


def test_profile_tracks_both_bodies():
    current = layers(CASE.down_to, CASE.speed, [np.pi / 2] * len(CASE.speed))
    profile = simulate_profile(DIVE, release_time=3.0, current=current, position=np.array([5.0, -2.0]))
    down = np.flatnonzero(np.isfinite(profile.anchor_track[0]))[-1]
    assert profile.anchor_track[:, down] == pytest.approx(profile.record.offset[:, 0], abs=0.15)
    taut = np.searchsorted(profile.time, profile.stages["pull-down"] + 0.2)
    apart = profile.anchor_track[:, taut : down - 1] - profile.vehicle_track[:, taut : down - 1]
    below = (profile.anchor_depth - profile.vehicle_depth)[taut : down - 1]
    assert np.sqrt(apart[0] ** 2 + apart[1] ** 2 + below**2) == pytest.approx(DIVE.line_length, abs=0.02)
    assert (np.diff(profile.anchor_depth) >= -1e-6).all()


def test_a_current_that_grows_evenly_is_met_as_it_is_between_the_times_at_which_it_is_looked_up():
    """1 mm/s² more, and 1 cm/s less for each metre of depth: about the vehicle's middle and the anchor's."""

    class Growing:
        steady_for = 10.0

        def velocity(self, t, depth, _):
            return np.stack((0.2 + 0.001 * t - 0.01 * depth, 0.0 * depth))

    start = np.array([100.0, 300.0])
    place = np.array([[0.0, 0.0], [0.0, 0.0], [3.0, 4.0], [0.0, 0.0], [0.0, 0.0], [5.0, 5.0]])
    water = TiedWater(Growing(), (0.5, -0.2), start)
    for t in (0.0, 10.0, 13.0, 17.5, 20.0, 26.0):
        east = water.at(t, place)[:, 0]
        expected = [0.2 + 0.001 * (start + t) - 0.01 * depth for depth in (place[2] - 0.5, place[2] + 5.0 + 0.2)]
        assert east == pytest.approx(np.array(expected)), t
