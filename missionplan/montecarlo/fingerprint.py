"""Which code runs here: workers of a cluster prove that theirs is the same before their numbers are believed."""

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from importlib.resources.abc import Traversable


@cache
def fingerprint() -> str:
    """Return the package's version and the SHA-256 of its sources, cut to 12 digits."""
    digest = hashlib.sha256()
    for name, source in _sources(files("missionplan"), ""):
        digest.update(f"{name}\n".encode() + hashlib.sha256(source.read_bytes()).digest())
    return f"{version('missionplan')}, code {digest.hexdigest()[:12]}"


def _sources(folder: Traversable, before: str) -> Iterator[tuple[str, Traversable]]:
    """Yield the package's Python files with their paths, in an order that does not depend on the file system."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        name = f"{before}/{entry.name}"
        if entry.is_dir():
            yield from _sources(entry, name)
        elif entry.name.endswith(".py"):
            yield name, entry
