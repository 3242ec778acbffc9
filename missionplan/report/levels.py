"""Levels of a vehicle's parameters in words: trends, with what to do about them, and jumps."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.evidence import sized
from missionplan.report.diagnosis.findings import sized_clause
from missionplan.report.wording import capitalised, parameter_in_words
from missionplan.results.learned.evidence import ParameterEstimate
from missionplan.results.learned.levels import ParameterLevels

UPKEEP = "find out what changes it from mission to mission"
"""What to do about a trend of which the catalogue says nothing."""


def trends_in_words(levels: Iterable[ParameterLevels]) -> Iterator[str]:
    """Tell each trend as one: ``A trend: with each mission the vehicle goes 2.0 ± 0.2 % slower …: clean the hull``."""
    for each in levels:
        if not each.has_trend:
            continue
        info, trend = CATALOGUE[each.effect], _estimate(each, each.trend, each.trend_sd)
        own = sized_clause(info.finding, {each.name: trend}) if info.finding is not None else ""
        told = own or f"{parameter_in_words(each.effect, each.name)} changes by {sized(trend)}"
        urgent = "" if each.matters_in is None else f" In {each.matters_in} missions it costs success."
        upkeep = info.upkeep or UPKEEP
        coming = _sized(each, each.next_value, each.next_sd)
        yield f"A trend: with each mission {told}: {upkeep}. The next mission is planned with {coming}.{urgent}"


def jumps_in_words(levels: Iterable[ParameterLevels]) -> Iterator[str]:
    """Tell where a parameter jumped."""
    for each in levels:
        for jump in each.jumps:
            name = capitalised(parameter_in_words(each.effect, each.name))
            yield f"{name} jumped before {jump.record}, to {_sized(each, jump.value, jump.sd)}."


def _estimate(each: ParameterLevels, value: float, sd: float) -> ParameterEstimate:
    return ParameterEstimate(each.effect, each.name, value, sd, value - sd, value + sd, each.unit)


def _sized(each: ParameterLevels, value: float, sd: float) -> str:
    """Write a value of a parameter, a share in per cent."""
    finding = CATALOGUE[each.effect].finding
    found = _estimate(each, value, sd)
    if finding is not None and finding.in_percent and finding.parameter == each.name:
        found = replace(found, value=100.0 * value, sd=100.0 * sd, unit="%")
    return sized(found)
