"""The event of a rare failure, as it is written, and the ways in which it comes about."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.checks.requirements import quantity_unit
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.studies.rare_failure.result import Cause, FailureMode
from missionplan.studies.simulation.block_statistics import SCALES, requirement_key
from missionplan.studies.simulation.phase_trials import Flags

FAILS = "not total.success"
"""The default event."""
_FAILURES = ("struck_seafloor", "grounded", "line_parts")
"""Events that are failures themselves; of the others the failure is that they do not happen."""
_FORM = re.compile(r"(?P<negated>not\s+)?(?P<quantity>[^<>=]+?)\s*(?:(?P<sign>[<>])=?\s*(?P<limit>[^<>=]+))?")
_HINT = "such as 'not total.success', moor.struck_seafloor, 'not ingress.arrived' or 'moor.offset > 30 m'"


@dataclass(frozen=True)
class RareEvent:
    """A failure."""

    text: str
    """As written."""
    key: str
    """Column of the table of trials: ``total.success``, ``moor.offset_m``."""
    sign: int = 0
    """1 where the failure is a value above the limit, -1 where it is one below, 0 for an event."""
    limit: float = 0.0
    """In the unit of the column."""
    negated: bool = False
    """Whether the failure is that an event does not happen."""

    @classmethod
    def parse(cls, text: str, mission: Mission) -> "RareEvent":
        """Read ``not PHASE.EVENT``, ``PHASE.EVENT`` (one that is a failure), or ``PHASE.QUANTITY > LIMIT``.

        Raises
        ------
        InputError
            When the mission has no such quantity, the limit cannot be read, or the event is no failure.
        """
        text = " ".join(text.split())
        found = _FORM.fullmatch(text)
        if found is None:
            raise _wrong(text, "expected an event or a quantity with its limit")
        quantity, limit, negated = found["quantity"], found["limit"], found["negated"] is not None
        try:
            unit = quantity_unit(quantity, mission.phases)
            if unit is None:
                return cls._event(text, quantity, negated=negated, limited=limit is not None)
            if negated or limit is None:
                raise _wrong(text, f"{quantity} is a quantity: give the limit beyond which it is a failure")
            size = parse_number_with_unit(float(limit) if unit == "" else limit, unit) * SCALES.get(unit, 1.0)
        except (QuantityError, ValueError) as error:
            raise _wrong(text, str(error)) from None
        return cls(text, requirement_key(mission, quantity)[0], 1 if found["sign"] == ">" else -1, size)

    @classmethod
    def _event(cls, text: str, quantity: str, *, negated: bool, limited: bool) -> "RareEvent":
        name = quantity.rpartition(".")[2]
        if limited:
            raise _wrong(text, f"{name} is an event: it has no limit")
        if negated == (name in _FAILURES):
            other = quantity if negated else f"not {quantity}"
            raise _wrong(text, f"{text} is no failure, expected {other}")
        return cls(text, quantity, negated=negated)

    @property
    def phase(self) -> str:
        """Phase of the event, or ``total``."""
        return self.key.rpartition(".")[0]

    @property
    def name(self) -> str:
        """Event or quantity of that phase."""
        return self.key.rpartition(".")[2]

    @property
    def is_quantity(self) -> bool:
        """Whether the failure is a value beyond a limit."""
        return self.sign != 0

    def happens(self, columns: Mapping[str, Array | Flags]) -> Flags:
        """In which trials the failure happens; a value that was never reached lies beyond no limit."""
        values = columns[self.key]
        if self.is_quantity:
            return np.asarray(self.sign * (values - self.limit) > 0.0)
        flags = np.asarray(values, dtype=bool)
        return ~flags if self.negated else flags


def _wrong(text: str, message: str) -> InputError:
    return InputError([Problem(f"given {text!r}: {message}", key="rare", hint=_HINT)])


LEAST_SHARE = 0.02
"""Of the failures, of a way to fail that is described."""
LEAST_SHIFT = 0.5
"""Standard deviations from usual from which an input counts as unusual."""
MOST_CAUSES = 4


def failure_modes(
    weights: Array, steps: NDArray[np.str_], inputs: Mapping[str, Array], usual: Mapping[str, Array]
) -> tuple[FailureMode, ...]:
    """Group failing trials by where they fail, and find what was drawn unlike usual.

    Parameters
    ----------
    weights : array, shape (n,)
    steps : array of str, shape (n,)
    inputs : mapping of str to array, shape (n,)
        What was drawn in them; nan where it was never needed.
    usual : mapping of str to array, shape (m,)
        The same of plain trials.
    """
    shares = {str(step): float(weights[steps == step].sum() / weights.sum()) for step in np.unique(steps)}
    modes = [
        FailureMode(step, share, _causes(steps == step, weights, inputs, usual))
        for step, share in shares.items()
        if share >= LEAST_SHARE
    ]
    return tuple(sorted(modes, key=lambda mode: -mode.share))


def _causes(
    chosen: NDArray[np.bool_], weights: Array, inputs: Mapping[str, Array], usual: Mapping[str, Array]
) -> tuple[Cause, ...]:
    found = []
    for source, values in inputs.items():
        drawn = chosen & np.isfinite(values)
        before = usual[source][np.isfinite(usual[source])]
        if before.size < 2 or weights[drawn].sum() < 0.5 * weights[chosen].sum() or not np.std(before) > 0.0:
            continue
        mean = float(np.average(values[drawn], weights=weights[drawn]))
        found.append(Cause(source, mean, float(np.mean(before)), float(np.std(before))))
    unusual = [cause for cause in found if abs(cause.shift) >= LEAST_SHIFT]
    return tuple(sorted(unusual, key=lambda cause: -abs(cause.shift))[:MOST_CAUSES])
