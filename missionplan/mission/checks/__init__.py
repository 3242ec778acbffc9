"""What the world and other sections allow: here every quantity against what its key declares possible and usual.

`sections` compares what stands in the file, `relations` what its keys mean together. Here too the notes on a mission
that is read: what is unusual in it, and what was left out or cut off.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from missionplan.effects import CATALOGUE, FAILED_PLUGINS
from missionplan.errors import KeyPath, LocalProblem
from missionplan.mission.schema.effect_list import POSTERIOR, EffectEntry
from missionplan.mission.schema.phases import Phase
from missionplan.mission.schema.quantity_parser import IN_UNIT, Limit
from missionplan.mission.validation_errors import parsers_of
from missionplan.montecarlo.distributions import Distribution, Quantity
from missionplan.montecarlo.normal_transform import NormalTransform

_TAIL = 0.01
"""Share of the draws beyond each end."""
EFFECT_SCALES = 6.0
"""Plausible sizes of an effect's parameter, in its catalogue's standard deviations, beyond which it is unusual."""


@dataclass(frozen=True)
class Findings:
    """What the limits say of a mission."""

    problems: tuple[LocalProblem, ...] = ()
    """What cannot be."""
    notices: tuple[LocalProblem, ...] = ()
    """What is unusual."""

    def __add__(self, other: "Findings") -> "Findings":
        """Join two."""
        return Findings((*self.problems, *other.problems), (*self.notices, *other.notices))


def check_ranges(sections: Sequence[tuple[str, object]], phases: Sequence[Phase]) -> Findings:
    """Compare quantities with what is possible and usual.

    `sections`: the mission's sections by name, but for the phases.

    Returns
    -------
    Findings
        By key path from the top of the mission.
    """
    findings = Findings()
    for name, section in sections:
        findings += _of(section, (name,))
    for index, phase in enumerate(phases):
        findings += _of(phase, ("phases", index, phase.kind))
    return findings


def ends(quantity: Quantity) -> tuple[float, float]:
    """Return the value twice, or the ends of what 98 % of the draws of a distribution lie between."""
    if isinstance(quantity, NormalTransform):
        return quantity.quantile(_TAIL), quantity.quantile(1.0 - _TAIL)
    return float(quantity), float(quantity)


def _of(value: object, path: KeyPath) -> Findings:
    findings = Findings()
    for inner, quantity, limit in _limited(value, path, None):
        findings += _compared(inner, quantity, limit)
    return findings


def _limited(value: object, path: KeyPath, limit: Limit | None) -> Iterator[tuple[KeyPath, Quantity, Limit]]:
    """Quantities inside a value that have limits, with their key paths in the file."""
    if isinstance(value, float | NormalTransform):
        if limit is not None:
            yield path, value, limit  # type: ignore[misc]  # every transform of a normal is one of the distributions
    elif isinstance(value, BaseModel):
        fields = type(value).model_fields
        for field, inner in value:
            yield from _limited(inner, (*path, fields[field].alias or field), _limit_of(fields[field]))
    elif isinstance(value, tuple):
        for index, inner in enumerate(value):
            yield from _limited(inner, (*path, index), limit)


def _limit_of(field: FieldInfo) -> Limit | None:
    """Return what a field may be, with the unit of the numbers."""
    limit = next((annotation for annotation in field.metadata if isinstance(annotation, Limit)), None)
    return limit if limit is None or limit.unit is not None else replace(limit, unit=parsers_of(field)[0].unit)


def _compared(path: KeyPath, quantity: Quantity, limit: Limit) -> Findings:
    unit = limit.unit or ""
    scale = IN_UNIT.get(unit, 1.0)
    low, high = (scale * end for end in ends(quantity))
    if limit.signed:
        low, high = (0.0 if low < 0.0 < high else min(abs(low), abs(high))), max(abs(low), abs(high))
    span = f"{four_digits(low)} {unit}" if low == high else f"{four_digits(low)} to {four_digits(high)} {unit}"
    if low < limit.possible[0] or high > limit.possible[1]:
        message = f"{span.strip()} is impossible: expected {_range(limit.possible, unit)} ({limit.source})"
        return Findings(problems=(LocalProblem(path, message),))
    if 0.0 < low < limit.usual[0] or high > limit.usual[1]:
        message = f"{span.strip()} is unusual: {limit.source}. Is the unit right?"
        return Findings(notices=(LocalProblem(path, message),))
    return Findings()


def check_effects(effects: Sequence[EffectEntry]) -> Findings:
    """Compare what a mission states of its effects with the catalogue's plausible sizes; draws have units already."""
    notices = []
    for entry in (entry for entry in effects if entry.explanation is None or entry.explanation[0] != POSTERIOR):
        for name, quantity in entry.parameters.items():
            parameter = CATALOGUE[entry.effect].parameters[name]
            low, high = ends(quantity)
            size, most = max(abs(low), abs(high)), EFFECT_SCALES * parameter.scale
            if parameter.scale > 0.0 and size > most:
                value, within = (f"{four_digits(number)} {parameter.unit}".rstrip() for number in (size, most))
                message = f"{value} is unusual: the catalogue's plausible sizes are within {within}. Is the unit right?"
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


_LEAST_TOLD = 1e-12
"""Probability below which nothing is said of what was cut off."""


def notices(unusual: Sequence[str], uncertain: Mapping[str, Distribution]) -> tuple[str, ...]:
    """Return a note for each unusual value, distribution cut at its physical range, and plug-in left out."""
    cut = (
        f"{path}: {_percent(value.mass_cut)} of the distribution lies outside the physical range and was cut off"
        for path, value in uncertain.items()
        if value.mass_cut > _LEAST_TOLD
    )
    plugins = (f"the plug-in {name} of effects is left out: {reason}" for name, reason in FAILED_PLUGINS.items())
    return (*unusual, *cut, *plugins)


def _percent(share: float) -> str:
    """Write a share in two digits, as long as a trial in a hundred thousand may meet it."""
    return f"{100.0 * share:.2g} %" if share >= 1e-5 else "less than 0.001 %"
