"""Which trial is worth making next: designs valued by what the choice after them would save, with their costs."""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import cast

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.explanations import Weighed
from missionplan.diagnosis.next_trial.belief import believe, likely_fits
from missionplan.diagnosis.next_trial.designs import TrialKind
from missionplan.diagnosis.next_trial.valuation import Valuation
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.errors import MissionplanError
from missionplan.results.learned.next_trial import NextTrial

KINDS: Mapping[str, tuple[str, str]] = {
    "transit": ("missionplan.diagnosis.next_trial.leg_trials", "LegTrials"),
    "descent": ("missionplan.diagnosis.next_trial.dive_trials", "DiveTrials"),
}
"""By kind of data, module and class of its trials."""


def next_trial(explanations: Sequence[Weighed], found: PipelineResult, scale: float, seed: int) -> NextTrial:
    """Value the trials that could follow a diagnosis, or find out why that cannot be done.

    Parameters
    ----------
    explanations : sequence of Weighed
        The mission's explanations laid against the data so far, the likeliest first.
    found : PipelineResult
        What the diagnosis found with that one.
    scale : float
        Of the random errors, as in the extended mission.
    seed : int
        Of all draws.
    """
    kind = explanations[0].bound.kind
    if kind not in KINDS:
        return NextTrial(reason=f"no trials are designed for data of kind {kind}")
    try:
        return valuation(explanations, found, scale, seed).result()
    except (MissionplanError, FloatingPointError) as error:
        return NextTrial(reason=str(error))


def valuation(explanations: Sequence[Weighed], found: PipelineResult, scale: float, seed: int) -> Valuation:
    """Draw what is unknown after a diagnosis and run the missions: parameters as of `next_trial`.

    Raises
    ------
    InputError
        When an extended mission is not valid, or lacks what is to be chosen.
    """
    bound = explanations[0].bound
    module, name = KINDS[bound.kind]
    made = getattr(import_module(module), name)
    kind = cast("Callable[[DataKind], TrialKind]", made)(bound)
    believed = believe(likely_fits(explanations, found), kind.posterior, scale)
    return Valuation.of(kind, believed, seed)
