"""How a result becomes a report: the package names the renderer once, so that results need not know any report."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

Renderer = Callable[[Any], "Rendered"]


@dataclass(frozen=True)
class Rendered:
    """A page as HTML, its figures as SVG by name, and files for other programs (GeoJSON, KML) by file name."""

    html: str
    figures: dict[str, str]
    files: dict[str, str] = field(default_factory=dict)


_registered: list[Renderer] = []


def register_renderer(renderer: Renderer) -> None:
    """Name the function that renders every result; the last one named is used."""
    _registered[:] = [renderer]


def render(result: Any) -> Rendered:
    """Render a result with the registered renderer.

    Raises
    ------
    LookupError
        When none is registered.
    """
    if not _registered:
        raise LookupError("no renderer is registered: import missionplan first")
    return _registered[0](result)
