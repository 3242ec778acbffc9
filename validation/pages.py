"""What was measured as the tables of `docs/validation`: put into the pages of the site, and printed."""

import math
import re

from benchmarks import table as speed
from validation.record import DIFFERS, FAILS, FOLDER, HOLDS, LIBRARIES, NOT_MEASURED, Found, load
from validation.rows import CHEAP, LEVELS, PAGES, Accepted, Row, all_rows, rows_of

MARK = re.compile(r"^\[Measured: (.+)\]\(.+\)$", re.MULTILINE)
"""The line of a page that stands for a table; where the pages are read without it, it leads to the data."""
_VERDICTS = {HOLDS: "holds", DIFFERS: "differs", FAILS: "**fails**", NOT_MEASURED: "not measured"}


def page(name: str) -> str:
    """Return a page of `docs/validation`, by its name, with its tables."""
    return with_tables((FOLDER / f"{name}.md").read_text(encoding="utf-8"))


def with_tables(text: str) -> str:
    """Return a page with the tables in place of the lines that stand for them."""
    return MARK.sub(lambda mark: measured(mark[1]), text)


def measured(what: str) -> str:
    """Return the table of a page, the summary of all pages, or the table of a comparison of speeds.

    Raises
    ------
    KeyError
        When there is nothing of this name.
    """
    if what == "all rows":
        return summary(load())
    levels = {name: level for level, name in PAGES.items()}
    return table(levels[what], load()) if what in levels else speed.as_markdown(*speed.load(what))


def summary(found: dict[str, Found]) -> str:
    """Return how many rows of each level hold, differ, fail and are not measured, with links to the pages."""
    lines = ["| compared with | rows | hold | differ | fail | not measured |", "|" + "---|" * 6]
    for level, title in LEVELS.items():
        lines.append(_counts(f"[{title}]({PAGES[level]}.md)", list(rows_of(level)), found))
    return "\n".join([*lines, _counts("all", list(all_rows().values()), found)])


def table(level: str, found: dict[str, Found]) -> str:
    """Return the rows of a level, with figures, and when and with what each was measured."""
    own = list(rows_of(level))
    parts = ["| ID | claim | case | reference | measured | accepted | verdict | command |", "|" + "---|" * 8]
    parts += [_line(each, found.get(each.name)) for each in own]
    notes = [f"`{each.name}`: {each.differs}" for each in own if each.differs]
    parts += ["", "Where the reference is not met:", "", *(f"- {note}" for note in notes)] if notes else []
    for each in own:
        seen = found.get(each.name)
        if seen is not None and seen.has_figure:
            parts += ["", f"![{each.claim}: {each.case}](figures/{each.name}.svg)"]
    parts += ["", "When and with what:", "", "| ID | date | commit | seed | CPU time | versions |", "|" + "---|" * 6]
    return "\n".join(parts + [_circumstances(each, found[each.name]) for each in own if each.name in found])


def _counts(name: str, rows: list[Row], found: dict[str, Found]) -> str:
    verdicts = [found[each.name].verdict if each.name in found else NOT_MEASURED for each in rows]
    counts = [str(verdicts.count(verdict)) for verdict in (HOLDS, DIFFERS, FAILS, NOT_MEASURED)]
    return "| " + " | ".join((name, str(len(rows)), *counts)) + " |"


def _line(row: Row, found: Found | None) -> str:
    if found is None:
        measured, verdict = "–", f"{_VERDICTS[NOT_MEASURED]}: costs {row.cost:g} s"
    elif not found.values:
        measured, verdict = "–", f"{_VERDICTS[found.verdict]}: {found.why}"
    else:
        measured = "; ".join(f"{each.name} {shown(found.values[each.name])}{_unit(each)}" for each in row.accepted)
        verdict = _VERDICTS[found.verdict]
    peers = [f"{name} {found.versions[name]}" for name in row.packages if found and name in found.versions]
    reference = f"{row.reference} ({', '.join(peers)})" if peers else row.reference
    accepted = "; ".join(_limits(each) for each in row.accepted if each.is_limited) or "reported"
    anchor = f'<span id="{row.name.replace(".", "-")}"></span>`{row.name}`'
    cells = (anchor, row.claim, row.case, reference, measured, accepted, verdict, f"`{row.command}`")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def shown(value: float | None) -> str:
    """Write a number with three or four digits."""
    if value is None:
        return "none"
    if value and not 1e-3 <= abs(value) < 1e5:
        mantissa, _, exponent = f"{value:.2e}".partition("e")
        return f"{mantissa}·10{_raised(int(exponent))}"
    return f"{value:.4g}".replace("-", "−")


def _raised(number: int) -> str:
    return "".join("⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".index(digit)] for digit in str(number))


def _unit(each: Accepted) -> str:
    return f" {each.unit}" if each.unit else ""


def _limits(each: Accepted) -> str:
    if math.isinf(each.low):
        words = f"≤ {shown(each.high)}"
    elif math.isinf(each.high):
        words = f"≥ {shown(each.low)}"
    else:
        words = f"{shown(each.low)} to {shown(each.high)}"
    return f"{words}{_unit(each)}"


def _circumstances(row: Row, found: Found) -> str:
    """A row that went on from what was done before does not know what it cost."""
    cost = f"{found.cpu_s:g} s" if found.cpu_s > 0.05 * row.cost or row.cost <= CHEAP else "continued"
    seed = "–" if found.seed is None else str(found.seed)
    packages = ("Python", *LIBRARIES, *row.packages)
    used = ", ".join(f"{name} {found.versions[name]}" for name in packages if name in found.versions)
    return f"| `{row.name}` | {found.date} | {found.commit} | {seed} | {cost} | {used} |"
