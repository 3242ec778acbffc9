"""Data set folders: `dataset.yaml` and its CSV, with every problem of a file at once."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missionplan.errors import InputError, Problem
from missionplan.mission.reading.documents import Document, load_document
from missionplan.mission.units import QuantityError, parse_number_with_unit

KINDS = ("descent", "transit", "drag", "free-oscillation", "thruster", "propeller-transient", "summary")
DIAGNOSED = ("descent", "transit", "summary")
TANK = ("drag", "free-oscillation", "thruster", "propeller-transient")
MAX_BYTES = 2_000_000_000
SHOWN = 5
"""Bad cells of one column that are named one by one; the rest are counted."""

_KEYS = ("kind", "name", "file", "noise", "runs", "source")
_MISSING = ("", "nan", "NaN", "NA", "N/A", "null")


@dataclass(frozen=True)
class RawDataset:
    """What the folder says, before it is turned into dives or legs.

    Attributes
    ----------
    kind, name, source : str
        As in ``dataset.yaml``.
    document : Document
        ``dataset.yaml`` with its line marks.
    noise : mapping
        Stated standard deviations [SI].
    table : DataFrame
        Rows of the CSV with ``ok`` not 0; numeric columns are floats, blanks nan; the index is the file's line.
    file : str
        The CSV, as messages name it.
    notices : tuple of str
        Treatments the reader should know of.
    problems : tuple of Problem
        Cells that are no numbers, nan in the table: to be raised with what else is wrong.
    """

    kind: str
    name: str
    source: str
    document: Document
    noise: Mapping[str, float]
    table: pd.DataFrame
    file: str
    notices: tuple[str, ...]
    problems: tuple[Problem, ...] = ()


def read_dataset(
    folder: Path, columns: Mapping[str, Mapping[str, Iterable[str]]], noise: Mapping[str, str]
) -> RawDataset:
    """Read a data set folder.

    Parameters
    ----------
    folder : Path
        The folder.
    columns : mapping
        For each kind that is welcome, names of its ``text`` and ``numeric`` columns.
    noise : mapping
        Names of stated noises and their units.

    Raises
    ------
    InputError
        All problems of ``dataset.yaml``, or why the CSV is no table.
    """
    if not folder.is_dir():
        raise InputError([Problem("no such folder", str(folder), hint="a data set is a folder with dataset.yaml")])
    document = load_document(folder / "dataset.yaml")
    if not isinstance(document.data, dict):
        raise InputError([document.problem((), "expected keys such as kind:, name: and file:")])
    problems = _check_keys(document, columns)
    stated = _read_noise(document, noise, problems)
    if problems:
        raise InputError(problems)
    kind, path = document.data["kind"], folder / document.data["file"]
    wanted = columns[kind]
    table, notices, bad_cells = _read_table(path, tuple(wanted["text"]), tuple(wanted["numeric"]))
    words = {key: str(document.data.get(key, "")).strip() for key in ("name", "source")}
    name = words["name"] or folder.name
    return RawDataset(kind, name, words["source"], document, stated, table, str(path), notices, bad_cells)


def _check_keys(document: Document, columns: Mapping[str, Any]) -> list[Problem]:
    data, problems = document.data, []
    for key in data:
        if key not in _KEYS:
            close = get_close_matches(key, _KEYS, n=1)
            problems.append(document.problem((key,), "unknown key", f"did you mean {close[0]}?" if close else ""))
    kind = data.get("kind")
    if kind not in KINDS:
        problems.append(document.problem(("kind",), f"given {kind!r}, expected one of {', '.join(KINDS)}"))
    elif kind not in columns:
        problems.append(
            document.problem(
                ("kind",),
                f"a data set of kind {kind} cannot be diagnosed; expected one of {', '.join(columns)}",
            )
        )
    file = data.get("file")
    if not isinstance(file, str) or not file:
        problems.append(document.problem(("file",), "expected the name of a CSV file in this folder"))
    elif Path(file).is_absolute() or ".." in Path(file).parts:
        problems.append(document.problem(("file",), f"given {file!r}, expected a file inside this folder"))
    return problems


def _read_noise(document: Document, units: Mapping[str, str], problems: list[Problem]) -> dict[str, float]:
    given = document.data.get("noise") or {}
    if not isinstance(given, dict):
        problems.append(document.problem(("noise",), "expected a mapping such as {depth: 0.05 m}"))
        return {}
    stated = {}
    for key, text in given.items():
        if key not in units:
            problems.append(document.problem(("noise", key), f"unknown noise; expected one of {', '.join(units)}"))
            continue
        value = read_quantity(document, ("noise", key), text, units[key], problems)
        if value is not None and value <= 0.0:
            problems.append(document.problem(("noise", key), f"given {text}, expected more than 0"))
        elif value is not None:
            stated[key] = value
    return stated


def read_quantity(
    document: Document, path: tuple[str | int, ...], text: Any, unit: str, problems: list[Problem]
) -> float | None:
    """Read one quantity of ``dataset.yaml``; on failure add to `problems` and return None."""
    try:
        return parse_number_with_unit(text, unit)
    except QuantityError as problem:
        problems.append(document.problem(path, str(problem)))
        return None


def _read_table(
    path: Path, text: tuple[str, ...], numeric: tuple[str, ...]
) -> tuple[pd.DataFrame, tuple[str, ...], tuple[Problem, ...]]:
    shown = str(path)
    if not path.is_file():
        raise InputError([Problem("no such file", shown)])
    if path.stat().st_size > MAX_BYTES:
        raise InputError([Problem(f"is larger than {MAX_BYTES / 1e9:g} GB", shown, hint="split it, or thin it")])
    known = {*text, *numeric, "ok"}
    try:
        header = pd.read_csv(path, nrows=0, encoding="utf-8-sig", skipinitialspace=True)
        extra = [column for column in header.columns if column not in known]
        options: dict[str, Any] = {
            "encoding": "utf-8-sig",
            "usecols": lambda column: column in known,
            "skipinitialspace": True,
            "na_values": list(_MISSING),
            "keep_default_na": False,
            "skip_blank_lines": False,
        }
        table = _floats_or_words(path, options, text)
    except UnicodeDecodeError as error:
        raise InputError([Problem(f"is not UTF-8 text (byte {error.start})", shown)]) from None
    except pd.errors.EmptyDataError:
        raise InputError([Problem("is empty; expected a header row and data", shown)]) from None
    except pd.errors.ParserError as error:
        raise InputError([Problem(f"is not a table: {error}", shown)]) from None
    table.index = pd.RangeIndex(2, len(table) + 2)
    table = table.dropna(how="all")
    notices = [f"{path.name}: columns not used: {', '.join(extra)}"] if extra else []
    table, problems = _numbers(table, text, shown)
    if "ok" in table:
        left_out = int((table["ok"] == 0).sum())
        table = table[table["ok"] != 0].drop(columns="ok")
        if left_out:
            notices.append(f"{path.name}: {left_out} rows left out as marked (ok = 0)")
    return table, tuple(notices), tuple(problems)


def _floats_or_words(path: Path, options: dict[str, Any], text: tuple[str, ...]) -> pd.DataFrame:
    """Read numbers as floats at once; only a file with bad cells is read again as words."""
    as_words = dict.fromkeys(text, str)
    header = pd.read_csv(path, nrows=0, encoding=options["encoding"], skipinitialspace=True)
    as_floats = {column: float for column in header.columns if column not in as_words and options["usecols"](column)}
    try:
        table: pd.DataFrame = pd.read_csv(path, dtype={**as_words, **as_floats}, **options)
    except ValueError as error:
        if isinstance(error, UnicodeDecodeError):
            raise
        table = pd.read_csv(path, dtype=str, **options)
    return table


def _numbers(table: pd.DataFrame, text: tuple[str, ...], shown: str) -> tuple[pd.DataFrame, list[Problem]]:
    """Turn the columns that are not text into floats; name the first bad cells of each column, count the rest."""
    problems: list[Problem] = []
    converted: dict[Any, Any] = {}
    for column in table.columns:
        if column in text:
            converted[column] = table[column].astype(object).where(table[column].notna(), "").astype(str).str.strip()
            continue
        numbers = pd.to_numeric(table[column], errors="coerce").astype(float)
        bad = (numbers.isna() & table[column].notna()) | np.isinf(numbers)
        for line in table.index[bad][:SHOWN]:
            problems.append(Problem(f"given {table.at[line, column]!r}, expected a number", shown, int(line), column))
        if bad.sum() > SHOWN:
            problems.append(Problem(f"{int(bad.sum()) - SHOWN} more cells are no numbers", shown, key=column))
        converted[column] = numbers.where(~bad)
    return pd.DataFrame(converted, index=table.index), problems


def problems_of(raw: RawDataset, required: Iterable[str]) -> list[Problem]:
    """Give the problems so far of a CSV that has the columns required.

    Raises
    ------
    InputError
        When it lacks some: nothing more can be looked for then.
    """
    missing = []
    for column in required:
        if column not in raw.table:
            close = get_close_matches(column, [str(name) for name in raw.table.columns], n=1)
            missing.append(Problem("column is missing", raw.file, 1, column, f"is it {close[0]}?" if close else ""))
    if missing:
        raise InputError([*missing, *raw.problems])
    return list(raw.problems)
