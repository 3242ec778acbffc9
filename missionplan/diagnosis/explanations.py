"""Missions that carry a doubt, into a diagnosis and out of it: one plain mission an explanation, and back to one.

Prior odds of the explanations are their probabilities in the mission; their evidence is that of the base model, which
has their effects with the distributions as the priors of their parameters. So each keeps its Occam factor, and on the
data that it was made from a mission gains no cause.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.data_kind import DataKind, bind_dataset
from missionplan.diagnosis.extended_mission import Hypothesis
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, fitted
from missionplan.diagnosis.inference.selection import CREDIBLE, Selection, log_prior
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.effects import CATALOGUE, exclusive_groups
from missionplan.errors import RunError
from missionplan.mission import Mission
from missionplan.phases.hooks import MarkovProcess
from missionplan.results.learned.evidence import Causes, ExplanationOdds

UNLIKE, NEGLIGIBLE, MOST_SEARCHED = 3.0, 0.01, 2
"""Nats below the likeliest explanation from which causes are searched beside another, unless its prior is less, and how
many are searched at most, those of the greatest prior: the search takes as long as a diagnosis."""
MOST, FEW = 12, 3
"""Combinations of explanations that are compared, the likeliest, and explanations of one doubt that all are."""


@dataclass(frozen=True)
class Explained:
    """A mission under one explanation of each of its doubts."""

    prior: float
    """Probability of the combination, of those compared."""
    causes: Causes
    """Effects of the explanations; empty where none holds."""
    mission: Mission
    """With these effects as plain ones."""


@dataclass(frozen=True)
class Weighed:
    """An explanation of a mission laid against a data set."""

    explained: Explained
    bound: DataKind
    """The data set, bound to its mission."""
    base: CauseFit | None
    """Its base model fitted; None where the mission has no doubt."""
    log_weight: float
    """Log of prior times evidence of the base model."""
    extended: CauseFit | None = None
    """With the causes found beside the likeliest explanation, or beside this one, where they are better than none."""
    gain: float = 0.0
    """What causes add to the log of its weight."""

    @property
    def fit(self) -> CauseFit | None:
        """With what was found, else its base model's."""
        return self.base if self.extended is None else self.extended


def explained_missions(mission: Mission) -> tuple[Explained, ...]:
    """Return the mission under each combination of its explanations, the likeliest first; itself where it has none.

    Of a posterior these are the sets that hold 95 % of the probability: the others' effects are of the catalogue.
    """
    if not mission.doubts:
        return (Explained(1.0, (), mission),)
    combinations = product(*(_likely(doubt.probabilities) for doubt in mission.doubts))
    likeliest = sorted(
        (math.prod(doubt.probabilities[n] for doubt, n in zip(mission.doubts, numbers, strict=True)), numbers)
        for numbers in combinations
    )[-MOST:][::-1]
    total = sum(prior for prior, _ in likeliest)
    return tuple(Explained(prior / total, *_known(mission, numbers)) for prior, numbers in likeliest)


def _likely(probabilities: Sequence[float]) -> list[int]:
    """The fewest numbers that hold 95 % of the probability where there are many, else all."""
    ordered = sorted(range(len(probabilities)), key=lambda number: -probabilities[number])
    before = np.cumsum([0.0, *(probabilities[number] for number in ordered)])
    return ordered[: max(FEW, int(np.count_nonzero(before[:-1] < CREDIBLE)))]


def _known(mission: Mission, numbers: Sequence[int]) -> tuple[Causes, Mission]:
    """Effects of the explanations of these numbers, and the mission in which they are known to hold."""
    causes: Causes = ()
    for doubt, number in zip(mission.doubts, numbers, strict=True):
        mission, causes = mission.knowing(doubt.place, number), (*causes, *doubt.causes[number])
    return causes, mission


def weighed(
    mission: Mission, dataset: Path, seed: int, jobs: int, part: Callable[[DataKind], DataKind] | None = None
) -> tuple[Weighed, ...]:
    """Lay a data set, or a part of it, against each explanation of a mission, the likeliest after the data first.

    Data that the mission has learned from leave the explanations as probable as they were.

    Raises
    ------
    InputError
        As `bind_dataset` does.
    RunError
        When no explanation's base model can be fitted.
    """
    missions = explained_missions(mission)
    bound = [bind_dataset(dataset, explained.mission, seed) for explained in missions]
    bound = bound if part is None else [part(one) for one in bound]
    here = [{entry.effect for entry in one.mission.effects} for one in bound]  # without what is of another place
    missions = tuple(
        replace(e, causes=tuple(c for c in e.causes if c in effects)) for e, effects in zip(missions, here, strict=True)
    )
    if len(missions) == 1 or bound[0].is_known:
        return tuple(Weighed(one, data, None, math.log(one.prior)) for one, data in zip(missions, bound, strict=True))
    fits = [fitted(one.model, [((), ())], jobs)[0] for one in bound]
    explanations = [
        Weighed(explained, one, fit, math.log(explained.prior) + fit.log_evidence)
        for explained, one, fit in zip(missions, bound, fits, strict=True)
        if isinstance(fit, CauseFit)
    ]
    if not any(math.isfinite(one.log_weight) for one in explanations):
        raise RunError("the base model cannot be fitted with any of the mission's explanations")
    return tuple(sorted(explanations, key=lambda one: -one.log_weight))


