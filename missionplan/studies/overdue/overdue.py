"""Expected times and search areas of a mission, from one block of its trials with all their tracks."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.streams import stream
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.results.overdue import ExpectedTime, Overdue
from missionplan.scenario.scenario import Scenario
from missionplan.studies.overdue.search_areas import DRIFTS, Cloud, FloatingVehicle, Way, search_areas
from missionplan.studies.simulation.block_statistics import failures_by_step
from missionplan.studies.simulation.mission_trials import MissionTrials
from missionplan.studies.simulation.phase_trials import AGROUND, FLOODED_EARLY, Flags, PhaseTrials

FEWEST_BACK = 50
"""Trials that come back without which no sheet is made."""
FEWEST_FAILED = 20
"""Trials that failed in a way, from which its search area is taken; with fewer, others are assumed to fail so."""
MOST_SURFACINGS = 5
"""Of a transit that the sheet names, besides its arrival."""
CONFIDENCE = 0.9
"""That the latest of the trials lies beyond a share, for them to tell its time: of 0.999, 2302 trials can."""
_LEAST_SHARE = 0.05
"""Of the trials that make a surfacing for it to be named."""
_SINKING = (AGROUND, FLOODED_EARLY)
_HELD = ("did not surface",)


def overdue(scenario: Scenario, trials: MissionTrials, seed: int) -> Overdue | None:
    """Return times and search areas; None where too few trials come back or no phase has a track.

    Parameters
    ----------
    scenario : Scenario
        With the draws of these trials.
    trials : MissionTrials
        With the tracks of all of them.
    seed : int
        Of the run.
    """
    back = np.isfinite(trials.total["duration_s"])
    moving = [phase for phase in trials.phases if phase.kind in ("transit", "moor")]
    if np.count_nonzero(back) < FEWEST_BACK or not moving:
        return None
    times = (*_surfacings(scenario, trials), _time("back", trials, scenario, trials.total["duration_s"]))
    steps = {name: failed & ~back for name, failed in failures_by_step(trials).items()}
    clouds = _clouds(trials, steps, moving, stream(seed, "overdue", 0))
    drift = FloatingVehicle(scenario.current, scenario.transit_effects, back.size)
    reach = max((_reach(phase) for phase in moving if phase.kind == "moor"), default=0.0)
    found = Overdue(
        times=times,
        missing={name: float(np.mean(failed)) for name, failed in steps.items() if np.any(failed)},
        areas=(),
        beyond_record=scenario.recorded is not None,
    )
    return replace(found, areas=tuple(search_areas(clouds, drift, found.worry_after, reach)))


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


def _clouds(
    trials: MissionTrials, steps: Mapping[str, Flags], moving: list[PhaseTrials], generator: np.random.Generator
) -> list[Cloud]:
    """Trials that failed in each way; where they are too few, all trials, assumed to fail so."""
    place, clock = _last_known(moving)
    failed: dict[Way, Flags] = {}
    for step, flags in steps.items():
        reason = step.rpartition(": ")[2]
        way: Way = "on the seafloor" if reason in _SINKING else "not released" if reason in _HELD else DRIFTS
        failed[way] = failed.get(way, np.zeros(flags.size, dtype=bool)) | flags
    clouds: list[Cloud] = []
    for way, (at, when) in _assumed(moving, generator).items():
        own = failed.get(way, np.zeros(clock.size, dtype=bool)) & _known(place, clock)
        if np.count_nonzero(own) >= FEWEST_FAILED:
            chosen = np.flatnonzero(own)
            clouds.append(Cloud(way, chosen, place[:, chosen], clock[chosen], assumed=False))
        elif np.count_nonzero(_known(at, when)) >= FEWEST_FAILED:
            chosen = np.flatnonzero(_known(at, when))
            clouds.append(Cloud(way, chosen, at[:, chosen], when[chosen], assumed=True))
    return clouds


def _known(place: Array, moment: Array) -> Flags:
    """Trials that were at a place, such as that of an anchor which was laid, at a moment."""
    return np.isfinite(moment) & np.isfinite(place).all(axis=0)


def _last_known(moving: list[PhaseTrials]) -> tuple[Array, Array]:
    """Where and when each trial was last at a fix."""
    track, time = _tracks(moving)
    count = np.arange(len(time))[:, None]
    last = np.max(np.where(np.isfinite(time), count, -1), axis=0)
    each = np.arange(time.shape[1])
    return track[last, :, each].T, np.where(last >= 0, time[last, each], np.nan)


def _assumed(moving: list[PhaseTrials], generator: np.random.Generator) -> dict[Way, tuple[Array, Array]]:
    """Where and when each trial would fail in each way, at a moment as likely as any other."""
    moors = [phase for phase in moving if phase.kind == "moor"]
    transits = [phase for phase in moving if phase.kind == "transit"]
    found: dict[Way, tuple[Array, Array]] = {}
    if moors:
        found["not released"] = (moors[-1].anchor, moors[-1].start)
    after = moving[moving.index(moors[-1]) :] if moors else transits
    found[DRIFTS] = _at_random_fix(after, generator)
    if transits:
        found["on the seafloor"] = _on_the_way(transits, generator)
        found["still under way"] = _on_the_way(transits[-1:], generator)
    return found


def _tracks(phases: list[PhaseTrials]) -> tuple[Array, Array]:
    return np.concatenate([phase.track for phase in phases]), np.concatenate([phase.track_time for phase in phases])


def _at_random_fix(phases: list[PhaseTrials], generator: np.random.Generator) -> tuple[Array, Array]:
    """A fix of each trial, at the surface, each as likely as any other."""
    track, time = _tracks(phases)
    if phases[0].kind == "moor":
        track, time = track[1:], time[1:]  # the anchor's touchdown is not at the surface
    return _picked(track, time, _random_row(np.isfinite(time), generator), 0.0)


def _on_the_way(phases: list[PhaseTrials], generator: np.random.Generator) -> tuple[Array, Array]:
    """A place of each trial between two fixes of one transit, each leg as likely as any other."""
    track, time = _tracks(phases)
    dives = np.concatenate([np.arange(len(phase.track_time)) % 2 == 0 for phase in phases])  # and by turns surfacings
    legs = dives[:-1, None] & np.isfinite(time[:-1]) & np.isfinite(time[1:])
    return _picked(track, time, _random_row(legs, generator), generator.random(time.shape[1]))


def _random_row(possible: Flags, generator: np.random.Generator) -> NDArray[np.intp]:
    """A row of each trial where it is possible, -1 where none is."""
    keys = np.where(possible, generator.random(possible.shape), -1.0)
    return np.where(possible.any(axis=0), np.argmax(keys, axis=0), -1)


def _picked(track: Array, time: Array, row: NDArray[np.intp], share: Array | float) -> tuple[Array, Array]:
    """Place and time of a row of each trial, a share of the way to the next."""
    each, further = np.arange(row.size), np.minimum(row + 1, len(time) - 1)
    share = np.where(np.asarray(share) > 0.0, share, 0.0)
    first, second = track[row, :, each].T, track[further, :, each].T
    place = first if not np.any(share) else first + share * (second - first)
    moment = time[row, each] if not np.any(share) else time[row, each] + share * (time[further, each] - time[row, each])
    return place, np.where(row >= 0, moment, np.nan)
