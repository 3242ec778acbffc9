"""The transition as a phase of `simulate`, and its file."""

from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.sweep_transition import sweep_transition

pytestmark = pytest.mark.usefixtures("unplanned", "unranked")

MISSION = Path(__file__).parents[3] / "missions" / "autosub-transition.yaml"


def test_probability_of_keeping_depth():
    outcome = simulate(missionplan.load(MISSION), trials=30, sheet=False)
    summary = outcome.summary()
    (phase,) = summary["phases"]
    assert phase["kind"] == "transition"
    assert {"depth_excursion_m", "pitch_excursion_rad", "hover_time_s", "energy_wh"} <= set(phase["quantities"])
    requirement = summary["requirements"][0]
    assert requirement["at_most"] == 0.85
    assert 0.5 < requirement["probability"]["value"] <= 1.0


def test_ballast_moves_energy_and_trials_are_the_draws():
    trials = simulate_block(missionplan.load(MISSION), seed=1, block=0, trials=40)
    ballast, energy = trials.draws["vehicle.net_buoyancy"], trials.phases[0].quantities["energy_wh"]
    deceleration = trials.draws["slow-down.deceleration"]
    assert np.all((ballast >= 53.0) & (ballast <= 212.0))
    hovering_power = ballast**1.5
    assert np.corrcoef(energy, hovering_power / deceleration)[0, 1] > 0.9


def rewritten(tmp_path, old, new):
    text = (MISSION.parent / "vehicles" / "autosub.yaml").read_text()
    assert old in text
    (tmp_path / "vehicles").mkdir()
    (tmp_path / "vehicles" / "autosub.yaml").write_text(text.replace(old, new))
    (tmp_path / "mission.yaml").write_text(MISSION.read_text())
    return tmp_path / "mission.yaml"


def test_an_unknown_derivative_is_reported_with_the_nearest(tmp_path):
    with pytest.raises(InputError, match=r"did you mean z_wdot"):
        missionplan.load(rewritten(tmp_path, "z_wdot:", "z_wdott:"))


def test_sternplanes_must_steer(tmp_path):
    with pytest.raises(InputError, match="sternplanes push the stern up"):
        missionplan.load(rewritten(tmp_path, "m_uud: -0.00131", "m_uud: 0.00131"))


def test_a_sweep_needs_a_thruster(tmp_path):
    path = rewritten(tmp_path, "thrusters:", "thrusters: []\nname_of_rest:")
    with pytest.raises(InputError):
        sweep_transition(missionplan.load(path))


def test_a_mission_without_transition_is_refused():
    with pytest.raises(InputError, match="no transition"):
        sweep_transition(missionplan.load(MISSION.parent / "fig8.yaml"))


def test_progress_counts_the_variants_of_the_vehicle():
    calls = []
    mission = missionplan.load(MISSION)
    cell = {"deceleration": ["0.01 m/s^2"], "steepness": ["0.1 m/s"], "mid_speed": ["0.75 m/s"]}  # those that are shown
    sweep_transition(mission.with_({"slow-down.sweep": cell}), time_step=1.0, progress=lambda *done: calls.append(done))
    assert calls == [(0, 3), (1, 3), (2, 3), (3, 3)]
