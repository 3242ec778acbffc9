"""Files on disk: the reports made so far; report folders, and checkpoints of finished blocks of trials."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.moments import moment_or_none
from missionplan.store.folder import as_path, is_folder

_MAX_DEPTH = 4
"""Folders below the root in which reports are looked for."""
_MAX_BYTES = 64_000_000


@dataclass(frozen=True)
class ReportEntry:
    """A report."""

    folder: Path
    command: str
    mission: str
    created: datetime | None
    """UTC; None where the summary does not say."""
    answer: str
    """What to do, as its decision says; why it cannot be read, where it cannot."""

    @property
    def page(self) -> Path:
        """The page to open."""
        return self.folder / "report.html"


def reports(root: str | Path = "reports") -> tuple[ReportEntry, ...]:
    """List the reports in a folder and below, the newest first.

    `root`: where studies write their reports by default.

    Raises
    ------
    InputError
        When there is no such folder.
    """
    root = as_path(root, "root")
    if not is_folder(root):
        raise InputError([Problem("no such folder of reports", str(root), hint="root names another")])
    entries = [_entry(folder) for folder in _folders(root, _MAX_DEPTH)]
    return tuple(sorted(entries, key=lambda entry: (_time(entry), str(entry.folder)), reverse=True))


def _folders(folder: Path, depth: int) -> Iterator[Path]:
    if (folder / "summary.json").is_file() and (folder / "report.html").is_file():
        yield folder
    elif depth:
        for inner in sorted(folder.iterdir()):
            if inner.is_dir() and not inner.is_symlink() and not inner.name.startswith("."):
                yield from _folders(inner, depth - 1)


def _entry(folder: Path) -> ReportEntry:
    try:
        summary = json.loads(_text(folder / "summary.json"))
    except (OSError, ValueError, RecursionError) as error:
        return ReportEntry(folder, "", "", None, f"cannot be read: {error}")
    if not isinstance(summary, dict):
        return ReportEntry(folder, "", "", None, "its summary.json is none of missionplan's")
    decision = summary.get("decision")
    answer = str(decision.get("do", "")) if isinstance(decision, dict) else ""
    mission = summary.get("mission") or summary.get("file") or ""
    created = moment_or_none(summary.get("created_utc"))
    return ReportEntry(folder, str(summary.get("command", "")), str(mission), created, answer)


def _time(entry: ReportEntry) -> float:
    return entry.created.timestamp() if entry.created else 0.0


def _text(path: Path) -> str:
    if path.stat().st_size > _MAX_BYTES:
        raise ValueError(f"{path.name} is larger than {_MAX_BYTES / 1e6:g} MB")
    return path.read_text(encoding="utf-8")
