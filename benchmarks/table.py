"""Tables of the comparisons: as text, as records in `validation/measured/speed.json`, and from these as Markdown."""

import json
from dataclasses import asdict
from typing import Any

from benchmarks.common import ROOT, Circumstances, Row, Section

STORE = ROOT / "validation" / "measured" / "speed.json"
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


def as_markdown(section: Section, measured: Circumstances) -> str:
    """Format a section as a Markdown table without empty columns, with when and where it was measured."""
    cells = [HEADINGS, *(_cells(row) for row in section.rows)]
    kept = [column for column in zip(*cells, strict=True) if any(column[1:])]
    lines = ["| " + " | ".join(row) + " |" for row in zip(*kept, strict=True)]
    lines.insert(1, "|" + " --- |" * len(kept))
    return "\n".join([*lines, "", *section.notes, f"Measured {measured.words()}."])


def write(name: str, section: Section, measured: Circumstances) -> None:
    """Write a comparison down in place of what it measured before."""
    record = {
        "measured": asdict(measured),
        "notes": section.notes,
        "rows": [{key: value for key, value in asdict(row).items() if value not in ("", None)} for row in section.rows],
    }
    text = json.dumps({**_kept(), name: record}, indent=1, sort_keys=True, ensure_ascii=False)
    STORE.write_text(f"{text}\n", encoding="utf-8")


def load(name: str) -> tuple[Section, Circumstances]:
    """Return what a comparison measured, when and where.

    Raises
    ------
    KeyError
        When it is not in the file.
    """
    record = _kept()[name]
    rows = tuple(Row(**row) for row in record["rows"])
    return Section(rows, notes=tuple(record["notes"])), Circumstances(**record["measured"])


def _kept() -> dict[str, Any]:
    return json.loads(STORE.read_text(encoding="utf-8"))


def _cells(row: Row) -> tuple[str, ...]:
    return (row.what, row.ours, row.peer, row.ratio, row.target, MET[row.met])
