"""SampledEvidence sampling: a check of the evidence that leans neither on linearity nor on a normal posterior."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.stats import multivariate_t

from missionplan.arrays import Array
from missionplan.montecarlo.streams import stream

DRAWS = 128
DOF, WIDENED = 5, 1.2
"""Of the Student-t proposal: its tails are heavier than the posterior's, and so is its middle wider."""


@dataclass(frozen=True)
class SampledEvidence:
    """Evidence by importance sampling.

    Attributes
    ----------
    log_evidence : float
        ln p(data).
    effective : float
        Draws that count, (Σw)²/Σw²: a few only where the posterior is unlike the one that was assumed.
    """

    log_evidence: float
    effective: float


def sampled_evidence(log_joint: Callable[[Array], Array], mean: Array, covariance: Array) -> SampledEvidence:
    """Integrate a joint density of data and parameters with draws from about the assumed posterior.

    Parameters
    ----------
    log_joint : callable
        ln p(data, parameters) of parameters, shape (s, k) → (s,); what is not finite counts as impossible.
    mean : array, shape (k,)
        Of the posterior as assumed.
    covariance : array, shape (k, k)
        Of the posterior as assumed.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the covariance is not positive definite.
    """
    proposal = multivariate_t(mean, WIDENED**2 * covariance, df=DOF)
    at = np.reshape(proposal.rvs(DRAWS, random_state=stream(0, "diagnose.importance", 0)), (DRAWS, len(mean)))
    logs = log_joint(at) - np.reshape(proposal.logpdf(at), DRAWS)
    logs = np.where(np.isfinite(logs), logs, -np.inf)
    if np.all(np.isneginf(logs)):
        return SampledEvidence(-np.inf, 0.0)
    weights = np.exp(logs - logs.max())
    evidence = float(logs.max() + np.log(weights.mean()))
    return SampledEvidence(evidence, float(weights.sum() ** 2 / np.sum(weights**2)))
