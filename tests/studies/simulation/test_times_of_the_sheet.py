"""The sheet's times, energies and places from trials made by hand: each phase's own start, end, track and anchor."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.studies.simulation.losses import _last_fix, losses
from missionplan.studies.simulation.overdue import _reach, _spent, _surfacings, _time
from missionplan.studies.simulation.phase_trials import PhaseTrials
from missionplan.studies.simulation.trial_block import MissionTrials

N = 40
LATER = np.arange(N, dtype=float)
"""Each trial is a second later than the one before."""


def phase(name, kind, start, end, times, track, energy, anchor=None, **failures):
    never = np.zeros(N, dtype=bool)
    return PhaseTrials(
        name=name,
        kind=kind,
        quantities={"energy_wh": np.full(N, energy), "excursion_m": np.linspace(0.0, 8.0, N)},
        events={},
        limits={},
        start=start + LATER,
        end=end + LATER,
        failures={"none": never, **failures},
        miss=np.zeros((2, N)),
        track=np.repeat(np.array(track, dtype=float)[:, :, None], N, axis=2),
        track_time=np.array(times, dtype=float)[:, None] + LATER,
        anchor=np.full((2, 0), np.nan)
        if anchor is None
        else np.repeat(np.array(anchor, dtype=float)[:, None], N, axis=1),
        goal=np.zeros((2, 1)),
        radius=10.0,
        inputs={},
    )


def trials():
    """Out with one surfacing on the way, a mooring, and back with none; energies of 10, 4 and 6 W h."""
    out = phase("out", "transit", 0.0, 1000.0, [0, 400, 460, 1000], [(0, 0), (300, 5), (310, 5), (700, 9)], 10.0)
    moor = phase(
        "moor", "moor", 1100.0, 3000.0, [1100, 1200, 3000], [(700, 9), (705, 11), (720, 20)], 4.0, (706.0, 12.0)
    )
    back = phase("back", "transit", 3000.0, 3600.0, [3000, 3600], [(720, 20), (2, 1)], 6.0)
    total = {"duration_s": back.end, "energy_wh": np.full(N, 20.0)}
    return MissionTrials((out, moor, back), total, np.ones(N, dtype=bool), {})


BATTERY = SimpleNamespace(capacity=50.0 * JOULES_PER_WATT_HOUR)


def test_each_time_is_that_of_its_own_event():
    found = {each.name: each for each in _surfacings(BATTERY, trials())}
    middle = np.median(LATER)
    assert {name: each.p50 - middle for name, each in found.items()} == {
        "out, surfacing 1": 400.0,
        "out, arrival": 1000.0,
        "moor, up from the seafloor": 3000.0,
    }
    back = _time("back", trials(), BATTERY, trials().total["duration_s"])
    assert back.p50 - middle == 3600.0
    assert (back.share, found["out, arrival"].share) == (1.0, 1.0)
    assert back.p95 == pytest.approx(3600.0 + np.quantile(LATER, 0.95)) or np.isnan(back.p95)
    assert np.isnan(back.p99)  # forty trials cannot tell it


def test_the_energy_left_is_that_of_the_phases_before_and_a_share_of_its_own():
    found = {each.name: each.energy_left for each in _surfacings(BATTERY, trials())}
    assert found == pytest.approx(
        {"out, surfacing 1": 50.0 - 10.0 * 0.4, "out, arrival": 40.0, "moor, up from the seafloor": 36.0}
    )
    assert _spent(trials(), 2050.0 + LATER) == pytest.approx(10.0 + 4.0 * 0.5)
    assert _spent(trials(), 1050.0 + LATER) == pytest.approx(10.0)
    assert _spent(trials(), 9000.0 + LATER) == pytest.approx(20.0)


def test_the_energy_left_is_what_all_but_one_in_twenty_have():
    made = trials()
    made.phases[0].quantities["energy_wh"] = np.linspace(8.0, 12.0, N)
    (arrival,) = (each for each in _surfacings(BATTERY, made) if each.name == "out, arrival")
    assert arrival.energy_left == pytest.approx(50.0 - np.quantile(np.linspace(8.0, 12.0, N), 0.95))


def test_a_surfacing_that_few_make_is_not_named_and_a_last_one_is_the_arrival():
    made = trials()
    first = made.phases[0]
    first.track_time[2:, 1:] = np.nan  # one trial of forty goes on
    assert "out, surfacing 1" not in {each.name for each in _surfacings(BATTERY, made)}


def test_where_and_when_it_was_last_at_a_fix():
    made = trials()
    made.phases[2].track_time[1, 3] = np.nan
    made.phases[1].track_time[:, 5] = np.nan
    made.phases[2].track_time[:, 5] = np.nan
    for each in made.phases:
        each.track_time[:, 7] = np.nan
    place, time = _last_fix(made.phases)
    assert (place[:, 0], time[0]) == (pytest.approx([2.0, 1.0]), 3600.0)
    assert (place[:, 3], time[3]) == (pytest.approx([720.0, 20.0]), 3003.0)
    assert (place[:, 5], time[5]) == (pytest.approx([700.0, 9.0]), 1005.0)
    assert np.isnan(time[7])


def test_each_way_to_fail_is_assumed_where_and_when_it_would_be():
    """Held on its anchor since the dive; adrift from a fix after it; on the seafloor or under way between two fixes."""
    found = {each.way: each for each in losses(trials().phases, {}, np.random.default_rng(1))}
    assert all(each.is_assumed for each in found.values())
    at, when = found["not released"].position, found["not released"].clock
    assert at == pytest.approx(np.repeat([[706.0], [12.0]], N, axis=1))
    assert when == pytest.approx(1100.0 + LATER)
    at, when = found["adrift at the surface"].position, found["adrift at the surface"].clock
    assert set(np.round(when - LATER)) == {1200.0, 3000.0, 3600.0}
    fixes = {(705.0, 11.0), (720.0, 20.0), (2.0, 1.0)}
    assert set(zip(*at.tolist(), strict=True)) == fixes
    at, when = found["still under way"].position, found["still under way"].clock
    share = (when - LATER - 3000.0) / 600.0
    assert np.all((share >= 0.0) & (share <= 1.0))
    assert np.ptp(share) > 0.5
    assert at == pytest.approx(np.stack((720.0 - 718.0 * share, 20.0 - 19.0 * share)))
    at, when = found["on the seafloor"].position, found["on the seafloor"].clock
    under = when - LATER
    legs = [(under >= low) & (under <= high) for low, high in ((0.0, 400.0), (460.0, 1000.0), (3000.0, 3600.0))]
    assert np.sum(legs, axis=0).tolist() == [1] * N, "not at the surface, and not between transits"
    assert min(leg.sum() for leg in legs) > 3
    out = under <= 1000.0
    first = out & (under <= 400.0)
    assert at[0, first] == pytest.approx(300.0 * under[first] / 400.0)


def test_those_that_failed_are_taken_where_there_are_enough():
    some, few = np.arange(N) < 25, np.arange(N) >= 35
    failed = {("back", "out of energy"): some, ("moor", "did not surface"): few}
    found = {each.way: each for each in losses(trials().phases, failed, np.random.default_rng(1))}
    adrift, held = found["adrift at the surface"], found["not released"]
    assert (adrift.is_assumed, held.is_assumed) == (False, True)
    assert adrift.trials.tolist() == list(range(25))
    assert adrift.position == pytest.approx(np.repeat([[2.0], [1.0]], 25, axis=1))
    assert len(held.trials) == N
    held = losses(trials().phases, {("moor", "did not surface"): some}, np.random.default_rng(1))[0]
    assert (held.way, held.is_assumed, held.trials.tolist()) == ("not released", False, list(range(25)))
    assert held.clock == pytest.approx(1100.0 + LATER[:25])  # it hangs there from its dive on
    assert held.position == pytest.approx(np.repeat([[706.0], [12.0]], 25, axis=1))


def test_how_far_it_hangs_from_its_anchor_is_a_high_quantile():
    assert _reach(trials().phases[1]) == pytest.approx(np.quantile(np.linspace(0.0, 8.0, N), 0.95))
    assert _reach(PhaseTrials(**{**vars(trials().phases[1]), "quantities": {}})) == 0.0


def test_each_mooring_has_areas_of_its_own():
    made = trials().phases
    second = phase("deep", "moor", 3700.0, 5000.0, [3700, 3800, 5000], [(2, 1), (3, 1), (9, 9)], 4.0, (4.0, 1.0))
    home = phase("home", "transit", 5000.0, 5600.0, [5000, 5600], [(9, 9), (0, 0)], 6.0)
    found = losses((*made, second, home), {}, np.random.default_rng(1))
    named = [(each.way, each.after) for each in found]
    assert named[:4] == [
        ("not released", "moor"),
        ("not released", "deep"),
        ("adrift at the surface", "moor"),
        ("adrift at the surface", "deep"),
    ]
    by_name = {(each.way, each.after): each for each in found}
    assert by_name["not released", "moor"].position[:, 0] == pytest.approx([706.0, 12.0])
    assert by_name["not released", "deep"].position[:, 0] == pytest.approx([4.0, 1.0])
    after_first, after_second = (by_name["adrift at the surface", name].clock - LATER for name in ("moor", "deep"))
    assert (after_first.min(), after_first.max()) == (1200.0, 3600.0)
    assert after_second.min() == 3800.0


def test_those_lost_before_the_first_mooring_have_an_area_where_there_are_enough():
    failed = {("out", "not arrived"): np.arange(N) < 30}
    found = losses(trials().phases, failed, np.random.default_rng(1))
    before, after = (each for each in found if each.way == "adrift at the surface")
    assert (before.after, before.is_assumed, before.trials.size) == ("", False, 30)
    assert (after.after, after.is_assumed) == ("moor", True)
