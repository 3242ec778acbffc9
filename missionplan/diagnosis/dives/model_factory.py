"""From a mission and dive logs to a model: the mission's first mooring at its means, bound to the dives."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from missionplan.arrays import Array
from missionplan.datasets.records import DescentData, MeasuredDive
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.preparation import PreparedDives
from missionplan.diagnosis.given.effects import GivenEffect
from missionplan.diagnosis.given.priors import check_together, given_effects, given_priors
from missionplan.effects import effects_of
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.views import MooringMission
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import descent_stages
from missionplan.phases.mooring.forces import DescentHooks, Dive
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario

AT_SURFACE = 0.5
"""Depth that a vehicle at the surface is read at, at most: waves, trim and the offset of a sensor [m]."""
SMOOTHED = 5
"""Readings of which the median is taken."""


def descent_model(data: PreparedDives, mission: Mission) -> DescentModel:
    """Bind a mission's first mooring to dive logs.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    return DescentModel(DescentForward(descent_builder(mission), data.dives), given_on_descent(mission))


def given_on_descent(mission: Mission) -> tuple[GivenEffect, ...]:
    """Return a mission's own effects on a descent, as its dives are diagnosed.

    Raises
    ------
    InputError
        When a diagnosis cannot hold them together.
    """
    given = given_priors(mission, effects_of("descent"))
    check_together(given, mission, "descent")
    return given


def descent_builder(mission: Mission) -> Callable[[Array, Array], Dive]:
    """Return the mission's descent, without effects, as a function of wet weights [N] and line lengths [m].

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    MooringMission.of(mission, depth=False)
    scenario = Scenario.at_means(mission).at_depth(0.0)

    def build(weights: Array, lines: Array) -> Dive:
        phase = scenario.moor().model_copy(update={"line_length": lines, "lateral": "uncoupled"})
        return dive_of(scenario, phase, weights)

    return build


def check_leaves_surface(data: DescentData, mission: Mission) -> None:
    """Refuse dives in which the vehicle never leaves the surface, or whose log ends before it could.

    Raises
    ------
    InputError
        With each of them.
    """
    floating = [dive for dive in data.dives if float(_running_median(dive.depth).max()) < AT_SURFACE]
    if not floating:
        return
    problems = []
    for dive, taut in zip(floating, _taut_times(floating, mission), strict=True):
        end = float(dive.t[-1])
        if end <= taut:
            words = f"the log ends {end:.3g} s after the separation, before the line is taut (at {taut:.3g} s)"
        else:
            words = (
                f"the vehicle never leaves the surface: its depths are at most {dive.depth.max():.3g} m, and the line "
                f"of {dive.line_length:.4g} m is taut {taut:.3g} s after the separation"
            )
        problems.append(Problem(f"{dive.name}: {words}", data.file, dive.line, "depth_m"))
    raise InputError(problems)


def _taut_times(dives: list[MeasuredDive], mission: Mission) -> Array:
    """Times from the separation to the taut line as the mission expects them, shape (n,) [s]."""
    weights, lines, depths = (
        np.array([getattr(dive, key) for dive in dives]) for key in ("wet_weight", "line_length", "site_depth")
    )
    effects = [effect for effect in given_effects(mission) if isinstance(effect, DescentEffect)]
    dive = replace(descent_builder(mission)(weights, lines), site_depth=depths)
    return descent_stages(dive, DescentHooks(effects), len(dives)).taut_at


def _running_median(values: Array) -> Array:
    """Median of each value and its neighbours, the record mirrored at its ends."""
    mirrored = np.pad(values, SMOOTHED // 2, mode="symmetric")
    return np.asarray(np.median(sliding_window_view(mirrored, SMOOTHED), axis=-1))
