"""Tables of the comparisons: as text, and between markers in `docs/validation/speed.md`."""

import re

from benchmarks.common import ROOT, Row, Section

PAGE = ROOT / "docs" / "validation" / "speed.md"
HEADINGS = ("", "missionplan", "reference", "ratio", "target", "met")
MET = {None: "", True: "yes", False: "**no**"}


def as_text(section: Section) -> str:
    """Format a section for a terminal: one line per row, without empty cells."""
    lines = []
    for row in section.rows:
        peer = f"; reference {row.peer}" if row.peer else ""
        ratio = f"; {row.ratio}" if row.ratio else ""
        target = f" (target {row.target})" if row.target else ""
        missed = " MISSED" if row.met is False else ""
        lines.append(f"  {row.what}: {row.ours}{peer}{ratio}{target}{missed}")
    return "\n".join([*lines, *(f"  {note}" for note in section.notes)])


def as_markdown(section: Section, measured: str) -> str:
    """Format a section as a Markdown table without empty columns, with when and where it was measured."""
    cells = [HEADINGS, *(_cells(row) for row in section.rows)]
    kept = [column for column in zip(*cells, strict=True) if any(column[1:])]
    lines = ["| " + " | ".join(row) + " |" for row in zip(*kept, strict=True)]
    lines.insert(1, "|" + " --- |" * len(kept))
    return "\n".join([*lines, "", *section.notes, f"Measured {measured}."])


def write(name: str, section: Section, measured: str) -> None:
    """Write a section's table between its markers and leave the rest of the page unchanged.

    Raises
    ------
    ValueError
        When the page has no such markers.
    """
    page = PAGE.read_text(encoding="utf-8")
    marked = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
    if not marked.search(page):
        raise ValueError(f"{PAGE.name} has no markers for {name}")
    content = as_markdown(section, measured)
    PAGE.write_text(marked.sub(lambda found: f"{found[1]}{content}\n{found[2]}", page), encoding="utf-8")


def _cells(row: Row) -> tuple[str, ...]:
    return (row.what, row.ours, row.peer, row.ratio, row.target, MET[row.met])
