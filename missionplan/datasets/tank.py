"""Data sets from a tank, of any of its kinds: the keys of their `dataset.yaml`, their columns, and their reading."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import Field
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.datasets import (
    DatasetFormat,
    DatasetSettings,
    RawDataset,
    Text,
    dataset_kind,
    read_dataset,
    read_named_table,
)
from missionplan.datasets.records import ROW_BY_ROW, row_identities, row_texts, table_identity, written_once
from missionplan.datasets.table import Columns, CsvTable, wrong_cells
from missionplan.errors import Problem
from missionplan.mission.schema import FileSection, Moment, ReadBy
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.site import WaterSection
from missionplan.mission.units import QuantityError
from missionplan.moments import EPOCH_SCALE
from missionplan.montecarlo.distributions import Quantity, mean_of
from missionplan.physics.water import sea_water
from missionplan.store.folder import as_path

MAX_TABLE_BYTES = 50_000_000

Area = Annotated[float, q.fixed("m^2", open_low=True)]
Inertia = Annotated[float, q.fixed("kg*m^2", open_low=True)]
FlowDamping = Annotated[float, q.fixed("kg/m", open_low=True)]
Lever = Annotated[float, q.fixed("m", -math.inf)]
ForceNoise = Annotated[float, q.fixed("N", open_low=True)]
MomentNoise = Annotated[float, q.fixed("N*m", open_low=True)]
Number = Annotated[float, q.fixed("", open_low=True)]
Fraction = Annotated[float, q.fixed("", high=0.99)]
Slope = Annotated[float, q.fixed("", -math.inf)]


class NoiseLevels(FileSection):
    """Standard deviations of the sensors, where they are known."""

    force: Annotated[ForceNoise | None, Doc("standard deviation of a force")] = None
    thrust: Annotated[ForceNoise | None, Doc("standard deviation of a thrust")] = None
    moment: Annotated[MomentNoise | None, Doc("standard deviation of a moment")] = None
    displacement: Annotated[q.FixedLength | None, Doc("standard deviation of a displacement")] = None


class TankSettings(DatasetSettings):
    """Keys of a data set from a tank."""

    start: Annotated[Moment | None, Doc("date of the measurements")] = None
    noise: Annotated[NoiseLevels, Doc("errors of what was measured")] = NoiseLevels()
    water: Annotated[WaterSection | None, Doc("water in the tank")] = None


class Compared(FileSection):
    """Another table of the same kind to compare with, such as a CFD calculation."""

    name: Annotated[Text, Doc("what the other table is"), Field(examples=["towing tank"])]
    file: Annotated[str, Doc("its CSV"), Field(examples=["cfd.csv"])]
    reference_area: Annotated[Area | None, Doc("area to which its coefficients refer")] = None


class DragSettings(TankSettings):
    """Keys of a data set of kind ``drag``; `scale` is full size over model."""

    reference_area: Annotated[Area, Doc("area to which the drag coefficient refers")]
    reference_length: Annotated[q.FixedLength, Doc("length of the Reynolds number")]
    scale: Annotated[Number, Doc("full size over model")] = 1.0
    compare: Annotated[Compared | None, Doc("another table of the same kind")] = None


DRAG = DatasetFormat(
    "drag",
    DragSettings,
    Columns((("speed_m_s", "force_n"),), optional=("force_sd_n",), max_bytes=MAX_TABLE_BYTES),
)


class _Needed(QuantityParser):
    """Reads a positive quantity, and says why it is needed where it is missing."""

    def parse(self, value: object) -> Quantity:
        """Read a value; see `QuantityParser.parse`."""
        if value is None:
            raise QuantityError(
                "missing; stiffness, mass and added mass cannot be found together from frequencies (only k/(m + m_ad) "
                f"acts), so the first two must be given; expected {self.expected}"
            )
        return super().parse(value)


class OscillationSettings(TankSettings):
    """Keys of a data set of kind ``free-oscillation``; `scale` is full size over model."""

    stiffness: Annotated[
        float, ReadBy(_Needed("N/m", low=0.0, open_low=True, fixed=True)), Doc("stiffness of the springs")
    ] = Field(default=None, validate_default=True)
    mass: Annotated[float, ReadBy(_Needed("kg", low=0.0, open_low=True, fixed=True)), Doc("mass of the model")] = Field(
        default=None, validate_default=True
    )
    scale: Annotated[Number, Doc("full size over model")] = 1.0


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

    diameter: Annotated[q.FixedLength, Doc("diameter of the disc")]
    wake_fraction: Annotated[Fraction, Doc("share of the speed by which the wake is slower")] = 0.0
    axial_flow_factor: Annotated[Fraction, Doc("factor a on the axial flow")] = 0.0
    torque_coefficient: Annotated[
        tuple[Number, Slope] | None, Doc("β₀ and β₁ of K_Q = β₀ + β₁J"), Field(examples=[[0.05, -0.04]])
    ] = None
    shaft_inertia: Annotated[Inertia | None, Doc("moment of inertia of motor, shaft and propeller")] = None
    flow_damping: Annotated[FlowDamping | None, Doc("d_f0 and d_f of the flow in the disc")] = None


class PropellerSettings(TankSettings):
    """Keys of a data set of kind ``propeller-transient``."""

    geometry: Annotated[PropellerGeometry, Doc("what is known of the propeller")]


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

    diameter: Annotated[q.FixedLength, Doc("diameter of the tunnel")]
    position: Annotated[Lever, Doc("distance ahead of the centre of rotation")] = 0.0


class ThrusterSettings(TankSettings):
    """Keys of a data set of kind ``thruster``."""

    geometry: Annotated[ThrusterGeometry | None, Doc("what is known of a tunnel thruster")] = None


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


Settings = DragSettings | OscillationSettings | ThrusterSettings | PropellerSettings
_FORMATS: tuple[DatasetFormat[Settings], ...] = (DRAG, FREE_OSCILLATION, THRUSTER, PROPELLER_TRANSIENT)
TANK_FORMATS = {form.kind: form for form in _FORMATS}
FRESH_WATER = (1000.0, 1.01e-6)
"""Density [kg/m³] and kinematic viscosity [m²/s] where nothing is said of the tank's water: Avila et al., 19 °C."""


