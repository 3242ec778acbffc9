"""Fits of several sets of causes, divided among processes, and the best relinearised together."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, FitsTogether, Model
from missionplan.montecarlo.parallel.mapping import parallel_map


def fitted(model: Model, requests: Sequence[FitRequest], jobs: int = 1) -> list[CauseFit | FailedFit]:
    """Fit several sets; relinearise what is fitted together.

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
    found = parallel_map(model.fit_all, requests, jobs=jobs, separately=not isinstance(model, FitsTogether))
    fits = [_in_numbers(fit) for fit in found]
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
