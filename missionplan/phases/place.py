"""What trials meet on their way: ground, land, zones kept out of, and water of which no depth is known."""

from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, take_trials
from missionplan.phases.ground import Ground
from missionplan.phases.zones import Fence, Zone


class Cause(IntEnum):
    """What a trial has met; none of the others has met anything."""

    NONE = 0
    UNCHARTED = 1
    AGROUND = 2
    ON_LAND = 3
    KEEP_OUT = 4


@dataclass(frozen=True)
class SeaLevel:
    """Height of the sea level over the datum of the depths: a level, waves, and a record."""

    level: Scalars = 0.0
    """Shape (n,). [m]"""
    frequency: Array = field(default_factory=lambda: np.zeros(0))
    cosine: Array = field(default_factory=lambda: np.zeros(0))
    sine: Array = field(default_factory=lambda: np.zeros(0))
    """Shape (k,). Of waves ``C·cos(ωt) + S·sin(ωt)`` [rad/s, m, m]."""
    time: Array = field(default_factory=lambda: np.zeros(0))
    height: Array = field(default_factory=lambda: np.zeros(0))
    """Shape (m,). Of a record, linear between, held at its ends [s, m]."""

    def at(self, t: Array) -> Array:
        """Height at times since the mission's start [s], one a trial, shape (n,) [m]."""
        level = np.zeros(t.shape) + self.level
        for frequency, cosine, sine in zip(self.frequency, self.cosine, self.sine, strict=True):
            level += cosine * np.cos(frequency * t) + sine * np.sin(frequency * t)
        return level + np.interp(t, self.time, self.height) if self.time.size else level

    @property
    def lowest(self) -> float:
        """What no trial's level ever falls below [m]."""
        waves = float(np.hypot(self.cosine, self.sine).sum())
        return float(np.min(self.level)) - waves + float(self.height.min() if self.time.size else 0.0)


@dataclass(frozen=True)
class Way:
    """Straight ways of a block of trials, each between two moments."""

    start: Array
    end: Array
    """Shape (2, n). [m]."""
    begun: Array
    ended: Array
    """Shape (n,). Since the mission's start [s]."""
    least: Scalars = 0.0
    greatest: Scalars = 0.0
    """Shape (n,). Depths of the vehicle's axis on the way [m]."""

    @property
    def times(self) -> Array:
        """When they begin and end, shape (2, n) [s]."""
        return np.stack((self.begun, self.ended))

    @property
    def depths(self) -> Array:
        """Least and greatest depth on the way, shape (2, n) [m]."""
        return np.array(np.broadcast_arrays(self.least, self.greatest, self.begun)[:2], dtype=float)

    def take(self, trials: NDArray[np.intp]) -> "Way":
        """Select trials."""
        return take_trials(self, trials, alike=True)


@dataclass(frozen=True)
class Contact:
    """What each trial of a block met first, and where."""

    cause: NDArray[np.int8]
    """A `Cause`, shape (n,)."""
    leg: NDArray[np.int64]
    """Shape (n,). From 1; 0 where nothing was met, or not on a leg."""
    where: Array
    """nan where nothing was met, shape (2, n) [m]."""
    nearest: Array
    """Shape (4, n) or (0, n). How near each trial came to each cause but none: 0 where it was met first, infinite where
    it never was under way; none where the place does not measure it. Of ground and unknown depths as in
    `Ground.spare_along`, of zones in metres."""

    @classmethod
    def none(cls, trials: int, *, measured: bool = False) -> "Contact":
        """Return that of trials that met nothing."""
        nearest = np.full((len(Cause) - 1 if measured else 0, trials), np.inf)
        nothing = np.zeros(trials, dtype=np.int8), np.zeros(trials, dtype=np.int64)
        return cls(*nothing, np.full((2, trials), np.nan), nearest)

    @property
    def met(self) -> NDArray[np.bool_]:
        """Whether a trial met anything."""
        return np.asarray(self.cause != Cause.NONE)

    def of(self, cause: Cause) -> NDArray[np.bool_]:
        """Whether a trial met this first."""
        return np.asarray(self.cause == cause)

    def take(self, trials: NDArray[np.intp]) -> "Contact":
        """Select trials."""
        return Contact(self.cause[trials], self.leg[trials], self.where[:, trials], self.nearest[:, trials])

    def note(self, rows: NDArray[np.intp], other: "Contact", leg: int) -> None:
        """Enter what some trials met that had met nothing before."""
        before = ~self.met[rows]
        if len(self.nearest):
            self.nearest[:, rows[before]] = np.minimum(self.nearest[:, rows], other.nearest)[:, before]
        fresh = other.met & before
        chosen = rows[fresh]
        self.cause[chosen], self.leg[chosen] = other.cause[fresh], leg
        self.where[:, chosen] = other.where[:, fresh]


