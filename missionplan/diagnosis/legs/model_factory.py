"""From a mission and a navigation log to a model: the mission's first transit at its means, bound to the legs."""

import math
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.given.priors import check_together, given_effects, given_priors
from missionplan.diagnosis.legs.likelihood.covariance import FIX_UNSTATED
from missionplan.diagnosis.legs.likelihood.fix_gaps import share_of_fix_errors
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.effects import effects_of
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.views import navigation_of
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.currents import Current, Span
from missionplan.phases.hooks import TransitEffect
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current

DRAWS = 512
"""Draws of the mission from which its own uncertainty of the current is taken."""


def transit_model(data: TransitData, mission: Mission, seed: int) -> TransitModel:
    """Bind a mission's first transit to a navigation log.

    Parameters
    ----------
    data : TransitData
        The log.
    mission : Mission
    seed : int
        Of the draws of the mission's current.

    Raises
    ------
    InputError
        When the mission has no transit or no navigation, or its current cannot be read.
    """
    navigation = navigation_of(mission)
    recorded = recorded_current(mission, np.hstack((data.start, data.end)))
    means = Scenario.at_means(mission, recorded)
    drawn = means.sampled(seed=seed, block=0, size=DRAWS)
    if means.current is not None:
        check_cover(data, means.current, float(np.mean(means.transit().depth)), mission)
    current, base, spread = _expected_velocity(data, means, drawn)
    error = navigation.velocity_error
    base = base + np.array([[mean_of(part)] for part in error.mean])
    spread = np.hypot(spread, [np.std(side) for side in drawn.velocity_error.mean])
    fix_error = float(np.sqrt(max(mean_of(navigation.fix_error) ** 2, 0.0)))
    given = given_priors(mission, effects_of("transit"))
    check_together(given, mission, "transit")
    current_sd = (float(spread[0]), float(spread[1]))
    phase = means.transit()
    planned = float(np.mean(phase.speed)), float(np.mean(phase.depth))
    model = TransitModel(
        data, base, error.covariance, fix_error, current_sd, given, site_current=current, planned=planned
    )
    return with_fix_share(replace(model, base=_with_given_effects(model, mission)))


def with_fix_share(model: TransitModel) -> TransitModel:
    """Return a model with the part of the gaps between fixes that is an error of either, estimated from its log."""
    sigma = math.sqrt(max(0.5 * float(np.trace(model.covariance)), 1e-6))
    fix_sd = model.data.typical_fix_sd or model.fix_error or FIX_UNSTATED[0]
    data, error = model.data, model.data.velocity_error - model.base
    share = share_of_fix_errors(model.gaps, error, data.under_way, sigma, fix_sd)
    if not share:
        return model
    notice = (
        "The errors of fixes show in the gaps between the fix after a leg and the one before the next: "
        f"{100.0 * share:.0f} % of a gap is taken as the error of either fix."
    )
    return replace(model, data=replace(data, notices=(*data.notices, notice)), fix_share=share)


def check_cover(data: TransitData, current: Current, depth: float, mission: Mission) -> None:
    """Refuse a log that leaves the record of the current: its misfit would be that of a current made up.

    Raises
    ------
    InputError
        With the number of such legs, and the times of the log.
    """
    if not current.is_binding:
        return
    ends = data.t_start + data.under_way
    covered = np.broadcast_to(current.covers(Span(data.t_start, ends, depth, (data.start, data.end))), ends.shape)
    if covered.all():
        return
    hours = (float(data.t_start.min()) / 3600.0, float(ends.max()) / 3600.0)
    legs = f"{np.count_nonzero(~covered)} of the {data.n} legs of {data.name}"
    when = f"the log runs from {hours[0]:.1f} to {hours[1]:.1f} h after the mission's start, {depth:.0f} m down"
    hint = "is start: right? `outside: hold` in site.current keeps the record's last value"
    problem = f"{legs} lie beyond this record of the current: {when}"
    raise InputError([Problem(problem, mission.file, key="site.current", hint=hint)])


def _expected_velocity(data: TransitData, means: Scenario, drawn: Scenario) -> tuple[Array, Array, Array]:
    """The site's current on each leg, with that at the surface, each (2, n), and its standard deviation (2,) [m/s]."""
    if means.current is None or drawn.current is None:
        return np.zeros((2, data.n)), np.zeros((2, data.n)), np.zeros(2)
    depth = float(np.mean(means.transit().depth))
    through = data.dead_reckoned - data.start
    velocity = means.current.mean_velocity(data.t_start, data.under_way, depth, data.start, through)
    surfaced = data.t_start + data.under_way
    drift = means.current.velocity(surfaced, 0.0, data.end)
    expected = velocity + drift * data.surface / data.under_way
    place = np.repeat(data.start[:, :1], DRAWS, axis=1)
    draws = drawn.current.velocity(float(data.t_start[0]), depth, place)
    under_way, whole = (np.broadcast_to(each, (2, data.n)).copy() for each in (velocity, expected))
    return under_way, whole, np.broadcast_to(draws, (2, DRAWS)).std(axis=1)


def _with_given_effects(model: TransitModel, mission: Mission) -> Array:
    """Velocity error that the mission expects, its own effects at their means included, shape (2, n) [m/s]."""
    effects = [effect for effect in given_effects(mission) if isinstance(effect, TransitEffect)]
    return model.base + model.velocity_error(effects)
