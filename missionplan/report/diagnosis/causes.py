"""What the causes of a diagnosis are, as the catalogue has them: what happens, its usual size, what it looks like."""

from collections.abc import Iterable, Mapping, Sequence

from missionplan.effects import CATALOGUE
from missionplan.report.page import PageSection
from missionplan.results.diagnosis import Diagnosis
from missionplan.results.evidence import Causes, ParameterEstimate

_DESCRIBED = 5


def names(causes: Causes) -> str:
    """Write a set of causes in words."""
    return _enumerated([cause.replace("-", " ") for cause in causes])


def found_causes(causes: Causes, found: Iterable[ParameterEstimate]) -> str:
    """Write a set of causes in words, of their sizes as found: one too large to be true is said to be like it."""
    sizes = {(parameter.effect, parameter.name): abs(parameter.value) for parameter in found}
    return _enumerated([_found(cause, sizes) for cause in causes])


def _found(cause: str, sizes: Mapping[tuple[str, str], float]) -> str:
    likeness = CATALOGUE[cause].likeness
    if likeness is not None and sizes.get((cause, likeness.parameter), 0.0) > likeness.size:
        return likeness.words
    return names((cause,))


def _enumerated(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + f" and {words[-1]}" if words else "no cause"


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
