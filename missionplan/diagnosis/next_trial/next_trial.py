"""Which trial is worth making next: designs valued by what the choice after them would save, with their costs."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import cast

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.judgement import Judgement
from missionplan.diagnosis.next_trial.belief import believe, possible_fits
from missionplan.diagnosis.next_trial.designs import TrialKind
from missionplan.diagnosis.next_trial.valuation import Valuation
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.errors import MissionplanError
from missionplan.results.next_trial import NextTrial

KINDS: Mapping[str, tuple[str, str]] = {
    "transit": ("leg_trials", "LegTrials"),
    "descent": ("dive_trials", "DiveTrials"),
}
"""By kind of data, module and class of its trials."""


def next_trial(bound: DataKind, found: PipelineResult, judgement: Judgement, scale: float, seed: int) -> NextTrial:
    """Value the trials that could follow a diagnosis, or find out why that cannot be done.

    Parameters
    ----------
    bound : DataKind
        The data so far, bound to the mission.
    found, judgement
        What the diagnosis found.
    scale : float
        Of the random errors, as in the extended mission.
    seed : int
        Of all draws.
    """
    if bound.kind not in KINDS:
        return NextTrial(reason=f"no trials are designed for data of kind {bound.kind}")
    try:
        return valuation(bound, found, judgement, scale, seed).result(bound)
    except (MissionplanError, FloatingPointError) as error:
        return NextTrial(reason=str(error))


def valuation(bound: DataKind, found: PipelineResult, judgement: Judgement, scale: float, seed: int) -> Valuation:
    """Draw what is unknown after a diagnosis and run the missions: parameters as of `next_trial`.

    Raises
    ------
    InputError
        When an extended mission is not valid, or lacks what is to be chosen.
    """
    module, name = KINDS[bound.kind]
    made = getattr(import_module(f"missionplan.diagnosis.next_trial.{module}"), name)
    kind = cast("Callable[[DataKind], TrialKind]", made)(bound)
    believed = believe(
        possible_fits(found, judgement),
        bound.model_coordinates,
        kind.posterior,
        lambda fit: bound.extended_mission(bound.widened(fit, scale)),
    )
    return Valuation.of(kind, believed, seed)
