"""The hold: how the vehicle stands on its line while the current changes, and whether the anchor stays.

Quasi-static: after the minute or two in which they settle from touchdown on, vehicle and line follow the current.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, over_trials, take_trials
from missionplan.phases.currents import Current, LayeredCurrent
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.forces import DescentHooks
from missionplan.physics.held_line import HeldBody, HeldLine
from missionplan.physics.line_statics import HeldPose, held_pose, settling_nose
from missionplan.physics.seafloor import (
    ROUGHNESS,
    LayersAbove,
    LyingAnchor,
    ProfileAbove,
    Slope,
    anchor_drag_on_bed,
    holding_margin,
    least_weight,
)

SAMPLE_TIME = 600.0
MOST_SAMPLES = 300
"""Times of a hold at which the speed of a current that changes is looked at: every ten minutes, at most so many."""
_NODES = 13
"""Altitudes at which a current from a record is taken, over the height of line and vehicle; linear between them."""


@dataclass(frozen=True)
class Hold:
    """What hangs on the line, and where."""

    body: HeldBody
    line: HeldLine
    anchor: LyingAnchor
    site_depth: Scalars
    """At the anchor, shape (n,) [m]."""
    slope: Slope = field(default_factory=Slope)
    """Of the seafloor."""
    roughness: Scalars = ROUGHNESS
    """z₀ of the seafloor, shape (n,) [m]."""

    def after(self, pose: HeldPose, layers: LayersAbove, time: Scalars) -> HeldPose:
        """The pose on the way to which the nose is a time after touchdown [s], the rest as it will be."""
        speed = np.hypot(*layers.at(pose.nose[2][None])[:, 0])
        return replace(pose, nose=settling_nose(pose, self.line.length, speed, time))

    def clearance(self, pose: HeldPose) -> Array:
        """Height of the lowest point of the hull above the seafloor, shape (n,) [m]; its ends are hemispheres."""
        radius, length = 0.5 * self.body.diameter, self.body.length
        centres = (pose.nose + place * pose.axis for place in (radius, length - radius))
        # measured across the seafloor, which slopes
        normal = self.slope.normal.reshape(3, -1)
        return np.asarray(np.minimum(*((centre * normal).sum(axis=0) for centre in centres)) - radius)

    def altitude(self, pose: HeldPose) -> Array:
        """Height of the nose above the seafloor below it, shape (n,) [m]."""
        return np.asarray(pose.nose[2] + self.slope.fall(pose.nose[:2]))

    def loads(self, pose: HeldPose, current: LayersAbove) -> tuple[Array, Array]:
        """Pull of the line on the anchor, shape (3, n), and the anchor's own drag, shape (2, n) [N]."""
        drag = anchor_drag_on_bed(self.anchor, current.velocity[0], self.body.density, self.roughness)
        return pose.tension_at_anchor, drag

    def margin(self, pose: HeldPose, current: LayersAbove) -> Array:
        """Margin with which the anchor holds, shape (n,); see `holding_margin`."""
        return holding_margin(self.anchor, *self.loads(pose, current), self.slope)

    def least_weight(self, pose: HeldPose, current: LayersAbove) -> Array:
        """Wet weight of an anchor of the same size that just holds, shape (n,) [N]."""
        return least_weight(self.anchor.friction, *self.loads(pose, current), self.slope)


@dataclass(frozen=True)
class HoldRecord:
    """Envelope of a hold, arrays of shape (n,) unless stated otherwise."""

    nose_altitude: Array
    """Least height of the nose above the seafloor [m]."""
    excursion: Array
    """Greatest horizontal distance of the nose from the anchor: the radius of the watch circle [m]."""
    line_tension: Array
    """Greatest [N]."""
    holding_margin: Array
    """Least; see `seafloor.holding_margin`."""
    grounded: NDArray[np.bool_]
    """Whether the hull ever touches the seafloor."""
    parted_from: Array
    """Where the nose is when the line parts, east, north and up from the anchor, shape (3, n) [m]."""

    @property
    def anchor_holds(self) -> NDArray[np.bool_]:
        """Whether the anchor stays where it came down."""
        return self.holding_margin >= 0.0


def hold_vehicle(hold: Hold, current: Current, anchor: Array, start: Array, duration: Scalars) -> HoldRecord:
    """Follow a block of vehicles from touchdown until their lines part.

    A current that changes is sampled; the vehicle is followed at the start, at the end, and when the current about it
    is fastest and slowest.

    Parameters
    ----------
    anchor : array, shape (2, n)
        Where it came down, east and north of the coordinates' origin [m].
    start : array, shape (n,)
        Touchdown since the mission's start [s].
    duration : float or array, shape (n,)
        Until the line parts [s].
    """
    lasting = over_trials(duration, start.size)
    record, pose = _at(hold, current, anchor, start, lasting)
    if isinstance(current, LayeredCurrent) or not np.any(lasting):
        return record
    for moment in extreme_moments(hold, current, anchor, start, lasting):
        between = np.flatnonzero((moment > start) & (moment < start + lasting))  # not the start or the end once more
        if between.size:
            part, near = take_trials(hold, between), take_trials(pose, between)
            when = moment[between], lasting[between]
            now, _ = _at(part, current.take(between), anchor[:, between], *when, near)
            record = _with(record, between, _envelope(take_trials(record, between), now))
    return _envelope(record, _at(hold, current, anchor, start + lasting, lasting, pose)[0])


