"""What a mission or a plan does under each explanation that is held possible, and in each member of an ensemble."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.results.entries import Entry, Record

Causes = tuple[str, ...]


@dataclass(frozen=True)
class ExplainedOutcome(Record):
    """The trials of a simulation in which one explanation holds."""

    place: Annotated[str, Entry("key path of the `one-of`")]
    number: Annotated[int, Entry("of the explanation there; how many there are, for none")]
    causes: Annotated[Causes, Entry("its effects; empty for none")]
    probability: Annotated[float, Entry("of the explanation, as the mission gives it")]
    success: Annotated[Probability, Entry("of the whole mission in these trials")]
    duration: Annotated[Statistic, Entry("of the whole mission", "s")]
    energy: Annotated[Statistic, Entry("of the whole mission", "W h")]
    trials: Annotated[int, Entry("in which it holds")]


def success_differs(explained: Sequence[ExplainedOutcome]) -> bool:
    """Whether success is likelier under one explanation than under another, beyond chance: 95 % intervals apart."""
    tried = [each.success for each in explained if each.trials]
    return bool(tried) and max(each.low for each in tried) > min(each.high for each in tried)


def label(causes: Iterable[str]) -> str:
    """Name an explanation: its effects in words."""
    words = [cause.replace("-", " ") for cause in causes]
    return " and ".join(words) if words else "none of them"


@dataclass(frozen=True)
class MemberOutcome(Record):
    """What a plan does in one member."""

    name: Annotated[str, Entry("name of the member", key="member")]
    probability: Annotated[float, Entry("of the member")]
    good: Annotated[Probability, Entry("success, arrival or a dive within the radius, where the member comes true")]


def members_differ(members: Sequence[MemberOutcome]) -> bool:
    """Whether the plan does better in one member than in another, beyond chance: 95 % intervals apart."""
    return bool(members) and max(each.good.low for each in members) > min(each.good.high for each in members)
