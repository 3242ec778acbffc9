"""Thrusters: thrust at a command, at rest or under way."""

from missionplan.datasets.reading import DatasetFormat
from missionplan.datasets.table import Columns
from missionplan.datasets.tank.settings import MAX_TABLE_BYTES, Lever, TankSettings
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection


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
