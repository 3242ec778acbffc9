"""Tank experiments with hidden effects: the generators by closed forms; the tool on a case of every effect."""

import numpy as np
import pytest

from . import tank
from .tool import diagnose_without_plans


def test_towing_is_half_rho_a_c_u_squared():
    rig = tank.towing(np.random.default_rng(1))
    speed, force = rig.columns["speed_m_s"], rig.read({})
    assert np.ptp(force / speed**2) == pytest.approx(0.0, abs=1e-9)
    assert rig.read({"drag-bias": 0.3}) == pytest.approx(1.3 * force)
    changed = rig.read({"reynolds-drag": -0.2}) / force
    assert np.polyfit(np.log(speed), np.log(changed), 1)[0] == pytest.approx(-0.2)


def test_springs_swing_at_their_frequency_and_die_away():
    rig = tank.springs(np.random.default_rng(2))
    mass, stiffness = (float(rig.dataset[key].split()[0]) for key in ("mass", "stiffness"))
    for heavier in (0.0, 0.4):
        time, x = rig.columns["t_s"], rig.read({"added-mass": heavier})
        down = np.flatnonzero((x[:-1] > 0.0) & (x[1:] <= 0.0))
        crossings = time[down] + (time[down + 1] - time[down]) * x[down] / (x[down] - x[down + 1])
        period = np.mean(np.diff(crossings))
        assert period == pytest.approx(2 * np.pi * np.sqrt(mass * (1 + heavier) / stiffness), rel=3e-3)
    plain, damped = rig.read({}), rig.read({"quadratic-damping": 5.0})
    assert np.std(damped[36:]) < 0.7 * np.std(plain[36:])


def test_jets_push_less_under_way_and_astern():
    rig = tank.jets(np.random.default_rng(3))
    ahead, still = rig.columns["rpm"] > 0, rig.columns["speed_m_s"] == 0.0
    ratio = rig.read({"jet-suction": 6.0}) / rig.read({})
    assert np.all(ratio[still] == 1.0)
    assert np.all(ratio[~still] < 1.0)
    assert rig.read({"thrust-asymmetry": 0.25})[~ahead] == pytest.approx(0.75 * rig.read({})[~ahead])


def test_a_strength_is_one_where_the_size_is_its_standard_error():
    """Drag bias with prior uncertainty b and n readings of relative noise s: 1/√(s²/n + b²), the exponent orthogonal."""
    rig = tank.towing(np.random.default_rng(4))
    count = len(rig.noise)
    share = rig.noise[0] / rig.read({})[0]
    expected = 0.1 / np.hypot(1.1 * share / np.sqrt(count) / 1.1, tank.PRIOR_SD["drag-bias"])
    assert tank.strength(rig, "drag-bias", 0.1, tank.EFFECTS["drag"]) == pytest.approx(expected, rel=0.01)


def test_same_seed_same_case():
    first, second = (tank.draw(7, "thruster", "jet-suction") for _ in range(2))
    assert first.rows == second.rows
    assert first.strength >= tank.SMALLEST * 0.999


EVERY = [(kind, effect) for kind, effects in tank.EFFECTS.items() for effect in (*effects, None)]
QUICK = (
    ("drag", "drag-bias"),
    ("drag", None),
    ("free-oscillation", "added-mass"),
    ("thruster", "jet-suction"),
    ("propeller-transient", "axial-flow"),
)


@pytest.mark.parametrize("seed", [41, pytest.param(42, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("kind", "effect"),
    [each if each in QUICK else pytest.param(*each, marks=pytest.mark.slow) for each in EVERY],
)
def test_the_tool_finds_what_is_there_and_nothing_else(kind, effect, seed, tmp_path):
    case = tank.draw(seed, kind, effect)
    outcome = diagnose_without_plans(case, tmp_path / "seen", tmp_path / "truth")
    assert outcome.diagnosis["causes"] == list(case.truth)
    assert outcome.diagnosis["verdict"] == ("explained" if effect else "adequate")
