"""Keys that `dataset.yaml` has for tank data, and the columns of each kind of them."""

from typing import Annotated

from pydantic import Field

from missionplan.datasets.reading import DatasetFormat, DatasetSettings, Text
from missionplan.datasets.table import Columns
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy, invalid
from missionplan.mission.schema.site import WaterSection
from missionplan.montecarlo.distributions import Quantity

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


class Compared(FileSection):
    """Another table of the same kind to compare with, such as a CFD calculation."""

    name: Text
    file: str
    reference_area: Area | None = None


class DragSettings(TankSettings):
    """Keys of a data set of kind ``drag``; `scale` is full size over model."""

    reference_area: Area
    reference_length: q.FixedLength
    scale: Number = 1.0
    compare: Compared | None = None


DRAG = DatasetFormat(
    "drag",
    DragSettings,
    Columns((("speed_m_s", "force_n"),), optional=("force_sd_n",), max_bytes=MAX_TABLE_BYTES),
)


def _known(unit: str) -> ReadBy:
    """Return a validator of a positive quantity that says why it is needed where it is missing."""
    parser = QuantityParser(unit, low=0.0, open_low=True, fixed=True)

    def read(value: object) -> Quantity:
        if value is None:
            raise invalid(
                "missing; stiffness, mass and added mass cannot be found together from frequencies (only k/(m + m_ad) "
                f"acts), so the first two must be given; expected {parser.expected}"
            )
        return parser(value)

    return ReadBy(read)


class OscillationSettings(TankSettings):
    """Keys of a data set of kind ``free-oscillation``; `scale` is full size over model."""

    stiffness: Annotated[float, _known("N/m")] = Field(default=None, validate_default=True)
    mass: Annotated[float, _known("kg")] = Field(default=None, validate_default=True)
    scale: Number = 1.0


FREE_OSCILLATION = DatasetFormat(
    "free-oscillation",
    OscillationSettings,
    Columns(
        (("t_s", "displacement_m"), ("mode", "frequency_hz")),
        optional=("frequency_sd_hz",),
        text=("mode",),
        times=("t_s",),
        max_bytes=MAX_TABLE_BYTES,
    ),
)


class PropellerGeometry(FileSection):
    """Geometry of a propeller; torque constants and inertia are needed where the shaft rate was not measured.

    `flow_damping` is d_f of Eq. 30 [kg/m]; default 2ρA_p, momentum theory.
    """

    diameter: q.FixedLength
    wake_fraction: Fraction = 0.0
    axial_flow_factor: Fraction = 0.0
    torque_coefficient: tuple[Number, Slope] | None = None
    shaft_inertia: Inertia | None = None
    flow_damping: FlowDamping | None = None


class PropellerSettings(TankSettings):
    """Keys of a data set of kind ``propeller-transient``."""

    geometry: PropellerGeometry


PROPELLER_TRANSIENT = DatasetFormat(
    "propeller-transient",
    PropellerSettings,
    Columns(
        (("t_s", "rpm", "thrust_n", "speed_m_s"), ("t_s", "shaft_torque_n_m", "thrust_n", "speed_m_s")),
        times=("t_s",),
        max_bytes=MAX_TABLE_BYTES,
    ),
)


class ThrusterGeometry(FileSection):
    """Geometry of a tunnel thruster; `position` ahead of the pivot of the moments."""

    diameter: q.FixedLength
    position: Lever = 0.0


class ThrusterSettings(TankSettings):
    """Keys of a data set of kind ``thruster``."""

    geometry: ThrusterGeometry | None = None


THRUSTER = DatasetFormat(
    "thruster",
    ThrusterSettings,
    Columns(
        (("rpm", "thrust_n"), ("voltage_v", "thrust_n")),
        optional=("run", "speed_m_s", "moment_n_m"),
        complete=("speed_m_s",),
        text=("run",),
        max_bytes=MAX_TABLE_BYTES,
    ),
)
