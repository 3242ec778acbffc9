"""When to expect a vehicle, when to worry, and the smallest areas that hold it, by way to fail and hours overdue.

From one block of the mission's trials with all their tracks, and from searches that found nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import contourpy
import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.streams import stream
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.failures import Failure
from missionplan.results.whereabouts import AFLOAT, SHARES, DriftAssumption, ExpectedTime, Overdue, SearchArea
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.drift import Drift
from missionplan.studies.simulation.losses import Losses, Search, losses
from missionplan.studies.simulation.phase_trials import Flags, PhaseTrials
from missionplan.studies.simulation.trial_block import MissionTrials

Polygon = tuple[Array, ...]
"""Closed rings of shape (2, k): the outer one, then those of its holes [m]."""
_CELLS = 160
"""Of the grid along the longer axis."""
_REACH = 4.0
"""Of a kernel, in its standard deviations."""
_KERNEL = 0.7
"""Width of the kernels in units of that which is best for a normal cloud: less, as clouds are bent."""
_LEAST = 1.0
"""Standard deviation that a cloud has at least, where all points lie alike [m]."""


@dataclass(frozen=True)
class Cloud:
    """Points with weights."""

    points: Array
    """Shape (2, n). [m]"""
    weights: Array
    """Their sum is one, shape (n,)."""

    @cached_property
    def centre(self) -> Array:
        """Mean, shape (2,) [m]."""
        return np.asarray(self.points @ self.weights)

    @cached_property
    def axes(self) -> tuple[Array, Array]:
        """Standard deviations along the short and the long axis [m], and unit vectors of these as columns."""
        off = self.points - self.centre[:, None]
        values, vectors = np.linalg.eigh((off * self.weights) @ off.T)
        return np.sqrt(np.maximum(values, _LEAST**2)), vectors

    @cached_property
    def _density(self) -> tuple[Array, Array, Array, Array]:
        """A kernel estimate on a grid along the axes, in units of the standard deviations: of x, y, and by (y, x).

        Then at each point, as the others alone give it: what a point adds at its own place is no evidence that the
        vehicle is there, and areas that counted it would be too small, shape (n,).
        """
        sds, vectors = self.axes
        scaled = (vectors.T @ (self.points - self.centre[:, None])) / sds[:, None]
        alike = 1.0 / float(np.sum(np.square(self.weights)))  # as many points of one weight would tell as much
        width = _KERNEL * alike ** (-1.0 / 6.0)
        low, high = scaled.min(axis=1) - _REACH * width, scaled.max(axis=1) + _REACH * width
        step = min(float(np.max(high - low)) / _CELLS, 0.5 * width)
        x, y = (np.arange(a, b + step, step) for a, b in zip(low, high, strict=True))
        row, column = (np.rint((at - axis[0]) / step).astype(int) for at, axis in ((scaled[1], y), (scaled[0], x)))
        cells = np.bincount(row * x.size + column, self.weights, minlength=y.size * x.size)
        along, across = _kernels(y.size, width / step), _kernels(x.size, width / step)
        smooth = along @ cells.reshape(y.size, x.size) @ across
        return x, y, smooth, smooth[row, column] - self.weights * along[row, row] * across[column, column]

    def areas(self, shares: Sequence[float]) -> list[tuple[Polygon, ...]]:
        """Return, for each share, the parts of the area of highest density that holds it."""
        x, y, values, of_points = self._density
        order = np.argsort(-of_points)
        sums, contours = (
            np.cumsum(self.weights[order]),
            contourpy.contour_generator(x, y, values, fill_type="OuterOffset"),
        )
        areas = []
        for share in shares:
            level = float(of_points[order[min(int(np.searchsorted(sums, share)), order.size - 1)]])
            lines = contours.filled(max(level, 1e-6 * float(values.max())), np.inf)
            areas.append(
                tuple(
                    tuple(self._placed(points[a:b].T) for a, b in pairwise(offsets))
                    for points, offsets in zip(*lines, strict=True)
                )
            )
        return areas

    def densest(self) -> Array:
        """Return the place of highest density, shape (2,) [m]."""
        x, y, values, _ = self._density
        row, column = np.unravel_index(int(np.argmax(values)), values.shape)
        return self._placed(np.array([[x[column]], [y[row]]]))[:, 0]

    def _placed(self, scaled: Array) -> Array:
        sds, vectors = self.axes
        return np.asarray(self.centre[:, None] + vectors @ (sds[:, None] * scaled))


def _kernels(count: int, sd: float) -> Array:
    """Normal kernels about each of so many cells, each of sum one where it is whole; shape (count, count)."""
    reach = np.arange(-int(_REACH * sd + 0.5), int(_REACH * sd + 0.5) + 1)
    total = np.exp(-0.5 * np.square(reach / sd)).sum()
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    return np.where(apart <= reach[-1], np.exp(-0.5 * np.square(apart / sd)) / total, 0.0)


HOURS = (0.0, 1.0, 3.0, 6.0, 12.0, 24.0)
"""Hours overdue for which areas are given, as far as the current is known."""


def search_areas(
    lost: Sequence[Losses], drift: Drift, worry: float, reach: dict[str, float], searches: Sequence[Search] = ()
) -> Iterator[SearchArea]:
    """Yield the areas of each way to be lost, by hours overdue and by the share that they hold.

    `drift`: of the whole block. `worry`: when the vehicle is overdue [s]. `reach`: how far from its anchor a held
    vehicle is, by mooring [m]. `searches`: that found nothing, in the order of their times.
    """
    for part in lost:
        looked = [search for search in searches if search.way == part.way]
        if part.way == AFLOAT:
            yield from _adrift(part, drift, worry, looked)
            continue
        missed = np.ones(part.clock.size)
        for search in looked:
            missed = missed * np.where(part.clock <= search.time, search.missed(part.position), 1.0)
        more = reach.get(part.after, 0.0) if part.way == "not released" else None
        yield from _areas(part, part.position, missed, 0.0, more)


def _adrift(losses: Losses, drift: Drift, worry: float, searches: Sequence[Search]) -> Iterator[SearchArea]:
    """Areas of those that drift: the search sees them where they are at its time."""
    stops: list[tuple[float, Search | float]] = [(search.time, search) for search in searches]
    until = drift.known_until(worry)
    stops += [(worry + 3600.0 * hours, 3600.0 * hours) for hours in HOURS if worry + 3600.0 * hours <= until]
    if not stops:
        return
    stops.sort(key=lambda stop: stop[0])
    times = [time for time, _ in stops]
    whole, clock = np.zeros((2, drift.trials)), np.full(drift.trials, times[-1])
    whole[:, losses.trials], clock[losses.trials] = losses.position, losses.clock
    missed = np.ones(losses.clock.size)
    for (time, stop), places in zip(stops, drift.places(whole, clock, times), strict=True):
        here = places[:, losses.trials]
        if isinstance(stop, Search):
            missed = missed * np.where(losses.clock <= time, stop.missed(here), 1.0)
        else:
            yield from _areas(losses, here, missed, stop, None)


def _areas(losses: Losses, places: Array, missed: Array, overdue: float, reach: float | None) -> Iterator[SearchArea]:
    """Areas of one cloud; circles about its centre where the vehicle is held within reach of its anchor."""
    left = float(np.mean(missed))
    if left == 0.0:
        return
    cloud = Cloud(places, missed / missed.sum())
    shapes = cloud.areas(SHARES) if reach is None else [_circle(cloud, share, reach) for share in SHARES]
    sds, vectors = cloud.axes
    centre, densest = cloud.centre, cloud.densest() if reach is None else cloud.centre
    for share, polygons in zip(SHARES, shapes, strict=True):
        length, width = (float(np.sqrt(-2.0 * np.log1p(-share)) * sd) for sd in sds[::-1])
        if reach is not None:
            length = width = float(np.max(np.hypot(*(polygons[0][0] - centre[:, None]))))
        yield SearchArea(
            way=losses.way,
            after=losses.after,
            overdue=overdue,
            share=share,
            polygons=polygons,
            centre_east=float(centre[0]),
            centre_north=float(centre[1]),
            densest_east=float(densest[0]),
            densest_north=float(densest[1]),
            half_length=length,
            half_width=width,
            toward=float(np.arctan2(*vectors[:, 1]) % np.pi),
            missed=left,
            trials=losses.trials.size,
            is_assumed=losses.is_assumed,
        )


def _circle(cloud: Cloud, share: float, reach: float) -> tuple[Polygon, ...]:
    """The circle about the points' centre that holds a share of them, widened by the reach of the line."""
    away = np.hypot(*(cloud.points - cloud.centre[:, None]))
    order = np.argsort(away)
    number = int(np.searchsorted(np.cumsum(cloud.weights[order]), share))
    radius = float(away[order[min(number, order.size - 1)]]) + reach
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    return ((cloud.centre[:, None] + radius * np.stack((np.cos(angles), np.sin(angles))),),)


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

    `scenario`: with the draws of these trials. `trials`: with the tracks of all of them. `seed`: of the run.
    `searches`: that found nothing.
    """
    back = np.isfinite(trials.total["duration_s"])
    names = {phase.name: phase.label for phase in scenario.mission.phases}
    trials = replace(trials, phases=tuple(replace(phase, name=names[phase.name]) for phase in trials.phases))
    moving = [phase for phase in trials.phases if phase.kind in ("transit", "moor")]
    if np.count_nonzero(back) < FEWEST_BACK or not moving:
        return None
    times = (*_surfacings(scenario, trials), _time("back", trials, scenario, trials.total["duration_s"]))
    failed = dict(_first_failures(trials, ~back))
    drift = Drift.of(scenario, seed, back.size)
    sheet = Overdue(
        times=times,
        missing={f"{phase}: {reason}": float(np.mean(flags)) for (phase, reason), flags in failed.items()},
        areas=(),
        searches=len(searches),
    )
    lost = losses(moving, failed, stream(seed, "overdue", 0))
    reach = {phase.name: _reach(phase) for phase in moving if phase.kind == "moor"}
    areas = tuple(search_areas(lost, drift, sheet.worry_after, reach, searches))
    last = sheet.worry_after + 3600.0 * HOURS[-1]
    return replace(sheet, areas=areas, assumptions=tuple(_assumptions(scenario, drift, last)))


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
            kinds = {f"{reason}, {leaves}": lost for leaves, lost in left.items()}
            for name, lost in (kinds or {reason: flags}).items():
                if np.any(good & lost & missing):
                    yield (phase.name, name), good & lost & missing
            good = good & ~flags


def _reach(mooring: PhaseTrials) -> float:
    """How far a held vehicle is from its anchor, in all but 5 % of the trials [m]."""
    values = mooring.quantities.get("excursion_m", np.zeros(1))
    excursions = values[np.isfinite(values)]
    return float(np.quantile(excursions, 0.95)) if excursions.size else 0.0


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
    there = clock[reached]
    p50, p95, p99, p999 = (
        float(np.quantile(there, share)) if share**there.size <= 1.0 - CONFIDENCE else np.nan  # too few can tell it
        for share in (0.5, 0.95, 0.99, 0.999)
    )
    left = scenario.capacity / JOULES_PER_WATT_HOUR - _spent(trials, clock)
    rest = left[reached & np.isfinite(left)]
    return ExpectedTime(
        name, float(np.mean(reached)), p50, p95, p99, p999, float(np.quantile(rest, 0.05)) if rest.size else np.nan
    )


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
