"""Correlations against the quantities that they name."""

from collections.abc import Mapping, Sequence

from missionplan.errors import LocalProblem
from missionplan.mission.schema.monte_carlo import CorrelationSection
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.draws import correlation_problems


def check_correlations(
    correlations: Sequence[CorrelationSection], quantities: Mapping[str, Quantity]
) -> list[LocalProblem]:
    """List what keeps a mission's quantities, given by key path, from having these correlations."""
    found = correlation_problems(quantities, [correlation.pair for correlation in correlations])
    return [problem.within(("correlations",)) for problem in found]
