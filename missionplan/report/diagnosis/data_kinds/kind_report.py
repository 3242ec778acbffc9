"""What a report says and draws for one kind of data."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from missionplan.report.page import Figure
from missionplan.results.learned.diagnosis import Diagnosis


def _no_figures(diagnosis: Diagnosis) -> list[Figure]:
    return []


def _no_numbers(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    return []


def _no_gain(diagnosis: Diagnosis, before: float, after: float) -> str:
    return ""


@dataclass(frozen=True)
class KindReport:
    """A kind of data in the report; `kinds.REPORTS` lists them all.

    Attributes
    ----------
    unit : str
        Of errors of prediction.
    data_figure : callable
        Draws the data against the base model, and the extended one where causes are claimed: the report's main figure.
    residual_figures : callable
        Draws what is left before and after.
    numbers : callable
        Further main numbers, as label and value.
    gained : callable
        Writes what the causes gain on data held out, from the rms errors before and after [`unit`]: the end of a
        sentence, or nothing.
    not_constant : str
        What is said of causes that do not hold still, after their names.
    calibration : mapping
        Keys of `Diagnosis.calibration` in words.
    """

    unit: str
    data_figure: Callable[[Diagnosis], Figure]
    residual_figures: Callable[[Diagnosis], list[Figure]] = _no_figures
    numbers: Callable[[Diagnosis], list[tuple[str, str]]] = _no_numbers
    gained: Callable[[Diagnosis, float, float], str] = _no_gain
    not_constant: str = ""
    calibration: Mapping[str, str] = field(default_factory=dict)
