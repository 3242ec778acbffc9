"""What a reader of logs is: it recognises files of its format and makes a track of them; and which there are."""

import gzip
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import BinaryIO, cast

from missionplan.errors import InputError, Problem, shown
from missionplan.importers.mapping import MappedName
from missionplan.importers.track import Track
from missionplan.packages import PluginError, how_to_install, load_plugin

DAMAGED = (OSError, ValueError, LookupError, EOFError, RuntimeError, ArithmeticError, TypeError, zlib.error)
"""Errors by which libraries say that a file is damaged."""


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

        Parameters
        ----------
        damaged : type
            By which the reader's library says that a file is damaged, besides the usual ones.
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


def needed_module(name: str, extra: str, format_name: str) -> ModuleType:
    """Import a library that a format needs.

    Raises
    ------
    InputError
        When it is not installed: what to install.
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
    found: dict[str, Importer] = {each.name: each for module in modules for each in module.IMPORTERS}
    left_out: list[Problem] = []
    for entry in entry_points(group=_GROUP):
        try:
            importer = load_plugin(entry)
            reason = "" if isinstance(importer, Importer) else "is no Importer"
        except PluginError as error:
            importer, reason = None, f"cannot be loaded: {error}"
        if isinstance(importer, Importer) and importer.name in found:
            reason = f"has the name of another, {shown(importer.name)}"
        if reason or not isinstance(importer, Importer):
            left_out.append(Problem(f"the importer {entry.name} ({entry.value}) is left out: it {reason}"))
        else:
            found = {importer.name: importer, **found}  # asked first: it knows its own files better
    return found, left_out
