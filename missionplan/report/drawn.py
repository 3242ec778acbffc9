"""Figures as SVG text."""

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.text import Text

from missionplan.report.axes import draw_in_units, set_ticks
from missionplan.report.html.readings import Slider, name_series, readings
from missionplan.report.typesetting import typeset

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SVG_DPI = 72
"""Dots per inch at which SVG is drawn."""


class DrawnFigure(Protocol):
    """A figure as drawn: SVG text, and what the page's script reads off it, as JSON (`html.readings`)."""

    @property
    def svg(self) -> str:
        """SVG text."""

    @property
    def plot(self) -> str:
        """Readings, as JSON."""


@dataclass(frozen=True)
class Drawn:
    """A drawing that is done."""

    svg: str
    plot: str = ""


@contextmanager
def style() -> Iterator[None]:
    """Apply the project's figure style, leaving the caller's matplotlib settings alone."""
    path = files("missionplan.report") / "style.mplstyle"
    with mpl.rc_context(fname=Path(str(path))):
        yield


def draw(figure: "Figure", slider: Slider | None = None) -> Drawn:
    """Draw a figure in the style and the units that are set."""
    FigureCanvasSVG(figure)
    draw_in_units(figure.axes)
    set_ticks(figure.axes)
    for text in figure.findobj(Text):
        text.set_text(typeset(text.get_text()))
    figure.set_dpi(SVG_DPI)
    if (layout := figure.get_layout_engine()) is not None:  # saving would draw the whole figure twice for its sake
        layout.execute(figure)
        with mpl.rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)
    series = name_series(figure)
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return Drawn(buffer.getvalue(), readings(figure, series, slider))


Draw = Callable[["Figure", Slider | None], DrawnFigure]
"""Draws a figure, or has it drawn."""
_chosen: ContextVar[Draw] = ContextVar("draw", default=draw)


def drawing_of(figure: "Figure", slider: Slider | None = None) -> DrawnFigure:
    """Draw a figure in the way that is chosen: here, or in another process."""
    return _chosen.get()(figure, slider)


@contextmanager
def drawing_by(draw: Draw) -> Iterator[None]:
    """Choose who draws."""
    token = _chosen.set(draw)
    try:
        yield
    finally:
        _chosen.reset(token)
