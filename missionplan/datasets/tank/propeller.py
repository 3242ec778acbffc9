"""A propeller's response: thrust against time, with the shaft rate or the torque that drives it."""

from missionplan.datasets.reading import DatasetFormat
from missionplan.datasets.table import Columns
from missionplan.datasets.tank.settings import (
    MAX_TABLE_BYTES,
    FlowDamping,
    Fraction,
    Inertia,
    Number,
    Slope,
    TankSettings,
)
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.section import FileSection


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
