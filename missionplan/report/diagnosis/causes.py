"""What the causes of a diagnosis are, as the catalogue has them: what happens, its usual size, what it looks like."""

from collections.abc import Iterable, Mapping, Sequence

from missionplan.effects import CATALOGUE
from missionplan.report.page import PageSection
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import Causes, ParameterEstimate

_DESCRIBED = 5
MOST_CERTAIN = 0.999
"""Probability beyond which it is not told more exactly: the models are approximate."""


ALMOST_ALL = 0.995
"""Part of a whole beyond which it is told no more exactly."""


def names(causes: Causes) -> str:
    """Write a set of causes in words."""
    return enumerated([cause.replace("-", " ") for cause in causes])


def found_causes(causes: Causes, found: Iterable[ParameterEstimate]) -> str:
    """Write a set of causes in words, of their sizes as found: one too large to be true is said to be like it."""
    sizes = {(parameter.effect, parameter.name): abs(parameter.value) for parameter in found}
    return enumerated([_found(cause, sizes) for cause in causes])


def _found(cause: str, sizes: Mapping[tuple[str, str], float]) -> str:
    likeness = CATALOGUE[cause].likeness
    if likeness is not None and sizes.get((cause, likeness.parameter), 0.0) > likeness.size:
        return likeness.words
    return names((cause,))


def enumerated(words: Sequence[str]) -> str:
    """Join words with commas and an "and"."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + f" and {words[-1]}" if words else "no cause"


def explanations_in_words(diagnosis: Diagnosis) -> str:
    """Write what is in doubt, with its probabilities; empty where nothing is."""
    told = [
        f"{names(each.causes) if each.causes else 'none of them'} {percent(each.probability)}"
        + ("" if each.prior is None else f" (was {percent(each.prior)})")
        for each in diagnosis.explanations
    ]
    if not told:
        return ""
    if any(each.prior is not None for each in diagnosis.explanations):
        return f"Of the mission's explanations the probabilities are now: {', '.join(told)}."
    return f"It carries the doubt, each trial drawing which explanation holds: {', '.join(told)}."


def percent(probability: float) -> str:
    """Write a probability, which is never certain."""
    if probability > MOST_CERTAIN:
        return f"> {100.0 * MOST_CERTAIN:.1f} %"
    if probability < 1.0 - MOST_CERTAIN:
        return f"< {100.0 * (1.0 - MOST_CERTAIN):.1f} %"
    return f"{100.0 * probability:.1f} %"


def part(share: float) -> str:
    """Write a part of a whole, which is never said to be all of it: the models are approximate."""
    return "over 99 %" if share > ALMOST_ALL else f"{100.0 * share:.0f} %"


def causes_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Describe the causes claimed, then those that would do nearly as well."""
    claimed = [cause for causes in (diagnosis.causes, *diagnosis.rivals) for cause in causes]
    described = list(dict.fromkeys(claimed))[:_DESCRIBED]
    heading = "What such a cause is" if len(described) == 1 else "What such causes are"
    return [PageSection(heading, [_described(cause) for cause in described])] if diagnosis.causes else []


def _described(cause: str) -> str:
    info = CATALOGUE[cause]
    words = f"{names((cause,)).capitalize()}. {info.what} Sizes that occur: {info.sizes}"
    if info.confused_with:
        words += f" Easily taken for {', '.join(names((other,)) for other in info.confused_with)}."
    return f"{words} What tells it from others: {info.distinguished_by[0].lower()}{info.distinguished_by[1:]}"
