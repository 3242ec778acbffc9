"""What a reader of logs is: it recognises files of its format and makes a track of them; and which there are.

Readings gathered from one file or message after another, in little memory.
"""

import gzip
import math
import zlib
from array import array
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.identity import PluginError, how_to_install, load_plugin
from missionplan.importers.mapping import MappedName
from missionplan.importers.track import Break, Series, Track, clock_jumps, series

DAMAGED = (
    OSError, ValueError, LookupError, EOFError, RuntimeError, ArithmeticError, TypeError, AttributeError, SyntaxError,
    zlib.error,
)  # fmt: skip
"""Errors by which libraries say that a file is damaged, of XML too, or its messages lack a field."""


class PartlyReadError(Exception):
    """A file is damaged from some place on, and what stands before is used."""


@dataclass(frozen=True)
class ReadOptions:
    """What the user says of the sources."""

    names: Mapping[str, MappedName] = field(default_factory=dict)
    """Quantities (`lat`, `time`, ...) and where the source has them."""
    cache: Path | None = None
    """Folder of the sensor lists of Slocum gliders."""
    vehicle: str | None = None
    """To be read where one file holds several."""


@dataclass(frozen=True)
class Identity:
    """Whose log a file is, as far as it or its name says."""

    vehicle: str = ""
    deployment: str = ""
    """Nothing where it is not told."""


@dataclass
class SourceLog:
    """Keeps what became of each file while a reader works."""

    passed_over: list[Problem] = field(default_factory=list)
    """Files that were not read, with the reason."""
    read: list[Path] = field(default_factory=list)
    """Files that were."""
    progress: Callable[[int, int], None] | None = None
    """Called with the number of files done and of all."""
    is_strict: bool = False
    """Whether a damaged file ends the import."""

    def each(self, files: Sequence[Path]) -> Iterator[Path]:
        """Yield the files, with the progress shown."""
        for done, path in enumerate(files):
            if self.progress is not None:
                self.progress(done, len(files))
            yield path
        if self.progress is not None:
            self.progress(len(files), len(files))

    @contextmanager
    def reading(self, path: Path, damaged: type[Exception] = OSError) -> Iterator[None]:
        """Read one file: what goes wrong inside is noted, and the file passed over.

        `damaged` are the types by which the reader's library says that a file is damaged, besides the usual ones.
        """
        try:
            yield
        except InputError:
            raise
        except PartlyReadError as error:
            self.read.append(path)
            self._note(Problem(f"read in part: {error}", str(path)))
        except (*DAMAGED, damaged) as error:
            words = str(error).strip().splitlines() or [type(error).__name__]
            self._note(Problem(f"passed over: {words[0][:200]}", str(path)))
        else:
            self.read.append(path)

    def _note(self, problem: Problem) -> None:
        if self.is_strict:
            raise InputError([problem])
        self.passed_over.append(problem)


@dataclass(frozen=True)
class Importer:
    """A reader of one format. Installed packages add theirs through the entry points `missionplan.importers`."""

    name: str
    """As `--format` names it."""
    describes: str
    """What it reads, in a few words."""
    recognises: Callable[[Path, bytes], bool]
    """From a path and the first bytes of the file to whether it is of this format."""
    read: Callable[[Sequence[Path], ReadOptions, SourceLog], Track]
    """From files, options and a log of what became of each file to a track."""
    is_guessed: bool = True
    """Whether files are read by it without `--format`."""
    identify: Callable[[Path], Identity] | None = None
    """From a path to the vehicle and the deployment that a file is of; may raise as a reader does."""
    is_choosing: bool = False
    """Whether a file may be of several vehicles, of which the reader reads one."""


def unpacked(path: Path) -> BinaryIO:
    """Open a file for reading, through gzip where its name ends so."""
    return cast(BinaryIO, gzip.open(path, "rb")) if path.suffix.lower() == ".gz" else path.open("rb")


