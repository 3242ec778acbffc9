from dataclasses import replace

import numpy as np
import pytest

from missionplan.effects.dive_forces import BroadsideStart, DragBias, VerticalCurrent
from missionplan.phases.currents import layers
from missionplan.phases.mooring import ascend
from missionplan.phases.mooring.forces import Dive
from missionplan.physics.drag import QuadraticDrag

DIVE = Dive(
    wet_weight=11.7,
    anchor_mass=2.8,
    anchor_added_mass=0.54,
    anchor_drag=QuadraticDrag(1.17),
    vehicle_mass=10.2,
    vehicle_added_mass=0.24,
    net_buoyancy=0.89,
    vehicle_drag=QuadraticDrag(3.3),
    line_length=5.0,
    site_depth=30.0,
)


def rise(dive, trials=1, current=None, **options):
    return ascend(
        dive,
        current=current or layers([100.0], [0.0], [0.0]),
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
        since_taut=np.full(trials, 1e4),
        start=np.broadcast_to(np.maximum(np.asarray(dive.site_depth) - dive.line_length, 0.0), (trials,)),
        **{"end": 0.0, **options},
    )


def test_constant_drag_gives_the_closed_form():
    terminal = np.sqrt(0.89 / 3.3)
    tau = DIVE.free_mass * terminal / 0.89
    record = rise(DIVE)
    assert record.ascent_time == pytest.approx(tau * np.arccosh(np.exp(25.0 / (terminal * tau))), rel=1e-6)
    assert record.surfaced.all()


def test_layers_carry_the_vehicle_by_the_time_in_each():
    record = rise(DIVE, current=layers([10.0, 100.0], [0.5, 0.3], [np.pi / 2, 0.0]))
    terminal = np.sqrt(0.89 / 3.3)
    assert record.drift[0, 0] == pytest.approx(0.5 * 10.0 / terminal, abs=0.07)
    assert record.drift[1, 0] == pytest.approx(0.3 * (record.ascent_time[0] - 10.0 / terminal), abs=0.07)


def test_a_vehicle_without_buoyancy_stays_down():
    record = rise(replace(DIVE, net_buoyancy=np.array([-0.1, 0.89]), site_depth=12.0), 2)
    assert record.surfaced.tolist() == [False, True]
    assert np.isnan(record.ascent_time[0])


def test_drag_found_in_a_descent_slows_the_ascent():
    assert rise(DIVE, effects=(DragBias(0.5),)).ascent_time > rise(DIVE).ascent_time * 1.1


def test_what_faded_in_the_descent_does_not_come_back():
    faded = BroadsideStart(5.0, 20.0)
    assert rise(DIVE, effects=(faded,)).ascent_time == pytest.approx(rise(DIVE).ascent_time, rel=1e-9)


def test_a_moored_vehicle_starts_at_rest_over_the_ground():
    """Without drag moving water changes nothing, and the vehicle rises by half of its acceleration times t²."""
    slippery = replace(DIVE, vehicle_drag=QuadraticDrag(1e-9))
    record = rise(slippery, effects=(VerticalCurrent(0.1),))
    assert record.ascent_time == pytest.approx(np.sqrt(2.0 * 25.0 * DIVE.free_mass / DIVE.net_buoyancy), rel=1e-6)


def test_at_the_surface_there_is_nothing_to_rise():
    assert rise(replace(DIVE, line_length=40.0)).ascent_time == pytest.approx(0.0, abs=1e-6)


def test_it_ends_when_the_tail_is_at_the_surface():
    terminal = np.sqrt(0.89 / 3.3)
    tau = DIVE.free_mass * terminal / 0.89
    record = rise(DIVE, end=1.2)
    assert record.ascent_time == pytest.approx(tau * np.arccosh(np.exp(23.8 / (terminal * tau))), rel=1e-6)
