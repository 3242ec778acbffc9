"""The pages of `docs/validation` that are made from what the rows measured."""

import math
import re

from validation.record import DIFFERS, FAILS, FOLDER, HOLDS, NOT_MEASURED, Found
from validation.rows import CHEAP, LEVELS, Accepted, Row, all_rows

PAGE = FOLDER / "index.md"
_BEGIN, _END = "<!-- begin rows -->", "<!-- end rows -->"
_VERDICTS = {HOLDS: "holds", DIFFERS: "differs", FAILS: "**fails**", NOT_MEASURED: "not measured"}


def write(found: dict[str, Found]) -> None:
    """Write the table between its markers; what stands before and after stays."""
    page = PAGE.read_text(encoding="utf-8")
    marked = re.compile(rf"{_BEGIN}\n.*?{_END}", re.DOTALL)
    if not marked.search(page):
        raise ValueError(f"{PAGE.name} has no markers for the rows")
    text = table(found)
    PAGE.write_text(marked.sub(lambda _: f"{_BEGIN}\n{text}\n{_END}", page), encoding="utf-8")


def table(found: dict[str, Found]) -> str:
    """Return the table, level by level, with figures, and when and with what each row was measured."""
    rows = all_rows()
    parts = [_counts(rows, found), ""]
    for level, title in LEVELS.items():
        own = [each for each in rows.values() if each.level == level]
        parts += [f"## {title}", ""]
        parts += ["| ID | claim | case | reference | measured | accepted | verdict | command |", "|" + "---|" * 8]
        parts += [_line(each, found.get(each.name)) for each in own]
        parts.append("")
        notes = [f"`{each.name}`: {each.differs}" for each in own if each.differs]
        parts += ["Where the reference is not met:", "", *(f"- {note}" for note in notes), ""] if notes else []
        for each in own:
            seen = found.get(each.name)
            if seen is not None and seen.has_figure:
                parts += [f"![{each.claim}: {each.case}](figures/{each.name}.svg)", ""]
    parts += ["## When and with what", "", "| ID | date | commit | seed | CPU time | versions |", "|" + "---|" * 6]
    parts += [_circumstances(each, found[name]) for name, each in rows.items() if name in found]
    return "\n".join(parts)


def _counts(rows: dict[str, Row], found: dict[str, Found]) -> str:
    counts = {verdict: sum(each.verdict == verdict for each in found.values()) for verdict in _VERDICTS}
    never = len(rows) - len(found)
    return (
        f"{len(rows)} rows: {counts[HOLDS]} hold, {counts[DIFFERS]} differ for a reason that is given, "
        f"{counts[FAILS]} fail, {counts[NOT_MEASURED] + never} not measured."
    )


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
    """Return the anchor of a row on the page."""
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
