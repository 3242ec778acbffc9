"""Figures as SVG text."""

import io
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.text import Text

from missionplan.montecarlo.parallel.pool import interrupts_deferred, result_of, running_pool
from missionplan.report.axes import draw_in_units, set_ticks
from missionplan.report.html.readings import Shown, name_series, readings
from missionplan.report.quantities import reader_system, reading_in
from missionplan.report.wording import typeset

if TYPE_CHECKING:
    from loky import ProcessPoolExecutor
    from matplotlib.figure import Figure


PLAIN = Shown()
"""Of a figure to which the page adds nothing."""
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


def draw(figure: "Figure", shown: Shown = PLAIN) -> Drawn:
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
        for axes in figure.axes:  # the solver's last bits vary from run to run, and ids in the SVG are made of them
            axes.set_position(np.round(axes.get_position(original=True).bounds, 9), which="original")
    series = name_series(figure)
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return Drawn(buffer.getvalue(), readings(figure, series, shown))


Draw = Callable[["Figure", Shown], DrawnFigure]
"""Draws a figure, or has it drawn."""
_chosen: ContextVar[Draw] = ContextVar("draw", default=draw)


def drawing_of(figure: "Figure", shown: Shown = PLAIN) -> DrawnFigure:
    """Draw a figure in the way that is chosen: here, or in another process."""
    return _chosen.get()(figure, shown)


@contextmanager
def drawing_by(draw: Draw) -> Iterator[None]:
    """Choose who draws."""
    token = _chosen.set(draw)
    try:
        yield
    finally:
        _chosen.reset(token)


AT_ONCE = 2
"""Figures that the pool has at once, at most; this process draws the others."""


@contextmanager
def drawing_in_parallel() -> Iterator[None]:
    """Let the pool that is running, if one is, draw some of the figures; the drawings are the same."""
    executor = running_pool()
    if executor is None:
        yield
        return
    with drawing_by(_Parallel(executor).drawing_of):
        yield


@dataclass(frozen=True)
class _Parallel:
    """Draws with the processes of a pool, and here while they are busy."""

    executor: "ProcessPoolExecutor"
    pending: "list[Future[Drawn]]" = field(default_factory=list)

    def drawing_of(self, figure: "Figure", shown: Shown) -> DrawnFigure:
        self.pending[:] = [future for future in self.pending if not future.done()]
        if len(self.pending) >= AT_ONCE:
            return draw(figure, shown)
        from loky.backend.reduction import dumps

        content = bytes(dumps((figure, shown)))
        try:
            with interrupts_deferred():
                future = self.executor.submit(_drawn, content, reader_system())
        except BrokenExecutor:
            return draw(figure, shown)
        self.pending.append(future)
        return _DrawnElsewhere(future, figure, shown)


@dataclass(frozen=True, eq=False)
class _DrawnElsewhere:
    """A drawing that another process makes; should that process die, this one makes it."""

    future: "Future[Drawn]"
    figure: "Figure"
    shown: Shown

    @property
    def svg(self) -> str:
        """SVG text."""
        return self._drawn.svg

    @property
    def plot(self) -> str:
        """Readings, as JSON."""
        return self._drawn.plot

    @cached_property
    def _drawn(self) -> Drawn:
        try:
            return result_of(self.future)
        except BrokenExecutor:
            return draw(self.figure, self.shown)


def _drawn(content: bytes, units: str) -> Drawn:
    """Draw a pickled figure in the project's style."""
    figure, shown = pickle.loads(content)
    with style(), reading_in(units):
        return draw(figure, shown)
