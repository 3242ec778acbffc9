"""Every quantity of a mission against the table of what is possible and usual."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel

from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath, LocalProblem
from missionplan.mission.checks.limits.table import EFFECT_SCALES, IN_UNIT, LIMITS, Limit
from missionplan.mission.schema.effect_list import EffectEntry
from missionplan.mission.schema.phases import Phase
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.normal_transform import NormalTransform

_TAIL = 0.01
"""Share of the draws beyond each end."""


@dataclass(frozen=True)
class Findings:
    """What the limits say of a mission.

    Attributes
    ----------
    problems : tuple of LocalProblem
        What cannot be.
    notices : tuple of LocalProblem
        What is unusual.
    """

    problems: tuple[LocalProblem, ...] = ()
    notices: tuple[LocalProblem, ...] = ()

    def __add__(self, other: "Findings") -> "Findings":
        """Join two."""
        return Findings((*self.problems, *other.problems), (*self.notices, *other.notices))


def check_ranges(sections: Sequence[tuple[str, object]], phases: Sequence[Phase]) -> Findings:
    """Compare quantities with what is possible and usual.

    Parameters
    ----------
    sections : sequence of (str, section)
        The mission's sections by name, but for the phases.
    phases : sequence of Phase

    Returns
    -------
    Findings
        By key path from the top of the mission.
    """
    found = Findings()
    for name, section in sections:
        found += _of(section, (name,), name)
    for index, phase in enumerate(phases):
        found += _of(phase, ("phases", index, phase.kind), phase.kind)
    return found


def ends(quantity: Quantity) -> tuple[float, float]:
    """Return the value twice, or the ends of what 98 % of the draws of a distribution lie between."""
    if isinstance(quantity, NormalTransform):
        return quantity.quantile(_TAIL), quantity.quantile(1.0 - _TAIL)
    return float(quantity), float(quantity)


def _of(value: object, path: KeyPath, key: str) -> Findings:
    found = Findings()
    for inner, name, quantity in _quantities(value, path, key):
        limit = LIMITS.get(name) or LIMITS.get(name.removeprefix("vehicle."))
        if limit is not None:
            found += _compared(inner, quantity, limit)
    return found


def _quantities(value: object, path: KeyPath, key: str) -> Iterator[tuple[KeyPath, str, Quantity]]:
    """Quantities inside a value, with their key paths in the file and in the table."""
    if isinstance(value, float | NormalTransform):
        yield path, key, value  # type: ignore[misc]  # every transform of a normal is one of the distributions
    elif isinstance(value, BaseModel):
        fields = type(value).model_fields
        for field, inner in value:
            name = fields[field].alias or field
            yield from _quantities(inner, (*path, name), f"{key}.{name}")
    elif isinstance(value, tuple):
        for index, inner in enumerate(value):
            yield from _quantities(inner, (*path, index), key)


def _compared(path: KeyPath, quantity: Quantity, limit: Limit) -> Findings:
    scale = IN_UNIT.get(limit.unit, 1.0)
    low, high = (scale * end for end in ends(quantity))
    if limit.signed:
        low, high = (0.0 if low < 0.0 < high else min(abs(low), abs(high))), max(abs(low), abs(high))
    given = (
        f"{four_digits(low)} {limit.unit}" if low == high else f"{four_digits(low)} to {four_digits(high)} {limit.unit}"
    )
    if low < limit.possible[0] or high > limit.possible[1]:
        message = f"{given.strip()} is impossible: expected {_range(limit.possible, limit.unit)} ({limit.source})"
        return Findings(problems=(LocalProblem(path, message),))
    if 0.0 < low < limit.usual[0] or high > limit.usual[1]:
        message = f"{given.strip()} is unusual: {limit.source}. Is the unit right?"
        return Findings(notices=(LocalProblem(path, message),))
    return Findings()


def check_effects(effects: Sequence[EffectEntry]) -> Findings:
    """Compare the parameters of a mission's effects with the catalogue's plausible sizes."""
    notices = []
    for entry in effects:
        for name, quantity in entry.parameters.items():
            known = CATALOGUE[entry.effect].parameters[name]
            low, high = ends(quantity)
            size, most = max(abs(low), abs(high)), EFFECT_SCALES * known.scale
            if known.scale > 0.0 and size > most:
                given, within = (f"{four_digits(number)} {known.unit}".rstrip() for number in (size, most))
                message = f"{given} is unusual: the catalogue's plausible sizes are within {within}. Is the unit right?"
                notices.append(LocalProblem((*entry.path, entry.effect, name), message))
    return Findings(notices=tuple(notices))


def _range(ends_of: tuple[float, float], unit: str) -> str:
    low, high = ends_of
    words = f"at most {four_digits(high)} {unit}".strip() if np.isfinite(high) else ""
    return f"at least {four_digits(low)} {unit}".strip() + (f" and {words}" if words else "") if low > 0.0 else words


def four_digits(value: float) -> str:
    """Write four digits, large numbers in groups of three."""
    text = f"{value:.4g}"
    if "e+" not in text:
        return text
    return f"{float(text):,.0f}".replace(",", "\u202f")
