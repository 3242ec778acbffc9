"""Dive logs as they are fitted: without bottom contact, with the noise estimated, averaged in bins."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.records import TOUCHDOWN_MARGIN, DescentData, MeasuredDive
from missionplan.errors import InputError, Problem, counted

MAX_SAMPLES = 70
MIN_SAMPLES = 10
MIN_DIVES = 2
NEEDED = (
    f"{MIN_DIVES} dives are needed to hold one out, 3 to find an outlying one, and two different anchor weights or "
    "line lengths to tell most causes apart"
)
LEVEL_QUANTILE, LEVEL_SHARES = 0.98, (0.8, 0.95)
"""Quantile of the readings that is a log's level, and shares of it between which the descent's speed is taken."""
LEVEL_TIMES = 4.0
"""Times as long as at that speed the last of the way takes, where a log ends level."""
STRUCK_SHARES = (0.6, 0.85)
"""Shares of the deepest reading: of those beyond the first a bend is sought, of those beyond the second it is taken for
a touchdown, after which a vehicle coasts no further than a metre or two."""
STRUCK_RATE, STRUCK_SD = 0.7, 6.0
"""Rate after a touchdown over that before it, at most, and the bend over its standard error, at least."""
FEWEST_AFTER, MOST_BENT = 3, 200
"""Readings on either side of a bend at least, and of all among which it is sought, about."""
TIMES_PER_BIN = 6
"""Times kept in a bin, at most."""
MOVING_DEPTH = 0.15
"""Reading from which a dive is fitted [m]: before, the sensor rests, and quantised readings have no white noise."""
BIN_GROWTH = 1.6
"""Power by which bins grow along a dive: what separates a sensor's lag from a late clock lasts a second or two."""
MIN_NOISE = 0.008
"""Accuracy that neither sensor nor integration exceeds, over a bin [m]."""
TOO_DEEP, TOO_FAST = 1.5, 3.0
"""Readings over the site's depth, and their rate [m/s], above which metres are doubted."""
NORMAL_QUARTILE = 0.6745
"""Median of |z| for a standard normal z."""


@dataclass(frozen=True)
class DiveLog:
    """One dive as it is fitted."""

    name: str
    """Of the run."""
    t: Array
    depth: Array
    sd: Array
    """Time since the separation by the log's clock [s], reading [m], and its noise's standard deviation [m], each of a
    bin of consecutive readings, shape (m,)."""
    fine: Array
    """Times within the bins [s]: a model is averaged over them as the readings were, shape (f,)."""
    bins: NDArray[np.int_]
    """Bin of each of them, shape (f,)."""
    shares: Array
    """Weight of each in its bin's mean, shape (f,)."""
    wet_weight: float
    line_length: float
    site_depth: float
    """Of this dive [N, m, m]."""
    identity: str = ""
    """Hash of the dive as it was logged."""


@dataclass(frozen=True)
class PreparedDives:
    """Dives of a data set, ready to be fitted."""

    name: str
    source: str
    """Of the data set."""
    dives: tuple[DiveLog, ...]
    """In the order of the file."""
    notices: tuple[str, ...]
    """Treatments the reader should know of."""
    date: float = math.nan
    """Of the dives [s since 1970]; nan where it is not known."""

    @property
    def identities(self) -> tuple[str, ...]:
        """Hash of each dive."""
        return tuple(log.identity for log in self.dives)

    def subset(self, keep: NDArray[np.bool_]) -> "PreparedDives":
        """Keep some of the dives."""
        return replace(self, dives=tuple(log for log, is_kept in zip(self.dives, keep, strict=True) if is_kept))


