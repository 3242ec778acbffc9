"""What a result depends on: the program with plug-ins and libraries, the contents of its inputs, options and seed.

One identity serves all: finished blocks are used again only by a run of the same, workers of a cluster prove the
program's part of it, every summary states it, and `compare`, `history` and `verify` name in what two of them differ.
"""

import hashlib
import json
import os
import platform
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points, requires, version
from importlib.util import find_spec

PLUGINS = ("missionplan.effects", "missionplan.importers")
"""Entry points by which other packages add code."""


version_of = cache(version)
"""Version of a package that is installed: its metadata are read once."""


class PluginError(Exception):
    """A plug-in cannot be loaded; its words say why."""


def load_plugin(entry: EntryPoint) -> object:
    """Load what an entry point names; what its module prints goes to standard error.

    Raises PluginError: whatever somebody else's code raises, also when it would end the program.
    """
    try:
        with redirect_stdout(sys.stderr):
            return entry.load()
    except (Exception, SystemExit) as error:
        raise PluginError(f"{type(error).__name__}: {error}") from error


def blamed_plugin(error: BaseException) -> str | None:
    """Name the plug-in in whose code an error arose, here or in another process; None where it arose in none."""
    frames = [line for line in "".join(traceback.format_exception(error)).splitlines() if 'File "' in line]
    for entry in (entry for group in PLUGINS for entry in entry_points(group=group)):
        if any(place in frame for place in _places(entry.module.partition(".")[0]) for frame in frames):
            return entry.name
    return None


def _places(package: str) -> list[str]:
    """Return where the code of a package lies: its folders, or its file."""
    spec = find_spec(package)
    if spec is None:
        return []
    return [f'"{folder}/' for folder in spec.submodule_search_locations or ()] or [f'"{spec.origin}"']


def how_to_install(extra: str) -> str:
    """Write the command that installs the libraries of an extra, wherever this package itself came from."""
    needed = [requirement.split(";") for requirement in requires("missionplan") or ()]
    libraries = [name.strip() for name, *marker in needed if f'extra == "{extra}"' in "".join(marker).replace("'", '"')]
    return " ".join(["pip install", *(f"'{library}'" for library in libraries)])


LIBRARIES = ("numpy", "scipy", "pandas", "pint", "gsw", "pyproj", "utide")
"""Whose versions may change the numbers; Python's own sums changed with 3.12."""
_OF_THE_MACHINE = ("jobs", "backend", "scheduler")
"""Options that say where blocks are computed: no number depends on them."""
_SHOWN = 12
"""Digits of a digest in messages."""
_CHUNK = 1 << 20


@dataclass(frozen=True)
class Program:
    """The code that computes numbers."""

    version: str
    """Of this package."""
    code: str
    """SHA-256 of its files."""
    plugins: Mapping[str, str]
    """SHA-256 of the files of each package that adds effects or formats; ``missing`` where there are none."""
    libraries: Mapping[str, str]
    """Versions of Python and of the numerical libraries."""

    def parts(self) -> dict[str, object]:
        """Return its parts as plain data."""
        plugins, libraries = dict(self.plugins), dict(self.libraries)
        return {"version": self.version, "code": self.code, "plugins": plugins, "libraries": libraries}


@cache
def running_program() -> Program:
    """Identify the code of this process, as it was when first asked: a plug-in's is found without running it."""
    entries = [entry for group in PLUGINS for entry in entry_points(group=group)]
    plugins = sorted({entry.module.partition(".")[0] for entry in entries})
    return Program(
        version_of("missionplan"),
        _digest_of_folder(os.path.dirname(__file__)),  # noqa: PTH120 - imported by what knows no paths
        {name: _plugin_digest(name) for name in plugins},
        {"python": ".".join(platform.python_version_tuple()[:2]), **{name: version_of(name) for name in LIBRARIES}},
    )


@dataclass(frozen=True)
class Identity:
    """What a result depends on."""

    inputs: Mapping[str, object]
    """By what they are (``mission``, ``datasets``): plain data, or digests of files."""
    options: Mapping[str, object]
    """Those that a number depends on, the command among them."""
    seed: int | None
    """None where nothing is drawn."""
    program: Program = field(default_factory=running_program)

    @classmethod
    def of(cls, inputs: Mapping[str, object], options: Mapping[str, object], seed: int | None) -> "Identity":
        """Identify a result of this process; options that only say where it is computed are left out."""
        kept = {name: value for name, value in options.items() if name not in _OF_THE_MACHINE}
        return cls(_plain(inputs), _plain(kept), seed, running_program())

    def parts(self) -> dict[str, object]:
        """Return version, code, plug-ins, libraries, inputs (by their digests), options and seed as plain data."""
        inputs = {name: digest_of(value) for name, value in self.inputs.items()}
        return {**self.program.parts(), "inputs": inputs, "options": dict(self.options), "seed": self.seed}

    @property
    def digest(self) -> str:
        """SHA-256 of `parts`."""
        return digest_of(self.parts())

    def whole(self) -> dict[str, object]:
        """Return everything as plain data, inputs as they are, so that a difference can be named."""
        return {**self.program.parts(), "inputs": dict(self.inputs), "options": dict(self.options), "seed": self.seed}

    @classmethod
    def from_whole(cls, data: Mapping[str, object]) -> "Identity":
        """Read what `whole` returned; raises KeyError or TypeError for anything else."""
        made = Program(*(data[key] for key in ("version", "code", "plugins", "libraries")))  # type: ignore[arg-type]
        inputs, options = data["inputs"], data["options"]
        if not all(isinstance(part, dict) for part in (inputs, options, made.plugins, made.libraries)):
            raise TypeError("an identity's parts are mappings")
        return cls(inputs, options, data["seed"], made)  # type: ignore[arg-type]


