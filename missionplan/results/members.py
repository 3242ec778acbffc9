"""What a plan does in each member of the current's ensemble: which of them spoils it."""

from collections.abc import Sequence
from dataclasses import dataclass

from missionplan.montecarlo.statistics import Probability


@dataclass(frozen=True)
class MemberOutcome:
    """What a plan does in one member.

    Attributes
    ----------
    name : str
    probability : float
        Of the member.
    good : Probability
        Of what the plan is for, where the member comes true: success, arrival, a dive within the radius.
    """

    name: str
    probability: float
    good: Probability

    def summary(self) -> dict[str, object]:
        """Return the entry of `summary.json`."""
        return {"member": self.name, "probability": self.probability, "good": self.good.summary()}


def members_differ(members: Sequence[MemberOutcome]) -> bool:
    """Whether the plan does better in one member than in another, beyond chance: 95 % intervals apart."""
    return bool(members) and max(each.good.low for each in members) > min(each.good.high for each in members)
