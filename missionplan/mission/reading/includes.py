"""Files that a mission file names: vehicle, rates, tide and posterior, put in their places, and other paths."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from missionplan.errors import InputError, KeyPath, Problem, did_you_mean, shown
from missionplan.mission.reading.documents import Document, load_document, nearest_file
from missionplan.mission.reading.posterior import WITHOUT, problem_of_section, read_posterior
from missionplan.montecarlo.posterior_file import DamagedPosteriorError, PosteriorFile
from missionplan.store.folder import is_file, matching, real_path

CLASSES = Path(__file__).parents[2] / "starter" / "reliability"
"""Starter values of `vehicle.reliability`, a file for each class of vehicle."""
REMOTE = ("http://", "https://", "dods://")
"""Beginnings of addresses that are read over the network (OPeNDAP)."""


def include_files(document: Document, folder: Path, *, allow_outside: bool) -> list[Problem]:
    """Put the files of the vehicle and the tide in their places and resolve the path of the current's file.

    Parameters
    ----------
    document : Document
        Of a mission; changed.
    folder : Path
        To which paths are relative.
    allow_outside : bool
        Whether files may lie outside the folder's tree.

    Returns
    -------
    list of Problem
        A vehicle with a problem is taken out of the document.
    """
    files = _Files(document, folder, allow_outside)
    vehicle = document.data.get("vehicle")
    if isinstance(vehicle, str) and not files.include(vehicle, ("vehicle",)):
        del document.data["vehicle"]
    _include_reliability(document.data, files, Path(vehicle).parent if isinstance(vehicle, str) else Path())
    if "posterior" in document.data and not files.draw(document.data["posterior"]):
        del document.data["posterior"]
    site = document.data.get("site")
    if isinstance(site, dict):
        _resolve_site(site, files)
    return files.problems


def _include_reliability(data: dict[str, Any], files: "_Files", beside: Path) -> None:
    """Put the starter values of a class of vehicle, or a file beside the vehicle's, in the place of their name."""
    vehicle, path = data.get("vehicle"), ("vehicle", "reliability")
    name = vehicle.get("reliability") if isinstance(vehicle, dict) else None
    if not isinstance(name, str):
        return
    if (starter := CLASSES / f"{name}.yaml").is_file():
        files.document.graft(path, load_document(starter, f"reliability of {name}"))
    elif Path(name).suffix:
        if not files.include(str(beside / name), path):
            del data["vehicle"]["reliability"]
    else:
        known = sorted(each.stem for each in CLASSES.glob("*.yaml"))
        message = f"given {shown(name)}, expected a list of hazards, a file of one, or {', '.join(known)}"
        files.refuse(path, message, did_you_mean(name, known))
        del data["vehicle"]["reliability"]


def _resolve_site(site: dict[str, object], files: "_Files") -> None:
    """Resolve the paths of the site's files, and put that of the tide in its place."""
    chart, wind, current = site.get("chart"), site.get("wind"), site.get("current")
    if isinstance(chart, str):
        site["chart"] = str(files.resolve(chart, ("site", "chart")) or chart)
    if isinstance(wind, dict) and isinstance(wind.get("file"), str):
        wind["file"] = files.resolve_many(wind["file"], ("site", "wind", "file")) or wind["file"]
    for key in ("bathymetry", "land", "keep_out", "tide_height"):
        section = site.get(key)
        if isinstance(section, dict) and isinstance(section.get("file"), str):
            section["file"] = str(files.resolve(section["file"], ("site", key, "file")) or section["file"])
    if isinstance(current, dict):
        _resolve_current(current, files)
        if isinstance(current.get("tide"), str) and not files.include(current["tide"], ("site", "current", "tide")):
            del site["current"]


def _resolve_current(current: dict[str, object], files: "_Files") -> None:
    """Resolve the path of a current's file, or of each member of an ensemble."""
    path, given = ("site", "current", "file"), current.get("file")
    if isinstance(given, str):
        current["file"] = files.resolve_many(given, path) or given
    elif isinstance(given, list):
        names = [(name, (*path, index)) for index, name in enumerate(given)]
        current["file"] = [(isinstance(name, str) and files.resolve_many(name, at)) or name for name, at in names]


@dataclass
class _Files:
    """Files that a document may name, and the problems with those that it names."""

    document: Document
    folder: Path
    allow_outside: bool
    problems: list[Problem] = field(default_factory=list)

    def include(self, name: str, path: KeyPath) -> bool:
        """Put a file's document in the place of its name; False where that cannot be done."""
        target = self.resolve(name, path)
        if target is None:
            return False
        try:
            self.document.graft(path, load_document(target, str(self.folder / name)))
        except InputError as error:
            self.problems += error.problems
            return False
        return True

    def draw(self, section: object) -> bool:
        """Put the posterior that the mission names in its place; False where that cannot be done."""
        if isinstance(section, PosteriorFile):
            return True
        wrong = problem_of_section(section)
        if wrong is not None or not isinstance(section, dict):
            path, message, hint = wrong or ((), "is no mapping", "")
            self.refuse(("posterior", *path), message, hint)
            return False
        target = self.resolve(section["file"], ("posterior", "file"))
        if target is None:
            return False
        try:
            found = read_posterior(target, section, self.document.data.get("learned_from"))
        except DamagedPosteriorError as error:
            self.refuse(("posterior", "file"), f"{section['file']} {error}", WITHOUT)
            return False
        self.document.data["posterior"] = found
        return True

    def resolve_many(self, name: str, path: KeyPath) -> str | None:
        """Absolute path of a file or a pattern of files, or an address; None where none may be read."""
        if name.startswith(REMOTE):
            return name
        if "*" not in name or "\0" in name:
            target = self.resolve(name, path)
            return None if target is None else str(target)
        pattern = real_path((self.folder / name).parent) / Path(name).name
        if not self.allow_outside and not pattern.is_relative_to(real_path(self.folder)):
            message = f"given {shown(name)}, which lies outside the mission file's folder"
            self.refuse(path, message, "allow_outside=True permits it")
            return None
        if not matching(str(pattern)):
            self.refuse(path, f"given {shown(name)}; no file is named like that")
            return None
        return str(pattern)

    def resolve(self, name: str, path: KeyPath) -> Path | None:
        """Absolute path of a file that the document names at `path`; None where it may not be read."""
        given = f"given {shown(name)}"
        if "\0" in name:
            self.refuse(path, f"{given}; a file name cannot contain a null character")
            return None
        target = real_path(self.folder / name)
        if not self.allow_outside and not target.is_relative_to(real_path(self.folder)):
            message = f"{given}, which lies outside the mission file's folder"
            self.refuse(path, message, "allow_outside=True permits it")
            return None
        if not is_file(target):
            self.refuse(path, f"{given}; there is no such file", nearest_file(target, real_path(self.folder)))
            return None
        return target

    def refuse(self, path: KeyPath, message: str, hint: str = "") -> None:
        """Note why the value at `path` cannot be."""
        self.problems.append(self.document.problem(path, message, hint))
