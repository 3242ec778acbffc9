"""What the causes of a diagnosis are, as the catalogue has them: what happens, its usual size, what it looks like."""

from missionplan.effects import CATALOGUE
from missionplan.report.page import PageSection
from missionplan.results.diagnosis import Diagnosis
from missionplan.results.evidence import Causes

_DESCRIBED = 5


def names(causes: Causes) -> str:
    """Write a set of causes in words."""
    plain = [cause.replace("-", " ") for cause in causes]
    return plain[0] if len(plain) == 1 else ", ".join(plain[:-1]) + f" and {plain[-1]}" if plain else "no cause"


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
