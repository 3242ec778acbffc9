"""Pages and terminal views in the units of the crew."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from missionplan.report.crew.conversion import column_in_units, in_units, row_in_units
from missionplan.report.page import Block, Page, PageSection, Table, Terminal
from missionplan.report.typesetting import typeset_page, typeset_section, typeset_terminal


def page_in_units(page: Page, system: str) -> Page:
    """Convert a page that is typeset."""
    converted = replace(page, sections=[_with_tables(section, system) for section in page.sections])
    return typeset_page(converted, partial(in_units, system=system))


def section_in_units(section: PageSection, system: str) -> PageSection:
    """Convert a section that is typeset."""
    return typeset_section(_with_tables(section, system), partial(in_units, system=system))


def terminal_in_units(shown: Terminal, system: str) -> Terminal:
    """Convert a terminal's view that is typeset."""
    columns, rows = _columns(shown.columns, shown.rows, system)
    return typeset_terminal(replace(shown, columns=columns, rows=rows), partial(in_units, system=system))


def _with_tables(section: PageSection, system: str) -> PageSection:
    return replace(section, blocks=[_table(block, system) for block in section.blocks])


def _table(block: Block, system: str) -> Block:
    if not isinstance(block, Table):
        return block
    columns, rows = _columns(block.columns, block.rows, system)
    return replace(block, columns=columns, rows=rows)


def _columns(heads: Sequence[str], rows: Sequence[Sequence[str]], system: str) -> tuple[list[str], list[Sequence[str]]]:
    """Convert the columns whose heads have a unit."""
    rows = [row_in_units(heads, row, system) for row in rows]
    converted = [
        column_in_units(head, [row[index] for row in rows], system)
        if all(len(row) > index for row in rows)
        else (head, [])
        for index, head in enumerate(heads)
    ]
    if any(len(cells) != len(rows) for _, cells in converted):
        return list(heads), list(rows)
    return [head for head, _ in converted], [list(cells) for cells in zip(*(c for _, c in converted), strict=True)]
