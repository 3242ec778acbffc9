"""What a trial is to the valuation, whatever is tried: a design with its mission and its cost by the planner.

And what each alternative costs under each draw of what is unknown: the mission itself, on common random numbers.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import parameters_from
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.belief import Believed, Posterior
from missionplan.diagnosis.next_trial.experiment import DecisionProblem, Draws
from missionplan.diagnosis.next_trial.prediction import Prediction
from missionplan.effects import CATALOGUE
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.results.decision import FAILURE_LOSS
from missionplan.results.learned.next_trial import LossUnit
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.trial_block import run_block


@dataclass(frozen=True)
class Alternatives:
    """What may be chosen."""

    key: str
    """``d_max_m`` or ``anchor_wet_weight_n``."""
    values: Array
    """[m or N], shape (a,)."""
    change: Callable[[Mission, float], Mission]
    """The mission with one of them."""


@dataclass(frozen=True)
class Losses:
    """The decision with the numbers that explain its losses."""

    problem: DecisionProblem
    """Losses in `unit`."""
    unit: LossUnit
    """Energy where the mission has a budget, else time."""
    failure: float
    """Loss counted for a failure besides [unit]."""
    success: Array
    """Probability of success with each alternative, shape (a,)."""


def losses(
    believed: Sequence[Believed],
    draws: Draws,
    alternatives: Alternatives,
    seed: int,
    generator: np.random.Generator,
) -> Losses:
    """Run the mission with every alternative under every draw, the same random numbers for all alternatives.

    Each draw is one trial of the mission; `seed` is of the missions' other random numbers, `generator` of how the
    effects differ from record to record.
    """
    runs = [
        _trials(belief, parameters, alternatives, seed, generator)
        for belief, parameters in zip(believed, draws.parameters, strict=True)
    ]
    energy, duration, success = (np.concatenate([run[index] for run in runs]) for index in range(3))
    has_energy = bool(np.isfinite(energy).any())
    cost = energy if has_energy else duration / 60.0
    works = success > 0.0
    usual = float(np.mean(cost[works & np.isfinite(cost)])) if np.any(works & np.isfinite(cost)) else 1.0
    failure = FAILURE_LOSS * usual
    loss = np.where(np.isfinite(cost), cost, usual) + failure * (1.0 - success)
    unit: LossUnit = "W h" if has_energy else "min"
    return Losses(DecisionProblem(alternatives.values, loss, draws.weight), unit, failure, draws.weight @ success)


def _trials(
    belief: Believed, parameters: Array, alternatives: Alternatives, seed: int, generator: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Energy [W h], time [s] and success of every draw with every alternative, shape (n, a) each."""
    spikes = np.array([coordinate.spike for coordinate in belief.coordinates])
    today = parameters + generator.standard_normal(parameters.shape) * spikes
    # draws of the parameters by their key paths in the mission, inside their ranges
    draws = {}
    for effect, named in parameters_from(belief.coordinates, today.T).items():
        for name, drawn in named.items():
            parameter = CATALOGUE[effect].parameters[name]
            draws[f"effects.{effect}.{name}"] = np.clip(drawn, parameter.low, parameter.high)
    columns = []
    for value in alternatives.values.tolist():
        mission = alternatives.change(belief.mission, value)
        scenario = Scenario.at_means(mission, recorded_current(mission)).sampled(
            seed=seed, block=0, size=len(parameters)
        )
        scenario = replace(scenario, drawn=scenario.drawn.at(draws))
        trials = run_block(scenario, seed, 0, len(parameters), inputs=False)
        columns.append((trials.total["energy_wh"], trials.total["duration_s"], trials.success.astype(float)))
    energy, duration, success = (np.stack(values, axis=1) for values in zip(*columns, strict=True))
    return energy, duration, success


COSTING_TRIALS = 16
"""Runs of a trial's mission of which its cost is the mean."""


@dataclass(frozen=True)
class Cost:
    """Time [min], and energy [W h] where it is known."""

    minutes: float
    energy_wh: float | None


class TrialKind(ABC):
    """Trials that can be made from one kind of data: designs, what they would show, what they decide."""

    @property
    @abstractmethod
    def designs(self) -> Sequence[str]:
        """Designs in words."""

    @abstractmethod
    def posterior(self, bound: DataKind, fit: CauseFit) -> Posterior:
        """Return what a fit of the data, bound to a mission, says of its parameters."""

    @abstractmethod
    def predictions(self, design: int, believed: Sequence[Believed]) -> list[Prediction]:
        """Return the data of a design as each set of causes predicts them."""

    @abstractmethod
    def trial(self, design: int) -> Mapping[str, object]:
        """Return the mission file's data of a design."""

    def cost(self, design: int, seed: int) -> "Cost | None":
        """Return what a design takes by the planner's model; None where it cannot be made."""
        return cost_of(self.trial(design), seed)

    @abstractmethod
    def alternatives(self) -> Alternatives:
        """Return what the planner may choose."""


def cost_of(trial: Mapping[str, object], seed: int) -> Cost | None:
    """Time and energy of a trial's mission, the mean of a few runs of it; None where it cannot be made."""
    try:
        mission = Mission.from_data(trial)
        means = Scenario.at_means(mission, recorded_current(mission))
        runs = run_block(means.sampled(seed=seed, block=0, size=COSTING_TRIALS), seed, 0, COSTING_TRIALS, inputs=False)
    except (MissionplanError, FloatingPointError):
        return None
    duration, energy = (runs.total[key] for key in ("duration_s", "energy_wh"))
    ended = np.isfinite(duration)
    if np.count_nonzero(ended) < 0.5 * COSTING_TRIALS:
        return None
    has_energy = np.isfinite(energy[ended]).all()
    return Cost(float(duration[ended].mean()) / 60.0, float(energy[ended].mean()) if has_energy else None)
