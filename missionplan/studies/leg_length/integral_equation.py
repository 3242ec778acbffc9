"""Expected costs of a sweep by the integral equation, and what of a mission it does not allow for."""

import itertools

from missionplan.montecarlo.distributions import Distribution, mean_of
from missionplan.phases.transit.analytic.expectation import MAX_RATIO, TransitExpectation, expected_transit
from missionplan.phases.transit.leg_table import LegTable
from missionplan.studies.leg_length.sweep_scenario import SweepScenario, start_of


def analytic_obstacle(scenario: SweepScenario) -> str:
    """Return the first property of the mission that the analytic cost does not allow for; empty where there is none."""
    mission, navigation = scenario.mission, scenario.navigation
    (phase,) = (transit for transit in mission.transits if transit.name == scenario.phase.name)
    error = navigation.velocity_error
    places = [place for place in (start_of(mission, phase), phase.to) if isinstance(place, tuple)]
    course = (phase.speed, phase.shaft_rate, phase.arrival_radius, *itertools.chain.from_iterable(places))
    uncertain = (*course, navigation.surfacing_time, *error.mean)
    own_error = () if mission.sweep.sigma else (error.sigma,)
    obstacles = {
        "a current": bool(mission.site and mission.site.current),
        "drift compensation": navigation.drift_compensation != "none",
        "a fix error": navigation.fix_error != 0.0,
        "effects": bool(scenario.means.effects_afloat),
        "a propeller, which takes time to gather way": scenario.plan(0, scenario.means).length_lost is not None,
        "uncertain speed, error, surfacing time or place": any(
            isinstance(quantity, Distribution) for quantity in (*uncertain, *own_error)
        ),
        "a velocity error that is not isotropic": not mission.sweep.sigma and error.isotropic_sigma is None,
        "a velocity error whose mean is not zero": any(mean_of(component) != 0.0 for component in error.mean),
        f"a velocity error over {MAX_RATIO:g} of the speed": any(
            scenario.sigma(index) > MAX_RATIO * scenario.speed for index in range(len(scenario.sigmas))
        ),
    }
    return next((words for words, applies in obstacles.items() if applies), "")


def analytic_curve(scenario: SweepScenario, index: int) -> tuple[TransitExpectation, ...]:
    """Solve for the expected transit of every d_max of a curve, and of the table after them."""
    sigma = scenario.sigma(index)
    lengths: list[float | LegTable] = [float(d_max) for d_max in scenario.d_max]
    return tuple(
        expected_transit(
            scenario.distance, d_max, scenario.speed, scenario.arrival_radius, sigma, scenario.surfacing_time
        )
        for d_max in [*lengths, *([scenario.table] if scenario.table is not None else [])]
    )
