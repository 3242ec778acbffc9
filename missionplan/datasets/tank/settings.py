"""Keys that `dataset.yaml` has for every kind of tank data, and the types of their quantities."""

from typing import Annotated

from missionplan.datasets.reading import DatasetSettings
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy
from missionplan.mission.schema.site import WaterSection

MAX_TABLE_BYTES = 50_000_000

Area = Annotated[float, ReadBy(QuantityParser("m^2", low=0.0, open_low=True, fixed=True))]
Inertia = Annotated[float, ReadBy(QuantityParser("kg*m^2", low=0.0, open_low=True, fixed=True))]
FlowDamping = Annotated[float, ReadBy(QuantityParser("kg/m", low=0.0, open_low=True, fixed=True))]
Lever = Annotated[float, ReadBy(QuantityParser("m", fixed=True))]
ForceNoise = Annotated[float, ReadBy(QuantityParser("N", low=0.0, open_low=True, fixed=True))]
MomentNoise = Annotated[float, ReadBy(QuantityParser("N*m", low=0.0, open_low=True, fixed=True))]
Number = Annotated[float, ReadBy(QuantityParser("", low=0.0, open_low=True, fixed=True))]
Fraction = Annotated[float, ReadBy(QuantityParser("", low=0.0, high=0.99, fixed=True))]
Slope = Annotated[float, ReadBy(QuantityParser("", fixed=True))]


class NoiseLevels(FileSection):
    """Standard deviations of the sensors, where they are known."""

    force: ForceNoise | None = None
    thrust: ForceNoise | None = None
    moment: MomentNoise | None = None
    displacement: q.FixedLength | None = None


class TankSettings(DatasetSettings):
    """Keys of a data set from a tank."""

    noise: NoiseLevels = NoiseLevels()
    water: WaterSection | None = None
