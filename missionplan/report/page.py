"""The parts of a report, its figures drawn as SVG text; `html` renders them as one self-contained page."""

import io
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property, partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.text import Text

from missionplan.montecarlo.pool import Copy, copies_at_once
from missionplan.report.axes import draw_in_units, set_ticks
from missionplan.report.readings import Shown, Slider, name_series, readings
from missionplan.report.wording import setting, typeset

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure


PLAIN = Shown()
"""Of a figure to which the page adds nothing."""
SVG_DPI = 72
"""Dots per inch at which SVG is drawn."""


@dataclass(frozen=True)
class Drawn:
    """A drawing that is done: SVG text, and what the page's script reads off it, as JSON (`html.readings`)."""

    svg: str
    plot: str = ""


@contextmanager
def style() -> Iterator[None]:
    """Apply the project's figure style, leaving the caller's matplotlib settings alone."""
    with mpl.rc_context(fname=Path(str(files("missionplan.report") / "style.mplstyle"))):
        yield


def draw(figure: "MatplotlibFigure", shown: Shown = PLAIN) -> Drawn:
    """Draw a figure in the style and the units that are set."""
    FigureCanvasSVG(figure)
    draw_in_units(figure.axes)
    set_ticks(figure.axes)
    for text in _texts(figure):
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


def _texts(figure: "MatplotlibFigure") -> Iterator[Text]:
    """Texts but those of ticks, which their formatters write; to ask for these would make them."""
    for parent in (figure, *figure.axes):
        for child in parent.get_children():
            if isinstance(child, Axis):
                yield child.label
            elif not isinstance(child, Axes):
                yield from cast("list[Text]", child.findobj(Text))


DrawnFigure = Drawn | Copy[Drawn]
Draw = Callable[["MatplotlibFigure", Shown], DrawnFigure]
"""Draws a figure, or has it drawn in another process."""
_chosen: ContextVar[Draw] = ContextVar("draw", default=draw)


def drawing_by(draw: Draw) -> AbstractContextManager[None]:
    """Choose who draws."""
    return setting(_chosen, draw)


@contextmanager
def drawing_in_parallel(processes: int | None = None) -> Iterator[None]:
    """Draw some of the figures in copies of this process, where these may be made; drawings are the same.

    `processes`: that draw at once, this one included; default: one per core.
    """
    copies = Copies(copies_at_once(processes))
    with drawing_by(copies.drawing_of):
        try:
            yield
        finally:
            copies.end()


@dataclass
class Copies:
    """Draws in copies of this process, `most` at once, and here while these are busy."""

    most: int
    made: list[Copy[Drawn]] = field(default_factory=list)

    def drawing_of(self, figure: "MatplotlibFigure", shown: Shown) -> DrawnFigure:
        """Draw a figure in a copy, where one may be made."""
        if sum(copy.is_busy for copy in self.made) >= self.most:
            return draw(figure, shown)
        try:
            self.made.append(Copy(partial(draw, figure, shown)))
        except OSError:  # of processes or files there may be no more
            return draw(figure, shown)
        return self.made[-1]

    def end(self) -> None:
        """Let go of all."""
        for copy in self.made:
            copy.end()


INK, GRID = "#222222", "#dddddd"
"""Colours of the figure style, which the page replaces by those of its light or dark theme."""

BLUE, ORANGE, GREEN, PINK, YELLOW, SKY, GREY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#666666",
)
"""Okabe–Ito colours, in the order of the figure style's cycle."""


Cells = tuple[Sequence[str], Sequence[Sequence[str]]]
"""Columns and rows of a table."""
Drawing = Callable[..., None]
"""Draws one plot of a result: called with axes, the result, and options of the plot's own."""


