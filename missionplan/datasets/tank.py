"""Data sets from the tank: `dataset.yaml` and its table, with every problem of both reported at once."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PlainValidator, ValidationError, model_validator

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission.reading.documents import Document, load_document, read_text
from missionplan.mission.reading.validation_errors import validation_problems
from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, invalid
from missionplan.mission.schema.site import WaterSection
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics.water import sea_water

MAX_TABLE_BYTES = 50_000_000
Area = Annotated[float, PlainValidator(QuantityParser("m^2", low=0.0, open_low=True, fixed=True))]
Volume = Annotated[float, PlainValidator(QuantityParser("m^3", low=0.0, open_low=True, fixed=True))]
Mass = Annotated[float, PlainValidator(QuantityParser("kg", low=0.0, open_low=True, fixed=True))]
Stiffness = Annotated[float, PlainValidator(QuantityParser("N/m", low=0.0, open_low=True, fixed=True))]
Inertia = Annotated[float, PlainValidator(QuantityParser("kg*m^2", low=0.0, open_low=True, fixed=True))]
FlowDamping = Annotated[float, PlainValidator(QuantityParser("kg/m", low=0.0, open_low=True, fixed=True))]
Lever = Annotated[float, PlainValidator(QuantityParser("m", fixed=True))]
Noise = Annotated[float, PlainValidator(QuantityParser("N", low=0.0, open_low=True, fixed=True))]
MomentNoise = Annotated[float, PlainValidator(QuantityParser("N*m", low=0.0, open_low=True, fixed=True))]
Number = Annotated[float, PlainValidator(QuantityParser("", low=0.0, open_low=True, fixed=True))]
Fraction = Annotated[float, PlainValidator(QuantityParser("", low=0.0, high=0.99, fixed=True))]
Slope = Annotated[float, PlainValidator(QuantityParser("", fixed=True))]


class Compared(FileSection):
    """Another table of the same kind to compare with, such as a CFD calculation."""

    name: str
    file: str
    reference_area: Area | None = None


class NoiseLevels(FileSection):
    """Standard deviations of the sensors, where they are known."""

    force: Noise | None = None
    thrust: Noise | None = None
    moment: MomentNoise | None = None
    displacement: q.FixedLength | None = None


class _Common(FileSection):
    name: str = ""
    file: str
    source: str = ""
    noise: NoiseLevels = NoiseLevels()
    water: WaterSection | None = None


class DragSettings(_Common):
    """Towed at constant speed: `speed_m_s`, `force_n`, optional `force_sd_n`."""

    kind: Literal["drag"]
    reference_area: Area
    reference_length: q.FixedLength
    scale: Number = 1.0
    compare: Compared | None = None


class OscillationSettings(_Common):
    """Free oscillation: `t_s`, `displacement_m`, or `mode`, `frequency_hz` and optional `frequency_sd_hz`."""

    kind: Literal["free-oscillation"]
    stiffness: Stiffness | None = None
    mass: Mass | None = None
    scale: Number = 1.0

    @model_validator(mode="after")
    def _identifiable(self) -> "OscillationSettings":
        missing = [key for key in ("stiffness", "mass") if getattr(self, key) is None]
        if missing:
            raise invalid(
                f"missing {' and '.join(missing)}: stiffness, mass and added mass cannot be found together from "
                "frequencies (only k/(m + m_ad) acts), so the first two must be given"
            )
        return self


class ThrusterGeometry(FileSection):
    """Of a tunnel thruster; `position` ahead of the pivot of the moments."""

    diameter: q.FixedLength
    position: Lever = 0.0


class ThrusterSettings(_Common):
    """Thrust at a command: `run`, `rpm` or `voltage_v`, `thrust_n`, optional `speed_m_s`, `moment_n_m`."""

    kind: Literal["thruster"]
    geometry: ThrusterGeometry | None = None
    runs: dict[str, Any] = Field(default_factory=dict)


class PropellerGeometry(FileSection):
    """Of a propeller; torque constants and inertia are needed where the shaft rate was not measured.

    `flow_damping` is d_f of Eq. 30 [kg/m]; default 2ρA_p, momentum theory.
    """

    diameter: q.FixedLength
    wake_fraction: Fraction = 0.0
    axial_flow_factor: Fraction = 0.0
    torque_coefficient: tuple[Number, Slope] | None = None
    shaft_inertia: Inertia | None = None
    flow_damping: FlowDamping | None = None


class PropellerSettings(_Common):
    """A propeller's response: `t_s`, `rpm` or `shaft_torque_n_m`, `thrust_n`, `speed_m_s`."""

    kind: Literal["propeller-transient"]
    geometry: PropellerGeometry


