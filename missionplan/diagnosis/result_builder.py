"""From what the pipeline found to the tables and entries of the result."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import Candidate
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.montecarlo.parallel.mapping import parallel_map
from missionplan.results.learned.evidence import GroupScore, RankedSet

LISTED = 12
"""Sets of the ranking that are reported."""


def as_reported(bound: DataKind, found: PipelineResult, jobs: int = 1) -> PipelineResult:
    """Return what was found with the estimates of the base model and of the sets listed as they are reported."""
    ranking = found.selection.ranking
    base, *reported = parallel_map(
        partial(_reported_fits, bound), [found.selection.base, *(each.fit for each in ranking[:LISTED])], jobs=jobs
    )
    listed = tuple(replace(each, fit=fit) for each, fit in zip(ranking, reported, strict=False))
    fits = {each.causes: each.fit for each in (*listed, *ranking[LISTED:])}
    return replace(
        found,
        selection=replace(found.selection, base=base, ranking=listed + ranking[LISTED:]),
        best=fits.get(found.best.causes, base),
    )


def _reported_fits(bound: DataKind, fits: Sequence[CauseFit]) -> list[CauseFit]:
    return [bound.as_reported(fit) for fit in fits]


def ranked_sets(bound: DataKind, found: PipelineResult, residuals: pd.DataFrame) -> tuple[RankedSet, ...]:
    """Return the best sets, best first.

    Parameters
    ----------
    bound : DataKind
        The data set.
    found : PipelineResult
        The diagnosis.
    residuals : DataFrame
        Of the data set under the best fit.
    """
    listed = found.selection.ranking[:LISTED]
    shares = bound.shares_explained(found.selection.base, [candidate.fit for candidate in listed], residuals)
    return tuple(_ranked(found, candidate, share) for candidate, share in zip(listed, shares, strict=True))


def _ranked(found: PipelineResult, candidate: Candidate, share: float) -> RankedSet:
    held_out = found.held_out.get(candidate.causes)
    return RankedSet(
        candidate.causes,
        candidate.log_bayes_factor,
        candidate.score,
        found.posterior.get(candidate.causes),
        candidate.fit.estimates,
        held_out.gain if held_out else None,
        share,
    )


def group_scores(found: PipelineResult) -> tuple[GroupScore, ...]:
    """Return the held-out scores of the best set, group by group; none where it was not held out."""
    ranking = found.selection.ranking
    held_out = found.held_out.get(ranking[0].causes) if ranking else None
    if held_out is None:
        return ()
    return tuple(
        GroupScore(
            before.group,
            before.log_score,
            after.log_score,
            float(np.sqrt(before.squared_error / before.count)),
            float(np.sqrt(after.squared_error / after.count)),
        )
        for before, after in zip(held_out.base, held_out.extended, strict=True)
    )