_HEAD = 4096
"""Bytes of a file by which it is recognised."""


def head_of(path: Path) -> bytes:
    """First bytes of a file, unpacked where it is packed."""
    with unpacked(path) as stream:
        return bytes(stream.read(_HEAD))


def needed_module(name: str, extra: str, format_name: str) -> ModuleType:
    """Import a library that a format needs.

    Raises InputError when it is not installed: what to install.
    """
    try:
        return import_module(name)
    except ImportError:
        hint = how_to_install(extra)
        message = f"the format {format_name} needs the package {name.partition('.')[0]}, which is not installed"
        raise InputError([Problem(message, hint=hint)]) from None


_GROUP = "missionplan.importers"
_OWN = ("slocum", "seaglider", "trajectory", "textlogs", "imc", "moos", "rosbag", "ardupilot", "track")
"""Modules of `readers`, in the order in which they are asked whether they recognise a file."""


def known_importers() -> tuple[dict[str, Importer], list[Problem]]:
    """Return the importers by name, and why any that an installed package adds is left out."""
    modules = [import_module(f"missionplan.importers.readers.{name}") for name in _OWN]
    importers: dict[str, Importer] = {importer.name: importer for module in modules for importer in module.IMPORTERS}
    left_out: list[Problem] = []
    for entry in entry_points(group=_GROUP):
        try:
            importer = load_plugin(entry)
            reason = "" if isinstance(importer, Importer) else "is no Importer"
        except PluginError as error:
            importer, reason = None, f"cannot be loaded: {error}"
        if isinstance(importer, Importer) and importer.name in importers:
            reason = f"has the name of another, {shown(importer.name)}"
        if reason or not isinstance(importer, Importer):
            left_out.append(Problem(f"the importer {entry.name} ({entry.value}) is left out: it {reason}"))
        else:
            importers = {importer.name: importer, **importers}  # asked first: it knows its own files better
    return importers, left_out


MOST = 400_000
"""Readings that are held of one channel: of more, one in half a second, in a second and so on is kept."""
_FINEST = 0.5


def spaced(t: Array, interval: float) -> NDArray[np.bool_]:
    """Which readings to keep for one in each interval [s]: the first in it that came; they come in any order."""
    keep = np.zeros(len(t), dtype=bool)
    keep[np.unique(np.floor(np.asarray(t) / interval), return_index=True)[1]] = True
    return keep


class ChannelStore:
    """Readings of named channels."""

    def __init__(self) -> None:
        self._parts: dict[str, list[tuple[Array, Array]]] = defaultdict(list)
        self._intervals: dict[str, float] = {}

    def add(self, name: str, t: Array, values: Array) -> None:
        """Add readings of a channel, from one file."""
        if not len(t):
            return
        t, values = np.asarray(t, dtype=float), np.asarray(values)
        if name in self._intervals:
            keep = spaced(t, self._intervals[name])
            t, values = t[keep], values[keep]
        self._parts[name].append((t, values))
        while sum(len(part) for part, _ in self._parts[name]) > MOST:
            self._intervals[name] = 2.0 * self._intervals.get(name, 0.5 * _FINEST)
            kept = [(part, values, spaced(part, self._intervals[name])) for part, values in self._parts[name]]
            self._parts[name] = [(part[keep], values[keep]) for part, values, keep in kept]

    def series(self, name: str, factor: float = 1.0) -> Series:
        """Return a channel's readings in the order of time, times a factor."""
        t, values = self.joined(name)
        return series(t, values * factor)

    def joined(self, name: str) -> tuple[Array, Array]:
        """Times and values of a channel, in the order they were added."""
        parts = self._parts.get(name, [])
        if not parts:
            return np.empty(0), np.empty(0)
        return np.concatenate([t for t, _ in parts]), np.concatenate([values for _, values in parts])

    def at(self, name: str, t: Array) -> Array:
        """Values of a channel at exactly these times; nan where it has none."""
        channel = self.series(name)
        place = np.searchsorted(channel.t, t)
        values = np.full(len(t), np.nan)
        inside = place < len(channel)
        hit = np.flatnonzero(inside)[channel.t[place[inside]] == t[inside]]
        values[hit] = channel.values[place[hit]]
        return values

    def __contains__(self, name: object) -> bool:
        return bool(self._parts.get(str(name)))


