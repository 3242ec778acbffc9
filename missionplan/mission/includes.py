"""Files that a mission file names: vehicle, rates, tide and posterior, put in their places, and other paths.

The draws that a mission names as its `posterior`: read, compared with their hash, and put in their place.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, KeyPath, Problem, did_you_mean, shown
from missionplan.identity import digest_of_files
from missionplan.mission.documents import Document, load_document, nearest_file
from missionplan.mission.schema import invalid
from missionplan.montecarlo.posterior import MOST_BYTES, DamagedPosteriorError, PosteriorFile, sha256
from missionplan.store.folder import is_file, matching, real_path

CLASSES = Path(__file__).parents[1] / "starter" / "reliability"
"""Starter values of `vehicle.reliability`, a file for each class of vehicle."""
REMOTE = ("http://", "https://", "dods://")
"""Beginnings of addresses that are read over the network (OPeNDAP)."""


def include_files(document: Document, folder: Path, *, allow_outside: bool) -> list[Problem]:
    """Put the files of the vehicle and the tide in their places and resolve the path of the current's file.

    `document`: of a mission; changed. `folder`: to which paths are relative. `allow_outside`: whether files may lie
    outside the folder's tree.

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


def with_contents(data: Mapping[str, object], names: Iterable[str]) -> dict[str, object]:
    """Return a mission's data with names and contents' SHA-256 in place of the paths of files that it names.

    Raises InputError when one of the files can no longer be read.
    """
    contents = {name: _by_contents(name) for name in names if not name.startswith(REMOTE)}
    return {key: _replaced(value, contents) for key, value in data.items() if key != "schema"}


def _by_contents(name: str) -> str:
    try:
        return f"{Path(name).name} (SHA-256 {digest_of_files(matching(name))})"
    except OSError as error:
        raise InputError([Problem(f"cannot be read: {error.strerror or error}", name)]) from error


def _replaced(value: object, texts: Mapping[str, str]) -> object:
    """Return plain data with some of its texts replaced."""
    if isinstance(value, Mapping):
        return {key: _replaced(inner, texts) for key, inner in value.items()}
    if isinstance(value, list):
        return [_replaced(inner, texts) for inner in value]
    return texts.get(value, value) if isinstance(value, str) else value


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
        classes = sorted(file.stem for file in CLASSES.glob("*.yaml"))
        message = f"given {shown(name)}, expected a list of hazards, a file of one, or {', '.join(classes)}"
        files.refuse(path, message, did_you_mean(name, classes))
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
    path, file = ("site", "current", "file"), current.get("file")
    if isinstance(file, str):
        current["file"] = files.resolve_many(file, path) or file
    elif isinstance(file, list):
        names = [(name, (*path, index)) for index, name in enumerate(file)]
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
            posterior = read_posterior(target, section, self.document.data.get("learned_from"))
        except DamagedPosteriorError as error:
            self.refuse(("posterior", "file"), f"{section['file']} {error}", WITHOUT)
            return False
        self.document.data["posterior"] = posterior
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
        words = f"given {shown(name)}"
        if "\0" in name:
            self.refuse(path, f"{words}; a file name cannot contain a null character")
            return None
        target = real_path(self.folder / name)
        if not self.allow_outside and not target.is_relative_to(real_path(self.folder)):
            message = f"{words}, which lies outside the mission file's folder"
            self.refuse(path, message, "allow_outside=True permits it")
            return None
        if not is_file(target):
            self.refuse(path, f"{words}; there is no such file", nearest_file(target, real_path(self.folder)))
            return None
        return target

    def refuse(self, path: KeyPath, message: str, hint: str = "") -> None:
        """Note why the value at `path` cannot be."""
        self.problems.append(self.document.problem(path, message, hint))


KEYS = ("file", "sha256", "summary")
SIGMA = ("", "sigma_v")
"""Column of the velocity error's standard deviation."""
WITHOUT = "diagnose again writes it; without `posterior` the mission forgets what it has learned"


def posterior_of(value: object) -> PosteriorFile:
    """Return the posterior of a mission's data, as a pydantic validator does: its file is in its place already."""
    if isinstance(value, PosteriorFile):
        return value
    wrong = problem_of_section(value)
    path, message, _ = wrong or ((), "its draws were not read", "")
    raise invalid(message, path)


def problem_of_section(section: object) -> tuple[KeyPath, str, str] | None:
    """Say what is wrong with the section as written: key path, message, hint; None where nothing is."""
    if not isinstance(section, Mapping):
        return (), f"given {shown(section)}, expected {{file, sha256, summary}} as diagnose writes it", ""
    for key in section:
        if key not in KEYS:
            return (str(key),), "unknown key", did_you_mean(str(key), KEYS)
    for key in KEYS[:2]:
        if not isinstance(section.get(key), str):
            return (key,), "missing" if key not in section else f"given {shown(section[key])}, expected text", ""
    return None


def read_posterior(path: Path, section: Mapping[str, object], learned_from: object) -> PosteriorFile:
    """Read the file of a posterior.

    Raises DamagedPosteriorError when it is damaged, beyond bounds, or not the one that the mission names.
    """
    content = _content(path)
    digest = sha256(content)
    if digest != section["sha256"]:
        raise DamagedPosteriorError(
            f"is damaged, or another mission's: its SHA-256 is {digest[:12]}…, expected {str(section['sha256'])[:12]}…"
        )
    posterior = PosteriorFile(content)
    _check_columns(posterior)
    if posterior.learned_from != hash_of(learned_from):
        raise DamagedPosteriorError("is another mission's: it was not learned from what `learned_from` lists")
    if section.get("summary", posterior["summary"]) != posterior["summary"]:
        raise DamagedPosteriorError(
            "has another summary, which is for reading alone: an effect stated in `effects` goes before the draws"
        )
    return posterior


def read_draws(path: Path) -> PosteriorFile:
    """Read a file of draws by itself.

    Raises DamagedPosteriorError when it cannot be read or is none.
    """
    return PosteriorFile(_content(path))


def _content(path: Path) -> bytes:
    """Read no more of a file than a posterior may have.

    Raises DamagedPosteriorError.
    """
    try:
        with path.open("rb") as stream:
            return stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise DamagedPosteriorError(f"cannot be read: {error.strerror or error}") from error


def hash_of(learned_from: object) -> str:
    """Hash of what a mission has learned from."""
    listed = learned_from if isinstance(learned_from, list | tuple) else ()
    return sha256("\n".join(map(str, listed)).encode())


def _check_columns(posterior: PosteriorFile) -> None:
    """Refuse effects and values that the catalogue does not have."""
    draws = posterior.draws
    for effect in draws.effects:
        if effect not in CATALOGUE:
            raise DamagedPosteriorError(f"has the effect {effect!r}, which is not in the catalogue")
        names = [name for other, name in draws.columns if other == effect]
        if set(names) - set(CATALOGUE[effect].parameters):
            raise DamagedPosteriorError(f"has parameters that {effect} does not have")
    for effect, name in draws.columns:
        values, _ = draws.column((effect, name))
        low, high = (0.0, float("inf"))
        if effect:
            low, high = CATALOGUE[effect].parameters[name].low, CATALOGUE[effect].parameters[name].high
        elif (effect, name) != SIGMA:
            raise DamagedPosteriorError(f"has the column {name!r}, which means nothing here")
        margin = 1e-6 * (1.0 + abs(values).max())
        if values.min() < low - margin or values.max() > high + margin:
            raise DamagedPosteriorError(f"has values of {effect}.{name} out of its range")