def weighed_with_causes(explanations: Sequence[Weighed], jobs: int) -> tuple[tuple[Weighed, ...], Selection | None]:
    """Search causes beside each explanation that the data are unlike as it stands, and order all by what they then are.

    A law of errors that was learned describes a new current too, if badly: against an explanation without that law its
    evidence is that of the better one only where that has a cause for the current as well.

    Returns
    -------
    explanations : tuple of Weighed
        The likeliest with its causes first. Those whose base models are as good as the best one's gain as much as it.
    selection : Selection or None
        All sets of causes beside the first; None where none was searched.
    """
    first, *others = explanations
    unlike = [one for one in others if one.log_weight < first.log_weight - UNLIKE and one.explained.prior > NEGLIGIBLE]
    unlike = sorted(unlike, key=lambda one: -one.explained.prior)[:MOST_SEARCHED]
    if not unlike or first.bound.is_known:
        return tuple(explanations), None
    selections = {id(one): one.bound.model.all_sets(jobs=jobs) for one in (first, *unlike)}
    gain = log_gain(selections[id(first)])
    with_gains = [replace(one, gain=gain) for one in explanations]
    for place, one in enumerate(explanations):
        selection = selections.get(id(one))
        if selection is not None and one is not first:  # it has the likeliest causes that were found beside it
            likeliest = max(selection.posterior, key=selection.posterior.__getitem__)
            fit = next((candidate.fit for candidate in selection.ranking if candidate.causes == likeliest), None)
            with_gains[place] = replace(one, extended=fit, gain=log_gain(selection))
    best = max(range(len(with_gains)), key=lambda place: with_gains[place].log_weight + with_gains[place].gain)
    return (with_gains[best], *with_gains[:best], *with_gains[best + 1 :]), selections.get(id(explanations[best]))


def with_found(explanations: Sequence[Weighed], pipeline_result: PipelineResult, jobs: int) -> tuple[Weighed, ...]:
    """Fit the causes claimed beside the likeliest explanation beside each other one too.

    Else what the explanations say nothing about, as legs of a doubt that dives left, would decide for the likeliest.
    """
    if not pipeline_result.best.causes:
        return tuple(explanations)
    first, others = explanations[0], explanations[1:]
    gain, added = log_gain(pipeline_result.selection), _added(first, pipeline_result.best.causes, jobs)
    if not others or added is None:
        return (replace(first, gain=gain), *others)
    first = replace(first, gain=gain, extended=added[0])  # fitted as beside the others: what they share is told once
    return (first, *(_with_causes(one, pipeline_result.best.causes, gain - added[1], jobs) for one in others))


def _with_causes(one: Weighed, causes: Causes, odds: float, jobs: int) -> Weighed:
    """Add causes, of which those without an explanation have log odds in prior and checks, to an explanation."""
    added = _added(one, causes, jobs)
    gain = one.gain if one.extended is not None else 0.0
    if added is not None and odds + added[1] > gain:
        return replace(one, extended=added[0], gain=odds + added[1])
    return replace(one, gain=gain)


def _added(one: Weighed, causes: Causes, jobs: int) -> tuple[CauseFit, float] | None:
    """Causes fitted beside an explanation, and the log evidence that they add to it; None where they cannot be."""
    model = one.bound.model
    if one.base is None or not set(causes) <= set(model.candidates):
        return None
    if any(len(group & set(causes)) > 1 for group in model.alternatives):
        return None
    (fit,) = fitted(model, [(causes, (one.base,))], jobs)
    if isinstance(fit, FailedFit) or not fit.possible:
        return None
    return fit, fit.log_evidence - one.base.log_evidence


def log_gain(selection: Selection) -> float:
    """What all that may be there adds to the log evidence of nothing; by the likeliest set where that has no number."""
    if selection.nothing > 0.0:
        return -math.log(selection.nothing)
    best = selection.ranking[0]
    prior = log_prior(len(best.causes), selection.catalogue)
    return best.log_bayes_factor + prior - math.log(selection.posterior[best.causes])


