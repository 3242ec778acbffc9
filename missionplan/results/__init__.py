"""Results of the studies as frozen data classes; their base: provenance, a summary, tables, saving as a report folder.

Every module holds the result of one study; those from measurements are `learned`; those that one study alone reads lie
with it.
"""

import csv
import io
import json
import math
import platform
import threading
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import yaml

from missionplan.errors import InputError, Problem
from missionplan.identity import Identity, how_to_install, version_of
from missionplan.montecarlo.posterior import FILE, PosteriorFile
from missionplan.rendering import Plots, presenter, render
from missionplan.results.decision import ROWS_OF_COMMAND, Assumption, CheckedRange, Coverage, Decision, changes_of
from missionplan.results.entries import Entry, Record, summary_of
from missionplan.store.folder import as_path, check_holds_no_input, new_folder, write_atomically

if TYPE_CHECKING:  # workers import this module: pandas takes half a second
    import pandas as pd
    import xarray

_rendering = threading.Lock()
"""Figures are drawn one at a time: Matplotlib is not made for threads."""
SCHEMA = "missionplan/summary/1"
"""Of `summary.json`: the number goes up when a key changes its meaning or goes."""
_SAID_OTHERWISE = ("dataset", "datasets", "folder", "precision", "trials_run")
"""Options whose contents are among the inputs, or that only chose the number of trials, which is."""
_LIBRARIES = ("numpy", "scipy", "pandas", "matplotlib", "joblib", "pydantic", "pint")


@dataclass(frozen=True)
class Provenance(Record):
    """Where a result comes from: enough to reproduce it."""

    command: Annotated[str, Entry("name of the study on the command line")]
    mission: Annotated[str, Entry("the mission's name")]
    file: Annotated[str, Entry("mission file, as given")]
    seed: Annotated[int, Entry("of the Monte Carlo")] = 0
    trials: Annotated[int, Entry("of the Monte Carlo; zero where none were run")] = 0
    options: Annotated[Mapping[str, object], Entry("the study's options")] = field(default_factory=dict)
    elapsed_s: Annotated[float, Entry("wall time of the study [s]", digits=3)] = field(kw_only=True)
    data: Mapping[str, object] = field(default_factory=dict)
    """The mission file's data with includes in place."""
    notices: Annotated[
        tuple[str, ...], Entry("notes on the input: truncated distributions, values outside a model's range")
    ] = ()
    inputs: Mapping[str, object] = field(default_factory=dict)
    """What it depends on: plain data and digests of files by what they are; default: `data`."""
    holds: Annotated[
        tuple[Coverage, ...],
        Entry("what a probability of success holds of the world, and what not", key="probability_holds"),
    ] = ()
    checked: Annotated[
        tuple[CheckedRange, ...],
        Entry("quantities of the mission beside the ranges in which the models were checked", key="checked_ranges"),
    ] = ()
    created: datetime = field(default_factory=lambda: datetime.now(UTC))
    """When the study ended, UTC."""

    @cached_property
    def identity(self) -> Identity:
        """What the result depends on; not the paths by which it was named, nor where blocks were computed."""
        options = {name: value for name, value in self.options.items() if name not in _SAID_OTHERWISE}
        kept = {"command": self.command, **options, "trials": self.trials}
        return Identity.of(self.inputs or {"data": self.data}, kept, self.seed)

    @property
    def schema(self) -> Annotated[str, Entry()]:
        """Name and version of the schema that the summary follows."""
        return SCHEMA

    @property
    def rests_on(self) -> Annotated[tuple[str, ...], Entry()]:
        """Rows of docs/validation on which the answer rests: ``python -m validation ID`` measures one again."""
        rare = " --rare" if "rare" in self.options else ""
        return ROWS_OF_COMMAND.get(f"{self.command}{rare}", ROWS_OF_COMMAND.get(self.command, ()))

    @property
    def version(self) -> Annotated[str, Entry()]:
        """Version of missionplan."""
        return version_of("missionplan")

    @property
    def created_utc(self) -> Annotated[str, Entry()]:
        """When the study ended, UTC (ISO 8601)."""
        return self.created.isoformat(timespec="seconds")

    @property
    def python(self) -> Annotated[str, Entry()]:
        """Version of Python."""
        return platform.python_version()

    @property
    def libraries(self) -> Annotated[Mapping[str, str], Entry()]:
        """Versions of the libraries that numbers may depend on."""
        return {name: version_of(name) for name in _LIBRARIES}

    @property
    def digest(self) -> Annotated[str, Entry(key="identity")]:
        """Hash of all that the result depends on."""
        return self.identity.digest

    @property
    def identity_parts(self) -> Annotated[Mapping[str, object], Entry()]:
        """What that hash is computed from."""
        return self.identity.parts()


OF_THE_RUN = frozenset(
    {
        *("schema", "version", "probability_holds", "checked_ranges", "rests_on", "options", "elapsed_s", "file"),
        *("created_utc", "python", "libraries", "notices", "identity", "identity_parts"),
    }
)
"""Keys of a summary that tell of the run and not of its answer."""


def without_run(summary: Mapping[str, object]) -> dict[str, object]:
    """Return what of a summary is its answer: the same for runs of one identity."""
    return {key: value for key, value in summary.items() if key not in OF_THE_RUN}


