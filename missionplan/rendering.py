"""How a result becomes a report: what presents it is loaded when the first is shown, so that results import none."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

from missionplan.errors import InputError, Problem, did_you_mean, shown

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

    def render_report(self, result: Any, /) -> Rendered:
        """Render the report."""

    def headline(self, result: Any, /) -> str:
        """Write the answer in a sentence or two."""

    def text(self, result: Any, /) -> str:
        """Write one screen of text."""

    def notebook(self, result: Any, /) -> str:
        """Write a part of an HTML page, as a notebook shows it."""

    def plots(self, result: Any, /) -> Mapping[str, Plot]:
        """Return its plots by name, the main one first."""


def presenter() -> Presenter:
    """Return what presents results."""
    return cast(Presenter, import_module("missionplan.report.render"))


def render(result: object) -> Rendered:
    """Render the report of a result."""
    return presenter().render_report(result)


class Plots:
    """Plots of a result, by name: ``result.plot.tracks(ax=axes)``; each returns the axes that it drew on."""

    def __init__(self, result: object) -> None:
        self._result = result

    def __call__(self, name: str | None = None, /, *, ax: "Axes | None" = None, **options: object) -> "Axes":
        """Draw a plot.

        Parameters
        ----------
        name : str, optional
            Of the plot; default: the main one.
        ax : matplotlib Axes, optional
            To draw on; default: new ones.
        **options
            Of the plot's own, such as the quantity of a histogram.

        Raises
        ------
        InputError
            When the result has no such plot.
        """
        return self._named(name)(ax=ax, **options)

    def __getattr__(self, name: str) -> Plot:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._named(name)
        except InputError as error:
            raise AttributeError(str(error)) from None

    def __dir__(self) -> list[str]:
        return list(presenter().plots(self._result))

    def __repr__(self) -> str:
        return f"<plots of {type(self._result).__name__}: {', '.join(dir(self)) or 'none'}>"

    def _named(self, name: str | None) -> Plot:
        plots = presenter().plots(self._result)
        if plots and (name is None or name in plots):
            return plots[name if name is not None else next(iter(plots))]
        expected = f"expected one of {', '.join(plots)}" if plots else "the result has no plots"
        hint = did_you_mean(str(name), plots)
        raise InputError([Problem(f"given {shown(name)}, {expected}", key="plot", hint=hint)])