@dataclass(frozen=True)
class TankData:
    """A data set from a tank."""

    name: str
    source: str
    """Of the data set."""
    settings: Settings
    """Keys of ``dataset.yaml``, in SI."""
    columns: dict[str, Array]
    """Numbers of each column, nan where blank; rows with ``ok`` = 0 are left out."""
    labels: dict[str, list[str]]
    """Columns of text: `mode`, `run`."""
    compared: dict[str, Array] | None
    """Columns of the table to compare with."""
    notices: tuple[str, ...]
    """Columns ignored, rows left out."""
    raw: Mapping[str, object]
    """Data of ``dataset.yaml``."""
    identities: tuple[str, ...] = ()
    """Hash of each row; one of the whole where rows are moments of a record in time, or many."""

    def subset(self, keep: NDArray[np.bool_]) -> "TankData":
        """Keep some of the rows, each of which has a hash of its own."""
        return replace(
            self,
            columns={name: column[keep] for name, column in self.columns.items()},
            labels={name: np.array(words)[keep].tolist() for name, words in self.labels.items()},
            identities=tuple(np.array(self.identities)[keep].tolist()),
        )

    @property
    def date(self) -> float:
        """Of the measurements [s since 1970]; nan where it is not known."""
        return math.nan if self.settings.start is None else self.settings.start.timestamp()

    @property
    def density(self) -> float:
        """Density of the tank's water [kg/m³]."""
        return _density_and_viscosity(self.settings.water)[0]

    @property
    def viscosity(self) -> float:
        """Kinematic viscosity of the tank's water [m²/s]."""
        return _density_and_viscosity(self.settings.water)[1]


def _density_and_viscosity(water: WaterSection | None) -> tuple[float, float]:
    if water is None:
        return FRESH_WATER
    if water.temperature is not None and water.salinity is not None:
        state = sea_water(mean_of(water.temperature), mean_of(water.salinity))
        return float(state.density), float(state.viscosity)
    return mean_of(water.density or math.nan), mean_of(water.viscosity or math.nan)