def hypotheses(
    explanations: Sequence[Weighed], pipeline_result: PipelineResult, scale: float
) -> tuple[Hypothesis, ...]:
    """Return what may hold after a diagnosis, the likeliest first.

    These are the sets of causes found beside the likeliest explanation, and the other explanations as they are.

    `explanations` are as `with_found` returns them; `scale` is of the random errors, see `DataKind.carried`.
    """
    listed = possible_fits(explanations, pipeline_result)
    total = sum(weight for *_, weight in listed)
    return tuple(
        Hypothesis(
            (*one.explained.causes, *fit.causes),
            float(weight / total),
            one.bound.mission,
            tuple(prior.effect for prior in one.bound.given),
            one.bound.carried(fit, scale),
            one.bound.extended_mission(one.bound.carried(fit, scale)),
            one.bound.places,
            one.bound.date,
        )
        for one, fit, weight in listed
    )


def possible_fits(
    explanations: Sequence[Weighed], pipeline_result: PipelineResult
) -> list[tuple[Weighed, CauseFit, float]]:
    """Return the fits that may hold with their weights, the likeliest first: as `hypotheses`."""
    first, others = explanations[0], explanations[1:]
    fits = {candidate.causes: candidate.fit for candidate in pipeline_result.selection.ranking} | {
        (): pipeline_result.selection.base
    }
    shares = _stationary(
        {causes: share for causes, share in pipeline_result.selection.posterior.items() if causes in fits}, fits
    )
    total = sum(shares.values())
    masses = explanation_weights(explanations)
    if first.extended is not None:
        fits[first.extended.causes] = first.extended
    listed = [(first, fits[causes], float(masses[0]) * share / total) for causes, share in shares.items()]
    listed += [(one, one.fit, float(mass)) for one, mass in zip(others, masses[1:], strict=True) if one.fit is not None]
    return sorted(listed, key=lambda row: -row[2])


def explanation_weights(explanations: Sequence[Weighed]) -> Array:
    """Weights of the mission's explanations with what was found beside them, the greatest 1."""
    logs = [one.log_weight + one.gain for one in explanations]
    return np.asarray(np.exp(np.array(logs) - max(logs)))


def _stationary(shares: Mapping[Causes, float], fits: Collection[Causes]) -> dict[Causes, float]:
    """Give the share of a set with a walk to the same set with a law that is stationary, where that was fitted.

    A walk starts from nothing with each record: on the next one its present velocity would be forgotten, and what it
    started from be taken for a current.
    """
    laws = {name for group in exclusive_groups("transit") for name in group if _process(name) is not None}
    walks = {name for name in laws if not np.any(_process(name))}
    sums: dict[Causes, float] = {}
    for causes, share in shares.items():
        plain = set(causes) - walks
        others = [fit for fit in fits if set(fit) - (laws - walks) == plain and set(fit) & (laws - walks)]
        target = others[0] if set(causes) & walks and others else causes
        sums[target] = sums.get(target, 0.0) + share
    return sums


def _process(name: str) -> float | None:
    """Variance with which a process begins, at its usual size; None where the effect is none."""
    info = CATALOGUE[name]
    usual = info.make({key: parameter.median for key, parameter in info.parameters.items()})
    return float(np.max(usual.first_variance)) if isinstance(usual, MarkovProcess) else None


def odds(explanations: Sequence[Weighed], hypotheses: Sequence[Hypothesis]) -> tuple[ExplanationOdds, ...]:
    """Return what is in doubt after a diagnosis, the likeliest first: the mission's explanations, else what was found.

    Sets that differ in a statistical description alone are told as one. Empty where one holds 95 % of the probability.
    """
    if len(explanations) > 1:
        weights = explanation_weights(explanations)
        shares = zip(explanations, (weights / weights.sum()).tolist(), strict=True)
        return _merged([(one.explained.causes, one.explained.prior, share) for one, share in shares])
    rows = _merged([(hypothesis.causes, None, hypothesis.probability) for hypothesis in hypotheses])
    before = np.cumsum([0.0, *(row.probability for row in rows)])
    credible = rows[: int(np.count_nonzero(before[:-1] < CREDIBLE))]
    total = sum(row.probability for row in credible)
    again = tuple(replace(row, probability=row.probability / total) for row in credible)
    return again if len(again) > 1 else ()


def _merged(listed: Sequence[tuple[Causes, float | None, float]]) -> tuple[ExplanationOdds, ...]:
    """Join sets with statistical descriptions to those without; listed with prior and posterior probabilities."""
    plain = {causes for causes, *_ in listed}
    sums: dict[Causes, list[float]] = {}
    for causes, prior, share in listed:
        physical = tuple(name for name in causes if CATALOGUE[name].part != "covariance")
        pair = sums.setdefault(physical if physical in plain else causes, [0.0, 0.0])
        pair[0], pair[1] = pair[0] + (prior or 0.0), pair[1] + share
    has_priors = any(prior is not None for _, prior, _ in listed)
    rows = [ExplanationOdds(causes, prior if has_priors else None, share) for causes, (prior, share) in sums.items()]
    return tuple(sorted(rows, key=lambda row: -row.probability))
