"""How a result becomes a report: the package registers its presenter, so that results need not import reports."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Plot = Callable[..., "Axes"]
"""Draws one plot of a result: on the axes `ax`, or on new ones."""


@dataclass(frozen=True)
class Rendered:
    """A page as HTML, its figures as SVG by name, and files for other programs (GeoJSON, KML) by file name."""

    html: str
    figures: dict[str, str]
    files: dict[str, str] = field(default_factory=dict)


class Presenter(Protocol):
    """All the ways in which a result of any study is shown."""

    def report(self, result: object, /) -> Rendered:
        """Render the report."""

    def headline(self, result: object, /) -> str:
        """Write the answer in a sentence or two."""

    def text(self, result: object, /) -> str:
        """Write one screen of text."""

    def notebook(self, result: object, /) -> str:
        """Write a part of an HTML page, as a notebook shows it."""

    def plots(self, result: object, /) -> Mapping[str, Plot]:
        """Return its plots by name, the main one first."""


_registered: list[Callable[[], Presenter]] = []


def register_presenter(load: Callable[[], Presenter]) -> None:
    """Register the function that loads what presents every result; the last one registered is used."""
    _registered[:] = [load]


def presenter() -> Presenter:
    """Return what presents results.

    Raises
    ------
    LookupError
        When none is registered.
    """
    if not _registered:
        raise LookupError("no presenter is registered: import missionplan first")
    return _registered[0]()


def render(result: object) -> Rendered:
    """Render the report of a result."""
    return presenter().report(result)
