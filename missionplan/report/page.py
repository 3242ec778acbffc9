"""The parts of a report, and their rendering as one self-contained HTML page."""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader
from markupsafe import Markup

from missionplan.rendering import Rendered
from missionplan.results.base import Provenance, to_yaml

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

SVG_DPI = 72
"""Dots per inch at which SVG is drawn."""
_LARGEST = 1.7
"""Largest scale of a figure on the page [px/pt]: text of 10 pt is then 17 px high, as the page's."""


@dataclass(frozen=True)
class Figure:
    """A figure: file name without suffix, SVG text, alternative text for readers who cannot see it, and a caption."""

    name: str
    svg: str
    alt: str
    caption: str = ""


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
    """A heading that states a finding, and the blocks that show it; a sheet is printed on a page of its own."""

    heading: str
    blocks: Sequence[Block]
    is_sheet: bool = False


@dataclass(frozen=True)
class Page:
    """A report: the answer in a sentence, the figure that shows it, the main numbers, then sections.

    Attributes
    ----------
    title : str
        The question.
    answer : str
        The answer in a sentence or two.
    figure : Figure or None
        The figure that shows the answer.
    numbers : sequence of (label, value)
        Two or three main numbers, with intervals and units.
    sections : sequence of PageSection
        Everything else.
    verdict : str
        How the answer is marked: "good", "bad" or "".
    rerun : str
        The command that reproduces the result, where it is not the study's own on the folder's `mission.yaml`.
    files : mapping
        Files for other programs, by name.
    """

    title: str
    answer: str
    figure: Figure | None
    numbers: Sequence[tuple[str, str]]
    sections: Sequence[PageSection]
    verdict: str = ""
    rerun: str = ""
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Terminal:
    """A result for a terminal: a sentence, a compact table, and the verdict of the page."""

    sentence: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    verdict: str = ""


@contextmanager
def style() -> Iterator[None]:
    """Apply the project's figure style, leaving the caller's matplotlib settings alone."""
    import matplotlib as mpl

    path = files("missionplan.report") / "style.mplstyle"
    with mpl.rc_context(fname=Path(str(path))):
        yield


def to_figure(figure: "MatplotlibFigure", name: str, alt: str, caption: str = "") -> Figure:
    """Convert a matplotlib figure (made with `matplotlib.figure.Figure`, not pyplot) to SVG text."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    FigureCanvasSVG(figure)
    figure.set_dpi(SVG_DPI)
    if (layout := figure.get_layout_engine()) is not None:  # saving would draw the whole figure twice for its sake
        layout.execute(figure)
        with mpl.rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return Figure(name, buffer.getvalue(), alt, caption)


def inline(figure: Figure) -> Markup:
    """Prepare a figure's SVG for inlining: ids of its own, the page's colours, alternative text.

    It scales with the column, until its text has the size of the page's.
    """
    svg = figure.svg[figure.svg.index("<svg") :]
    svg = re.sub(r'\b(id="|xlink:href="#|href="#|url\(#)', rf"\1{figure.name}-", svg)
    svg = re.sub(INK, "currentColor", svg, flags=re.IGNORECASE)
    svg = re.sub(GRID, "var(--grid)", svg, flags=re.IGNORECASE)
    svg = re.sub(BLUE, "var(--blue)", svg, flags=re.IGNORECASE)
    svg = re.sub(
        r'<svg([^>]*?) width="[^"]*"',
        r"<svg\1",
        re.sub(r'<svg([^>]*?) height="[^"]*"', r"<svg\1", svg, count=1),
        count=1,
    )
    label = Markup.escape(figure.alt)
    width = re.search(r'viewBox="0 0 ([\d.]+)', svg)
    limit = f' style="max-width: {_LARGEST * float(width[1]):.0f}px"' if width else ""
    return Markup(svg.replace("<svg", f'<svg role="img" aria-label="{label}"{limit}', 1))


def render_page(page: Page, provenance: Provenance, notices: Sequence[str]) -> Rendered:
    """Render a page, with notices on the input before its sections and its provenance at the end."""
    environment = Environment(
        loader=PackageLoader("missionplan.report", "."), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["inline"] = inline
    environment.tests["text"] = lambda block: isinstance(block, str)
    environment.tests["figure"] = lambda block: isinstance(block, Figure)
    environment.tests["table"] = lambda block: isinstance(block, Table)
    html = environment.get_template("page.html").render(
        page=page,
        provenance=provenance,
        notices=notices,
        summary=provenance.summary(),
        mission_yaml=to_yaml(provenance.data),
        rerun=page.rerun or rerun_command(provenance),
    )
    shown = [page.figure] if page.figure else []
    shown += [block for section in page.sections for block in section.blocks if isinstance(block, Figure)]
    return Rendered(html, {figure.name: figure.svg for figure in shown}, dict(page.files))


def rerun_command(provenance: Provenance) -> str:
    """Write the command that reproduces the result from the folder's own `mission.yaml`."""
    options = [f"--{name.replace('_', '-')} {value}" for name, value in provenance.options.items() if _is_given(value)]
    return " ".join(["missionplan", provenance.command, "mission.yaml", f"--seed {provenance.seed}", *options])


def _is_given(value: object) -> bool:
    return value is not None and not isinstance(value, bool)
