"""A transit of a mission as the phase takes it: plan, normals and surroundings for a block of trials."""

import numpy as np
from numpy.typing import NDArray

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.mission import Navigation
from missionplan.mission.phases import LegTable as TableSection
from missionplan.mission.phases import TransitPhase
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.streams import LegNormals
from missionplan.phases.compensation import Compensation, Forecast, compensation_named
from missionplan.phases.currents import Current
from missionplan.phases.hooks import Scalars, TransitEffect
from missionplan.phases.legs import LegTable
from missionplan.phases.transit_plan import Surroundings, TransitNormals, TransitPlan, VelocityError
from missionplan.studies.site import Drawn, means, position, site_current

Array = NDArray[np.float64]


def navigation_of(mission: Mission) -> Navigation:
    """Give the section that every transit needs.

    Raises
    ------
    InputError
        When the mission has none.
    """
    if mission.navigation is None:
        raise InputError([Problem("missing; a transit needs it", mission.file, key="navigation")])
    return mission.navigation


def transit_plan(mission: Mission, phase: TransitPhase, drawn: Drawn) -> TransitPlan:
    """Build the plan of a transit from the draws of a block."""
    navigation, name = navigation_of(mission), phase.name
    origin = mission.site.origin if mission.site else None
    d_max: Scalars | LegTable
    if isinstance(phase.d_max, TableSection):
        left, leg = np.array(phase.d_max.table, dtype=float).T
        d_max = LegTable(left, leg)
    else:
        d_max = drawn[f"{name}.d_max"]
    return TransitPlan(
        goal=position(mission, phase.to, f"{name}.to", drawn),
        speed=drawn[f"{name}.speed"],
        arrival_radius=drawn[f"{name}.arrival_radius"],
        d_max=d_max,
        surfacing_time=drawn["navigation.surfacing_time"],
        velocity_error=velocity_error(navigation, drawn),
        fix_error=drawn["navigation.fix_error"],
        depth=drawn[f"{name}.depth"],
        max_legs=navigation.max_legs,
        latitude=origin.latitude if origin else float("nan"),
    )


def velocity_error(navigation: Navigation, drawn: Drawn) -> VelocityError:
    """Build N(v̄, Σ_v) of Eq. 24 from the draws of a block."""
    path = "navigation.velocity_error"
    mean = np.stack(np.broadcast_arrays(*(np.asarray(drawn[f"{path}.mean[{axis}]"]) for axis in (0, 1))))
    if navigation.velocity_error.sigma is None:
        return VelocityError.general(navigation.velocity_error.covariance, mean)
    return VelocityError.isotropic(drawn[f"{path}.sigma"], mean)


def transit_normals(mission: Mission, phase: TransitPhase, seed: int, block: int) -> TransitNormals:
    """Open the streams of a transit's normals for a block."""
    names = [f"{phase.name}.effects.{effect}" for effect in _transit_effects(mission)]
    return TransitNormals(
        velocity=LegNormals(seed, f"{phase.name}.velocity_error", block),
        fix_on_surfacing=LegNormals(seed, f"{phase.name}.fix_on_surfacing", block),
        fix_on_diving=LegNormals(seed, f"{phase.name}.fix_on_diving", block),
        fix_at_start=LegNormals(seed, f"{phase.name}.fix_at_start", block),
        effects=[LegNormals(seed, name, block) for name in names],
    )


def surroundings(mission: Mission, phase: TransitPhase, drawn: Drawn) -> Surroundings:
    """Build the current, the compensation and the effects of a transit from the draws of a block."""
    return Surroundings(site_current(mission, drawn), compensation(mission, phase), _effects(mission, drawn))


def compensation(mission: Mission, phase: TransitPhase) -> Compensation | None:
    """Build the mission's drift compensation; it knows the means of the mission's models."""
    navigation, known = navigation_of(mission), means(mission)
    error = navigation.velocity_error
    forecast = Forecast(
        current=site_current(mission, known),
        mean_error=np.array([mean_of(component) for component in error.mean]),
        depth=mean_of(phase.depth),
        surfacing_time=mean_of(navigation.surfacing_time),
    )
    fix_error = mean_of(navigation.fix_error)
    return compensation_named(navigation.drift_compensation, forecast, error.covariance, fix_error)


def mean_drift(mission: Mission, phase: TransitPhase, start: Array) -> Array:
    """Mean velocity that carries the vehicle under way at the start, v̄ and the mean current, shape (2,) [m/s]."""
    error = np.array([mean_of(component) for component in navigation_of(mission).velocity_error.mean])
    current: Current | None = site_current(mission, means(mission))
    if current is None:
        return error
    return error + current.velocity(0.0, mean_of(phase.depth), start.reshape(2, -1)[:, :1])[:, 0]


def _transit_effects(mission: Mission) -> list[str]:
    return [entry.effect for entry in mission.effects if CATALOGUE[entry.effect].phase == "transit"]


def _effects(mission: Mission, drawn: Drawn) -> tuple[TransitEffect, ...]:
    built = []
    for entry in mission.effects:
        info = CATALOGUE[entry.effect]
        if info.phase == "transit":
            parameters = {name: drawn[f"effects.{entry.effect}.{name}"] for name in entry.parameters}
            effect = info.effect(**parameters)
            assert isinstance(effect, TransitEffect)
            built.append(effect)
    return tuple(built)
