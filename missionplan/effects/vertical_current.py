"""Water that moves up or down."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class VerticalCurrent(DescentEffect):
    """Water about both bodies that moves down at `speed` [m/s]."""

    speed: Scalars = 0.0

    def water_velocity(self) -> Scalars:
        """Return the downward velocity of the water [m/s]."""
        return self.speed


INFO = EffectInfo(
    id="vertical-current",
    phase="descent",
    tier="physical",
    effect=VerticalCurrent,
    parameters={"speed": Parameter("m/s", "of the water, down positive", -1.0, 1.0, scale=0.12, spike=0.003)},
    belongs_to="day",
    what=(
        "Up- or downwelling along a slope, Langmuir circulation, internal waves: the bodies sink through moving water."
    ),
    finding=Finding(
        "speed",
        "the water sinks at {size}",
        "the water rises at {size}",
        remedy="dive at another state of the tide, or plan with the extended mission",
    ),
    sizes="0.02 to 0.3 m/s in coastal water, where more is not known. Either sign.",
    confused_with=("drag-bias", "depth-scale"),
    distinguished_by=(
        "Dives with 0.4 times the anchor's weight: a current shifts slow and fast dives alike, drag does not."
    ),
    instrument=Instrument("a current profiler beside the dives", "speed", 0.02),
)
