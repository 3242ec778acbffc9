"""Where a vehicle may be that is overdue: for each way to be lost, by hours overdue, after searches in vain."""

from collections.abc import Iterator, Sequence

import numpy as np

from missionplan.arrays import Array
from missionplan.results.overdue import AFLOAT, SHARES, SearchArea
from missionplan.studies.overdue.density import Cloud, Polygon
from missionplan.studies.overdue.drift import Drift
from missionplan.studies.overdue.losses import Losses
from missionplan.studies.overdue.searches import Search

HOURS = (0.0, 1.0, 3.0, 6.0, 12.0, 24.0)
"""Hours overdue for which areas are given, as far as the current is known."""


def search_areas(
    lost: Sequence[Losses], drift: Drift, worry: float, reach: dict[str, float], searches: Sequence[Search] = ()
) -> Iterator[SearchArea]:
    """Yield the areas of each way to be lost, by hours overdue and by the share that they hold.

    Parameters
    ----------
    lost : sequence of Losses
    drift : Drift
        Of the whole block.
    worry : float
        When the vehicle is overdue [s].
    reach : mapping of str to float
        How far from its anchor a held vehicle is, by mooring [m].
    searches : sequence of Search
        That found nothing, in the order of their times.
    """
    for losses in lost:
        looked = [search for search in searches if search.way == losses.way]
        if losses.way == AFLOAT:
            yield from _adrift(losses, drift, worry, looked)
            continue
        missed = np.ones(losses.clock.size)
        for search in looked:
            missed = missed * np.where(losses.clock <= search.time, search.missed(losses.position), 1.0)
        more = reach.get(losses.after, 0.0) if losses.way == "not released" else None
        yield from _areas(losses, losses.position, missed, 0.0, more)


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
