"""Effects on the course made good and the speed through the water: compass, sideslip, propeller, Doppler log."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, Instrument, LegRecord, Likeness, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CompassBias(TransitEffect):
    """The course made through the water is turned clockwise by `angle` [rad] from the assumed one."""

    angle: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.exp(-1j * np.asarray(self.angle))


COMPASS_BIAS = EffectInfo(
    id="compass-bias",
    effect=CompassBias,
    parameters={
        "angle": Parameter(
            "rad", "angle of the true course from the assumed one, clockwise", -0.8, 0.8, scale=0.08, spike=0.0026
        )
    },
    what="A misaligned compass, a wrong declination, or magnetisation that turns with the hull.",
    finding=Finding(
        "angle",
        "the compass reads {size} low",
        "the compass reads {size} high",
        remedy="swing it, or enter the correction",
    ),
    sizes="1 to 10°, either sign.",
    ageing="jumps",
    upkeep=("find what turns the compass further from mission to mission",) * 2,
    confused_with=("compass-deviation", "mean-current"),
    distinguished_by="Legs on at least three headings.",
    linear=False,
    instrument=Instrument("a swing of the compass on land, all round", "angle", 0.009),
)


@dataclass(frozen=True)
class CompassDeviation(TransitEffect):
    """The course is turned clockwise by ``amplitude·cos(heading − phase)`` [rad], heading clockwise from north."""

    amplitude: Scalars = 0.0
    phase: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        east, north = leg.along
        angle = self.amplitude * (np.cos(self.phase) * north + np.sin(self.phase) * east)
        return np.exp(-1j * np.asarray(angle))


COMPASS_DEVIATION = EffectInfo(
    id="compass-deviation",
    effect=CompassDeviation,
    parameters={
        "amplitude": Parameter("rad", "greatest deviation", 0.0, 0.8, scale=0.08, spike=0.0026),
        "phase": Parameter("rad", "heading at which the deviation is greatest, clockwise from north"),
    },
    what="Hard iron near the compass: the error is a sine of the heading (semicircular deviation).",
    finding=Finding(
        "amplitude",
        "the compass errs by up to {size}, by its heading",
        "the compass errs by up to {size}, by its heading",
        remedy="swing it all round and enter the table of deviations",
    ),
    sizes="2 to 15° for a compass that was not calibrated (swung).",
    ageing="jumps",
    confused_with=("compass-bias", "mean-current", "speed-scale"),
    distinguished_by="Legs on headings all round the compass.",
    polar=(("amplitude", "phase"),),
    linear=False,
    likeness=Likeness(
        "amplitude", math.radians(10.0), "an error that depends on heading, as a compass deviation would"
    ),
    instrument=Instrument("a swing of the compass on land, all round", "amplitude", 0.009),
)


@dataclass(frozen=True)
class CompassJump(TransitEffect):
    """From `moment` [s] on the course is turned clockwise by `angle` [rad]; for a part of its leg, by that part."""

    angle: Scalars = 0.0
    moment: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.asarray(np.exp(-1j * np.asarray(self.angle * leg.share_after(self.moment))))


COMPASS_JUMP = EffectInfo(
    id="compass-jump",
    effect=CompassJump,
    parameters={
        "angle": Parameter(
            "rad", "jump of the true course from the assumed one, clockwise", -1.0, 1.0, scale=0.1, spike=1e-4
        ),
        "moment": Parameter("s", "when", 0.0, median=21600.0, factor=4.0, searched="time"),
    },
    what="Something magnetic shifts in the hull, the vehicle is knocked, or a filter of the compass loses its place.",
    finding=Finding(
        "angle",
        "the compass jumped at {at} and reads {size} lower since",
        "the compass jumped at {at} and reads {size} higher since",
        remedy="find what moved, and swing the compass",
    ),
    sizes="2 to 20°, either sign.",
    confused_with=("compass-bias", "compass-deviation", "persistent-error"),
    distinguished_by="Legs on several headings before and after it.",
    linear=False,
    terms=(Term(("angle",), ("moment",)),),
)


@dataclass(frozen=True)
class HeadingByDepth(TransitEffect):
    """The course is turned clockwise by `rate` [rad/m] times the mean depth of the leg."""

    rate: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.asarray(np.exp(-1j * np.asarray(self.rate * np.where(np.isfinite(leg.depth), leg.depth, 0.0))))


HEADING_BY_DEPTH = EffectInfo(
    id="heading-by-depth",
    effect=HeadingByDepth,
    parameters={
        "rate": Parameter(
            "rad/m",
            "angle of the true course from the assumed one, clockwise, for each metre of depth",
            -0.02,
            0.02,
            scale=1e-3,
            spike=2e-6,
            extent_scale=0.08,
        )
    },
    what="Pressure bends what holds the compass, or a hull that is squeezed moves iron beside it.",
    finding=Finding(
        "rate",
        "the compass reads {size} lower for each 100 m of depth",
        "the compass reads {size} higher for each 100 m of depth",
        remedy="swing it at depth, or enter the correction by depth",
        each=100.0,
        unit="rad",
    ),
    sizes="1 to 10° over 100 to 1000 m.",
    confused_with=("compass-bias",),
    distinguished_by="Legs on the same headings at several depths.",
    lacking=lambda record: (
        "" if record.depths > 2.0 else "needs the depth of the legs (column depth_m), and different ones"
    ),
    linear=False,
    terms=(Term(("rate",)),),
)


@dataclass(frozen=True)
class Sideslip(TransitEffect):
    """The course is turned clockwise by ``angle/U²``, U the speed in m/s: lift of the hull balances the force.

    Lift of a slender body at small angles grows as ½ρU² times the angle (Hoerner & Borst 1975, *Fluid-Dynamic Lift*).
    """

    angle: Scalars = 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128]:
        """Return the turn of each leg's course, shape (n,)."""
        return np.exp(-1j * np.asarray(self.angle / np.maximum(leg.speed, 0.1) ** 2))