@dataclass(frozen=True)
class Place:
    """Ground, zones and sea level, and how much water the vehicle needs."""

    ground: Ground | None = None
    fence: Fence | None = None
    sea_level: SeaLevel = field(default_factory=SeaLevel)
    draught: Scalars = 0.0
    """Of the hull below its axis, shape (n,) [m]."""
    clearance: Scalars = 0.0
    """Water that is to stay under it, shape (n,) [m]."""
    is_measured: bool = False
    """Whether contacts say how near trials came to what they did not meet, which takes several times as long."""
    notices: tuple[str, ...] = ()
    """What is unusual about its files."""

    @property
    def zones(self) -> tuple[Zone, ...]:
        """All zones."""
        return self.fence.zones if self.fence is not None else ()

    def lasting(self) -> "Place":
        """Return the place without zones that hold at some times alone."""
        zones = tuple(zone for zone in self.zones if zone.since == -np.inf and zone.until == np.inf)
        return replace(self, fence=replace(self.fence, zones=zones) if self.fence is not None and zones else None)

    def take(self, trials: NDArray[np.intp]) -> "Place":
        """Select trials."""
        drawn = self.sea_level.level, self.draught, self.clearance
        level, draught, clearance = take_trials(drawn, trials, alike=True)
        return replace(self, sea_level=replace(self.sea_level, level=level), draught=draught, clearance=clearance)

    def water_at(self, places: Array, t: Array) -> Array:
        """Depth of the water at places, shape (2, n), and times; nan where unknown or without a grid [m]."""
        if self.ground is None:
            return np.full(places.shape[1], np.nan)
        return self.ground.depth_at(places) + self.sea_level.at(t)

    def meets(self, way: Way) -> Contact:
        """Return what straight ways meet first; most meet nothing, which the box that holds all of them tells."""
        count = way.begun.size
        if not count:
            return Contact.none(0, measured=self.is_measured)
        is_deep, reached = self._is_deep(way), self.fence.reached(way.start, way.end) if self.fence is not None else ()
        if is_deep and not reached and not self.is_measured:
            return Contact.none(count)
        cause, share = np.zeros(count, dtype=np.int8), np.full(count, np.inf)
        if self.ground is not None and not is_deep:
            shoal, _, unknown = self.ground.too_shallow(way.start, way.end, self._needed(way))
            share = np.minimum(shoal, unknown)
            cause[np.isfinite(share)] = Cause.AGROUND
            cause[unknown < shoal] = Cause.UNCHARTED
        if self.fence is not None and reached:
            touched, which = self.fence.first(way.start, way.end, way.times, way.depths, reached)
            land = np.array([zone.is_land for zone in self.fence.zones])[which]
            sooner = np.isfinite(touched) & (touched <= share)
            cause[sooner] = np.where(land, Cause.ON_LAND, Cause.KEEP_OUT)[sooner]
            share = np.minimum(share, touched)
        met = np.isfinite(share)
        where = np.full((2, count), np.nan)
        where[:, met] = way.start[:, met] + share[met] * (way.end - way.start)[:, met]
        nearest = self._nearest(way, cause) if self.is_measured else np.empty((0, count))
        return Contact(cause, np.zeros(count, dtype=np.int64), where, nearest)

    def _is_deep(self, way: Way) -> bool:
        """Whether the box that holds all ways is deeper than any of them needs."""
        if self.ground is None:
            return True
        needed = np.max(way.greatest + np.asarray(self.draught) + np.asarray(self.clearance))
        low, high = np.minimum(way.start, way.end).min(axis=1), np.maximum(way.start, way.end).max(axis=1)
        return self.ground.is_deep(low, high, float(needed) - self.sea_level.lowest)

    def _needed(self, way: Way) -> Array:
        """Depth below the datum that has to be exceeded at both ends of ways, shape (2, n) [m]."""
        needed = way.greatest + np.asarray(self.draught) + np.asarray(self.clearance)
        return np.stack([needed - self.sea_level.at(t) for t in way.times])

    def _nearest(self, way: Way, cause: NDArray[np.int8]) -> Array:
        """How near ways come to each cause, as in `Contact`, given what they meet first."""
        nearest = np.full((len(Cause), cause.size), np.inf)
        if self.ground is not None:
            spare = self.ground.spare_along(way.start, way.end, self._needed(way))
            nearest[Cause.AGROUND], nearest[Cause.UNCHARTED] = spare
        for zone in self.zones:
            row = nearest[Cause.ON_LAND if zone.is_land else Cause.KEEP_OUT]
            np.minimum(row, zone.distance(way.start, way.end, way.times, way.depths), out=row)
        nearest = np.maximum(nearest, np.finfo(float).tiny)
        nearest[cause, np.arange(cause.size)] = 0.0
        return np.asarray(nearest[1:])


@dataclass
class Lookout:
    """Watches the trials of a transit: keeps what each met first."""

    place: Place
    """For the trials under watch."""
    contact: Contact

    @classmethod
    def over(cls, place: Place, trials: int) -> "Lookout":
        """Return one of trials that have met nothing yet."""
        return cls(place, Contact.none(trials, measured=place.is_measured))

    def watch(self, leg: int, way: Way, moving: Array | None) -> None:
        """See what the trials under way meet on leg `leg`, from 1."""
        going = ~self.contact.met if moving is None else (moving > 0.0) & ~self.contact.met
        if going.all():
            rows = np.arange(going.size)
            self.contact.note(rows, self.place.meets(way), leg)
        elif going.any():
            rows = np.flatnonzero(going)
            self.contact.note(rows, self.place.take(rows).meets(way.take(rows)), leg)

    def take(self, trials: NDArray[np.intp]) -> "Lookout":
        """Select trials."""
        return Lookout(self.place.take(trials), self.contact.take(trials))
