"""What a trial's outcomes would mean: causes and choices, with a rule that a crew can keep in mind."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.trials.decision import DecisionProblem
from missionplan.diagnosis.next_trial.belief import Believed
from missionplan.effects import CATALOGUE
from missionplan.results.learned.next_trial import OutcomeRule, TrialOutcome

LISTED = 5
"""Outcomes that are told, at most."""
RARE = 0.02
"""Probability below which an outcome is not told."""
RULES = 64
"""Thresholds that are tried for each parameter."""
FITTING = 0.8
"""Agreement from which a rule of one parameter is told."""


@dataclass(frozen=True)
class SimulatedTrial:
    """A trial, simulated for every draw."""

    probabilities: Array
    """Of each set of causes after it, shape (n, s)."""
    means: tuple[Array, ...]
    """Parameters as they are then estimated under each set, shape (n, k_s)."""
    chosen: NDArray[np.int_]
    """Alternative chosen then, shape (n,)."""


def outcomes(believed: Sequence[Believed], problem: DecisionProblem, made: SimulatedTrial) -> tuple[TrialOutcome, ...]:
    """Return how the trial may come out, by the causes likeliest then and the choice made, likeliest first."""
    likeliest = np.argmax(made.probabilities, axis=1)
    saved = problem.losses[:, problem.choice] - problem.losses[np.arange(len(made.chosen)), made.chosen]
    found = []
    for which, choice in sorted(set(zip(likeliest.tolist(), made.chosen.tolist(), strict=True))):
        own = (likeliest == which) & (made.chosen == choice)
        probability = float(problem.weight[own].sum())
        saving = float(problem.weight[own] @ saved[own]) / probability
        found.append(TrialOutcome(probability, believed[which].causes, float(problem.alternatives[choice]), saving))
    likely = [outcome for outcome in found if outcome.probability >= RARE]
    return tuple(sorted(likely, key=lambda outcome: -outcome.probability)[:LISTED])


def outcome_rule(believed: Sequence[Believed], problem: DecisionProblem, made: SimulatedTrial) -> OutcomeRule | None:
    """Return the threshold of one parameter that tells best whether the choice changes; None where none tells it well.

    Each set's parameters are judged by their estimates where the set holds, and count as the mission has them where
    another does: their estimates are weighted with the set's probability.
    """
    changed = made.chosen != problem.choice
    weight = problem.weight
    best: OutcomeRule | None = None
    for which, each in enumerate(believed):
        for index, coordinate in enumerate(each.coordinates):
            if coordinate.kind != "strength" or coordinate.effect not in each.causes:
                continue
            values = made.means[which][:, index] * made.probabilities[:, which]
            for threshold in np.quantile(values, (np.arange(RULES) + 0.5) / RULES).tolist():
                for above in (True, False):
                    there = values > threshold if above else values < threshold
                    agreement = float(weight[there == changed].sum())
                    if agreement >= max(FITTING, best.agreement + 1e-9 if best else 0.0) and np.any(there & changed):
                        causes, choice = _commonest(believed, problem, made, there & changed)
                        unit = CATALOGUE[coordinate.effect].parameters[coordinate.name].unit
                        names = (coordinate.effect, coordinate.name, unit)
                        best = OutcomeRule(*names, threshold, above, causes, choice, agreement)
    constant = float(max(weight[changed].sum(), weight[~changed].sum()))
    return best if best is not None and best.agreement > constant + 1e-9 else None


def _commonest(
    believed: Sequence[Believed], problem: DecisionProblem, made: SimulatedTrial, own: NDArray[np.bool_]
) -> tuple[tuple[str, ...], float]:
    """Commonest causes and choice among some of the draws."""
    which = int(np.argmax(problem.weight[own] @ made.probabilities[own]))
    counts = np.bincount(made.chosen[own], weights=problem.weight[own], minlength=len(problem.alternatives))
    return believed[which].causes, float(problem.alternatives[int(np.argmax(counts))])
