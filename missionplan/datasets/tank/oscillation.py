"""Free oscillation on springs: displacement against time, or the frequency of each mode."""

from typing import Annotated

from pydantic import Field

from missionplan.datasets.reading import DatasetFormat
from missionplan.datasets.table import Columns
from missionplan.datasets.tank.settings import MAX_TABLE_BYTES, Number, TankSettings
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import ReadBy, invalid
from missionplan.montecarlo.distributions import Quantity


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