def lifted(hold: Hold, effects: Iterable[DescentEffect]) -> Hold:
    """The vehicle with the lift of the effects on it, which acts at mid-length, at the depth of the taut line's end."""
    body = hold.body
    lift = DescentHooks(effects).lift(np.maximum(hold.site_depth - hold.line.length, 0.0))
    raising = body.raising_moment + 0.5 * body.length * lift
    return replace(hold, body=replace(body, net_buoyancy=body.net_buoyancy + lift, raising_moment=raising))


def layers_above(hold: Hold, current: Current, anchor: Array, moment: Array) -> LayersAbove:
    """Layers of a current above the anchor at a time, shape (n,) [s]."""
    trials, depth = moment.size, over_trials(hold.site_depth, moment.size)
    if isinstance(current, LayeredCurrent):
        upwards = slice(None, None, -1)
        edges = [depth - over_trials(edge, trials) for edge in current.down_to[-2::-1]]
        sides = zip(current.east[upwards], current.north[upwards], strict=True)
        velocity = [np.stack([over_trials(side, trials) for side in pair]) for pair in sides]
        return LayersAbove(np.stack([*edges, np.full(trials, np.inf)]), np.stack(velocity))
    reach = over_trials(hold.line.length + hold.body.length, trials)
    shares = np.linspace(0.0, 1.0, _NODES)
    velocity = [
        np.broadcast_to(current.velocity(moment, np.maximum(depth - share * reach, 0.0), anchor), (2, trials))
        for share in shares
    ]
    return ProfileAbove(shares[:, None] * reach, np.stack(velocity))


def extreme_moments(hold: Hold, current: Current, anchor: Array, start: Array, lasting: Array) -> tuple[Array, Array]:
    """Times of a hold at which the current about the vehicle is fastest and slowest, shape (n,) each [s]."""
    samples = int(np.clip(np.ceil(np.max(lasting) / SAMPLE_TIME), 1, MOST_SAMPLES)) + 1
    middle = np.maximum(hold.site_depth - 0.5 * (hold.line.length + hold.body.length), 0.0)
    shares = np.linspace(0.0, 1.0, samples)
    speeds = np.stack([np.hypot(*current.velocity(start + share * lasting, middle, anchor)) for share in shares])
    fastest, slowest = (shares[extreme(speeds, axis=0)] for extreme in (np.argmax, np.argmin))
    return start + fastest * lasting, start + slowest * lasting


def record_at_once(hold: Hold, pose: HeldPose, layers: LayersAbove) -> HoldRecord:
    """Record of one moment."""
    return HoldRecord(
        nose_altitude=hold.altitude(pose),
        excursion=pose.excursion,
        line_tension=pose.tension,
        holding_margin=hold.margin(pose, layers),
        grounded=hold.clearance(pose) <= 0.0,
        parted_from=pose.nose,
    )


def _at(
    hold: Hold, current: Current, anchor: Array, moment: Array, lasting: Array, near: HeldPose | None = None
) -> tuple[HoldRecord, HeldPose]:
    """Record and pose of one moment of a hold that lasts for a time [s]; the search begins `near` a pose.

    A hold that does not last, as the mission gives no time, is one in which the vehicle settles.
    """
    layers = layers_above(hold, current, anchor, moment)
    pose = held_pose(hold.body, hold.line, layers, near)
    time = np.where(lasting > 0.0, lasting, np.inf)
    return record_at_once(hold, hold.after(pose, layers, time), layers), pose


def _with(record: HoldRecord, trials: NDArray[np.intp], part: HoldRecord) -> HoldRecord:
    """The record with that of some trials put in."""
    changed = {quantity.name: getattr(record, quantity.name).copy() for quantity in fields(record)}
    for name, values in changed.items():
        values[..., trials] = getattr(part, name)
    return HoldRecord(**changed)


def _envelope(so_far: HoldRecord, now: HoldRecord) -> HoldRecord:
    return HoldRecord(
        nose_altitude=np.minimum(so_far.nose_altitude, now.nose_altitude),
        excursion=np.maximum(so_far.excursion, now.excursion),
        line_tension=np.maximum(so_far.line_tension, now.line_tension),
        holding_margin=np.minimum(so_far.holding_margin, now.holding_margin),
        grounded=so_far.grounded | now.grounded,
        parted_from=now.parted_from,
    )
