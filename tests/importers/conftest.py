"""Shared by tests of importers: what installed packages add is looked up once."""

from collections.abc import Iterator
from functools import cache

import pytest

from missionplan.importers import importer


@pytest.fixture(scope="session", autouse=True)
def looked_up_once() -> Iterator[None]:
    """To look through all installed packages takes as long as to read a small log."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "entry_points", cache(importer.entry_points))
        yield
