"""A log whose clock does not start when the anchor separates."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class ClockOffset(DescentEffect):
    """Everything is delayed by `time` on the clock of the log."""

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
        "time": Parameter("s", "offset, positive when the dive is late on the log", -10.0, 10.0, scale=0.5, spike=0.02)
    },
    what="Time zero of the log is the release command, or the clock of another computer, not the anchor's separation.",
    finding=Finding(
        "time",
        "the log has the dive {size} late",
        "the log has the dive {size} early",
        remedy="set the clocks together before the next dive; the plan stays as it is",
    ),
    sizes="Solenoids and pin pullers take 0.1 to 1 s; the clocks of loggers differ by as much. Either sign.",
    confused_with=("line-payout", "sensor-lag", "sensor-position"),
    distinguished_by="Dives with a much longer line (a payout delay grows with it, a clock does not).",
    changes_plan=False,
    follows_law=True,
    scatter="release",
    instrument=Instrument("the separation heard or filmed against the log's clock", "time", 0.05, 5.0),
)
