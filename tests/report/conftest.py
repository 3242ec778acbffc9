"""One browser for all tests of pages of a process."""

from collections.abc import Iterator

import pytest
from browsing import browsing


@pytest.fixture(scope="session")
def browser() -> Iterator:
    with browsing() as driver:
        yield driver
