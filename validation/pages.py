"""The pages of `docs/validation` that are made from what the rows measured."""

import math
import re
from pathlib import Path

from validation.record import DIFFERS, FAILS, FOLDER, HOLDS, NOT_MEASURED, Found
from validation.rows import CHEAP, LEVELS, Accepted, Row, all_rows, rows_of

_INDEX = FOLDER / "index.md"
_PAGES = {
    "closed": FOLDER / "closed-forms.md",
    "paper": FOLDER / "papers.md",
    "peer": FOLDER / "peers.md",
    "calibration": FOLDER / "calibration.md",
    "sea": FOLDER / "logs.md",
    "fault": FOLDER / "faults.md",
}
"""The page of each level of rows."""
_MARKED = re.compile(r"(<!-- begin rows -->\n).*?(<!-- end rows -->)", re.DOTALL)
_VERDICTS = {HOLDS: "holds", DIFFERS: "differs", FAILS: "**fails**", NOT_MEASURED: "not measured"}


def write(found: dict[str, Found]) -> None:
    """Write each level's rows and the summary between the markers of their pages; what stands around them stays."""
    _put(_INDEX, summary(found))
    for level, page in _PAGES.items():
        _put(page, table(level, found))


def _put(page: Path, text: str) -> None:
    before = page.read_text(encoding="utf-8")
    if not _MARKED.search(before):
        raise ValueError(f"{page.name} has no markers for the rows")
    page.write_text(_MARKED.sub(lambda marks: f"{marks[1]}{text}\n{marks[2]}", before), encoding="utf-8")


def summary(found: dict[str, Found]) -> str:
    """Return how many rows of each level hold, differ, fail and are not measured, with links to the pages."""
    lines = ["| compared with | rows | hold | differ | fail | not measured |", "|" + "---|" * 6]
    for level, title in LEVELS.items():
        lines.append(_counts(f"[{title}]({_PAGES[level].name})", list(rows_of(level)), found))
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
    anchor = f'<span id="{anchor_of(row.name)}"></span>`{row.name}`'
    cells = (anchor, row.claim, row.case, reference, measured, accepted, verdict, f"`{row.command}`")
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def anchor_of(name: str) -> str:
    """Return the anchor of a row on its page."""
    return name.replace(".", "-")


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
    used = ", ".join(f"{package} {version}" for package, version in found.versions.items())
    return f"| `{row.name}` | {found.date} | {found.commit} | {seed} | {cost} | {used} |"