class Samples:
    """Readings that come one by one, such as messages; the first column has the times [s]."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._columns = {name: array("d") for name in self._names}
        self._rows = list(self._columns.values())
        self._interval, self._last = 0.0, math.nan

    def add(self, *values: float) -> None:
        """Add one value of each column."""
        if self._interval:
            which = values[0] // self._interval
            if which == self._last:
                return
            self._last = which
        for column, value in zip(self._rows, values, strict=True):
            column.append(value)
        if len(self._rows[0]) > MOST:
            self._thin()

    def _thin(self) -> None:
        """Thin to half of the most: of readings that come in no order of time, those of one interval come apart."""
        while len(self) > MOST // 2:
            keep = spaced(self[self._names[0]], self._interval or _FINEST)
            for name, column in self._columns.items():
                column[:] = array("d", self[name][keep].tobytes())
            self._interval = self._interval or _FINEST
            self._interval *= 2.0 if len(self) > MOST // 2 else 1.0

    def __getitem__(self, name: str) -> Array:
        """Values of a column."""
        return np.array(self._columns[name], dtype=float)

    def __len__(self) -> int:
        return len(self._columns[self._names[0]])


_EXACT = ("t", "lat", "lon", "dr_lat", "dr_lon", "x", "y", "dr_x", "dr_y")
_COARSEST = 64.0
"""Interval to which rows are thinned at most [s]."""


class ColumnStore:
    """Columns of many files; a column that a file lacks is missing there."""

    def __init__(self) -> None:
        self._interval = 0.0
        self._parts: list[dict[str, Array]] = []
        self._joined: dict[str, Array] = {}
        self.breaks: tuple[Break, ...] = ()

    def add(self, columns: dict[str, Array]) -> None:
        """Add the columns of one file, of which `t` has the times since 1970 [s]; rows without a time are left out."""
        t = columns["t"]
        timed = np.isfinite(t)
        part: dict[str, Array] = {  # half of the memory for all but times and positions, which need their digits
            name: values[timed].astype("f8" if name in _EXACT else "f4") for name, values in columns.items()
        }
        self.breaks += tuple(clock_jumps(part["t"]))
        self._parts.append(self._thinned(part))
        while sum(len(part["t"]) for part in self._parts) > MOST and self._interval < _COARSEST:
            self._interval = 2.0 * self._interval if self._interval else _FINEST
            self._parts = [self._thinned(part) for part in self._parts]
        self._joined = {}

    def _thinned(self, part: dict[str, Array]) -> dict[str, Array]:
        """Keep one row in each interval, and those that are marked to be kept."""
        if not self._interval:
            return part
        keep = spaced(part["t"], self._interval)
        if "keep" in part:
            keep |= part["keep"] == 1.0
        return {name: values[keep] for name, values in part.items()}

    def __getitem__(self, name: str) -> Array:
        """Values of a column in the order of time."""
        if not self._joined and self._parts:
            names = dict.fromkeys(name for part in self._parts for name in part)
            times = np.concatenate([part["t"] for part in self._parts])
            order = np.argsort(times, kind="stable")
            for column in names:
                none = (np.full(len(part["t"]), np.nan) for part in self._parts)
                columns = [part.get(column, missing) for part, missing in zip(self._parts, none, strict=True)]
                self._joined[column] = np.concatenate(columns)[order]
            self._parts = []
        return self._joined.get(name, np.full(len(self._joined.get("t", ())), np.nan))
