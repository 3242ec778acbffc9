"""How a result becomes a report: the package registers its renderer, so that results need not import reports."""

from collections.abc import Callable
from dataclasses import dataclass, field

Renderer = Callable[[object], "Rendered"]
"""Renders a result of any study."""


@dataclass(frozen=True)
class Rendered:
    """A page as HTML, its figures as SVG by name, and files for other programs (GeoJSON, KML) by file name."""

    html: str
    figures: dict[str, str]
    files: dict[str, str] = field(default_factory=dict)


_registered: list[Renderer] = []


def register_renderer(renderer: Renderer) -> None:
    """Register the function that renders every result; the last one registered is used."""
    _registered[:] = [renderer]


def render(result: object) -> Rendered:
    """Render a result with the registered renderer.

    Raises
    ------
    LookupError
        When none is registered.
    """
    if not _registered:
        raise LookupError("no renderer is registered: import missionplan first")
    return _registered[0](result)
