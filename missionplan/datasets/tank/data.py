"""Data sets from a tank, of any of its kinds."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.identity import ROW_BY_ROW, row_identities, row_texts, table_identity, written_once
from missionplan.datasets.reading import DatasetFormat, RawDataset, dataset_kind, read_dataset, read_named_table
from missionplan.datasets.table import Columns, CsvTable, problems_at
from missionplan.datasets.tank.formats import (
    DRAG,
    FREE_OSCILLATION,
    PROPELLER_TRANSIENT,
    THRUSTER,
    DragSettings,
    OscillationSettings,
    PropellerSettings,
    ThrusterSettings,
)
from missionplan.datasets.times import EPOCH_SCALE
from missionplan.errors import Problem
from missionplan.mission.schema.site import WaterSection
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics.water import sea_water
from missionplan.store.paths import as_path

Settings = DragSettings | OscillationSettings | ThrusterSettings | PropellerSettings
_FORMATS: tuple[DatasetFormat[Settings], ...] = (DRAG, FREE_OSCILLATION, THRUSTER, PROPELLER_TRANSIENT)
TANK_FORMATS = {form.kind: form for form in _FORMATS}
FRESH_WATER = (1000.0, 1.01e-6)
"""Density [kg/m³] and kinematic viscosity [m²/s] where nothing is said of the tank's water: Avila et al., 19 °C."""


@dataclass(frozen=True)
class TankData:
    """A data set from a tank.

    Attributes
    ----------
    name, source : str
        Of the data set.
    settings : DragSettings, OscillationSettings, ThrusterSettings or PropellerSettings
        Keys of ``dataset.yaml``, in SI.
    columns : dict
        Numbers of each column, nan where blank; rows with ``ok`` = 0 are left out.
    labels : dict
        Columns of text: `mode`, `run`.
    compared : dict or None
        Columns of the table to compare with.
    notices : tuple of str
        Columns ignored, rows left out.
    raw : mapping
        Data of ``dataset.yaml``.
    identities : tuple of str
        Hash of each row; one of the whole where rows are moments of a record in time, or many.
    """

    name: str
    source: str
    settings: Settings
    columns: dict[str, Array]
    labels: dict[str, list[str]]
    compared: dict[str, Array] | None
    notices: tuple[str, ...]
    raw: Mapping[str, object]
    identities: tuple[str, ...] = ()

    def subset(self, keep: NDArray[np.bool_]) -> "TankData":
        """Keep some of the rows, each of which has a hash of its own."""
        return replace(
            self,
            columns={name: column[keep] for name, column in self.columns.items()},
            labels={name: np.array(words)[keep].tolist() for name, words in self.labels.items()},
            identities=tuple(np.array(self.identities)[keep].tolist()),
        )

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

    Parameters
    ----------
    folder : str or Path
        Folder with `dataset.yaml` and its CSV file.

    Raises
    ------
    InputError
        With every problem of `dataset.yaml` and of the tables.
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
    told: dict[str, Array | list[str]] = {**columns, **{name: words for name, words in labels.items() if name != "run"}}
    texts = row_texts([told[name] for name in sorted(told)])
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
    kind = raw.document.data.get("kind")

    def at(name: str, hint: str) -> list[Problem]:
        rows = raw.table.index[raw.table[name] <= 0.0]
        return problems_at(rows, lambda line: Problem("expected more than 0", raw.file, line, name, hint))

    columns = [(name, hint) for (of, name), hint in _POSITIVE.items() if of == kind and name in raw.table]
    return [problem for name, hint in columns for problem in at(name, hint)]


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