def prepare_dives(data: DescentData) -> PreparedDives:
    """Trim and average the dives of a data set; a dive with too few samples is left out.

    Raises
    ------
    InputError
        When too few dives are left.
    """
    notices = list(data.notices)
    prepared = [_prepare(dive, data.depth_noise, notices) for dive in data.dives]
    dives = tuple(dive for dive in prepared if dive is not None)
    if len(dives) < MIN_DIVES:
        why = "; ".join([f"too few: {NEEDED}", *notices[len(data.notices) :]])
        raise InputError([Problem(f"has {counted(len(dives), 'usable dive')}, {why}", data.file)])
    notices += _doubts_of_metres(data.dives, dives)
    return PreparedDives(data.name, data.source, dives, tuple(notices), data.date)


def _prepare(dive: MeasuredDive, stated: float | None, notices: list[str]) -> DiveLog | None:
    """Trim start and bottom contact, estimate the noise, average in bins; None when too little is left."""
    t, depth = dive.t, dive.depth
    level, does = levels_off_at(t, depth), "levels off"
    if np.isinf(level):
        level, does = slows_at(t, depth), "slows abruptly"
    if level < dive.deepest_fitted:
        moored = dive.site_depth - dive.line_length
        notices.append(f"{dive.name} {does} at {level:.4g} m, not at {moored:.4g} m: taken for its touchdown")
    beyond = np.flatnonzero(depth > min(dive.deepest_fitted, (1.0 - TOUCHDOWN_MARGIN) * level))
    end = int(beyond[0]) if len(beyond) else len(t)
    moving = np.flatnonzero(depth > MOVING_DEPTH)
    first = t[moving[0]] if len(moving) else 0.0
    keep = (np.arange(len(t)) < end) & (t >= max(0.0, first))
    t, depth = t[keep], depth[keep]
    if len(t) < MIN_SAMPLES:
        few = f"{len(t)} samples between separation and touchdown, {MIN_SAMPLES} needed"
        notices.append(f"{dive.name} is left out: {few}")
        return None
    gap = float(np.diff(t).max())
    if gap > 0.2 * float(np.ptp(t)) and gap > 5.0 * float(np.median(np.diff(t))):
        notices.append(f"{dive.name}: a gap of {gap:.1f} s in the log")
    noise = max(stated or 0.0, estimate_noise(t, depth))
    log = binned(dive.name, t, depth, noise, dive.wet_weight, dive.line_length, dive.site_depth)
    return replace(log, identity=dive.identity)


def levels_off_at(t: Array, depth: Array) -> float:
    """Return the depth at which a log ends level, as after touchdown; infinite where it ends in the descent [m].

    `t`, `depth`, shape (m,): times [s] and readings [m].
    """
    level = float(np.quantile(depth, LEVEL_QUANTILE))
    near, nearer = (int(np.argmax(depth >= share * level)) for share in LEVEL_SHARES)
    steady = (1.0 - LEVEL_SHARES[1]) / (LEVEL_SHARES[1] - LEVEL_SHARES[0]) * (t[nearer] - t[near])
    return level if level > MOVING_DEPTH and t[-1] - t[nearer] > LEVEL_TIMES * steady else np.inf


