"""Data from a tank: `formats` has the schema of each kind of `dataset.yaml` and its columns, `data` reads them."""

from missionplan.datasets.tank.data import TANK_FORMATS, TankData, read_tank_data
from missionplan.datasets.tank.formats import (
    DragSettings,
    OscillationSettings,
    PropellerGeometry,
    PropellerSettings,
    ThrusterGeometry,
    ThrusterSettings,
)

__all__ = [
    "TANK_FORMATS",
    "DragSettings",
    "OscillationSettings",
    "PropellerGeometry",
    "PropellerSettings",
    "TankData",
    "ThrusterGeometry",
    "ThrusterSettings",
    "read_tank_data",
]