Settings = DragSettings | OscillationSettings | ThrusterSettings | PropellerSettings
_SETTINGS: dict[str, type[Settings]] = {
    "drag": DragSettings,
    "free-oscillation": OscillationSettings,
    "thruster": ThrusterSettings,
    "propeller-transient": PropellerSettings,
}
_COLUMNS: dict[str, tuple[tuple[str, ...], ...]] = {
    "drag": (("speed_m_s", "force_n"),),
    "free-oscillation": (("t_s", "displacement_m"), ("mode", "frequency_hz")),
    "thruster": (("rpm", "thrust_n"), ("voltage_v", "thrust_n")),
    "propeller-transient": (
        ("t_s", "rpm", "thrust_n", "speed_m_s"),
        ("t_s", "shaft_torque_n_m", "thrust_n", "speed_m_s"),
    ),
}
"""For each kind, the sets of columns of which one must be there."""
_OPTIONAL = {
    "drag": ("force_sd_n",),
    "free-oscillation": ("frequency_sd_hz",),
    "thruster": ("run", "speed_m_s", "moment_n_m"),
    "propeller-transient": (),
}
_TEXT = {"mode", "run"}


@dataclass(frozen=True)
class TankData:
    """A data set of the tank, read.

    Attributes
    ----------
    settings : Settings
        What `dataset.yaml` says, in SI.
    columns : dict
        Numbers of each column, nan where blank; rows with ``ok`` = 0 are gone.
    labels : dict
        Text columns: `mode`, `run`.
    compared : dict or None
        Columns of the table to compare with.
    notes : tuple of str
        Columns ignored, rows left out.
    raw : dict
        The data of `dataset.yaml`.
    """

    settings: Settings
    columns: dict[str, Array]
    labels: dict[str, list[str]]
    compared: dict[str, Array] | None
    notes: tuple[str, ...]
    raw: dict[str, Any]

    @property
    def density(self) -> float:
        """Density of the tank's water [kg/m³]."""
        return _water(self.settings.water)[0]

    @property
    def viscosity(self) -> float:
        """Kinematic viscosity of the tank's water [m²/s]."""
        return _water(self.settings.water)[1]


FRESH_WATER = (1000.0, 1.01e-6)
"""Density [kg/m³] and kinematic viscosity [m²/s] of a tank that says nothing of its water: Avila et al., 19 °C."""


def _water(water: WaterSection | None) -> tuple[float, float]:
    if water is None:
        return FRESH_WATER
    if water.temperature is not None and water.salinity is not None:
        state = sea_water(mean_of(water.temperature), mean_of(water.salinity))
        return float(state.density), float(state.viscosity)
    return mean_of(water.density or math.nan), mean_of(water.viscosity or math.nan)


def dataset_kind(folder: Path) -> str:
    """Kind of a data set, from its `dataset.yaml` alone.

    Raises
    ------
    InputError
        When the file is missing or says no kind.
    """
    document = load_document(folder / "dataset.yaml")
    kind = document.data.get("kind") if isinstance(document.data, dict) else None
    if not isinstance(kind, str):
        raise InputError([document.problem((), "missing the key `kind`")])
    return kind


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
    folder = Path(folder)
    kind = dataset_kind(folder)
    document = load_document(folder / "dataset.yaml")
    if kind not in _SETTINGS:
        close = get_close_matches(kind, _SETTINGS, n=1)
        hint = f"did you mean {close[0]}?" if close else ""
        message = f"given {kind!r}; `identify` takes {', '.join(_SETTINGS)}"
        raise InputError([document.problem(("kind",), message, hint)])
    problems: list[Problem] = []
    settings = _settings(document, _SETTINGS[kind], problems)
    notes: list[str] = []
    columns, labels = _table(document, ("file",), folder, kind, problems, notes)
    compared = None
    if isinstance(document.data.get("compare"), dict):
        compared = _table(document, ("compare", "file"), folder, kind, problems, notes)[0]
    if problems or settings is None:
        raise InputError(problems)
    return TankData(settings, columns, labels, compared, tuple(notes), document.data)


