"""Pairs of a fault and its mend, by recipes: what the reckoning does and what it should do.

The first is published: Fossen's Python Vehicle Simulator took the advance speed of the REMUS 100's propeller from the
speed over the ground (its pull request 23). Its equations are written anew from Fossen (2021), *Handbook of Marine
Craft Hydrodynamics and Motion Control*, section 9.5, with the simulator's public coefficients. The others are faults of
sign, frame, unit and clock of the kinds that trackers of navigation software report, with the equations of both sides
here; they are no record of one tracker's entry.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .sailing import Array, Log, Moment, Recipe

DEG = np.pi / 180.0
CURRENT = 0.15 * np.array([np.sin(60.0 * DEG), np.cos(60.0 * DEG)])


@dataclass(frozen=True)
class Pair:
    """A fault and its mend.

    Attributes
    ----------
    before, after : Recipe
    names : tuple of set
        What names the fault rightly; a response describes it.
    mended : set
        What is there after the mend.
    response : str
        Part of the name of a term that describes it; empty: none is meant to.
    speeds : tuple of float
        Speeds of the legs, drawn from these [m/s].
    """

    before: Recipe
    after: Recipe
    names: tuple[frozenset[str], ...] = ()
    mended: frozenset[str] = frozenset()
    response: str = ""
    speeds: tuple[float, ...] = (1.5,)


RHO, DIAMETER, WAKE, DEDUCTION, SHAFT = 1026.0, 0.14, 0.944, 0.1, 1000.0 / 60.0
KT_0, KT_MAX, J_MAX = 0.4566, 0.1798, 0.6632
DRAG_AREA = 0.42 * 0.7 * 1.6 * 0.19 * 0.25
"""Parasitic drag of the hull [m²], for a speed near 1.7 m/s at 1000 rpm."""


def thrust(advance: float) -> float:
    """Thrust of the propeller, linear in the advance speed (Fossen 2021, section 9.5) [N]."""
    slope = (KT_MAX - KT_0) / J_MAX
    return (1.0 - DEDUCTION) * RHO * DIAMETER**4 * (KT_0 * SHAFT**2 + slope * WAKE * advance / DIAMETER * SHAFT)


def through_water(current_along: float, *, over_ground: bool) -> float:
    """Speed through the water at which thrust and drag balance [m/s]."""

    def left(speed: float) -> float:
        advance = speed + current_along if over_ground else speed
        return thrust(advance) - 0.5 * RHO * DRAG_AREA * speed**2

    return float(brentq(left, 0.1, 5.0))


def propeller(*, over_ground: bool) -> Recipe:
    """Legs of that vehicle in a current: its speed through the water over that in still water."""
    still = through_water(0.0, over_ground=False)

    def pace(m: Moment) -> float:
        along = float(CURRENT @ [np.sin(m.heading), np.cos(m.heading)])
        return through_water(along, over_ground=over_ground) / still

    return Recipe(pace=pace, water=lambda m: CURRENT)


def turned(angle: Callable[[Moment], float]) -> Recipe:
    """A fault of the heading alone."""
    return Recipe(turn=angle)


NOTHING = Recipe()
BIAS, SCALE, DEVIATION = frozenset({"compass-bias"}), frozenset({"speed-scale"}), frozenset({"compass-deviation"})
STEADY = frozenset({"mean-current"})
PAIRS: dict[str, Pair] = {
    "advance speed over the ground": Pair(
        propeller(over_ground=True),
        propeller(over_ground=False),
        (STEADY | {"current-response"},),
        STEADY,
        "current",
    ),
    # ψ = ψ_m + δ, and not ψ_m − δ, for a declination δ of 3.5° east
    "declination with the wrong sign": Pair(turned(lambda m: 7.0 * DEG), NOTHING, (BIAS,)),
    # ψ = ψ_m + D(ψ_m) of the table of deviations, and not ψ_m − D
    "table of deviations with the wrong sign": Pair(
        turned(lambda m: 6.0 * DEG * np.cos(m.heading - 0.7)), NOTHING, (DEVIATION,)
    ),
    # the quadrantal coefficients of soft iron added instead of subtracted
    "soft iron with the wrong sign": Pair(
        turned(lambda m: 5.0 * DEG * np.sin(2.0 * m.heading + 0.3)), NOTHING, (), frozenset(), "twice_course"
    ),
    # sway of the Doppler log positive to port where starboard is meant: twice the sideslip of 3°
    "sway of the other frame": Pair(turned(lambda m: 6.0 * DEG), NOTHING, (BIAS,)),
    # a knot taken as half a metre a second
    "knots by a half": Pair(Recipe(pace=lambda m: 1852.0 / 3600.0 / 0.5 + 0.03), NOTHING, (SCALE,)),
    # the Earth's rate, 15°/h times the sine of the latitude, added to the gyro's instead of taken off
    "Earth rate with the wrong sign": Pair(
        turned(lambda m: 2.0 * 15.04 * np.sin(50.0 * DEG) * DEG * m.since / 3600.0),
        NOTHING,
        (),
        frozenset(),
        "abeam_by",
    ),
    # reckoning runs from the fix, the propeller from 45 s later
    "reckoning before the propeller": Pair(
        Recipe(pace=lambda m: 0.0 if m.since < 45.0 else 1.0), NOTHING, (), frozenset(), "each_leg"
    ),
    # the loop of speed closed on the bottom track and not on revolutions; at one speed it is exactly a deviation
    "a loop on the bottom track": Pair(
        Recipe(water=lambda m: CURRENT, along=0.0),
        Recipe(water=lambda m: CURRENT),
        (STEADY | {"current-response"},),
        STEADY,
        "current",
        (1.0, 1.5, 2.0),
    ),
    # the heading's offset applied from a restart of the logger on, half-way
    "an offset from a restart on": Pair(
        turned(lambda m: 6.0 * DEG if m.t > 20000.0 else 0.0),
        NOTHING,
        (frozenset({"compass-jump"}),),
        frozenset(),
        "changed",
    ),
}


def log_of_pair(rng: np.random.Generator, speeds: tuple[float, ...] = (1.5,), count: int = 60) -> Log:
    """Draw the legs of a pair: all round the compass, of different lengths."""
    under_way, headings = rng.uniform(400.0, 1000.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    return Log(headings, under_way, rng.choice(speeds, count), np.full(count, 20.0), sigma=0.015, fix=2.0)


def still_speed() -> float:
    """Speed of the REMUS 100's recipe in still water [m/s]."""
    return through_water(0.0, over_ground=False)


def errors_of(array: Array) -> float:
    """Root mean square of velocity errors [m/s]."""
    return float(np.sqrt(np.mean(np.sum(array**2, axis=1))))
