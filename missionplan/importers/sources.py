"""Sources of an import: files and folders, each file once, with its checksum and the format it is recognised as."""

import hashlib
import os
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import yaml

from missionplan.errors import InputError, Problem, counted, did_you_mean, shown
from missionplan.importers.importer import DAMAGED, Identity, Importer, head_of
from missionplan.importers.track import Track
from missionplan.results import Provenance
from missionplan.results.imported import SourceEntry
from missionplan.store.folder import check_name, is_file, is_folder

_COMPANIONS = (".cac", ".ccc")
"""Files that others need and that are no logs themselves."""
_UTC = "times without a zone are taken as UTC"
_OF_BAGS = ("metadata.yaml",)
"""Names of such files."""


@dataclass(frozen=True)
class SourceFile:
    """A file that is read: its path and SHA-256."""

    path: Path
    checksum: str


@dataclass(frozen=True)
class Sources:
    """Files of one format, and those passed over with the reason."""

    importer: Importer
    files: tuple[SourceFile, ...]
    passed_over: tuple[Problem, ...]


@dataclass(frozen=True)
class Reading:
    """A track as read, and where it comes from."""

    track: Track
    name: str
    """Of the data set."""
    sources: tuple[SourceEntry, ...]
    passed_over: tuple[str, ...]
    """Files that were not read, with the reason."""
    options: Mapping[str, object]
    """As the report tells them."""
    began: float
    """When the import began, by the performance counter [s]."""

    def provenance(self, mission: str, notices: tuple[str, ...]) -> Provenance:
        """Return the provenance of the result, with the starter mission's data."""
        counted = len(self.passed_over)
        left = (f"{counted} file{'s were' if counted > 1 else ' was'} passed over",) if counted else ()
        all_notices = (*self.track.notices, *notices, *left, _UTC)
        return Provenance(
            "import",
            self.name,
            file="",
            options=self.options,
            elapsed_s=time.perf_counter() - self.began,
            data=yaml.safe_load(mission) if mission else {},
            notices=all_notices,
            inputs={"logs": {source.name: source.sha256 for source in self.sources}},
        )

    @property
    def source(self) -> str:
        """Where the data come from, for ``dataset.yaml``."""
        files = len(self.sources)
        return f"Imported from {files} {self.track.format} log{'s' if files > 1 else ''} by missionplan import."


def find_sources(
    sources: Sequence[Path], importers: Mapping[str, Importer], format_name: str | None, otherwise: str | None = None
) -> Sources:
    """Find the files to read, and what reads them.

    Raises InputError when a source is missing, nothing is recognised, or files of several formats are.

    Parameters
    ----------
    sources : sequence of Path
        Files and folders.
    importers : Mapping
        By name.
    format_name : str or None
        Format of all files; None to recognise it.
    otherwise : str or None
        Format of files of which none is of another: tables whose columns the user names, alone or beside GPX and NMEA.
    """
    if format_name is not None and format_name not in importers:
        hint = did_you_mean(format_name, importers) or f"one of {', '.join(importers)}"
        raise InputError([Problem(f"no format of the name {format_name!r}", key="format", hint=hint)])
    paths = _all_files(sources)
    if not paths:
        raise InputError([Problem("holds no files", str(source)) for source in sources])
    chosen, passed_over = _recognised(paths, sources, importers, format_name)
    if otherwise is not None and chosen.keys() <= {otherwise} and format_name in (None, otherwise):
        chosen, passed_over = _recognised(paths, sources, importers, otherwise, is_mapped=True)
    if not chosen:
        formats = ", ".join(importers)
        message = f"no log of a known format ({formats}) among {counted(len(paths), 'file')}"
        raise InputError(
            [Problem(message, str(sources[0]), hint="name one with --format; track reads tables with --map")]
        )
    if len(chosen) > 1:
        counts = ", ".join(f"{len(files)} of {name}" for name, files in chosen.items())
        raise InputError(
            [Problem(f"logs of several formats: {counts}", str(sources[0]), hint="choose one with --format")]
        )
    name, logs = next(iter(chosen.items()))
    files, repeated = _each_once(logs)
    return Sources(importers[name], tuple(files), (*passed_over, *repeated))


