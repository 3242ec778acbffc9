"""Levels of a vehicle's parameters from all that its records have told of them."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from missionplan.effects import CATALOGUE
from missionplan.mission.learned import Series, series_of
from missionplan.montecarlo.levels import Seen
from missionplan.results.learned.levels import Level, ParameterLevels


def parameter_levels(seen: Sequence[Seen], reports: Mapping[str, str] | None = None) -> tuple[ParameterLevels, ...]:
    """Return how each parameter that has a level went from mission to mission.

    Parameters
    ----------
    seen : sequence of Seen
        What records have told.
    reports : mapping, optional
        Names of the records by their hashes.
    """
    found = series_of(seen)
    return tuple(_told(series, reports or {}) for key, series in found.items() if key[2] == "strength")


def _told(series: Series, reports: Mapping[str, str]) -> ParameterLevels:
    levels, then = series.levels()
    mean, sd = levels.at(np.append(levels.measured.times, then))
    missions = tuple(
        Level(reports.get(each.record, each.record), each.date if math.isfinite(each.date) else None, *numbers)
        for each, *numbers in zip(
            series.records[-len(levels.measured.times) :],
            mean[:-1].tolist(),
            sd[:-1].tolist(),
            levels.jumps.tolist(),
            strict=True,
        )
    )
    effect, name, _ = series.of
    unit = CATALOGUE[effect].parameters[name].unit
    return ParameterLevels(effect, name, unit, missions, *levels.trend, float(mean[-1]), float(sd[-1]))
