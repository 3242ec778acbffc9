"""From a mission and a data set to a model: the mission's own phases, at its means, bound to the data."""

from collections.abc import Callable

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.legs import TransitData
from missionplan.datasets.summaries import SummaryData
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.preparation import PreparedDives
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.summaries.model import SummaryForward, SummaryModel, as_log
from missionplan.effects import CATALOGUE, Effect
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.phases import MoorPhase
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.phases.mooring.forces import Dive
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current

DRAWS = 512
"""Draws of the mission from which its own uncertainty of the current is taken."""


def transit_model(data: TransitData, mission: Mission, seed: int) -> TransitModel:
    """Bind the mission's first transit to a navigation log.

    Raises
    ------
    InputError
        When the mission has no transit, or its current cannot be read.
    """
    problems = []
    if not mission.transits:
        problems.append(Problem("has no transit to lay the legs against", mission.file, key="phases"))
    if mission.navigation is None:
        problems.append(Problem("needs navigation.velocity_error to be diagnosed", mission.file, key="navigation"))
    if problems:
        raise InputError(problems)
    assert mission.navigation is not None
    recorded = recorded_current(mission)
    means = Scenario.at_means(mission, recorded)
    drawn = Scenario.drawn(mission, recorded, seed=seed, block=0, size=DRAWS)
    name = mission.transits[0].name
    base, spread = _expected_velocity(data, means, drawn, name)
    error = mission.navigation.velocity_error
    base = base + np.array([[mean_of(part)] for part in error.mean])
    spread = np.hypot(spread, [np.std(np.asarray(drawn[f"navigation.velocity_error.mean[{k}]"])) for k in (0, 1)])
    fix_error = float(np.sqrt(max(mean_of(mission.navigation.fix_error) ** 2, 0.0)))
    model = TransitModel(data, base, error.covariance, fix_error, (float(spread[0]), float(spread[1])))
    return _with_given_effects(model, mission)


def _expected_velocity(data: TransitData, means: Scenario, drawn: Scenario, name: str) -> tuple[Array, Array]:
    """Velocity error that the site's current gives each leg, shape (2, n), and how unsure it is, shape (2,) [m/s]."""
    if means.current is None or drawn.current is None:
        return np.zeros((2, data.n)), np.zeros(2)
    depth = float(np.mean(means[f"{name}.depth"]))
    through = data.dead_reckoned - data.start
    velocity = means.current.mean_velocity(data.t_start, data.under_way, depth, data.start, through)
    surfaced = data.t_start + data.under_way
    drift = means.current.velocity(surfaced, 0.0, data.end)
    expected = velocity + drift * data.surface / data.under_way
    place = np.repeat(data.start[:, :1], DRAWS, axis=1)
    draws = drawn.current.velocity(float(data.t_start[0]), depth, place)
    return np.broadcast_to(expected, (2, data.n)).copy(), np.broadcast_to(draws, (2, DRAWS)).std(axis=1)


def _given(mission: Mission) -> list[Effect]:
    """The effects that the mission carries already, at their means; on readings too."""
    return [
        CATALOGUE[entry.effect].make({name: mean_of(value) for name, value in entry.parameters.items()})
        for entry in mission.effects
    ]


def _with_given_effects(model: TransitModel, mission: Mission) -> TransitModel:
    base = model.base.copy()
    data, leg = model.data, model.leg
    for effect in _given(mission):
        if isinstance(effect, TransitEffect):
            drift = effect.surface_velocity(data.t_start + data.under_way, data.surface, data.end)
            base = base + effect.velocity(leg) + drift * data.surface / data.under_way
    return TransitModel(data, base, model.covariance, model.fix_error, model.current_sd)


def descent_model(data: PreparedDives, mission: Mission) -> DescentModel:
    """Bind the mission's first mooring to dive logs.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    build, given = _builder(mission)
    return DescentModel(DescentForward(build, data.dives, given))


def summary_model(data: SummaryData, mission: Mission) -> SummaryModel:
    """Bind the mission's first mooring to summaries of dives.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    build, given = _builder(mission)
    logs = tuple(as_log(test) for test in data.tests)
    return SummaryModel(SummaryForward(build, logs, given, tests=data.tests))


def _builder(mission: Mission) -> tuple[Callable[[Array, Array], Dive], tuple[DescentEffect, ...]]:
    """The mission's descent from weights and lines, and the effects that it carries."""
    moor = mooring(mission)
    scenario = Scenario.at_means(mission)

    def build(weights: Array, lines: Array) -> Dive:
        own = {f"{moor.name}.anchor_wet_weight": weights, f"{moor.name}.line_length": lines}
        here = Scenario(mission, {**scenario.draws, "site.depth": 0.0, **own})
        return dive_of(here, moor.model_copy(update={"anchor_wet_weight": float(weights[0])}))

    return build, tuple(effect for effect in _given(mission) if isinstance(effect, DescentEffect))


def mooring(mission: Mission) -> MoorPhase:
    """The mission's first mooring, when it has what a descent needs.

    Raises
    ------
    InputError
        When it lacks something.
    """
    problems = []
    if not mission.moors:
        problems.append(Problem("has no mooring to lay the dives against", mission.file, key="phases"))
    if mission.vehicle is None or mission.vehicle.anchor is None or mission.vehicle.mass is None:
        problems.append(Problem("needs a vehicle with mass and anchor to be diagnosed", mission.file, key="vehicle"))
    if mission.site is None or mission.site.water is None:
        problems.append(Problem("needs the site's water to be diagnosed", mission.file, key="site.water"))
    if problems:
        raise InputError(problems)
    return mission.moors[0]
