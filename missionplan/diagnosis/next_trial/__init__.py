"""Which trial is worth making next: designs valued by what the choice after them would save, with their costs."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import cast

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.explanations import Weighed
from missionplan.diagnosis.next_trial.belief import (
    Believed,
    believe,
    causes_of,
    likely_fits,
    right_about_vehicle,
    to_do,
)
from missionplan.diagnosis.next_trial.designs import Cost, Losses, TrialKind, losses
from missionplan.diagnosis.next_trial.experiment import (
    DecisionProblem,
    Draws,
    Experiment,
    Saving,
    drawn,
    polynomial,
    value_of_information,
)
from missionplan.diagnosis.next_trial.prediction import Prediction
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.effects import CATALOGUE
from missionplan.effects.info import Instrument
from missionplan.errors import MissionplanError
from missionplan.results.learned.next_trial import NextTrial, OutcomeRule, PossibleSet, TrialOutcome, ValuedDesign


def instruments_for(believed: Sequence[Believed]) -> Mapping[Coordinate, Instrument]:
    """Return the instruments that measure a strength of a possible cause, by its coordinate."""
    instruments = {}
    for belief in believed:
        for coordinate in belief.coordinates:
            instrument = CATALOGUE[coordinate.effect].instrument
            if coordinate.effect not in belief.causes or coordinate.kind != "strength" or instrument is None:
                continue
            if instrument.parameter == coordinate.name:
                instruments[coordinate] = instrument
    return instruments


def measured(instrument: Instrument, coordinate: Coordinate, believed: Sequence[Believed]) -> list[Prediction]:
    """Return one reading of an instrument as each set of causes predicts it.

    Under sets without the effect the parameter is nil, to within its spike.
    """
    predictions = []
    for belief in believed:
        column = np.array([[float(parameter.key == coordinate.key) for parameter in belief.coordinates]])
        spike = 0.0 if column.any() else coordinate.spike
        noise = np.array([[instrument.sd**2 + spike**2]])
        predictions.append(Prediction(column @ belief.explanation.mean, column, noise))
    return predictions


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
    outcomes = []
    for which, choice in sorted(set(zip(likeliest.tolist(), made.chosen.tolist(), strict=True))):
        draws = (likeliest == which) & (made.chosen == choice)
        probability = float(problem.weight[draws].sum())
        saving = float(problem.weight[draws] @ saved[draws]) / probability
        outcomes.append(TrialOutcome(probability, believed[which].causes, float(problem.alternatives[choice]), saving))
    likely = [outcome for outcome in outcomes if outcome.probability >= RARE]
    return tuple(sorted(likely, key=lambda outcome: -outcome.probability)[:LISTED])


def outcome_rule(believed: Sequence[Believed], problem: DecisionProblem, made: SimulatedTrial) -> OutcomeRule | None:
    """Return the threshold of one parameter that tells best whether the choice changes; None where none tells it well.

    Each set's parameters are judged by their estimates where the set holds, and count as the mission has them where
    another does: their estimates are weighted with the set's probability.
    """
    changed = made.chosen != problem.choice
    weight = problem.weight
    best: OutcomeRule | None = None
    for which, belief in enumerate(believed):
        for index, coordinate in enumerate(belief.coordinates):
            if coordinate.kind != "strength" or coordinate.effect not in belief.causes:
                continue
            values = made.means[which][:, index] * made.probabilities[:, which]
            for threshold in np.quantile(values, (np.arange(RULES) + 0.5) / RULES).tolist():
                for above in (True, False):
                    there = values > threshold if above else values < threshold
                    agreement = float(weight[there == changed].sum())
                    if agreement >= max(FITTING, best.agreement + 1e-9 if best else 0.0) and np.any(there & changed):
                        draws = there & changed
                        commonest = int(np.argmax(problem.weight[draws] @ made.probabilities[draws]))
                        counts = np.bincount(
                            made.chosen[draws], weights=problem.weight[draws], minlength=len(problem.alternatives)
                        )
                        causes, choice = (
                            believed[commonest].causes,
                            float(problem.alternatives[int(np.argmax(counts))]),
                        )
                        unit = CATALOGUE[coordinate.effect].parameters[coordinate.name].unit
                        names = (coordinate.effect, coordinate.name, unit)
                        best = OutcomeRule(*names, threshold, above, causes, choice, agreement)
    constant = float(max(weight[changed].sum(), weight[~changed].sum()))
    return best if best is not None and best.agreement > constant + 1e-9 else None


DRAWS, FEWEST = 2000, 250
"""Draws of what is unknown, and of each set of causes at least."""
NEARLY = 0.85
"""Share of the greatest saving from which a design is good enough: of these the cheapest is the best."""
WORTH = 0.003
"""Saving over the loss of now from which a trial is worth making."""


@dataclass(frozen=True)
class Candidate:
    """A design or an instrument: its words and cost, what it would show, and its mission if it has one."""

    name: str
    cost: Cost
    predictions: tuple[Prediction, ...]
    trial: Mapping[str, object] | None


@dataclass(frozen=True)
class Valuation:
    """Draws of what is unknown with the losses of every alternative: the value of any trial follows from them."""

    kind: TrialKind
    believed: tuple[Believed, ...]
    draws: Draws
    losses: Losses
    decides: str
    seed: int
    left: Mapping[frozenset[str], float] = field(default_factory=dict)
    """Probability of the sets that are not considered, by what they ask for about the vehicle."""

    @classmethod
    def of(cls, kind: TrialKind, believed: tuple[Believed, ...], seed: int) -> "Valuation":
        """Draw, and run the missions."""
        generator = np.random.default_rng(seed)
        explanations = [belief.explanation for belief in believed]
        counts = [max(FEWEST, round(DRAWS * explanation.probability)) for explanation in explanations]
        draws = drawn(explanations, counts, generator)
        alternatives = kind.alternatives()
        return cls(
            kind, believed, draws, losses(believed, draws, alternatives, seed, generator), alternatives.key, seed
        )

    def result(self) -> NextTrial:
        """Value every design and find the best."""
        problem = self.losses.problem
        designs = [(*self.valued(candidate), candidate) for candidate in self.candidates()]
        designs.sort(key=lambda entry: (-entry[0].saving if entry[1].changes else 0.0, -entry[0].information))
        perfect = value_of_information(problem, self._perfect())
        result = NextTrial(
            decides=self.decides,
            unit=self.losses.unit,
            choice=float(problem.alternatives[problem.choice]),
            loss=float(problem.expected[problem.choice]),
            tried=(float(problem.alternatives.min()), float(problem.alternatives.max())),
            success=float(self.losses.success[problem.choice]),
            failure_loss=self.losses.failure,
            perfect=perfect.mean if perfect.changes else 0.0,
            explanations=tuple(PossibleSet(belief.causes, belief.explanation.probability) for belief in self.believed),
            designs=tuple(valued for valued, _, _ in designs),
            right=self.right(),
        )
        worth = [entry for entry in designs if entry[1].changes and entry[0].saving > WORTH * result.loss]
        if not worth:
            settling = result.settling
            return replace(result, trial=next((one.trial for valued, _, one in designs if valued is settling), None))
        # the cheapest of the designs that save nearly the most, and its outcomes
        enough = [entry for entry in worth if entry[0].saving >= NEARLY * worth[0][0].saving]
        best, saving, made = min(enough, key=lambda entry: entry[0].minutes)
        experiment = self.experiment(made)
        data = experiment.data(self.draws, np.random.default_rng(self.seed + 1))
        simulated = SimulatedTrial(experiment.probabilities(data), experiment.means(data), saving.chosen)
        trial_outcomes = outcomes(self.believed, problem, simulated)
        rule = outcome_rule(self.believed, problem, simulated)
        return replace(result, best=best, outcomes=trial_outcomes, rule=rule, trial=made.trial)

    def valued(self, candidate: Candidate) -> tuple[ValuedDesign, Saving]:
        """Value a trial."""
        experiment = self.experiment(candidate)
        data = experiment.data(self.draws, np.random.default_rng(self.seed + 1))
        saving = value_of_information(self.losses.problem, experiment.summaries(data))
        valued = ValuedDesign(
            candidate.name,
            candidate.cost.minutes,
            candidate.cost.energy_wh,
            experiment.expected_information(self.draws, data),
            saving.mean,
            saving.error,
            self.right(experiment.probabilities(data)),
            self.losses.unit,
        )
        return valued, saving

    def right(self, after: Array | None = None) -> float:
        """Probability that what is done about the vehicle is right; of sets left out, by what is known now."""
        probabilities = [belief.explanation.probability for belief in self.believed] if after is None else after
        asked = [to_do(belief.causes) for belief in self.believed]
        among = right_about_vehicle(asked, self.draws, np.asarray(probabilities))
        shares: dict[frozenset[str], float] = {}
        for remedies, belief in zip(asked, self.believed, strict=True):
            shares[remedies] = shares.get(remedies, 0.0) + belief.explanation.probability
        done = max(shares, key=lambda remedies: shares[remedies])
        return (1.0 - sum(self.left.values())) * among + self.left.get(done, 0.0)

    def experiment(self, candidate: Candidate) -> Experiment:
        """Return a trial as the sets of causes predict it."""
        return Experiment(tuple(belief.explanation for belief in self.believed), candidate.predictions)

    def candidates(self) -> Iterator[Candidate]:
        """Designs that the planner can make, then instruments."""
        yield from filter(None, map(self.designed, range(len(self.kind.designs))))
        for coordinate, instrument in instruments_for(self.believed).items():
            reading = measured(instrument, coordinate, self.believed)
            yield Candidate(instrument.description, Cost(instrument.minutes, None), tuple(reading), None)

    def designed(self, index: int) -> Candidate | None:
        """Return a design; None where it cannot be made."""
        cost = self.kind.cost(index, self.seed)
        predictions = () if cost is None else tuple(self.kind.predictions(index, self.believed))
        if cost is None or not all(np.isfinite(p.centre).all() and np.isfinite(p.noise).all() for p in predictions):
            return None
        return Candidate(self.kind.designs[index], cost, predictions, self.kind.trial(index))

    def _perfect(self) -> Array:
        """Columns that tell causes and sizes themselves, for the value of perfect information."""
        n, start, columns = len(self.draws.explanation), 0, []
        for belief, parameters in zip(self.believed, self.draws.parameters, strict=True):
            sd = np.sqrt(np.maximum(np.diag(belief.explanation.covariance), 1e-300))
            for column in polynomial((parameters - belief.explanation.mean) / sd):
                whole = np.zeros(n)
                whole[start : start + len(parameters)] = column
                columns.append(whole)
            start += len(parameters)
        return np.stack(columns, axis=1)


KINDS: Mapping[str, tuple[str, str]] = {
    "transit": ("missionplan.diagnosis.next_trial.leg_trials", "LegTrials"),
    "descent": ("missionplan.diagnosis.next_trial.dive_trials", "DiveTrials"),
}
"""By kind of data, module and class of its trials."""


def next_trial(explanations: Sequence[Weighed], pipeline_result: PipelineResult, scale: float, seed: int) -> NextTrial:
    """Value the trials that could follow a diagnosis, or find out why that cannot be done.

    `explanations` are the mission's, laid against the data so far, the likeliest first; `scale` is of the random
    errors, as in the extended mission.
    """
    kind = explanations[0].bound.kind
    if kind not in KINDS:
        return NextTrial(reason=f"no trials are designed for data of kind {kind}")
    try:
        return valuation(explanations, pipeline_result, scale, seed).result()
    except (MissionplanError, FloatingPointError) as error:
        return NextTrial(reason=str(error))


def valuation(explanations: Sequence[Weighed], pipeline_result: PipelineResult, scale: float, seed: int) -> Valuation:
    """Draw what is unknown after a diagnosis and run the missions: parameters as of `next_trial`.

    Raises InputError when an extended mission is not valid, or lacks what is to be chosen.
    """
    bound = explanations[0].bound
    module, name = KINDS[bound.kind]
    kind = cast("Callable[[DataKind], TrialKind]", getattr(import_module(module), name))(bound)
    likely, others = likely_fits(explanations, pipeline_result)
    left: dict[frozenset[str], float] = {}
    for one, fit, probability in others:
        asked = to_do(causes_of(one, fit))
        left[asked] = left.get(asked, 0.0) + probability
    return replace(Valuation.of(kind, believe(likely, kind.posterior, scale), seed), left=left)