def _needs_speeds(alike: str) -> Callable[[LegRecord], str]:
    """Say what an effect is on legs at one speed."""
    return lambda record: "" if record.speeds > 0.1 else f"needs legs at different speeds: at one speed it is {alike}"


SIDESLIP = EffectInfo(
    id="sideslip",
    effect=Sideslip,
    parameters={
        "angle": Parameter("rad", "angle to starboard of the heading at 1 m/s", -0.8, 0.8, scale=0.06, spike=0.001)
    },
    what="Bent fins, an antenna or trim to one side push the vehicle sideways; slowly it slips more.",
    finding=Finding(
        "angle",
        "the vehicle slips {size} to starboard at 1 m/s, less when it is faster",
        "the vehicle slips {size} to port at 1 m/s, less when it is faster",
        remedy="trim the fins",
    ),
    sizes="1 to 5° at 1 m/s.",
    confused_with=("compass-bias",),
    distinguished_by="Legs at two speeds on several headings: a compass errs as much at any speed.",
    lacking=_needs_speeds("a compass bias"),
    linear=False,
    terms=(Term(("angle",)),),
)


@dataclass(frozen=True)
class SpeedScale(TransitEffect):
    """True speed through the water is the assumed one times ``1 + fraction``."""

    fraction: Scalars = 0.0

    def course_factor(self, leg: Leg) -> Scalars:
        """Return the true speed of each leg over the assumed one, shape (n,)."""
        return 1.0 + self.fraction


SPEED_SCALE = EffectInfo(
    id="speed-scale",
    effect=SpeedScale,
    parameters={
        "fraction": Parameter(
            "", "relative error, positive when faster than assumed", -0.6, 0.6, scale=0.08, spike=0.002
        )
    },
    what="Revolutions converted to speed with a wrong factor: fouling, propeller, battery voltage.",
    finding=Finding(
        "fraction",
        "the vehicle goes {size} faster than it reckons",
        "the vehicle goes {size} slower than it reckons",
        remedy="calibrate speed against shaft rate on a measured mile, or enter the correction",
        in_percent=True,
    ),
    sizes="2 to 20 %; either sign.",
    ageing="drifts",
    upkeep=("check the log's calibration", "clean the hull and the propeller"),
    confused_with=("mean-current", "compass-deviation"),
    distinguished_by="Legs in both directions along one line.",
)


@dataclass(frozen=True)
class SpeedLoss(TransitEffect):
    """Of the speed beyond `threshold` [m/s] the part `fraction` is lost."""

    fraction: Scalars = 0.0
    threshold: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]: backwards along its course."""
        return np.asarray(-self.fraction * np.maximum(leg.speed - self.threshold, 0.0) * leg.along)


SPEED_LOSS = EffectInfo(
    id="speed-loss",
    effect=SpeedLoss,
    parameters={
        "fraction": Parameter(
            "", "part of the speed beyond the threshold that is lost", 0.0, 1.2, scale=0.5, spike=0.002
        ),
        "threshold": Parameter("m/s", "speed from which it is", 0.0, 20.0, median=1.2, factor=1.5, searched="speed"),
    },
    what="A motor or battery at its limit, cavitation, air drawn in: beyond some speed the vehicle gets no faster.",
    finding=Finding(
        "fraction",
        "of the speed beyond {at} the vehicle loses {size}",
        "of the speed beyond {at} the vehicle gains {size}",
        remedy="plan with the speed that it reaches",
        in_percent=True,
    ),
    sizes="20 to 100 % of what is asked beyond the limit.",
    confused_with=("speed-scale",),
    distinguished_by="Legs at several speeds below and above the threshold, both ways along a line.",
    lacking=_needs_speeds("a speed scale"),
    terms=(Term(("fraction",), ("threshold",)),),
)


@dataclass(frozen=True)
class CurrentResponse(TransitEffect):
    """A current along the course moves the vehicle by ``1 + along`` of itself, one across by all of itself.

    At −1 the speed over the ground is held. Thrust that depends on the speed over the ground holds a part of it.
    """

    along: Scalars = 0.0

    def answer_to_current(self, leg: Leg, water: Array) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.asarray(self.along * np.sum(water * leg.along, axis=0) * leg.along)


CURRENT_RESPONSE = EffectInfo(
    id="current-response",
    effect=CurrentResponse,
    parameters={
        "along": Parameter(
            "",
            "what the vehicle answers to a current along its course, over its answer across, less 1",
            -1.3,
            1.0,
            scale=0.5,
            spike=0.005,
        )
    },
    what=(
        "Something holds the speed over the ground, wholly or in part: a loop on a Doppler log, thrust or revolutions "
        "that follow the speed over the ground."
    ),
    finding=Finding(
        "along",
        "the vehicle answers to a current along its course with {size} of what it answers across, as where something "
        "holds its speed over the ground",
        remedy="find out what holds it; till then plan with the extended mission, which does so too",
        beyond=1.0,
    ),
    sizes="−1 for a loop that holds the speed over the ground, −0.2 to −0.6 for thrust that follows it.",
    confused_with=("compass-deviation", "mean-current"),
    distinguished_by="Legs all round the compass in a current that is known, or is twice as strong.",
    linear=False,
    terms=(Term(("along",)),),
)
