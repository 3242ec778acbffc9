"""A scale error of the depth sensor."""

from dataclasses import dataclass

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class DepthScale(DescentEffect):
    """Reading times ``1 + fraction``."""

    fraction: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads [m]."""
        return depth * (1.0 + self.fraction)


INFO = EffectInfo(
    id="depth-scale",
    phase="descent",
    tier="physical",
    effect=DepthScale,
    parameters={
        "fraction": Parameter(
            "", "relative error of the reading, too deep positive", -0.5, 0.5, scale=0.06, spike=0.003
        )
    },
    what="Wrong sensor range, or pressure converted to depth with the wrong density.",
    finding=Finding(
        "fraction",
        "the depth sensor reads {size} too deep",
        "the depth sensor reads {size} too shallow",
        remedy="calibrate it; the plan stays as it is",
        in_percent=True,
    ),
    sizes="Fresh water taken for sea water gives 2.6 %; sensors without calibration are wrong by 1 to 10 %.",
    confused_with=("drag-bias", "vertical-current", "clock-rate"),
    distinguished_by="Readings at a known depth (a lead line, the seafloor at touchdown).",
    changes_plan=False,
    instrument=Instrument("readings at two known depths (a lead line)", "fraction", 0.005, 20.0),
)
