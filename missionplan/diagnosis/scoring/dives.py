"""What a mission expects of the depths of dives, by the descent that `simulate` runs.

Each draw of the mission is a trial of the descent phase with the wet weight and the line of the dive. What is random
besides is that of the diagnosis: sensor, turbulence and scatter from dive to dive (`diagnosis.dives.noise`), averaged
over its grid.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.dives.forward import DRAG_EFFECT, LARGEST_RELEASE_DELAY, NO_BOTTOM, STEP, DiveHistories
from missionplan.diagnosis.dives.noise import dive_to_dive_covariance, noise_grid, sensor_and_turbulence_covariance
from missionplan.diagnosis.dives.preparation import DiveLog, PreparedDives
from missionplan.diagnosis.scoring.ensemble import Ensemble, Noise, Part
from missionplan.diagnosis.scoring.explanations import explained
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.views import MooringMission
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.depth_sensor import SensorHistory, sensor_history
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import Scenario

DRAWS = 256
"""Draws of the mission's uncertain quantities."""
CHANGE = 0.01
"""Step of the differences along drag and wet weight, of themselves."""
LATER = 0.05
"""Step of the differences along the release delay [s]."""


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
    phase = MooringMission.of(mission, depth=False).mooring()
    parts = tuple(_part(data, known, phase, share, seed) for share, known in explained(mission))
    groups = np.repeat(np.arange(len(data.dives)), [len(log.t) for log in data.dives])
    return Ensemble(np.concatenate([log.depth for log in data.dives]), groups, parts)


def _part(data: PreparedDives, mission: Mission, phase: MoorPhase, share: float, seed: int) -> Part:
    means = Scenario.at_means(mission)
    drawn = means.sampled(seed=seed, block=0, size=DRAWS)
    trials = DRAWS if drawn.uncertain else 1
    expected = np.concatenate([_history(log, drawn, phase, trials)(0.0) for log in data.dives]).T
    blocks = [_covariances(log, means, phase) for log in data.dives]
    noises = []
    for index, noise in enumerate(noise_grid()):
        covariance = _block_diagonal([block[index] for block in blocks])
        noises.append(Noise(float(np.exp(noise.log_prior)), covariance, np.ones(1), np.zeros(len(covariance))))
    return Part(share, expected, tuple(noises))


def _history(
    log: DiveLog,
    scenario: Scenario,
    phase: MoorPhase,
    trials: int,
    weight_factor: float = 1.0,
    further: tuple[DescentEffect, ...] = (),
) -> Callable[[float], Array]:
    """Run one dive; return its readings as a function of the delay of its separation [s]."""
    given: dict[str, Scalars] = {
        "site.depth": 0.0,
        f"{phase.name}.anchor_wet_weight": np.full(trials, weight_factor * log.wet_weight),
        f"{phase.name}.line_length": np.full(trials, log.line_length),
    }
    here = replace(scenario, draws={**scenario.draws, **given})
    plain = phase.model_copy(update={"anchor_wet_weight": log.wet_weight, "lateral": "uncoupled"})
    dive = replace(dive_of(here, plain), site_depth=NO_BOTTOM)
    until = float(log.fine[-1]) + LARGEST_RELEASE_DELAY
    own = (effect for effect in scenario.effects_on_readings_too if isinstance(effect, DescentEffect))
    effects = (*own, *further)
    history: SensorHistory = sensor_history(dive, trials, until, effects=effects, step=STEP)
    return DiveHistories((log,), history).readings


def _covariances(log: DiveLog, means: Scenario, phase: MoorPhase) -> Array:
    """Covariance of a dive's readings beside the draws, at each noise of the grid, shape (g, m, m) [m²]."""
    dragged = CATALOGUE[DRAG_EFFECT].make({"fraction": CHANGE})
    further = (dragged,) if isinstance(dragged, DescentEffect) else ()
    here = _history(log, means, phase, 1)
    centre, later, earlier = (here(delay)[:, 0] for delay in (0.0, LATER, -LATER))
    drag = (_history(log, means, phase, 1, further=further)(0.0)[:, 0] - centre) / CHANGE
    weight = (_history(log, means, phase, 1, 1.0 + CHANGE)(0.0)[:, 0] - centre) / CHANGE
    release = (later - earlier) / (2.0 * LATER)
    sensitivities = np.stack([release, np.ones_like(centre), drag, weight], axis=1)
    fixed = sensor_and_turbulence_covariance(log.t, log.sd, noise_grid())
    return fixed + dive_to_dive_covariance(sensitivities, np.zeros(len(centre)), noise_grid())


def _block_diagonal(blocks: list[Array]) -> Array:
    ends = np.cumsum([len(block) for block in blocks])
    total = np.zeros((int(ends[-1]), int(ends[-1])))
    for block, end in zip(blocks, ends.tolist(), strict=True):
        total[end - len(block) : end, end - len(block) : end] = block
    return total