def _settings(document: Document, model: type[Settings], problems: list[Problem]) -> Settings | None:
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        problems += validation_problems(error, document, model)
        return None


def _table(
    document: Document, key: tuple[str, ...], folder: Path, kind: str, problems: list[Problem], notes: list[str]
) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Read one CSV that the document names at `key`; problems and notes are added to."""
    name: Any = document.data
    for part in key:
        name = name.get(part) if isinstance(name, dict) else None
    if not isinstance(name, str):
        return {}, {}
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        problems.append(document.problem(key, f"given {name!r}, which lies outside the data set's folder"))
        return {}, {}
    try:
        rows = list(csv.reader(read_text(path, str(path), max_bytes=MAX_TABLE_BYTES).splitlines()))
    except InputError as error:
        problems += error.problems
        return {}, {}
    header = [column.strip().lstrip("\ufeff") for column in rows[0]] if rows else []
    wanted = _wanted(header, kind, str(path), problems)
    if not wanted:
        return {}, {}
    ignored = [column for column in header if column not in wanted and column != "ok"]
    if ignored:
        notes.append(f"{path.name}: columns not used: {', '.join(ignored)}")
    return _cells(rows, header, wanted, str(path), problems, notes)


def _wanted(header: Sequence[str], kind: str, shown: str, problems: list[Problem]) -> tuple[str, ...]:
    """Choose the set of columns that the table has, or report the nearest set as missing."""
    for columns in _COLUMNS[kind]:
        if set(columns) <= set(header):
            return tuple(columns) + tuple(column for column in _OPTIONAL[kind] if column in header)
    nearest = max(_COLUMNS[kind], key=lambda columns: len(set(columns) & set(header)))
    for column in nearest:
        if column not in header:
            close = get_close_matches(column, header, n=1)
            problems.append(Problem("missing column", shown, 1, column, f"is it {close[0]}?" if close else ""))
    return ()


def _cells(
    rows: list[list[str]],
    header: list[str],
    wanted: tuple[str, ...],
    shown: str,
    problems: list[Problem],
    notes: list[str],
) -> tuple[dict[str, Array], dict[str, list[str]]]:
    numbers: dict[str, list[float]] = {column: [] for column in wanted if column not in _TEXT}
    labels: dict[str, list[str]] = {column: [] for column in wanted if column in _TEXT}
    left_out = 0
    for line, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row):
            continue
        cells = dict(zip(header, (cell.strip() for cell in row), strict=False))
        values = {column: _number(cells.get(column, ""), shown, line, column, problems) for column in numbers}
        if cells.get("ok") == "0" or any(np.isnan(values[column]) for column in values if column not in _BLANK_ALLOWED):
            left_out += 1
            continue
        for column, value in values.items():
            numbers[column].append(value)
        for column in labels:
            labels[column].append(cells.get(column, ""))
    if left_out:
        notes.append(f"{Path(shown).name}: {left_out} row{'s' if left_out > 1 else ''} left out (ok = 0, or blank)")
    if not any(numbers.values()):
        problems.append(Problem("has no rows of data", shown))
    return {column: np.array(values) for column, values in numbers.items()}, labels


_BLANK_ALLOWED = ("force_sd_n", "frequency_sd_hz", "moment_n_m")


def _number(text: str, shown: str, line: int, column: str, problems: list[Problem]) -> float:
    if not text:
        return float("nan")
    try:
        value = float(text)
    except ValueError:
        value = float("inf")
    if not np.isfinite(value):
        problems.append(Problem(f"given {text!r}, expected a number", shown, line, column))
        return float("nan")
    return value
