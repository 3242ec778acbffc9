"""Levels of a vehicle's parameters from mission to mission, as diagnoses and histories tell them."""

from dataclasses import dataclass
from typing import Annotated

from missionplan.results.entries import Entry, Record

LIKELY, SDS, FEWEST = 0.9, 3.0, 3
"""Probability of a trend from which it is told, standard deviations that it has at least, and missions."""
AHEAD = (1, 2, 4, 8, 16)
"""Missions from now that are simulated to see when a trend matters."""
LIKELY_JUMP = 0.5
"""Probability of a jump from which it is told."""


@dataclass(frozen=True)
class Level(Record):
    """A parameter in one mission, by all missions together."""

    record: Annotated[str, Entry("hash of the mission's legs, dives or runs; of the history the report's folder")]
    date: Annotated[float | None, Entry("of the data, since 1970", "s")]
    value: Annotated[float, Entry("of the parameter, in its unit")]
    sd: Annotated[float, Entry("standard deviation")]
    jumped: Annotated[float, Entry("probability that it jumped since the mission before")]


@dataclass(frozen=True)
class ParameterLevels(Record):
    """How one parameter of the vehicle goes from mission to mission."""

    effect: Annotated[str, Entry("whose parameter it is")]
    name: Annotated[str, Entry("of the parameter")]
    unit: Annotated[str, Entry("of the parameter")]
    missions: Annotated[tuple[Level, ...], Entry("in the order of time")]
    trend: Annotated[float, Entry("change a mission, if there is a trend")]
    trend_sd: Annotated[float, Entry("standard deviation of it")]
    trend_probability: Annotated[float, Entry("that there is a trend of this sign")]
    next_value: Annotated[float, Entry("mean in the next mission")]
    next_sd: Annotated[float, Entry("standard deviation in the next mission, with the drift")]
    matters_in: Annotated[
        int | None, Entry("missions until success falls by 1 % by the trend; none: not soon, or not asked")
    ] = None
    agreement: Annotated[float, Entry("probability that measurements of one mission differ as much by chance")] = 1.0

    @property
    def has_trend(self) -> Annotated[bool, Entry()]:
        """Whether the trend is told as one."""
        likely = self.trend_probability >= LIKELY and abs(self.trend) >= SDS * self.trend_sd
        return likely and len(self.missions) >= FEWEST

    @property
    def jumps(self) -> tuple[Level, ...]:
        """Missions before which it jumped."""
        return tuple(level for level in self.missions if level.jumped >= LIKELY_JUMP)