class Result(Record, ABC):
    """A study's answer. Subclasses are frozen data classes with a field `provenance`."""

    report: ClassVar[str]
    """Module that renders the result (`report.render.ReportModule`), imported when it is shown."""
    provenance: Provenance

    def summary(self) -> dict[str, object]:
        """Return the contents of `summary.json`: SI values, keys that end with the unit."""
        entries = {**self.provenance.summary(), **summary_of(self)}
        other = entries.get("decision")
        decision = {**self.decision_for_crew().summary(), **(other if isinstance(other, Mapping) else {})}
        return {**entries, "decision": decision}

    @property
    def judged(self) -> "Result | None":
        """The mission with what is recommended, simulated with fresh draws; None where nothing was judged."""
        return None

    @property
    def certainty(self) -> Mapping[str, object] | None:
        """How sure the answer is, as the entry ``sure`` of its decision: a probability; None where none is told."""
        return None if self.judged is None else self.judged.certainty

    @property
    def assumed(self) -> tuple[Assumption, ...]:
        """What the answer takes for granted, as far as its worth was computed."""
        return () if self.judged is None else self.judged.assumed

    @property
    def recommended_values(self) -> Mapping[str, object]:
        """Values by key path that the mission is to have."""
        return {}

    def decision_for_crew(self) -> Decision:
        """Return what to do, how sure that is, on which assumptions, and what changes in the mission."""
        made = self.provenance
        return Decision(
            presenter().headline(self),
            self.certainty,
            self.assumed,
            changes_of(made.data, self.recommended_values),
            tuple(coverage.what for coverage in made.holds if not coverage.held),
        )

    @abstractmethod
    def to_frame(self) -> "pd.DataFrame":
        """The study's main table."""

    @abstractmethod
    def files(self) -> dict[str, str | bytes]:
        """Tables and other files of the report folder, by name."""

    def __init_subclass__(cls) -> None:
        """Keep the text of one screen: a data class would write out every field."""
        super().__init_subclass__()
        cls.__repr__ = Result.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        return presenter().text(self)

    def _repr_html_(self) -> str:
        with _rendering:
            return presenter().notebook(self)

    @property
    def plot(self) -> "Plots":
        """Plots of the result: ``result.plot()`` is the main one, ``dir(result.plot)`` names the others."""
        return Plots(self)

    def save(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the report folder: `report.html`, `summary.json`, `mission.yaml`, `figures/` and the tables.

        Parameters
        ----------
        folder : str or Path
            The report folder; it must be absent or empty.
        force : bool
            Overwrite files of the same names.

        Raises
        ------
        InputError
            When the folder is not empty and `force` is not given, or the mission file lies in it.
        RunError
            When the folder cannot be written.
        """
        folder = as_path(folder, "folder")
        check_holds_no_input(folder, [Path(self.provenance.file)] if self.provenance.file else ())
        with _rendering:
            rendered = render(self)
        contents: dict[str, str | bytes] = {
            "report.html": rendered.html,
            "summary.json": to_json(self.summary()),
            **mission_files(self.provenance.data),
            **{f"figures/{name}.svg": svg for name, svg in rendered.figures.items()},
            **self.files(),
            **rendered.files,
        }
        with new_folder(folder, force=force) as temporary:
            for name, content in contents.items():
                write_atomically(temporary / name, content)
        return folder


def to_json(summary: Mapping[str, object], *, ascii_only: bool = False) -> str:
    """Write a summary as JSON; a number that is not finite becomes null."""
    return json.dumps(_plain(summary), indent=2, ensure_ascii=ascii_only, allow_nan=False) + "\n"


def to_yaml(data: Mapping[str, object]) -> str:
    """Write a mission's data as YAML, keys in the order of the file."""
    return yaml.safe_dump(_plain(data), sort_keys=False, allow_unicode=True, width=120)


def mission_files(data: Mapping[str, object]) -> dict[str, str | bytes]:
    """Write a mission's data as ``mission.yaml``, with the draws that it names beside it."""
    learned = data.get("posterior")
    draws: dict[str, str | bytes] = {FILE: learned.content} if isinstance(learned, PosteriorFile) else {}
    return {"mission.yaml": to_yaml(data), **draws}


def to_grid(frame: "pd.DataFrame", dimensions: Sequence[str], unit: Mapping[str, str]) -> "xarray.Dataset":
    """Arrange a table whose rows are the cells of a grid as arrays.

    `dimensions`: columns that tell the cells apart. `unit`: unit of each column, written to its attribute ``units``.
    Raises InputError when xarray is not installed.
    """
    try:
        import_module("xarray")
    except ImportError as error:
        raise InputError([Problem("needs xarray", key="to_xarray", hint=how_to_install("netcdf"))]) from error
    grid = frame.set_index(list(dimensions)).to_xarray()
    for name, words in unit.items():
        if name in grid.variables:
            grid[name].attrs["units"] = words
    return grid


def to_csv(table: "pd.DataFrame | Sequence[Mapping[str, object]]") -> str:
    """Write a table, or its rows, as CSV without an index; text that a spreadsheet would compute gets a quote in front.

    Rows need no pandas, which takes as long to import as a small study to run.
    """
    if isinstance(table, Sequence):
        columns = list(table[0]) if table else []
        rows = [[row[name] for name in columns] for row in table]
    else:
        columns, rows = list(map(str, table.columns)), table.astype(object).to_numpy().tolist()
    written = io.StringIO()
    lines = csv.writer(written, lineterminator="\n")
    lines.writerow(map(_no_formula, columns))
    lines.writerows(map(_cell, row) for row in rows)
    return written.getvalue()


def _cell(value: object) -> object:
    """Write a cell: nothing for what is missing, and numbers with all their digits."""
    if hasattr(value, "item"):
        value = value.item()
    if value is None or type(value).__name__ in ("NAType", "NaTType") or (isinstance(value, float) and value != value):
        return ""
    return repr(value) if isinstance(value, float) else _no_formula(value)


def _no_formula(cell: object) -> object:
    if not isinstance(cell, str) or not cell.startswith(("=", "+", "-", "@", "\t", "\r")):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def _plain(value: object) -> object:
    """Mappings, lists and numbers that JSON and YAML can hold; None for a number that is not finite."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
