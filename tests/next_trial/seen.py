"""What a trial that was made has told: the choice after it, and the information that it brought."""

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.next_trial.experiment import DecisionProblem, Experiment, _fit


def choice_after(problem: DecisionProblem, summaries: Array, seen: Array) -> int:
    """Return the index of the best alternative once data have been seen, of summaries (1, q), those of the draws (n, q)."""
    against = problem.losses - problem.losses[:, [problem.choice]]
    return int(np.argmin(seen @ _fit(summaries, against, problem.weight)))


def realised_information(experiment: Experiment, which: int, parameters: Array, data: Array) -> float:
    """Gain in log density of the truth, an explanation and its parameters (k,), by data (N,) [nats]."""
    likelihood = logsumexp(experiment._updated[which].log_likelihoods(parameters[None], data[None]))
    return float(likelihood - logsumexp(experiment._log_joint(data[None])))
