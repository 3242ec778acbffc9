"""Towing at constant speed: drag against speed."""

from missionplan.datasets.reading import DatasetFormat, Text
from missionplan.datasets.table import Columns
from missionplan.datasets.tank.settings import MAX_TABLE_BYTES, Area, Number, TankSettings
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection


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
