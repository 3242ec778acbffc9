"""Required precision of a run: a standard error of one key figure below which no further block is run."""

import math
from dataclasses import dataclass, field

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.checks.requirements import quantity_unit
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.studies.simulation.block_statistics import SCALES, BlockStatistics, requirement_key

_Z95 = 1.959963984540054
SUCCESS = "success"
_OPTION = "precision"


@dataclass(frozen=True)
class Precision:
    """A standard error to be reached.

    Attributes
    ----------
    key : str
        Column of the statistics, such as ``moor.offset_m`` or ``total.success``.
    error : float
        In the results' unit, or a share of the mean.
    relative, is_event : bool
        Whether `error` is a share of the mean; whether it is that of a probability.
    text : str
        As written.
    """

    key: str
    error: float
    relative: bool
    is_event: bool
    text: str = field(default="", compare=False)

    @classmethod
    def parse(cls, text: str, mission: Mission) -> "Precision":
        """Read ``0.5%`` (of P(success)), ``success=0.002``, ``total.duration=0.5%`` or ``moor.offset=0.1 m``.

        Raises
        ------
        InputError
            When the mission has no such quantity, or the number cannot be read.
        """
        name, _, wanted = text.rpartition("=")
        name, wanted = name.strip() or SUCCESS, wanted.strip()
        quantity = f"total.{SUCCESS}" if name == SUCCESS else name
        unit = _unit(quantity, mission)
        share = wanted.endswith("%")
        try:
            if share or unit is None:
                error = float(wanted.removesuffix("%")) / (100.0 if share else 1.0)
            else:
                error = parse_number_with_unit(float(wanted) if unit == "" else wanted, unit) * SCALES.get(unit, 1.0)
        except (ValueError, QuantityError) as problem:
            hint = "such as 0.5%, success=0.002 or moor.offset=0.1 m"
            raise InputError([Problem(f"given {text!r}: {problem}", key=_OPTION, hint=hint)]) from None
        if not 0.0 < error < math.inf:
            raise InputError([Problem(f"given {text!r}, expected more than 0", key=_OPTION)])
        key, _ = requirement_key(mission, quantity)
        return cls(key, error, relative=share and unit is not None, is_event=unit is None, text=text)

    def is_reached(self, totals: BlockStatistics) -> bool:
        """Whether the standard error is below the required one.

        Of a probability, a quarter of Wilson's 95 % interval (Wilson 1927, J. Am. Stat. Assoc. 22, 209–212) takes the
        place of √(p(1 − p)/n), which is 0 as long as p is 0 or 1.
        """
        if self.is_event:
            probability = totals.counts[self.key].probability()
            return (probability.high - probability.low) / (2.0 * _Z95) < self.error
        statistic = totals.statistics[self.key].moments
        limit = self.error * (abs(float(statistic.mean)) if self.relative else 1.0)
        return bool(float(statistic.standard_error) < limit)


def _unit(quantity: str, mission: Mission) -> str | None:
    """Unit of a quantity's bound; None for an event."""
    try:
        return quantity_unit(quantity, mission.phases)
    except QuantityError as error:
        raise InputError([Problem(str(error), key=_OPTION)]) from None
