"""What a mission expects of the depths of dives, by the descent that `simulate` runs.

Each draw of the mission is a trial of the descent phase with the wet weight and the line of the dive. What is random
besides is that of the diagnosis' base model: sensor, turbulence and scatter from dive to dive
(`diagnosis.dives.noise`), averaged over its grid, and the little that no mission can rule out of each effect of the
catalogue (1 % of the drag).
"""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.dives.forward import NO_BOTTOM, STEP, DiveHistories
from missionplan.diagnosis.dives.model_factory import descent_model
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.dives.preparation import DiveLog, PreparedDives
from missionplan.diagnosis.scoring.ensemble import Ensemble, Noise, Part
from missionplan.diagnosis.scoring.explanations import explained
from missionplan.mission import Mission
from missionplan.mission.views import MooringMission
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.depth_sensor import sensor_history
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario

DRAWS = 256
"""Draws of the mission's uncertain quantities."""


def dive_ensemble(data: PreparedDives, mission: Mission, seed: int) -> Ensemble:
    """Return a mission's distribution of the depths of dives [m].

    Parameters
    ----------
    data : PreparedDives
    mission : Mission
    seed : int
        Of the draws.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    MooringMission.of(mission, depth=False)
    parts = tuple(_part(data, known, share, seed) for share, known in explained(mission))
    groups = np.repeat(np.arange(len(data.dives)), [len(log.t) for log in data.dives])
    return Ensemble(np.concatenate([log.depth for log in data.dives]), groups, parts)


def _part(data: PreparedDives, mission: Mission, share: float, seed: int) -> Part:
    means = Scenario.at_means(mission).at_depth(0.0)
    drawn = means.sampled(seed=seed, block=0, size=DRAWS)
    trials = DRAWS if drawn.draws else 1
    expected = np.concatenate([_readings(log, drawn, trials) for log in data.dives]).T
    model = descent_model(data, mission)
    spread = model.nuisance_sd(())  # nil for the mission's own effects: those are drawn
    noises = []
    for noise in noise_grid():
        covariance = model.total_covariance(model.base, noise, spread)
        noises.append(Noise(float(np.exp(noise.log_prior)), covariance, np.ones(1), np.zeros(len(covariance))))
    return Part(share, expected, tuple(noises))


def _readings(log: DiveLog, scenario: Scenario, trials: int) -> Array:
    """Run one dive in each draw; its readings, shape (m, trials) [m]."""
    weight, line = np.full(trials, log.wet_weight), np.full(trials, log.line_length)
    phase = scenario.moor().model_copy(update={"line_length": line, "lateral": "uncoupled"})
    dive = replace(dive_of(scenario, phase, weight), site_depth=NO_BOTTOM)
    effects = [effect for effect in scenario.effects_on_readings_too if isinstance(effect, DescentEffect)]
    history = sensor_history(dive, trials, float(log.fine[-1]), effects=effects, step=STEP)
    return DiveHistories((log,), history).readings(0.0)
