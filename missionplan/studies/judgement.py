"""Whether a recommendation does what the mission requires: the mission with it in place, simulated with fresh draws.

Every command that recommends (`size-anchor`, `optimise`, `plan-legs`, `sweep-dmax`) asks here, and its headline and
exit status follow: what was chosen on one set of random numbers is held to another.
"""

from collections.abc import Mapping
from dataclasses import replace

from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.results.simulation import Outcome
from missionplan.studies.exploration.variation import with_values
from missionplan.studies.simulation.assumptions import ledger
from missionplan.studies.simulation.simulate import simulate

FRESH = 1_000_003
"""Added to the seed on which the recommendation was chosen."""


def judged(
    mission: Mission,
    recommended: Mapping[str, object],
    *,
    trials: int,
    seed: int,
    jobs: int = 1,
    assumptions: bool = True,
) -> Outcome | None:
    """Simulate a mission with what is recommended, and without each of its assumptions.

    Parameters
    ----------
    mission : Mission
        As its file has it.
    recommended : mapping of str to object
        Values by key path, as a mission file has them.
    trials, seed : int
        With which the recommendation was chosen; the draws are those of another seed.
    jobs : int
    assumptions : bool
        Simulate it without each of its assumptions too; `doubted` does so later.

    Returns
    -------
    Outcome or None
        None where the mission requires nothing, or cannot be simulated as a whole.
    """
    if not mission.requirements:
        return None
    return simulated_with(mission, recommended, trials=trials, seed=seed + FRESH, jobs=jobs, assumptions=assumptions)


def doubted(mission: Mission, recommended: Mapping[str, object], outcome: Outcome) -> Outcome:
    """Simulate a mission that was judged without each of its assumptions too."""
    return replace(outcome, assumptions=ledger(_with(mission, recommended), outcome.provenance.seed))


def simulated_with(
    mission: Mission,
    values: Mapping[str, object],
    *,
    trials: int,
    seed: int,
    jobs: int = 1,
    assumptions: bool = False,
) -> Outcome | None:
    """Simulate a mission with other values at some key paths; None where it cannot be."""
    try:
        whole = _with(mission, values)
        return simulate(whole, trials=trials, seed=seed, jobs=jobs, assumptions=assumptions, sheet=False)
    except InputError:
        return None


def _with(mission: Mission, values: Mapping[str, object]) -> Mission:
    return Mission.from_data(with_values(mission.raw, values), file=mission.file)


def is_good(outcome: Outcome | None) -> bool:
    """Whether every requirement is met, and every anchor can be built; so too where nothing was judged."""
    return outcome is None or (outcome.requirements_met and outcome.can_be_built)
