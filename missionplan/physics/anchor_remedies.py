"""What would mend an anchor that cannot be built."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from missionplan.arrays import Array
from missionplan.physics.anchor import AnchorDesign, AnchorProblem, Construction, solve_anchor


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
        """The change as an instruction."""
        return f"{self.part} with {self.quantity} {self.needed:.4g} {self.unit} instead of {self.given:.4g} {self.unit}"


_KNOBS = (
    ("front", "a mass of", "kg", ("front", "mass")),
    ("back", "a mass of", "kg", ("back", "mass")),
    ("front", "its centre at", "m", ("front", "centre")),
    ("tube", "a mass per length of", "kg/m", ("tube_mass_per_length",)),
    ("trim ring", "a density of", "kg/m³", ("trim_density",)),
)
MAX_WET_WEIGHT = 500.0
"""Wet weight [N] that no hand-launched anchor exceeds: where the search for buildable weights ends."""
_DENSEST = 19300.0
"""Tungsten [kg/m³]."""
_FACTORS: Array = np.geomspace(0.25, 4.0, 161)


def find_remedies(design: AnchorDesign) -> tuple[Remedy, ...]:
    """Search for the least change of each single number of the construction that makes the anchor possible.

    Each number is tried between a quarter and four times its value and refined to a thousandth. A wider search would
    name parts that nobody can make; a ring is at most as dense as tungsten.

    Returns
    -------
    tuple of Remedy
        The smallest relative change first; empty when no single change mends it, or when nothing is wrong.
    """
    if design.feasible:
        return ()
    found = []
    for part, quantity, unit, path in _KNOBS:
        factor = _least_factor(design, path)
        if factor is not None:
            given = _knob(design.problem.construction, path)
            found.append((abs(math.log(factor)), Remedy(part, quantity, given, given * factor, unit)))
    return tuple(remedy for _, remedy in sorted(found, key=lambda item: item[0]))


def buildable_weights(problem: AnchorProblem) -> tuple[float, float] | None:
    """Range of wet weights [N], up to `MAX_WET_WEIGHT`, that the given parts can make with some tube and ring.

    Returns
    -------
    (low, high) or None
        To a hundredth of their size; None when no weight can be made.
    """
    weights = np.geomspace(0.5, MAX_WET_WEIGHT, 695)
    able = [float(weight) for weight in weights if solve_anchor(problem, float(weight)).feasible]
    return (able[0], min(able[-1], MAX_WET_WEIGHT)) if able else None


def _least_factor(design: AnchorDesign, path: tuple[str, ...]) -> float | None:
    def works(factor: float) -> bool:
        made = _turned(design.problem.construction, path, factor)
        if made.trim_density > _DENSEST:
            return False
        problem = replace(design.problem, construction=made)
        if made.front.centre > problem.radius:
            return False
        try:
            return solve_anchor(problem, design.wet_weight).feasible
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


def _knob(made: Construction, path: tuple[str, ...]) -> float:
    value: Any = made
    for name in path:
        value = getattr(value, name)
    return float(value)


def _turned(made: Construction, path: tuple[str, ...], factor: float) -> Construction:
    changed: Any = _knob(made, path) * factor
    if len(path) == 2:
        changed = replace(getattr(made, path[0]), **{path[1]: changed})
    return replace(made, **{path[0]: changed})
