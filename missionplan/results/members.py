"""What a plan does in each member of the current's ensemble: which of them spoils it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from missionplan.montecarlo.statistics import Probability
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class MemberOutcome(Record):
    """What a plan does in one member."""

    name: Annotated[str, Entry("name of the member", key="member")]
    probability: Annotated[float, Entry("of the member")]
    good: Annotated[Probability, Entry("success, arrival or a dive within the radius, where the member comes true")]


def members_differ(members: Sequence[MemberOutcome]) -> bool:
    """Whether the plan does better in one member than in another, beyond chance: 95 % intervals apart."""
    return bool(members) and max(each.good.low for each in members) > min(each.good.high for each in members)