def digest_of(value: object) -> str:
    """SHA-256 of plain data, keys in their order."""
    return hashlib.sha256(json.dumps(_plain(value), ensure_ascii=True).encode()).hexdigest()


def digest_of_files(paths: Iterable[str | os.PathLike[str]]) -> str:
    """SHA-256 of the contents of files, one after the other.

    Raises OSError when one cannot be read.
    """
    digest = hashlib.sha256()
    for path in paths:
        with open(path, "rb") as file:  # noqa: PTH123 - imported by what knows no paths
            while chunk := file.read(_CHUNK):
                digest.update(chunk)
    return digest.hexdigest()


def differences(before: Mapping[str, object], now: Mapping[str, object]) -> list[str]:
    """Name in what the parts of two programs or identities differ (also as `Identity.whole`), a line each."""
    old, new = dict(leaves(before)), dict(leaves(now))
    paths = [path for path in dict.fromkeys((*old, *new)) if old.get(path) != new.get(path)]
    lines = [f"{_words(path)}: was {_shown(old, path)}, now {_shown(new, path)}" for path in paths]
    if not lines and digest_of(before) != digest_of(now):
        lines.append("the order of keys in the inputs")
    return lines


def program_part(parts: Mapping[str, object]) -> dict[str, object]:
    """Return what of an identity's parts tells of the program."""
    return {name: parts.get(name) for name in ("version", "code", "plugins", "libraries")}


def leaves(value: object, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    """Yield each value of plain data that holds no others, with the keys that lead to it."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from leaves(inner, (*path, str(key)))
    elif isinstance(value, list | tuple) and value:
        for number, inner in enumerate(value):
            yield from leaves(inner, (*path, f"[{number}]"))
    elif path and value not in ({}, []):
        yield path, value


def _words(path: tuple[str, ...]) -> str:
    first, rest = path[0], path[1:]
    if first in ("code", "version"):
        return f"{first} of missionplan"
    if first in ("plugins", "libraries", "options"):
        kind = {"plugins": "plug-in", "libraries": "library", "options": "option"}[first]
        return " ".join((kind, ".".join(rest).replace(".[", "[")))
    return ".".join(rest if first == "inputs" else path).replace(".[", "[")


def _shown(leaves: Mapping[tuple[str, ...], object], path: tuple[str, ...]) -> str:
    if path not in leaves:
        return "nothing"
    value = leaves[path]
    is_digest = isinstance(value, str) and len(value) == 64 and all(digit in "0123456789abcdef" for digit in value)
    return str(value)[:_SHOWN] if is_digest else str(value)


def _plain(value: object) -> dict[str, object]:
    """Return a value as JSON gives it back: what is read from a file and what was written there are equal."""
    plain: dict[str, object] = json.loads(json.dumps(value, default=_jsonable))
    return plain


def _jsonable(value: object) -> object:
    if isinstance(value, Mapping):
        return dict(value)
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _plugin_digest(name: str) -> str:
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        spec = None
    folders = list(spec.submodule_search_locations or ()) if spec is not None else []
    if folders:
        return digest_of([_digest_of_folder(folder) for folder in folders])
    return digest_of_files([spec.origin]) if spec is not None and spec.has_location and spec.origin else "missing"


def _digest_of_folder(folder: str) -> str:
    digest = hashlib.sha256()
    for name, path in _files(folder, ""):
        digest.update(f"{name}\n".encode() + bytes.fromhex(digest_of_files([path])))
    return digest.hexdigest()


def _files(folder: str, before: str) -> Iterator[tuple[str, str]]:
    """Yield a package's files with their paths, in an order that does not depend on the file system."""
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        name = f"{before}/{entry.name}"
        if entry.is_dir():
            yield from _files(entry.path, name) if entry.name != "__pycache__" else ()
        elif not entry.name.endswith((".pyc", ".tmp", "~")) and not entry.name.startswith("."):
            yield name, entry.path
