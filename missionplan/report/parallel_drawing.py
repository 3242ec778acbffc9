"""Figures drawn by the processes of a pool while this one builds and draws others."""

import pickle
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from loky import ProcessPoolExecutor
from loky.backend.reduction import dumps

from missionplan.montecarlo.parallel.pool import interrupts_deferred, result_of, running_pool
from missionplan.report.drawn import Drawn, DrawnFigure, draw, drawing_by, style
from missionplan.report.html.readings import Slider
from missionplan.report.quantities import reader_system, reading_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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

    executor: ProcessPoolExecutor
    pending: "list[Future[Drawn]]" = field(default_factory=list)

    def drawing_of(self, figure: "Figure", slider: Slider | None) -> DrawnFigure:
        self.pending[:] = [future for future in self.pending if not future.done()]
        if len(self.pending) >= AT_ONCE:
            return draw(figure, slider)
        content = bytes(dumps((figure, slider)))
        try:
            with interrupts_deferred():
                future = self.executor.submit(_drawn, content, reader_system())
        except BrokenExecutor:
            return draw(figure, slider)
        self.pending.append(future)
        return _DrawnElsewhere(future, figure, slider)


@dataclass(frozen=True, eq=False)
class _DrawnElsewhere:
    """A drawing that another process makes; should that process die, this one makes it."""

    future: "Future[Drawn]"
    figure: "Figure"
    slider: Slider | None

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
            return draw(self.figure, self.slider)


def _drawn(content: bytes, units: str) -> Drawn:
    """Draw a pickled figure in the project's style."""
    figure, slider = pickle.loads(content)
    with style(), reading_in(units):
        return draw(figure, slider)