def read_tank_data(folder: str | Path) -> TankData:
    """Read a data set of one of the kinds drag, free-oscillation, thruster and propeller-transient.

    `folder`: folder with `dataset.yaml` and its CSV file. Raises InputError with every problem of `dataset.yaml` and of
    the tables.
    """
    folder = as_path(folder, "dataset")
    form = TANK_FORMATS[dataset_kind(folder, TANK_FORMATS)]
    raw = read_dataset(folder, form)
    problems = [*_not_positive(raw), *_unmoved(raw)]
    compared = _compared(folder, raw, form.columns, problems)
    settings = raw.checked(problems)
    rows, identities, notices = _counted_once(form.kind, raw.table)
    columns, labels = _split(rows)
    return TankData(
        raw.name,
        raw.source,
        settings,
        columns,
        labels,
        _split(compared.rows)[0] if compared is not None else None,
        (*raw.notices, *notices, *(compared.notices if compared is not None else ())),
        raw.document.data,
        identities,
    )


def _counted_once(kind: str, rows: pd.DataFrame) -> tuple[pd.DataFrame, tuple[str, ...], tuple[str, ...]]:
    """Rows of a table, once where it stands several times over; their hashes; and a notice of it."""
    columns, labels = _split(rows)
    data: dict[str, Array | list[str]] = {**columns, **{name: words for name, words in labels.items() if name != "run"}}
    texts = row_texts([data[name] for name in sorted(data)])
    once = np.ones(len(texts), dtype=bool) if "t_s" in columns else written_once(texts)
    notices = () if once.all() else (f"the rows stand {len(once) // once.sum()} times over, and count once",)
    texts = [text for text, keep in zip(texts, once, strict=True) if keep]
    is_whole = "t_s" in columns or len(texts) > ROW_BY_ROW
    identities = (table_identity(kind, texts),) if is_whole else row_identities(kind, texts)
    return rows[once], identities, notices


_POSITIVE = {
    (DRAG.kind, "speed_m_s"): "subtract what the gauge reads at rest, and leave its row out (ok = 0)",
    (DRAG.kind, "force_sd_n"): "",
    (FREE_OSCILLATION.kind, "frequency_hz"): "",
    (FREE_OSCILLATION.kind, "frequency_sd_hz"): "",
}
"""Columns of a kind whose numbers are more than nil, with a hint: a model at rest has no drag but the gauge's own."""


def _not_positive(raw: RawDataset[Settings]) -> list[Problem]:
    """List the cells that must be more than nil, and are not."""
    problems = []
    for (kind, name), hint in _POSITIVE.items():
        if kind == raw.document.data.get("kind") and name in raw.table:
            rows = raw.table.index[raw.table[name] <= 0.0]
            problems += wrong_cells(rows, "expected more than 0", raw.file, name, hint)
    force = raw.table["force_n"] if "force_n" in raw.table else pd.Series([1.0])
    if force.median() <= 0.0:
        message = "most forces are not above 0; expected the drag, against the motion, as positive"
        problems.append(Problem(message, raw.file, key="force_n"))
    return problems


def _unmoved(raw: RawDataset[Settings]) -> list[Problem]:
    """Find a thruster that is never told to turn: its record holds no constant of it."""
    if raw.document.data.get("kind") != THRUSTER.kind:
        return []
    commands = [name for name in ("voltage_v", "rpm") if name in raw.table]
    idle = [name for name in commands if len(raw.table) and not np.any(raw.table[name])]
    return [Problem("is 0 on every row: the thruster stands still", raw.file, key=name) for name in idle]


def _compared(folder: Path, raw: RawDataset[Settings], columns: Columns, problems: list[Problem]) -> CsvTable | None:
    """Read the table to compare with, where there is one; its problems are added."""
    if not isinstance(raw.document.data.get("compare"), dict):
        return None
    return read_named_table(folder, raw.document, ("compare", "file"), columns, problems)


def _split(rows: pd.DataFrame) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Columns of numbers, and columns of text."""
    numbers = rows.select_dtypes("float64")
    columns = {str(name): cells.to_numpy() for name, cells in numbers.items()}
    if "t_s" in columns and np.nanmin(columns["t_s"], initial=np.inf) > EPOCH_SCALE:
        columns["t_s"] = columns["t_s"] - np.nanmin(columns["t_s"])
    labels = {str(name): cells.tolist() for name, cells in rows.items() if name not in numbers}
    return columns, labels
