"""Verdict: what may be said of a data set, a reading of the posterior (`docs/diagnosis.md`)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import Causes, Verdict

SURE = 0.95
"""Probability from which something is said to be so."""
LIKELY = 0.5


@dataclass(frozen=True)
class Reading:
    """What a posterior says."""

    posterior: Mapping[Causes, float]
    """Probability of each set of causes."""
    nothing: float
    """That nothing is there: no cause, and nothing that no cause explains."""
    none_of_these: float
    """That something which no cause explains is there."""
    families: Sequence[Sequence[Causes]] = ()
    """Sets that differ in nothing that these data show, and that are told as one."""

    @property
    def claimed(self) -> Causes:
        """The likeliest set, where something is there; of a family its likeliest member."""
        if 1.0 - self.nothing < SURE or not self.posterior:
            return ()
        return max(self.posterior, key=lambda causes: self.posterior[causes])

    def probability(self, causes: Causes) -> float:
        """Probability of a set, its supersets and those of the sets told as one with it counted."""
        alike = next((family for family in self.families if causes in family), (causes,))
        held = [other for other in self.posterior if any(set(one) <= set(other) for one in alike)]
        return sum(self.posterior[other] for other in held)

    def verdict(self, *, is_constant: bool = True) -> Verdict:
        """Return the first verdict that fits."""
        if 1.0 - self.nothing < SURE:
            return "adequate"
        claimed = self.claimed
        if not is_physical(claimed) or sum(p for causes, p in self.posterior.items() if is_physical(causes)) < LIKELY:
            return "unexplained"
        if self.none_of_these >= LIKELY or not is_constant:
            return "partly-explained"
        return "ambiguous" if self.probability(claimed) < SURE else "explained"


def is_physical(causes: Causes) -> bool:
    """Whether a set names a physical cause; the others only describe the errors."""
    return any(CATALOGUE[name].tier == "physical" for name in causes)
