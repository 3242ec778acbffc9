"""Data set folders: `dataset.yaml`, checked against a schema, and its CSV, with every problem of both at once.

Read then `table` (a CSV), then a kind: `legs`, `dives`, `summaries` or `tank`; `records` are what was measured.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Generic, TypeVar

import pandas as pd
from pydantic import BeforeValidator, Field, ValidationError
from typing_extensions import Doc

from missionplan.datasets.table import Columns, CsvTable, read_table
from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.mission.documents import Document, load_document
from missionplan.mission.schema import DatasetSchema, FileSection
from missionplan.mission.validation_errors import validation_problems
from missionplan.store.folder import is_file, real_path


def _as_text(value: object) -> object:
    """Take a number or a date for the text it is written as."""
    return str(value).strip() if isinstance(value, str | int | float | date) else value


Text = Annotated[str, BeforeValidator(_as_text)]


class DatasetSettings(FileSection):
    """Keys that ``dataset.yaml`` has for every kind; `runs` says what differed from the mission, run by run."""

    kind: Annotated[str, Doc("what was measured")]
    file_schema: DatasetSchema = Field(default="missionplan/dataset/1", alias="schema")
    name: Annotated[Text, Doc("name of the data set, for reports"), Field(examples=["sea trial"])] = ""
    file: Annotated[str, Doc("the CSV beside it"), Field(examples=["legs.csv"])]
    source: Annotated[Text, Doc("where the data are from"), Field(examples=["log of 12 June 2025"])] = ""
    runs: Annotated[
        Mapping[str, object], Doc("what differed from the mission, run by run"), Field(examples=[{"1": {}}])
    ] = {}


S_co = TypeVar("S_co", bound=DatasetSettings, covariant=True)


@dataclass(frozen=True)
class DatasetFormat(Generic[S_co]):
    """A kind of data set: its name, the schema of its ``dataset.yaml`` and the columns of its CSV."""

    kind: str
    settings: type[S_co]
    columns: Columns


@dataclass(frozen=True)
class RawDataset(Generic[S_co]):
    """A data set as read, before it is turned into legs, dives or curves."""

    name: str
    source: str
    file: str
    """As in ``dataset.yaml`` (the name by default the folder's); the CSV as messages name it."""
    document: Document
    """``dataset.yaml`` with its line marks."""
    table: pd.DataFrame
    """Rows of the CSV, indexed by line."""
    notices: tuple[str, ...]
    """Treatments the reader should know of."""
    settings: S_co | None
    """Keys of ``dataset.yaml``; None where something is wrong with them."""
    problems: tuple[Problem, ...]
    """Of both files; see `checked`."""

    def checked(self, problems: Iterable[Problem] = ()) -> S_co:
        """Return the settings of a data set with which nothing is wrong.

        `problems`: further ones, of what the rows say. Raises InputError: all problems of the folder at once.
        """
        all_problems = [*self.problems, *problems]
        if all_problems or self.settings is None:
            raise InputError(all_problems)
        return self.settings


def load_dataset_document(folder: Path) -> Document:
    """Load ``dataset.yaml``.

    Raises InputError when there is none, or it is no mapping.
    """
    if is_file(folder):
        raise InputError([Problem("is a file; a data set is a folder with dataset.yaml", str(folder))])
    document = load_document(folder / "dataset.yaml")
    if not isinstance(document.data, dict):
        raise InputError([document.problem((), "expected keys such as kind:, name: and file:")])
    return document


def dataset_files(folder: Path) -> tuple[Path, ...]:
    """Return the files of a data set: ``dataset.yaml`` and each that one of its values names.

    Raises InputError when there is no ``dataset.yaml``, or it is no mapping.
    """
    files, left = [folder / "dataset.yaml"], list(load_dataset_document(folder).data.values())
    while left:
        value = left.pop()
        if isinstance(value, dict | list):
            left += value.values() if isinstance(value, dict) else value
        elif isinstance(value, str) and value.strip() and is_file(folder / value.strip()):
            files.append(folder / value.strip())
    return tuple(files)


def dataset_kind(folder: Path, kinds: Iterable[str]) -> str:
    """Return the kind of a data set, from its ``dataset.yaml`` alone.

    `kinds`: kinds that are expected. Raises InputError when the file is missing or its kind is none of these.
    """
    return _checked_kind(load_dataset_document(folder), tuple(kinds))


def _checked_kind(document: Document, kinds: tuple[str, ...]) -> str:
    expected = f"expected {'one of ' if len(kinds) > 1 else ''}{', '.join(kinds)}"
    kind = document.data.get("kind")
    if kind is None:
        raise InputError([document.problem(("kind",), f"missing; {expected}")])
    if kind not in kinds:
        hint = did_you_mean(str(kind), kinds)
        raise InputError([document.problem(("kind",), f"given {shown(kind)}, {expected}", hint)])
    return str(kind)


def read_dataset(folder: Path, form: DatasetFormat[S_co]) -> RawDataset[S_co]:
    """Read a data set folder.

    `form`: of the kind that is expected. Raises InputError when it is of another kind or holds no table with the
    columns of that kind: all problems at once.
    """
    document = load_dataset_document(folder)
    _checked_kind(document, (form.kind,))
    problems: list[Problem] = []
    settings = _settings(document, form.settings, problems)
    table = read_named_table(folder, document, ("file",), form.columns, problems)
    if table is None:
        raise InputError(problems)
    name = (settings.name if settings else "") or folder.resolve().name
    source = settings.source if settings else ""
    return RawDataset(name, source, table.file, document, table.rows, table.notices, settings, tuple(problems))


def _settings(document: Document, model: type[S_co], problems: list[Problem]) -> S_co | None:
    """Check the keys of ``dataset.yaml``; one without a value counts as not given."""
    values = {key: value for key, value in document.data.items() if value is not None}
    try:
        return model.model_validate(values)
    except ValidationError as error:
        problems += validation_problems(error, document, model)
        return None


_outside_allowed: ContextVar[bool] = ContextVar("outside_allowed", default=False)


@contextmanager
def files_outside(*, allowed: bool) -> Iterator[None]:
    """Let tables lie outside of their data set's folder, by their name or by a link, while the context lasts."""
    before = _outside_allowed.set(allowed)
    try:
        yield
    finally:
        _outside_allowed.reset(before)


def read_named_table(
    folder: Path, document: Document, key: tuple[str, ...], columns: Columns, problems: list[Problem]
) -> CsvTable | None:
    """Read the CSV that ``dataset.yaml`` names at a key path; None, and problems are added, where it cannot be read."""
    name: object = document.data
    for part in key:
        name = name.get(part) if isinstance(name, dict) else None
    if not isinstance(name, str):  # as the schema reports
        return None
    if not name.strip() or "\0" in name:
        problems.append(document.problem(key, f"given {shown(name)}, expected the name of a CSV file in this folder"))
        return None
    path = folder / name.strip()
    if not _outside_allowed.get() and not real_path(path).is_relative_to(real_path(folder)):
        message = f"given {shown(name)}, which lies outside the data set's folder"
        problems.append(document.problem(key, message, "allow_outside=True permits it"))
        return None
    try:
        table = read_table(path, columns)
    except InputError as error:
        problems += error.problems
        return None
    problems += table.problems
    return table
