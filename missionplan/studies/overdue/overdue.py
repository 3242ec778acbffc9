"""Expected times and search areas of a mission, from one block of its trials with all their tracks."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.streams import stream
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import Failure
from missionplan.results.overdue import DriftAssumption, ExpectedTime, Overdue
from missionplan.scenario.scenario import Scenario
from missionplan.studies.overdue.drift import Drift
from missionplan.studies.overdue.losses import losses
from missionplan.studies.overdue.search_areas import HOURS, search_areas
from missionplan.studies.overdue.searches import Search
from missionplan.studies.simulation.phase_trials import Flags, PhaseTrials
from missionplan.studies.simulation.trial_block import MissionTrials

FEWEST_BACK = 50
"""Trials that come back without which no sheet is made."""
MOST_SURFACINGS = 5
"""Of a transit that the sheet names, besides its arrival."""
CONFIDENCE = 0.9
"""That the latest of the trials lies beyond a share, for them to tell its time: of 0.999, 2302 trials can."""
_LEAST_SHARE = 0.05
"""Of the trials that make a surfacing for it to be named."""


def overdue(scenario: Scenario, trials: MissionTrials, seed: int, searches: Sequence[Search] = ()) -> Overdue | None:
    """Return times and search areas; None where too few trials come back or no phase has a track.

    Parameters
    ----------
    scenario : Scenario
        With the draws of these trials.
    trials : MissionTrials
        With the tracks of all of them.
    seed : int
        Of the run.
    searches : sequence of Search
        That found nothing.
    """
    back = np.isfinite(trials.total["duration_s"])
    moving = [phase for phase in trials.phases if phase.kind in ("transit", "moor")]
    if np.count_nonzero(back) < FEWEST_BACK or not moving:
        return None
    times = (*_surfacings(scenario, trials), _time("back", trials, scenario, trials.total["duration_s"]))
    failed = dict(_first_failures(trials, ~back))
    drift = Drift.of(scenario, seed, back.size)
    found = Overdue(
        times=times,
        missing={f"{phase}: {reason}": float(np.mean(flags)) for (phase, reason), flags in failed.items()},
        areas=(),
        searches=len(searches),
    )
    lost = losses(moving, failed, stream(seed, "overdue", 0))
    reach = {phase.name: _reach(phase) for phase in moving if phase.kind == "moor"}
    areas = tuple(search_areas(lost, drift, found.worry_after, reach, searches))
    last = found.worry_after + 3600.0 * HOURS[-1]
    return replace(found, areas=areas, assumptions=tuple(_assumptions(scenario, drift, last)))


def _assumptions(scenario: Scenario, drift: Drift, last: float) -> Iterator[DriftAssumption]:
    if scenario.leeway is None:
        yield DriftAssumption.NO_WIND
    if drift.is_error_assumed:
        yield DriftAssumption.ERROR_OF_CURRENT
    if drift.is_steady:
        yield DriftAssumption.STEADY_LAYERS
    if drift.ends < last or (isinstance(scenario.wind, RecordedCurrent) and scenario.wind.time[-1] < last):
        yield DriftAssumption.BEYOND_RECORD
    if drift.shore is None:
        yield DriftAssumption.NO_LAND


def _first_failures(trials: MissionTrials, missing: Flags) -> Iterator[tuple[tuple[str, str], Flags]]:
    """Trials that never end, by the phase and the reason for which they failed first."""
    good = np.ones(missing.size, dtype=bool)
    for phase in trials.phases:
        for reason, flags in phase.failures.items():
            left = phase.left if reason == Failure.EQUIPMENT else {}
            kinds = {f"{reason}, {leaves}": own for leaves, own in left.items()}
            for name, own in (kinds or {reason: flags}).items():
                if np.any(good & own & missing):
                    yield (phase.name, name), good & own & missing
            good = good & ~flags


def _reach(mooring: PhaseTrials) -> float:
    """How far a held vehicle is from its anchor, in all but 5 % of the trials [m]."""
    values = mooring.quantities.get("excursion_m", np.zeros(1))
    known = values[np.isfinite(values)]
    return float(np.quantile(known, 0.95)) if known.size else 0.0


def _surfacings(scenario: Scenario, trials: MissionTrials) -> Iterator[ExpectedTime]:
    """Times of the first surfacings of each transit, of its arrival, and of the fix after each mooring."""
    for number, phase in enumerate(trials.phases):
        last = number + 1 == len(trials.phases)
        if phase.kind == "transit":
            rows = phase.track_time[1::2]  # on surfacing; the rows between are on diving
            for surfacing, clock in enumerate(rows[:MOST_SURFACINGS], start=1):
                later = np.isfinite(rows[surfacing]) if surfacing < len(rows) else np.zeros(clock.size, dtype=bool)
                before_arrival = np.where(later, clock, np.nan)  # the last surfacing is the arrival
                if np.mean(later) >= _LEAST_SHARE:
                    yield _time(f"{phase.name}, surfacing {surfacing}", trials, scenario, before_arrival)
        if not last and np.any(np.isfinite(phase.end)):
            words = "up from the seafloor" if phase.kind == "moor" else "arrival"
            yield _time(f"{phase.name}, {words}", trials, scenario, phase.end)


def _time(name: str, trials: MissionTrials, scenario: Scenario, clock: Array) -> ExpectedTime:
    reached = np.isfinite(clock)
    p50, p95, p99, p999 = (_time_of(share, clock[reached]) for share in (0.5, 0.95, 0.99, 0.999))
    left = scenario.capacity / JOULES_PER_WATT_HOUR - _spent(trials, clock)
    known = left[reached & np.isfinite(left)]
    return ExpectedTime(
        name, float(np.mean(reached)), p50, p95, p99, p999, float(np.quantile(known, 0.05)) if known.size else np.nan
    )


def _time_of(share: float, clock: Array) -> float:
    """Time by which a share of the trials is there; nan where so few cannot tell it."""
    return float(np.quantile(clock, share)) if share**clock.size <= 1.0 - CONFIDENCE else np.nan


def _spent(trials: MissionTrials, clock: Array) -> Array:
    """Energy used until a time, evenly within each phase; nan for a phase that a trial did not end [W h]."""
    spent = np.zeros(clock.size)
    for phase in trials.phases:
        begun = np.isfinite(phase.start) & (clock > phase.start)
        used, lasted = phase.quantities.get("energy_wh"), phase.end - phase.start
        if used is None:
            return np.full(clock.size, np.nan)
        share = np.clip((clock - phase.start) / np.where(lasted > 0.0, lasted, 1.0), 0.0, 1.0)
        spent = spent + np.where(begun, share * used, 0.0)
    return spent
