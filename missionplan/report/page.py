"""The parts of a report; `html` renders them as one self-contained page."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from missionplan.report.drawn import DrawnFigure, drawing_of
from missionplan.report.html.readings import Shown, Slider

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure

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

    @property
    def svg(self) -> str:
        """SVG text."""
        return self.drawing.svg

    @property
    def plot(self) -> str:
        """What the page's script reads off it, as JSON (`html.readings`)."""
        return self.drawing.plot


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
    return Figure(re.sub(r"[^\w.-]+", "-", name), drawing_of(figure, Shown(slider, origin)), alt, caption)
