"""Data from a tank: one module a kind with the schema of its `dataset.yaml` and its columns; `data` reads them all."""

from missionplan.datasets.tank.data import TANK_FORMATS, TankData, read_tank_data
from missionplan.datasets.tank.drag import DragSettings
from missionplan.datasets.tank.oscillation import OscillationSettings
from missionplan.datasets.tank.propeller import PropellerGeometry, PropellerSettings
from missionplan.datasets.tank.thruster import ThrusterGeometry, ThrusterSettings

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
