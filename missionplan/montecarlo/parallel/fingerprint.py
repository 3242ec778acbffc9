"""Which code runs here: workers of a cluster prove that theirs is the same before their numbers are believed."""

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import entry_points, version
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import find_spec

_LIBRARIES = ("numpy", "scipy")
"""Whose versions may change the numbers."""
_PLUGINS = "missionplan.effects"
"""Entry points by which other packages add effects."""


@cache
def fingerprint() -> str:
    """Return versions and digests of the package and of what its numbers depend on.

    These are numpy and scipy (by version), and packages that add effects (by the SHA-256 of their sources, cut to 12
    digits).
    """
    parts = [f"{version('missionplan')}, code {_digest(files('missionplan'))}"]
    parts += [f"{name} {version(name)}" for name in _LIBRARIES]
    packages = {entry.module.partition(".")[0] for entry in entry_points(group=_PLUGINS)}
    parts += [f"effects of {name} {_plugin_digest(name)}" for name in sorted(packages)]
    return ", ".join(parts)


def _plugin_digest(name: str) -> str:
    """Digest of a plug-in's sources, found without running it."""
    try:
        found = find_spec(name)
    except (ImportError, ValueError):
        found = None
    if found is None or not found.origin:
        return "missing"
    is_package = found.submodule_search_locations is not None
    return _digest(files(name)) if is_package else _of_file(found.origin)


def _of_file(path: str) -> str:
    with open(path, "rb") as source:  # noqa: PTH123 - this package knows no paths
        return hashlib.sha256(source.read()).hexdigest()[:12]


def _digest(folder: Traversable) -> str:
    digest = hashlib.sha256()
    for name, source in _sources(folder, ""):
        digest.update(f"{name}\n".encode() + hashlib.sha256(source.read_bytes()).digest())
    return digest.hexdigest()[:12]


def _sources(folder: Traversable, before: str) -> Iterator[tuple[str, Traversable]]:
    """Yield a package's Python files with their paths, in an order that does not depend on the file system."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        name = f"{before}/{entry.name}"
        if entry.is_dir():
            yield from _sources(entry, name)
        elif entry.name.endswith(".py"):
            yield name, entry
