"""Correlations against the quantities that they name."""

from collections.abc import Mapping, Sequence

from missionplan.errors import LocalProblem
from missionplan.mission.schema.effect_list import OneOf
from missionplan.mission.schema.monte_carlo import CorrelationSection
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.draws import correlation_problems


def check_correlations(
    correlations: Sequence[CorrelationSection], quantities: Mapping[str, Quantity], doubts: Sequence[OneOf] = ()
) -> list[LocalProblem]:
    """List what keeps a mission's quantities, given by key path, from having these correlations.

    Those of an explanation are written in it: one matrix then holds together at a time.
    """
    problems = [
        LocalProblem((number, "between", side), f"{name} belongs to an explanation", "its own `correlations` hold it")
        for number, correlation in enumerate(correlations)
        for side, name in enumerate(correlation.between)
        if any(name.startswith(doubt.place) for doubt in doubts)
    ]
    problems = problems or correlation_problems(quantities, [correlation.pair for correlation in correlations])
    return [problem.within(("correlations",)) for problem in problems]