def of_one(batch: Sources, vehicle: str | None, deployment: str | None) -> tuple[Sources, Identity]:
    """Keep the files of one vehicle and deployment; those that tell neither are taken for its own.

    Raises InputError with the list, when files of several are given and none is chosen, or one that is not there.

    `vehicle`, `deployment`: as chosen; a deployment that no file names may be a date, which the caller looks for.
    """
    reader = batch.importer
    owners = {file: _identity(reader.identify, file.path) for file in batch.files}
    is_named = any(one.vehicle for one in owners.values())
    vehicle = _chosen(
        "vehicle", vehicle, {file: owners[file].vehicle for file in owners}, is_open=reader.is_choosing and not is_named
    )
    owners = {file: one for file, one in owners.items() if _same(one.vehicle, vehicle)}
    is_dated = bool(deployment) and not any(one.deployment for one in owners.values())
    named = _chosen("deployment", deployment, {file: owners[file].deployment for file in owners}, is_open=is_dated)
    kept = tuple(file for file, one in owners.items() if _same(one.deployment, named))
    return replace(batch, files=kept), Identity(vehicle, "" if is_dated else named)


def _identity(identify: Callable[[Path], Identity] | None, path: Path) -> Identity:
    try:
        return identify(path) if identify is not None else Identity()
    except DAMAGED:
        return Identity()  # the reader will say what is wrong with it


def _chosen(key: str, wanted: str | None, names: Mapping[SourceFile, str], *, is_open: bool) -> str:
    counts = Counter(name for name in names.values() if name)
    if is_open:
        return ""
    if wanted is not None:
        match = next((name for name in counts if name.lower() == wanted.lower()), None)
        if match is None:
            hint = did_you_mean(wanted, counts) or f"there is {', '.join(counts) or 'none that is named'}"
            raise InputError([Problem(f"no {key} {shown(wanted)} in these files", key=key, hint=hint)])
        return match
    if len(counts) > 1:
        listed = ", ".join(f"{name} ({count} file{'s' if count > 1 else ''})" for name, count in sorted(counts.items()))
        first = sorted(counts)[0]
        message = f"logs of {len(counts)} {key}s: {listed}"
        raise InputError([Problem(message, key=key, hint=f"choose one with --{key}, such as --{key} '{first}'")])
    return next(iter(counts), "")


def _same(name: str, wanted: str) -> bool:
    return not name or not wanted or name == wanted


def _all_files(sources: Sequence[Path]) -> list[Path]:
    """Every file named, and every one below a folder named but those that are hidden."""
    files: list[Path] = []
    problems = []
    for path in sources:
        check_name(str(path))
        if is_file(path):
            files.append(path)
        elif is_folder(path):
            files += sorted(_below(path))
        else:
            hint = did_you_mean(
                path.name, [file.name for file in path.parent.glob("*")] if is_folder(path.parent) else []
            )
            problems.append(Problem("no such file or folder", str(path), hint=hint))
    if problems:
        raise InputError(problems)
    return list(dict.fromkeys(files))


def _below(folder: Path) -> Iterator[Path]:
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(place) / name for name in names if not name.startswith("."))


def _recognised(
    paths: Sequence[Path],
    sources: Sequence[Path],
    importers: Mapping[str, Importer],
    format_name: str | None,
    *,
    is_mapped: bool = False,
) -> tuple[dict[str, list[Path]], list[Problem]]:
    """Sort files by format; with a format given, a file named by itself is read whatever it looks like.

    So is one in a folder where its columns are named (`is_mapped`).
    """
    chosen: dict[str, list[Path]] = {}
    passed_over = []
    for path in paths:
        if path.suffix.lower() in _COMPANIONS or path.name in _OF_BAGS:
            continue
        head, asked = _head(path), [format_name] if format_name else [k for k, v in importers.items() if v.is_guessed]
        name = next((name for name in asked if importers[name].recognises(path, head)), None)
        if name is None and format_name is not None and (path in sources or is_mapped):
            name = format_name
        if name is None:
            wanted = f"no {format_name} log" if format_name else "no log of a known format"
            passed_over.append(Problem(f"passed over: {wanted}", str(path)))
        else:
            chosen.setdefault(name, []).append(path)
    return chosen, passed_over


def _head(path: Path) -> bytes:
    """First bytes of a file; none where it cannot be read."""
    try:
        return head_of(path)
    except (OSError, EOFError, zlib.error):
        return b""


def _each_once(paths: Sequence[Path]) -> tuple[list[SourceFile], list[Problem]]:
    files: dict[str, SourceFile] = {}
    repeated = []
    for path in paths:
        try:
            with path.open("rb") as stream:
                checksum = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            repeated.append(Problem(f"passed over: {error.strerror or error}", str(path)))
            continue
        if checksum in files:
            repeated.append(Problem(f"passed over: the same as {files[checksum].path.name}", str(path)))
        else:
            files[checksum] = SourceFile(path, checksum)
    return list(files.values()), repeated
