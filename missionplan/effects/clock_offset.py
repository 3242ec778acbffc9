"""A log whose clock does not start when the anchor separates."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class ClockOffset(DescentEffect):
    """Everything comes `time` late on the clock of the log."""

    time: Scalars = 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Return the delay [s]."""
        return self.time


INFO = EffectInfo(
    id="clock-offset",
    phase="descent",
    tier="physical",
    effect=ClockOffset,
    parameters={
        "time": Parameter("s", "offset, positive when the dive comes late", -10.0, 10.0, scale=0.5, spike=0.02)
    },
    what="The log's zero is the release command, or another computer's clock, and not the separation of the anchor.",
    sizes="Solenoids and pin pullers take 0.1 to 1 s; loggers' clocks differ by as much. Either sign.",
    confused_with=("line-payout", "sensor-lag"),
    distinguished_by="Dives with a much longer line (a payout delay grows with it, a clock does not).",
    changes_plan=False,
)
