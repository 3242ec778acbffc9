"""Equipment that fails: when, in which phase, and what is left of the vehicle then."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.reliability import DistanceHazard, Hazard, HourlyHazard, Leaves, Per
from missionplan.phases.state import TrialState
from missionplan.physics.reliability import age_at_chance, age_at_rate, age_weibull, rate_of_counts
from missionplan.studies.simulation.phase_trials import EQUIPMENT, Exposure, Flags, PhaseTrials, TrialBlock

_LEAVES: dict[Per, Leaves] = {"release": "adrift", "wake-up": "moored"}
_HOUR, _KM = 3600.0, 1000.0
_TINY = 1e-300
"""Age and exposure in the place of none, whose logarithm is finite."""


@dataclass(frozen=True)
class Part:
    """A hazard with the age at which it strikes in each trial.

    Attributes
    ----------
    per : str
    leaves : str
    age : array, shape (n,)
        Of the exposure: seconds, metres or events, of which it strikes at the first after it.
    shape : float or array, shape (n,)
        Of the Weibull law; 1 where it strikes as likely at any age.
    """

    per: Per
    leaves: Leaves
    age: Array
    shape: Scalars = 1.0

    def margin(self, exposure: Array) -> Array:
        """Logarithm of the cumulative hazard at which it strikes over that of an exposure, shape (n,)."""
        shape = np.asarray(self.shape)
        return np.asarray(shape * np.log(np.maximum(self.age, _TINY) / np.maximum(exposure, _TINY)))


def parts_of(block: TrialBlock, trials: int) -> tuple[Part, ...]:
    """Draw when each part of the vehicle fails; none where its file gives no reliability."""
    vehicle = block.scenario.drawn.vehicle
    hazards = vehicle.reliability if vehicle is not None else ()
    return tuple(_drawn(block, number, hazard, trials) for number, hazard in enumerate(hazards))


def _drawn(block: TrialBlock, number: int, hazard: "Hazard[Scalars]", trials: int) -> Part:
    stream = f"vehicle.reliability[{number}]"
    normals = block.source.once(f"{stream}.age")[:trials]
    leaves = hazard.leaves or _LEAVES.get(hazard.per, "adrift")
    unit = _HOUR if isinstance(hazard, HourlyHazard) else _KM if isinstance(hazard, DistanceHazard) else 1.0
    if hazard.shape is not None and hazard.scale is not None:
        return Part(hazard.per, leaves, age_weibull(hazard.shape, hazard.scale, normals), hazard.shape)
    if hazard.failures is not None and hazard.exposure is not None:
        rate: Scalars = rate_of_counts(hazard.failures, hazard.exposure, block.source.once(f"{stream}.rate")[:trials])
        if unit == 1.0:
            return Part(hazard.per, leaves, age_at_chance(-np.expm1(-rate), normals))
        return Part(hazard.per, leaves, age_at_rate(rate / unit, normals))
    given: Scalars = 0.0 if hazard.rate is None else hazard.rate
    return Part(hazard.per, leaves, age_at_rate(given, normals) if unit != 1.0 else age_at_chance(given, normals))


def failing(
    parts: Sequence[Part], before: Exposure, begun: TrialState, after: TrialState, found: PhaseTrials
) -> tuple[TrialState, PhaseTrials, Exposure]:
    """End the trials whose equipment fails in a phase.

    Parameters
    ----------
    parts : sequence of Part
    before : Exposure
        Until the phase began.
    begun, after : TrialState
        At the phase's beginning and end.
    found : PhaseTrials
        Of the phase without failures of equipment.

    Returns
    -------
    state, found, exposure : TrialState, PhaseTrials, Exposure
        Until the phase's end. A trial that fails has no quantities and events of the phase.
    """
    exposure = before.plus(found.exposure)
    first, left = np.full(begun.trials, np.inf), np.full(begun.trials, -1)
    margin = np.min([part.margin(np.asarray(exposure.of(part.per))) for part in parts], axis=0)
    for number, part in enumerate(parts):
        low, high = before.of(part.per), exposure.of(part.per)
        strikes = begun.alive & (low < part.age) & (part.age <= high)
        span = np.where(high > low, high - low, 1.0)
        age = part.age if part.per in ("hour", "km") else np.ceil(part.age)
        share = np.where(strikes, (age - low) / span, np.inf)
        sooner = share < first
        first[sooner], left[sooner] = share[sooner], number
    failed = left >= 0
    lost: dict[str, Flags] = {
        leaves: failed & np.isin(left, [k for k, p in enumerate(parts) if p.leaves == leaves])
        for leaves in _kinds(parts)
    }
    if failed.any():
        after = replace(after, alive=after.alive & ~failed)
        found = replace(
            found,
            quantities={name: np.where(failed, np.nan, values) for name, values in found.quantities.items()},
            events={name: flags & ~failed for name, flags in found.events.items()},
            end=np.where(failed, np.nan, found.end),
            miss=np.where(failed, np.nan, found.miss),
        )
    failures, margins = {EQUIPMENT: failed, **found.failures}, {EQUIPMENT: margin, **found.margins}
    return after, replace(found, failures=failures, left=lost, margins=margins), exposure


def _kinds(parts: Sequence[Part]) -> list[Leaves]:
    return list(dict.fromkeys(part.leaves for part in parts))
