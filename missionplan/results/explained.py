"""What a simulated mission does under each explanation that it carries, beside what it does over all of them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from missionplan.montecarlo.statistics import Probability, Statistic

Causes = tuple[str, ...]


@dataclass(frozen=True)
class ExplainedOutcome:
    """The trials of a simulation in which one explanation holds.

    Attributes
    ----------
    place : str
        Key path of the `one-of`.
    number : int
        Of the explanation there; how many there are, for none.
    causes : tuple of str
        Its effects; empty for none.
    probability : float
        Of the explanation, as the mission gives it.
    success : Probability
    duration, energy : Statistic
        Of the whole mission [s, W h].
    trials : int
    """

    place: str
    number: int
    causes: Causes
    probability: float
    success: Probability
    duration: Statistic
    energy: Statistic
    trials: int

    def summary(self) -> dict[str, object]:
        """Return the entry of `summary.json`."""
        return {
            "place": self.place,
            "number": self.number,
            "causes": list(self.causes),
            "probability": self.probability,
            "trials": self.trials,
            "success": self.success.summary(),
            "duration_s": self.duration.summary(),
            "energy_wh": self.energy.summary(),
        }


def success_differs(explained: Sequence[ExplainedOutcome]) -> bool:
    """Whether success is likelier under one explanation than under another, beyond chance: 95 % intervals apart."""
    tried = [each.success for each in explained if each.trials]
    return bool(tried) and max(each.low for each in tried) > min(each.high for each in tried)


def label(causes: Iterable[str]) -> str:
    """Name an explanation: its effects in words."""
    words = [cause.replace("-", " ") for cause in causes]
    return " and ".join(words) if words else "none of them"
