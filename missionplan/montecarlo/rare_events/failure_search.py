"""The probability of a failure over all its ways and strata: screened, then estimated in two stages."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.rare_events import CHAINS, MOST_LEVELS, PILOT_CHAINS, SHARE, STEPS, run_levels, run_pilots
from missionplan.montecarlo.rare_events.strata import (
    Estimate,
    Model,
    ReliabilityIndices,
    StrataView,
    Stratum,
    TwoStages,
    WayDrive,
    runs_needed,
)
from missionplan.montecarlo.streams import stream

STREAM = "rare failure"
"""First part of the names of the random streams."""
FIRST = 8
"""Runs of the first stage, of each part."""
LEAST_SECOND = 4
"""Runs of the second stage, of each part."""
SCREENING = 2
"""Pilots by which each part is screened."""
SCREENED_TOGETHER = 48
"""Parts that are screened side by side: the sooner one has failed, the sooner others are seen to be negligible."""
TOGETHER = 24
"""Runs that go side by side: a call of a mission with 3000 trials takes hardly longer than one with 300."""
NEGLIGIBLE = 3e-3
"""Share of the whole below which a part is left at what its screening found, known to a factor of about two."""

Description = TypeVar("Description")
Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


class Runner(Protocol):
    """Runs a task on every item, perhaps in other processes, and returns the results in the order of the items."""

    def __call__(self, task: Callable[[Item], Outcome], items: Sequence[Item]) -> Iterator[Outcome]:
        """Run the task."""


@dataclass(frozen=True)
class Part:
    """One way to fail in one stratum, by their numbers."""

    stratum: int
    way: int


@dataclass(frozen=True)
class Batch:
    """Runs that go side by side: the part of each, and the name and number of their random stream."""

    parts: tuple[Part, ...]
    stage: str
    number: int


@dataclass(frozen=True)
class Screened:
    """What a part looks like at first."""

    part: Part
    probability: float
    """Of the failure and the stratum, roughly; zero where none was found."""
    nearest: float
    """Where none was found: probability, roughly, of coming as near to it as the nearest trials."""
    levels: int
    trials: int
    """That were run."""


@dataclass(frozen=True)
class BatchResult(Generic[Description]):
    """What a batch of runs found."""

    batch: Batch
    probabilities: Array
    counted: Array
    """Shape (runs,). Of the failure in this way and stratum; and what it adds to the whole."""
    described: Description
    """Of the trials that fail."""
    trials: int
    """That were run."""


@dataclass(frozen=True, eq=False)  # hashed by identity, as a block's task is
class FailureSearch(Generic[Description]):
    """What is searched, and how its runs are made; sent to the workers."""

    model: Model
    strata: Sequence[Stratum]
    indices: ReliabilityIndices
    """Of plain trials."""
    seed: int
    describe: Callable[[StrataView, Array], Description]
    """Of trials and their weights, shape (n,): what is kept of them."""
    known: float = 0.0
    """Share of plain trials that fail: what is rarer by far is not looked for."""

    @property
    def parts(self) -> list[Part]:
        """Every way in every stratum."""
        ways = len(self.indices.margins) + 1
        return [Part(stratum, way) for stratum in range(len(self.strata)) for way in range(ways)]

    def screen(self, batch: Batch) -> list[Screened]:
        """Look at parts by pilots, so many of each."""
        chains = PILOT_CHAINS if batch.stage == "screening" else 4 * PILOT_CHAINS
        pilots = run_pilots(
            self._drive(batch.parts),
            len(batch.parts),
            self._stream(batch),
            chains=chains,
            negligible=NEGLIGIBLE,
            chance=self.known,
        )
        looks = []
        for part in dict.fromkeys(batch.parts):
            part_pilots = [pilot for pilot, its_part in zip(pilots, batch.parts, strict=True) if its_part == part]
            probability = self.strata[part.stratum].probability
            rough = float(np.mean([pilot.probability if pilot.reached else 0.0 for pilot in part_pilots]))
            nearest = max(pilot.probability for pilot in part_pilots)
            trials = sum(pilot.count for pilot in part_pilots) * STEPS * chains
            levels = max(pilot.count for pilot in part_pilots)
            looks.append(Screened(part, probability * rough, probability * nearest, levels, trials))
        return looks

    def run(self, batch: Batch) -> BatchResult[Description]:
        """Make a batch of runs, each with a pilot of its own."""
        drive, generator = self._drive(batch.parts), self._stream(batch)
        pilots = run_pilots(drive, len(batch.parts), generator)
        run = run_levels(drive, pilots, generator)
        strata = [self.strata[part.stratum] for part in batch.parts]
        shares = np.array([stratum.probability for stratum in strata])
        described = self.describe(StrataView(run.failing, strata), np.repeat(shares, CHAINS) * run.weights)
        piloted = sum(pilot.count for pilot in pilots) * STEPS * PILOT_CHAINS
        return BatchResult(batch, shares * run.probabilities, shares * run.counted, described, piloted + run.trials)

    def _drive(self, parts: Sequence[Part]) -> WayDrive:
        return WayDrive(
            self.model, [self.strata[part.stratum] for part in parts], [part.way for part in parts], self.indices
        )

    def _stream(self, batch: Batch) -> np.random.Generator:
        return stream(self.seed, f"{STREAM}, {batch.stage}", batch.number)


@dataclass(frozen=True)
class Found(Generic[Description]):
    """What a search found."""

    estimate: Estimate
    """Of the failure, over all ways and strata."""
    screened: tuple[Screened, ...]
    """Every part."""
    batches: tuple[BatchResult[Description], ...]
    """Of the parts that were estimated, the first stage's first."""
    trials: int
    """That were run, without plain ones."""
    cut: bool
    """Whether fewer runs were made than the accuracy asked for takes."""

    def probability(self, way: int) -> float:
        """Of failing in a way, alone or with others."""
        runs: dict[Part, list[float]] = {}
        for batch in self.batches:
            for part, value in zip(batch.batch.parts, batch.probabilities, strict=True):
                runs.setdefault(part, []).append(float(value))
        looks = [look for look in self.screened if look.part.way == way]
        return sum(float(np.mean(runs[look.part])) if look.part in runs else look.probability for look in looks)


