"""A line that pays out more slowly than the anchor falls."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class LinePayout(DescentEffect):
    """Everything after the separation is delayed by `delay_per_length` for each metre of line."""

    delay_per_length: Scalars = 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Return the delay [s]."""
        return self.delay_per_length * line_length


INFO = EffectInfo(
    id="line-payout",
    phase="descent",
    tier="physical",
    effect=LinePayout,
    parameters={"delay_per_length": Parameter("s/m", "delay for each metre of line", 0.0, 5.0, scale=0.2, spike=0.004)},
    what=(
        "Friction or tangling on the spool: the line pays out more slowly than the anchor's free fall would pull it."
    ),
    finding=Finding(
        "delay_per_length",
        "the line takes {size} to pay out",
        remedy="plan with the slower dive, or let the line run more freely",
    ),
    sizes="From zero to about half a second per metre; a delay is positive. Assumed from hand-wound spools.",
    confused_with=("clock-offset",),
    distinguished_by=("Dives with a much longer or shorter line; with one length it is identical to a clock offset."),
)
