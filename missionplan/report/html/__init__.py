"""A page as one self-contained HTML file: its template `page.html`, its style `page.css`, figures as SVG in it."""

import re
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from hashlib import sha256
from importlib.resources import files
from itertools import chain, count, groupby

from jinja2 import Environment, PackageLoader
from markupsafe import Markup

from missionplan.rendering import Rendered
from missionplan.report.page import BLUE, GRID, INK, Block, Figure, Page, PageSection, Table, typed
from missionplan.report.quantities import given_units
from missionplan.report.wording import capitalised
from missionplan.results import Provenance, to_yaml
from missionplan.results.entries import mapping

_LARGEST = 1.7
"""Largest scale of a figure on the screen [px/pt]: text of 10 pt is then about as high as the page's."""
_TALL, _LONG = 0.8, 1.3
"""Height over width from which a figure is given more room on paper, so that its text can be read."""
_LONG_NAME = 18
"""Characters of a first cell for which a wide screen keeps more room."""
_MOST_CARDS, _NARROW = 8, 44
"""A narrow screen shows rows as cards if they have more characters than fit, unless there are too many."""
_SHORT = 14
"""Most rows of a table that is kept on one sheet of paper."""


def render_page(page: Page, planned: Sequence[PageSection], provenance: Provenance, notices: Sequence[str]) -> Rendered:
    """Render a page.

    `planned`: what was planned, and what its probability does not hold; they follow the page's own sections. `notices`:
    notes on the input.
    """
    page = named_apart(page)
    sections = [*page.sections, *planned]
    first = [section for section in sections if section.is_summary]
    appendix = sorted((section for section in sections if not section.is_summary), key=lambda section: section.is_sheet)
    script = (files("missionplan.report.html") / "page.js").read_text(encoding="utf-8")
    html = (
        _environment()
        .get_template("page.html")
        .render(
            page=page,
            first=first,
            appendix=appendix,
            provenance=provenance,
            notices=[_begun(notice) for notice in notices],
            summary=provenance.summary(),
            mission_yaml=to_yaml(provenance.data),
            rerun=page.rerun or rerun_command(provenance),
            script=Markup(script),
            script_hash=b64encode(sha256(script.encode()).digest()).decode(),
        )
    )
    shown = [page.figure] if page.figure else []
    shown += [block for section in (*first, *appendix) for block in section.blocks if isinstance(block, Figure)]
    return Rendered(html, {figure.name: figure.svg for figure in shown}, dict(page.export()))


def named_apart(page: Page) -> Page:
    """Give figures that have one name, as of the phases ``leg 1`` and ``leg-1``, names of their own."""
    taken = {page.figure.name} if page.figure else set()

    def named(block: Block) -> Block:
        if not isinstance(block, Figure):
            return block
        names = chain([block.name], (f"{block.name}-{number}" for number in count(2)))
        name = next(name for name in names if name not in taken)
        taken.add(name)
        return replace(block, name=name)

    sections = [replace(section, blocks=[named(block) for block in section.blocks]) for section in page.sections]
    return replace(page, write=lambda: sections)


def _begun(notice: str) -> str:
    """Begin a note with a capital, unless it begins with a name: of a phase, a key or a file."""
    first = notice.partition(" ")[0]
    return capitalised(notice) if first.isalpha() else notice


@cache  # which keeps the templates that it has compiled
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("missionplan.report", "html"), autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(inline=inline, grouped=grouped, shape=shape, size_class=size_class, filled=filled)
    environment.tests["text"] = lambda block: isinstance(block, str)
    environment.tests["figures"] = lambda block: isinstance(block, list)
    environment.tests["table"] = lambda block: isinstance(block, Table)
    return environment


def grouped(blocks: Sequence[Block]) -> list[Block | list[Figure]]:
    """Put figures that follow one another in a list: on paper they stand side by side."""
    groups: list[Block | list[Figure]] = []
    for is_figure, run in groupby(blocks, key=lambda block: isinstance(block, Figure)):
        if is_figure:
            groups.append([block for block in run if isinstance(block, Figure)])
        else:
            groups.extend(run)
    return groups


def shape(table: Table) -> str:
    """Choose how a table is shown on a narrow screen and on paper: the classes of its element."""
    few = len(table.rows) <= _SHORT
    wide = len(table.columns) > 2 and _characters(table) > _NARROW
    named = any(len(row[0]) > _LONG_NAME for row in table.rows)
    names = (("short", few), ("cards", wide and len(table.rows) <= _MOST_CARDS), ("long", not few), ("named", named))
    return " ".join(name for name, holds in names if holds)


def _characters(table: Table) -> int:
    """Count the characters that a row needs, its first cell wrapped and those of words too."""
    wrapped = max(table.text_columns, 1)
    columns = list(zip(table.columns, *table.rows, strict=True))[wrapped:]
    longest = (max(map(len, (*head.split(), *cells)), default=0) for head, *cells in columns)
    return 10 * wrapped + sum(2 + length for length in longest)


def filled(table: Table) -> Table:
    """Leave out the columns of a table that have no cell with anything in it."""
    kept = [
        index
        for index in range(len(table.columns))
        if not table.rows or any(len(row) > index and row[index] for row in table.rows)
    ]
    if len(kept) == len(table.columns):
        return table
    return replace(
        table,
        columns=[table.columns[index] for index in kept],
        rows=[[row[index] for index in kept] for row in table.rows],
        text_columns=sum(index < table.text_columns for index in kept),
    )


def inline(figure: Figure) -> Markup:
    """Prepare a figure's SVG for inlining: ids of its own, the page's colours, alternative text.

    It scales with the column, until its text has the size of the page's.
    """
    svg = figure.svg[figure.svg.index("<svg") :]
    svg = re.sub(r'\b(id="|xlink:href="#|href="#|url\(#)', rf"\g<1>{figure.name}-", svg)
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
    size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)
    limit = f' style="--widest: {_LARGEST * float(size[1]):.0f}px; --w: {size[1]}; --h: {size[2]}"' if size else ""
    return Markup(svg.replace("<svg", f'<svg preserveAspectRatio="xMinYMid" role="img" aria-label="{label}"{limit}', 1))


def size_class(figure: Figure) -> str:
    """Class of a figure that is about as high as it is wide, or fills a page."""
    size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', figure.svg)
    if size is None:
        return ""
    width, height = float(size[1]), float(size[2])
    return "page" if height > _LONG * width else "tall" if height > _TALL * width else ""


def rerun_command(provenance: Provenance) -> str:
    """Write the command that reproduces the result from the folder's own `mission.yaml`."""
    trials = mapping(provenance.data.get("monte_carlo")).get("trials")
    chosen = provenance.trials > 0 and not provenance.options.get("precision")
    arguments = {"trials": provenance.trials if chosen and provenance.trials != trials else None, **provenance.options}
    options = {name: value for name, value in arguments.items() if not isinstance(value, bool)}
    bare = provenance.options.get("assumptions") is False or None
    shown = {"seed": provenance.seed, **options, "no_assumptions": bare, "units": given_units() or None}
    return typed(provenance.command, "mission.yaml", **shown)
