"""Missions run from given normals, and the task of a worker: independent repetitions of subset simulation."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import RunError
from missionplan.montecarlo.rare_events.population import NormalPopulation
from missionplan.montecarlo.rare_events.subset_simulation import CHAINS, STEPS, Level, repeat
from missionplan.montecarlo.streams import stream
from missionplan.scenario.scenario import Scenario
from missionplan.studies.rare_failure.event import RareEvent
from missionplan.studies.rare_failure.margins import margins, scaled_margin
from missionplan.studies.simulation.block_statistics import failures_by_step
from missionplan.studies.simulation.mission_trials import MissionTrials
from missionplan.studies.simulation.trial_block import run_trials

BATCH = 4
"""Repetitions that a worker runs together."""
STREAM = "rare failure"
"""Name of the random stream of each batch, by its number."""


@dataclass(frozen=True)
class _OfLegs:
    population: NormalPopulation
    quantity: str

    def leg(self, number: int) -> Array:
        return self.population.cell(self.quantity, number, 2)


@dataclass(frozen=True)
class PopulationSource:
    """The normals of a population, as the phases of a mission draw them."""

    population: NormalPopulation

    def once(self, quantity: str) -> Array:
        """Normals of a quantity that is drawn once a trial, shape (n,)."""
        return np.asarray(self.population.cell(quantity)[0])

    def legs(self, quantity: str) -> _OfLegs:
        """Normals of a quantity that is drawn anew for each leg."""
        return _OfLegs(self.population, f"{quantity} by leg")


@dataclass(frozen=True)
class FailingTrials:
    """What a batch of repetitions found.

    Attributes
    ----------
    estimates : array, shape (repetitions,)
    weights : array, shape (n,)
        Of the failing trials.
    columns : mapping of str to array, shape (n,)
        What was drawn, and what came of it.
    inputs : tuple of str
        Names of the columns that were drawn.
    steps : array of str, shape (n,)
        Where each fails first, ``moor: anchor outside the radius``; empty where the mission succeeds all the same.
    trials : int
        That were run.
    """

    estimates: Array
    weights: Array
    columns: Mapping[str, NDArray[np.generic]]
    inputs: tuple[str, ...]
    steps: NDArray[np.str_]
    trials: int


@dataclass(frozen=True, eq=False)  # hashed by identity, as a block's task is
class DrivenMission:
    """A mission to be run from given normals, with the event that is asked about.

    Attributes
    ----------
    means : Scenario
    event : RareEvent
    sizes : mapping of str to float
        Standard deviations of the margins over plain trials.
    """

    means: Scenario
    event: RareEvent
    sizes: Mapping[str, float]

    def run(self, population: NormalPopulation, *, inputs: bool = False) -> tuple[Scenario, MissionTrials]:
        """Run one trial for each of a population.

        Raises
        ------
        RunError
            When the model fails numerically.
        """
        source = PopulationSource(population)
        scenario = self.means.sampled_from(source, population.trials)
        try:
            return scenario, run_trials(scenario, source, population.trials, inputs=inputs)
        except FloatingPointError as error:
            raise RunError(f"a trial near failure cannot be computed: {error}") from error

    def __call__(self, population: NormalPopulation) -> Array:
        """Return the margin of each trial."""
        scenario, trials = self.run(population)
        found = margins(self.event, trials, scenario)
        return scaled_margin(found, self.sizes, self.event.happens(trials.columns()))


@dataclass(frozen=True, eq=False)
class RareTask:
    """Runs a batch of repetitions by its number, in this process or another."""

    driven: DrivenMission
    levels: tuple[Level, ...]
    seed: int

    @property
    def trials(self) -> int:
        """Trials of one batch, the last ones included that are run again to be described."""
        return (STEPS * len(self.levels) + 1) * BATCH * CHAINS

    def __call__(self, batch: int) -> FailingTrials:
        """Run one batch; its first number is 1."""
        found = repeat(self.driven, self.levels, stream(self.seed, STREAM, batch), repetitions=BATCH, chains=CHAINS)
        _, trials = self.driven.run(found.failing, inputs=True)
        failed = found.weights > 0.0
        drawn = drawn_inputs(trials)
        return FailingTrials(
            estimates=found.estimates,
            weights=found.weights[failed],
            columns={name: values[failed] for name, values in trials.columns().items()},
            inputs=tuple(drawn),
            steps=_first_steps(trials)[failed],
            trials=found.trials + found.failing.trials,
        )


def drawn_inputs(trials: MissionTrials) -> dict[str, Array]:
    """What was drawn, by the names of the table of trials; what is drawn each leg as its sum over the legs."""
    inputs = dict(trials.draws)
    for phase in trials.phases:
        inputs |= {f"{phase.name}.{name}": values for name, values in phase.inputs.items()}
    return inputs


def _first_steps(trials: MissionTrials) -> NDArray[np.str_]:
    """Where each trial fails first; empty where it does not."""
    steps = np.full(trials.success.size, "", dtype=object)
    for step, failed in failures_by_step(trials).items():
        steps[failed] = step
    return steps.astype(str)
