"""Value of trials: draws of what is unknown, the losses of every choice under them, and what each trial would tell."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.trials.decision import Saving, value_of_information
from missionplan.diagnosis.inference.trials.experiment import Draws, Experiment, drawn, polynomial
from missionplan.diagnosis.inference.trials.prediction import Prediction
from missionplan.diagnosis.next_trial.belief import Believed
from missionplan.diagnosis.next_trial.designs import Cost, TrialKind
from missionplan.diagnosis.next_trial.instruments import instruments_for, measured
from missionplan.diagnosis.next_trial.losses import Losses, losses
from missionplan.diagnosis.next_trial.outcomes import SimulatedTrial, outcome_rule, outcomes
from missionplan.results.learned.next_trial import NextTrial, ValuedDesign

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

    @classmethod
    def of(cls, kind: TrialKind, believed: tuple[Believed, ...], seed: int) -> "Valuation":
        """Draw, and run the missions."""
        generator = np.random.default_rng(seed)
        explanations = [each.explanation for each in believed]
        counts = [max(FEWEST, round(DRAWS * each.probability)) for each in explanations]
        draws = drawn(explanations, counts, generator)
        alternatives = kind.alternatives()
        return cls(
            kind, believed, draws, losses(believed, draws, alternatives, seed, generator), alternatives.key, seed
        )

    def result(self) -> NextTrial:
        """Value every design and find the best."""
        problem, found = self.losses.problem, []
        for candidate in self.candidates():
            experiment = self.experiment(candidate)
            data = experiment.data(self.draws, np.random.default_rng(self.seed + 1))
            saving = value_of_information(problem, experiment.summaries(data))
            information = experiment.expected_information(self.draws, data)
            valued = ValuedDesign(
                candidate.name,
                candidate.cost.minutes,
                candidate.cost.energy_wh,
                information,
                saving.mean,
                saving.error,
            )
            found.append((valued, candidate, saving))
        found.sort(key=lambda entry: (-entry[0].saving if entry[2].changes else 0.0, -entry[0].information))
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
            explanations=tuple((each.causes, each.explanation.probability) for each in self.believed),
            designs=tuple(valued for valued, _, _ in found),
        )
        worth = [entry for entry in found if entry[2].changes and entry[0].saving > WORTH * result.loss]
        return self._with_best(result, worth) if worth else result

    def _with_best(self, result: NextTrial, worth: Sequence[tuple[ValuedDesign, Candidate, Saving]]) -> NextTrial:
        """Name the cheapest of the designs that save nearly the most, and tell its outcomes."""
        enough = NEARLY * worth[0][0].saving
        best, candidate, saving = min(
            (entry for entry in worth if entry[0].saving >= enough), key=lambda entry: entry[0].minutes
        )
        experiment = self.experiment(candidate)
        data = experiment.data(self.draws, np.random.default_rng(self.seed + 1))
        made = SimulatedTrial(experiment.probabilities(data), experiment.means(data), saving.chosen)
        problem = self.losses.problem
        return replace(
            result,
            best=best,
            outcomes=outcomes(self.believed, problem, made),
            rule=outcome_rule(self.believed, problem, made),
            trial=candidate.trial,
        )

    def experiment(self, candidate: Candidate) -> Experiment:
        """Return a trial as the sets of causes predict it."""
        return Experiment(tuple(each.explanation for each in self.believed), candidate.predictions)

    def candidates(self) -> Iterator[Candidate]:
        """Designs that the planner can make, then instruments."""
        for index, name in enumerate(self.kind.designs):
            cost = self.kind.cost(index, self.seed)
            if cost is not None:
                predictions = tuple(self.kind.predictions(index, self.believed))
                if all(np.isfinite(each.centre).all() and np.isfinite(each.noise).all() for each in predictions):
                    yield Candidate(name, cost, predictions, self.kind.trial(index))
        for coordinate, instrument in instruments_for(self.believed).items():
            reading = measured(instrument, coordinate, self.believed)
            yield Candidate(instrument.description, Cost(instrument.minutes, None), tuple(reading), None)

    def _perfect(self) -> Array:
        """Columns that tell causes and sizes themselves, for the value of perfect information."""
        n, start, columns = len(self.draws.explanation), 0, []
        for each, own in zip(self.believed, self.draws.parameters, strict=True):
            sd = np.sqrt(np.maximum(np.diag(each.explanation.covariance), 1e-300))
            for column in polynomial((own - each.explanation.mean) / sd):
                whole = np.zeros(n)
                whole[start : start + len(own)] = column
                columns.append(whole)
            start += len(own)
        return np.stack(columns, axis=1)
