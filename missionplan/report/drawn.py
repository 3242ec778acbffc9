"""Figures as SVG text."""

import io
import os
import pickle
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, Protocol, cast

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.text import Text

from missionplan.report.axes import draw_in_units, set_ticks
from missionplan.report.html.readings import Shown, name_series, readings
from missionplan.report.wording import typeset

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PLAIN = Shown()
"""Of a figure to which the page adds nothing."""
SVG_DPI = 72
"""Dots per inch at which SVG is drawn."""
_DEAF = {getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)}
"""Signals that end a command."""


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


@contextmanager
def drawing_in_parallel(processes: int | None = None) -> Iterator[None]:
    """Draw some of the figures in copies of this process, which have all that it has imported; drawings are the same.

    Parameters
    ----------
    processes : int, optional
        That draw at once, this one included; default: one per core. Where a process cannot be copied safely (off
        Linux, or beside other threads, whose locks a copy would hold for ever) this one draws all.
    """
    count = processes or len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1
    if count == 1 or threading.active_count() > 1:
        yield
        return
    copies = Copies(count - 1)
    with drawing_by(copies.drawing_of):
        try:
            yield
        finally:
            copies.end()


@dataclass
class Copies:
    """Draws in copies of this process, `most` at once, and here while these are busy."""

    most: int
    made: "list[_DrawnElsewhere]" = field(default_factory=list)

    def drawing_of(self, figure: "Figure", shown: Shown) -> DrawnFigure:
        """Draw a figure in a copy, where one may be made."""
        if sum(each.is_busy for each in self.made) >= self.most:
            return draw(figure, shown)
        try:
            self.made.append(_DrawnElsewhere(figure, shown))
        except OSError:  # of processes or files there may be no more
            return draw(figure, shown)
        return self.made[-1]

    def end(self) -> None:
        """Let go of all."""
        for each in self.made:
            each.end()


class _DrawnElsewhere:
    """A drawing that a copy of this process makes; should that die, this one makes it."""

    def __init__(self, figure: "Figure", shown: Shown) -> None:
        self._figure, self._shown = figure, shown
        self._pipe, writer = os.pipe()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, _DEAF)  # Ctrl-C is for this process; the copy ends by itself
        try:
            self.process = os.fork()
            if self.process == 0:
                self._draw_and_end(writer)
        except OSError:
            os.close(self._pipe)
            raise
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            os.close(writer)
        self._waits_for = True

    def _draw_and_end(self, writer: int) -> NoReturn:
        try:
            os.close(self._pipe)  # or a write to a parent that is gone would never fail
            with open(writer, "wb") as to_parent:
                pickle.dump(draw(self._figure, self._shown), to_parent)
        finally:
            os._exit(0)  # what this process would clean up is its parent's

    @property
    def is_busy(self) -> bool:
        """Whether it still draws: a copy writes once it is done."""
        return self._waits_for and not select.select([self._pipe], [], [], 0.0)[0]

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
            with open(self._pipe, "rb", closefd=False) as from_copy:
                return cast(Drawn, pickle.load(from_copy))
        except (EOFError, pickle.UnpicklingError):
            return draw(self._figure, self._shown)
        finally:
            self.end()

    def end(self) -> None:
        """Let go of the copy: one whose drawing nobody took ends when it cannot write it."""
        if self._waits_for:
            self._waits_for = False
            os.close(self._pipe)
            os.waitpid(self.process, 0)