def slows_at(t: Array, depth: Array) -> float:
    """Return the depth at which a log that ends soon after it slows abruptly, as at touchdown; else infinite [m].

    A line with one bend is fitted to the end of the log, the bend where the squares are least (Hinkley 1969,
    *Biometrika* 56).

    `t`, `depth`, shape (m,): times [s] and readings [m].
    """
    deepest = float(depth.max())
    begin = int(np.argmax(depth >= STRUCK_SHARES[0] * deepest))
    every = max(1, (len(t) - begin) // MOST_BENT)
    t, depth = t[begin::every], depth[begin::every]
    bends = range(FEWEST_AFTER, len(t) - FEWEST_AFTER)
    if not bends:
        return np.inf
    fits = [_bent_line(t, depth, bend) for bend in bends]
    at, before, change, error, _ = min(fits, key=lambda fit: fit[-1])
    is_struck = (
        at > STRUCK_SHARES[1] * deepest and before + change < STRUCK_RATE * before and -change > STRUCK_SD * error
    )
    return at if is_struck else np.inf


def _bent_line(t: Array, depth: Array, bend: int) -> tuple[float, float, float, float, float]:
    """Depth at a bend [m], rate before it, its change there and that one's error [m/s], and the sum of squares [m²]."""
    since = t - t[bend]
    design = np.stack([np.ones_like(t), since, np.maximum(since, 0.0)], axis=1)
    inverse = np.linalg.pinv(design.T @ design)
    at, before, change = (float(value) for value in inverse @ (design.T @ depth))
    squares = float(np.sum(np.square(depth - design @ [at, before, change])))
    return at, before, change, float(np.sqrt(inverse[2, 2] * squares / max(len(t) - 3, 1))), squares


def estimate_noise(t: Array, depth: Array) -> float:
    """Standard deviation of white noise, from each reading's distance to the line between its neighbours [m].

    Pseudo-residuals (Gasser, Sroka & Jennen-Steinmetz 1986), each over its own standard deviation, so that times need
    not be even; of these the median of the absolute values (Rousseeuw & Croux 1993). A quantised reading can have a
    median of zero; then the root mean square.

    `t`, `depth`, shape (m,): times [s] and readings [m].
    """
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    distance = depth[1:-1] - (1.0 - share) * depth[:-2] - share * depth[2:]
    scaled = distance / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
    by_median = float(np.median(np.abs(scaled))) / NORMAL_QUARTILE
    return by_median if by_median > 0.0 else float(np.sqrt(np.mean(scaled**2)))


def binned(
    name: str, t: Array, depth: Array, noise: float, wet_weight: float, line_length: float, site_depth: float
) -> DiveLog:
    """Average consecutive readings until at most `MAX_SAMPLES` are left, and keep their times within each bin.

    Within a bin at most `TIMES_PER_BIN` times are kept, of readings averaged first where there are more.

    Parameters
    ----------
    name : str
        Of the run.
    t, depth : array, shape (m,)
        Times [s] and readings [m].
    noise : float
        Standard deviation of a reading [m].
    wet_weight, line_length, site_depth : float
        Of this dive [N, m, m].
    """
    edges = np.arange(1, len(t))
    if len(t) > MAX_SAMPLES:
        shares = np.arange(1, MAX_SAMPLES) / MAX_SAMPLES
        edges = np.unique(np.maximum(np.round(len(t) * shares**BIN_GROWTH), 1.0)).astype(int)
    parts = np.split(np.arange(len(t)), edges)
    counts = np.array([len(part) for part in parts])
    inner = [piece for part in parts for piece in np.array_split(part, min(len(part), TIMES_PER_BIN))]
    fine = np.array([t[piece].mean() for piece in inner])
    bins = np.repeat(np.arange(len(parts)), np.minimum(counts, TIMES_PER_BIN))
    weights = np.array([len(piece) for piece in inner]) / counts[bins]
    times, depths = (np.array([values[part].mean() for part in parts]) for values in (t, depth))
    sd = np.maximum(noise / np.sqrt(counts), MIN_NOISE)
    return DiveLog(name, times, depths, sd, fine, bins, weights, wet_weight, line_length, site_depth)


def _doubts_of_metres(measured: Sequence[MeasuredDive], dives: Sequence[DiveLog]) -> list[str]:
    """Warn, without converting, when depths look like feet: deeper than the site, or faster than such a vehicle."""
    ratio = float(np.median([dive.depth.max() / dive.site_depth for dive in measured]))
    halves = [(dive.t[len(dive.t) // 2 :], dive.depth[len(dive.t) // 2 :]) for dive in dives]
    rate = float(np.median([float(np.polyfit(t, depth, 1)[0]) for t, depth in halves]))
    if ratio > TOO_DEEP:
        seen = f"depths reach {ratio:.1f} times the depth of the site"
    elif rate > TOO_FAST:
        seen = f"depths grow by {rate:.1f} a second, faster than such a vehicle sinks in metres"
    else:
        return []
    return [f"{seen}: are they in feet (0.3048 m)? Nothing was converted"]
