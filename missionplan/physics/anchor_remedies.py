"""Remedies for an anchor that cannot be built.

Trim of a submerged vehicle: the pitch at which its weights balance about its centre of buoyancy.

The net buoyancy, a hundredth of the weight, is left out of the balance: it moves the vehicle up or down, and its lever
about the centre of buoyancy is nil.
"""

import math
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from missionplan.arrays import Array
from missionplan.physics.anchor import AnchorDesign, AnchorProblem, solve_anchor


@dataclass(frozen=True)
class Remedy:
    """The least change of one number of the construction that makes an anchor possible, in SI units."""

    part: str
    quantity: str
    given: float
    needed: float
    unit: str

    @property
    def words(self) -> str:
        """The change as an instruction; rounded to the side that does."""
        scale = 10.0 ** (3 - math.floor(math.log10(abs(self.needed))))
        needed = (math.ceil if self.needed > self.given else math.floor)(self.needed * scale) / scale
        return f"{self.part} with {self.quantity} {needed:.4g} {self.unit} instead of {self.given:.4g} {self.unit}"


_NUMBERS = (
    ("front", "a mass of", "kg", "front.mass"),
    ("back", "a mass of", "kg", "back.mass"),
    ("front", "its centre at", "m", "front.centre"),
    ("tube", "a mass per length of", "kg/m", "tube_mass_per_length"),
    ("trim ring", "a density of", "kg/m³", "trim_density"),
)
"""Of the construction, which a remedy may change: part, quantity and unit in words, and the field."""
MAX_WET_WEIGHT = 500.0
"""Largest wet weight of a hand-launched anchor, the end of the search for buildable weights [N]."""
_MAX_DENSITY = 19300.0
"""Of tungsten [kg/m³]."""
_FACTORS: Array = np.geomspace(0.25, 4.0, 161)


def find_remedies(design: AnchorDesign) -> tuple[Remedy, ...]:
    """Search for the least change of each single number of the construction that makes the anchor possible.

    Each number is tried between a quarter and four times its value, and refined to a thousandth; changes beyond that
    are not practicable. A ring is at most as dense as tungsten.

    Returns
    -------
    tuple of Remedy
        The smallest relative change first; empty when no single change is enough, or none is needed.
    """
    if design.feasible:
        return ()
    remedies = []
    for part, quantity, unit, field in _NUMBERS:
        factor = _least_factor(design, field)
        if factor is not None:
            value: float = attrgetter(field)(design.problem.construction)
            remedies.append((abs(math.log(factor)), Remedy(part, quantity, value, value * factor, unit)))
    return tuple(remedy for _, remedy in sorted(remedies, key=lambda item: item[0]))


def buildable_weights(problem: AnchorProblem) -> tuple[float, float] | None:
    """Range of wet weights, up to `MAX_WET_WEIGHT`, that some tube and ring can give with these parts [N].

    Returns
    -------
    (low, high) or None
        To one per cent; None when no weight can be built.
    """
    weights = np.geomspace(0.5, MAX_WET_WEIGHT, 695)
    buildable = [float(weight) for weight in weights if solve_anchor(problem, float(weight)).feasible]
    return (buildable[0], min(buildable[-1], MAX_WET_WEIGHT)) if buildable else None


def _least_factor(design: AnchorDesign, field: str) -> float | None:
    """Factor nearest to 1 on a field with which the anchor can be built, to a thousandth; None where there is none."""
    construction = design.problem.construction
    name, _, inside = field.partition(".")

    def works(factor: float) -> bool:
        value = attrgetter(field)(construction) * factor
        part = replace(getattr(construction, name), **{inside: value}) if inside else value
        changed = replace(construction, **{name: part})
        if changed.trim_density > _MAX_DENSITY or changed.front.centre > design.problem.radius:
            return False
        try:
            return solve_anchor(replace(design.problem, construction=changed), design.wet_weight).feasible
        except ValueError:
            return False

    for factor in sorted(_FACTORS, key=lambda value: abs(math.log(value))):
        if works(factor):
            bad, good = 1.0, float(factor)
            while abs(good / bad - 1.0) > 1e-3:
                middle = math.sqrt(bad * good)
                bad, good = (bad, middle) if works(middle) else (middle, good)
            return good
    return None


_LEVEL = math.radians(2.0)
"""Pitch below which a vehicle counts as level."""


@dataclass(frozen=True)
class Weight:
    """A weight [N], its distance aft of the nose's tip [m], and below the axis [m]; negative ahead of it, above it."""

    size: float
    from_nose: float
    below_axis: float


@dataclass(frozen=True)
class TrimState:
    """Trim in one configuration."""

    configuration: str
    """Such as ``with the flooded anchor``."""
    net_force: float
    """Upward [N]."""
    moment: float
    """Of the weights about the centre of buoyancy with the vehicle level; positive puts the nose down [N m]."""
    pitch: float | None
    """Nose down; None where nothing rights the vehicle, or its centres are not known [rad]."""
    centres_known: bool
    """Whether the vehicle file gives them."""

    @property
    def verdict(self) -> str:
        """How the vehicle lies."""
        if self.pitch is None:
            if not self.centres_known:
                return "nose-heavy" if self.moment > 0.0 else "not known"
            return "turns over: its centre of gravity is not below that of buoyancy"
        if abs(self.pitch) <= _LEVEL:
            return "level"
        return "nose-heavy" if self.pitch > 0.0 else "tail-heavy"

    def summary(self) -> dict[str, object]:
        """Return an entry of ``summary.json``."""
        return {
            "configuration": self.configuration,
            "net_force_n": self.net_force,
            "moment_n_m": self.moment,
            "pitch_rad": self.pitch,
            "verdict": self.verdict,
        }


def trim(
    configuration: str,
    weights: tuple[Weight, ...],
    buoyancy: Weight,
    *,
    centres_known: bool = True,
) -> TrimState:
    """Find the trim of a vehicle.

    Parameters
    ----------
    buoyancy : Weight
        Size and centre of the buoyancy.
    centres_known : bool
        Whether they are known; assumed ones give no pitch.

    Returns
    -------
    TrimState
        tan θ = Σ W (x_B - x) / Σ W (z - z_B), nose down.
    """
    total = sum(weight.size for weight in weights)
    moment = sum(weight.size * (buoyancy.from_nose - weight.from_nose) for weight in weights)
    righting = sum(weight.size * (weight.below_axis - buoyancy.below_axis) for weight in weights)
    pitch = math.atan2(moment, righting) if centres_known and righting > 0.0 else None
    return TrimState(configuration, buoyancy.size - total, moment, pitch, centres_known)