def _batched(items: Sequence[Item], size: int) -> list[tuple[Item, ...]]:
    """Divide items into tuples of `size`; the last may be shorter."""
    return [tuple(items[start : start + size]) for start in range(0, len(items), size)]


class _Search(Generic[Description]):
    """A search as it goes: what was done, and how many trials it took."""

    def __init__(self, search: FailureSearch[Description], run: Runner, progress: Callable[[int], None]) -> None:
        self._search, self._run, self._told = search, run, progress
        self.trials = 0
        self.batches: list[BatchResult[Description]] = []

    def _count(self, trials: int) -> None:
        self.trials += trials
        self._told(self.trials)

    def screened(self) -> list[Screened]:
        """Screen all parts; look again, with more chains, where pilots ended before failure though not for rarity."""
        looks = {look.part: look for look in self._screened(self._search.parts, "screening")}
        whole = sum(look.probability for look in looks.values())
        stuck = [
            look.part
            for look in looks.values()
            if look.probability == 0.0
            and look.part.way < len(self._search.indices.margins)  # all together end where one fails
            and look.nearest > NEGLIGIBLE * whole
            and SHARE ** (MOST_LEVELS - 1) < look.nearest / self._search.strata[look.part.stratum].probability < 1.0
        ]
        looks |= {look.part: look for look in self._screened(stuck, "second look")}
        return list(looks.values())

    def _screened(self, parts: Sequence[Part], stage: str) -> Iterator[Screened]:
        together = [Batch(group, stage, number) for number, group in enumerate(_batched(parts, SCREENED_TOGETHER))]
        twice = [Batch(batch.parts * SCREENING, batch.stage, batch.number) for batch in together]
        for batch in self._run(self._search.screen, twice):
            self._count(sum(look.trials for look in batch))
            yield from batch

    def stage(self, parts: Sequence[Part], runs: Sequence[int], name: str) -> dict[Part, Array]:
        """Make so many runs of each part; return what each adds to the whole."""
        wanted = [part for part, count in zip(parts, runs, strict=True) for _ in range(count)]
        counted: dict[Part, list[float]] = {part: [] for part in parts}
        batches = [Batch(group, name, number) for number, group in enumerate(_batched(wanted, TOGETHER))]
        for result in self._run(self._search.run, batches):
            self._count(result.trials)
            self.batches.append(result)
            for part, value in zip(result.batch.parts, result.counted, strict=True):
                counted[part].append(float(value))
        return {part: np.array(values) for part, values in counted.items()}


def find(
    search: FailureSearch[Description],
    run: Runner,
    *,
    variation: float,
    most_trials: int,
    progress: Callable[[int], None] = lambda trials: None,
) -> Found[Description]:
    """Estimate the probability of a failure.

    `variation` is the coefficient of variation that is asked for; screening and the least number of runs are made
    whatever `most_trials`. `progress` is called with the trials done so far.
    """
    going = _Search(search, run, progress)
    screened = going.screened()
    whole = sum(look.probability for look in screened)
    kept = [look for look in screened if look.probability > NEGLIGIBLE * whole]
    parts = [look.part for look in kept]
    first = going.stage(parts, [FIRST] * len(parts), "first stage")
    runs, cut = runs_needed(
        list(first.values()),
        [look.levels * STEPS * (PILOT_CHAINS + CHAINS) for look in kept],
        variation=variation,
        most_cost=most_trials - going.trials,
        least=LEAST_SECOND,
    )
    second = going.stage(parts, runs, "second stage")
    left = sum(look.probability for look in screened if look not in kept)
    estimate = Estimate.of([TwoStages(first[part], second[part]) for part in parts], left)
    return Found(estimate, tuple(screened), tuple(going.batches), going.trials, cut)