@dataclass(frozen=True)
class Figure:
    """A figure: file name without suffix, drawing, alternative text for readers who cannot see it, and a caption."""

    name: str
    drawing: DrawnFigure
    alt: str
    caption: str = ""

    @cached_property
    def drawn(self) -> Drawn:
        """The drawing that is done; this process draws where a copy of it has died."""
        if isinstance(self.drawing, Drawn):
            return self.drawing
        try:
            return self.drawing.result
        except EOFError:
            return self.drawing.compute()

    @property
    def svg(self) -> str:
        """SVG text."""
        return self.drawn.svg

    @property
    def plot(self) -> str:
        """What the page's script reads off it, as JSON (`html.readings`)."""
        return self.drawn.plot


@dataclass(frozen=True)
class Table:
    """A table of formatted text. The first `text_columns` columns hold words, the others numbers."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    text_columns: int = 1


@dataclass(frozen=True)
class Listing:
    """Text in a monospaced font: part of a mission file, a command."""

    text: str


Block = str | Figure | Table | Listing
"""A paragraph of plain text, a figure, a table or a listing."""


@dataclass(frozen=True)
class PageSection:
    """A heading that states a finding, and the blocks that show it."""

    heading: str
    blocks: Sequence[Block]
    is_sheet: bool = False
    """Whether it is printed on a page of its own, after everything else."""
    is_summary: bool = False
    """Whether it belongs to the page that comes first; all else is folded on a screen until it is asked for."""


def typed(command: str, /, *words: object, **options: object) -> str:
    """Write a command as one types it: an option that is None is left out, of a list each item has it, True is bare."""
    items = [
        (key, value) for key, values in options.items() for value in (values if isinstance(values, list) else [values])
    ]
    arguments = [
        f"--{key.replace('_', '-')}{'' if value is True else f' {shlex.quote(str(value))}'}"
        for key, value in items
        if value is not None
    ]
    return " ".join(["missionplan", command, *(shlex.quote(str(word)) for word in words), *arguments])


@dataclass(frozen=True)
class Page:
    """All that a result shows, listed once: page, terminal, notebook and plots each take from it what they show.

    The answer in a sentence, the figure that shows it, the main numbers, then sections. What only some show is a
    function, called when it is shown: a terminal draws no figure.
    """

    title: str
    """The question."""
    answer: str
    """The answer in a sentence or two."""
    numbers: Sequence[tuple[str, str]]
    """Two or three main numbers, with intervals and units."""
    write: Callable[[], Sequence[PageSection]]
    """Writes the sections with everything else."""
    table: Callable[[], "Cells"]
    """Writes the compact table of a terminal, and of a notebook: its columns and rows."""
    draw: Callable[[], Figure | None] = lambda: None
    """Draws the figure that shows the answer; None where there is none."""
    plots: Mapping[str, Drawing] = field(default_factory=dict)
    """Plots on given axes by name, the main one first."""
    sentence: str = ""
    """The answer of a terminal and a notebook, where it says more than the page's."""
    verdict: str = ""
    """How the answer is marked: "good", "bad" or ""."""
    rerun: str = ""
    """The command that reproduces the result, where it is not the study's own on the folder's `mission.yaml`."""
    export: Callable[[], Mapping[str, str]] = dict
    """Writes files for other programs, by name."""

    @cached_property
    def figure(self) -> Figure | None:
        """The figure that shows the answer."""
        return self.draw()

    @cached_property
    def sections(self) -> Sequence[PageSection]:
        """Everything else."""
        return self.write()


@dataclass(frozen=True)
class Terminal:
    """A result for a terminal: a sentence, a compact table, and the verdict of the page."""

    sentence: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    verdict: str = ""


def to_figure(
    figure: "MatplotlibFigure",
    name: str,
    alt: str,
    caption: str = "",
    *,
    slider: Slider | None = None,
    origin: tuple[float, float] | None = None,
) -> Figure:
    """Draw a matplotlib figure (made with `matplotlib.figure.Figure`, not pyplot).

    Of its name, an id of the page and the name of a file, only letters, digits and hyphens are kept.
    """
    return Figure(re.sub(r"[^\w.-]+", "-", name), _chosen.get()(figure, Shown(slider, origin)), alt, caption)
