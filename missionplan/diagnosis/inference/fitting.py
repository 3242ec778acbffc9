"""Fits of several sets of causes, divided among processes; some are repeated, and the best relinearised together."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, FitsTogether, Model
from missionplan.montecarlo.parallel.mapping import parallel_map

RETRIES = 2
"""Pairs that are fitted again when they ended where they are impossible."""


def fitted(model: Model, requests: Sequence[FitRequest], jobs: int = 1) -> list[CauseFit | FailedFit]:
    """Fit several sets, pairs that ended badly once more from a fresh start; relinearise what is fitted together.

    A local search finds a local optimum: a fresh start is multistart with two starts (Rinnooy Kan & Timmer
    1987, *Math. Program.* 39).

    Parameters
    ----------
    model : Model
        Which fits.
    requests : sequence
        Sets, each with fits to start from.
    jobs : int
        Processes.

    Returns
    -------
    list
        A fit, or why there is none, for each set in their order.
    """
    fits = _fit_all(model, requests, jobs)
    for index, other in _retried(model, requests, fits, jobs):
        if isinstance(other, CauseFit) and other.possible:
            fits[index] = other
    fits = [_in_numbers(fit) for fit in fits]
    if not isinstance(model, FitsTogether):
        return fits
    best = max((fit.log_evidence for fit in fits if isinstance(fit, CauseFit)), default=0.0)
    return parallel_map(partial(model.relinearised, best=best), fits, jobs=jobs)


def _in_numbers(fit: CauseFit | FailedFit) -> CauseFit | FailedFit:
    """Return a fit whose evidence and estimates are finite; else say that it is none."""
    if isinstance(fit, FailedFit):
        return fit
    numbers = [fit.log_evidence]
    for each in (*fit.estimates, *fit.given):
        numbers += [each.value, each.sd, each.low, each.high]
    return fit if np.all(np.isfinite(numbers)) else FailedFit(fit.causes, "the data do not determine its parameters")


def _retried(
    model: Model, requests: Sequence[FitRequest], fits: Sequence[CauseFit | FailedFit], jobs: int
) -> list[tuple[int, CauseFit | FailedFit]]:
    """Fit again, from a fresh start, the best pairs that ended where they are impossible."""
    impossible = [
        (fit.log_evidence, index)
        for index, fit in enumerate(fits)
        if isinstance(fit, CauseFit)
        and len(fit.causes) == 2
        and not fit.possible
        and model.may_be_multimodal(fit.causes)
    ]
    again = [index for _, index in sorted(impossible, reverse=True)[:RETRIES]]
    afresh: list[FitRequest] = [(requests[index][0], ()) for index in again]
    return list(zip(again, _fit_all(model, afresh, jobs), strict=True))


def _fit_all(model: Model, requests: Sequence[FitRequest], jobs: int) -> list[CauseFit | FailedFit]:
    return parallel_map(model.fit_all, requests, jobs=jobs, separately=not isinstance(model, FitsTogether))
