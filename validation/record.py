"""What the rows measured, kept in `validation/measured`: numbers, verdict, seed, versions, commit, date."""

import json
import math
import platform
import re
import subprocess
import time
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from missionplan.report.page import draw, style
from validation.rows import PAGES, ROOT, NotMeasurableHereError, Options, Row, all_rows, rows_of

FOLDER = ROOT / "docs" / "validation"
FIGURES = FOLDER / "figures"
STORE = ROOT / "validation" / "measured"
HOLDS, DIFFERS, FAILS, NOT_MEASURED = "holds", "differs", "fails", "not measured"
LIBRARIES = ("numpy", "scipy")
_WHITE = '<rect width="100%" height="100%" fill="#ffffff"/>'
"""Behind a figure, so that it is legible on any page."""


@dataclass(frozen=True)
class Found:
    """What a row measured, when and with what.

    Attributes
    ----------
    values : dict
        By the names of the row's `accepted`; None stands for nan.
    verdict : str
    why : str
        Why it could not be measured.
    cpu_s : float
        CPU time of this process and its children [s].
    """

    values: dict[str, float | None]
    verdict: str
    date: str
    commit: str
    versions: dict[str, str]
    seed: int | None
    cpu_s: float
    has_figure: bool = False
    why: str = ""


def measured(row: Row, options: Options, *, figures: Path | None) -> Found:
    """Measure a row; its figure, if any, is written to a folder."""
    began, why, has_figure = _cpu(), "", False
    values: dict[str, float | None] = {}
    try:
        result = row.measure(options)
        judged = [each.holds(float(value)) for each, value in zip(row.accepted, result.values, strict=True)]
    except NotMeasurableHereError as reason:
        verdict, why = NOT_MEASURED, str(reason)
    except Exception as fault:  # the other rows are measured all the same
        verdict, why = FAILS, f"{type(fault).__name__}: {fault}"
    else:
        numbers = zip(row.accepted, result.values, strict=True)
        values = {each.name: None if math.isnan(value) else _rounded(value) for each, value in numbers}
        verdict = (DIFFERS if row.differs else HOLDS) if all(judged) else FAILS
        has_figure = result.figure is not None
        if result.figure is not None and figures is not None:
            figures.mkdir(exist_ok=True)
            with style():
                svg = draw(result.figure).svg
            text = re.sub(r"(<svg[^>]*>)", rf"\1{_WHITE}", svg, count=1)
            (figures / f"{row.name}.svg").write_text(text, encoding="utf-8")
    return Found(
        values,
        verdict,
        f"{datetime.now(UTC):%Y-%m-%d}",
        commit(),
        versions(row.packages),
        row.seed,
        round(_cpu() - began, 1),
        has_figure,
        why,
    )


def load() -> dict[str, Found]:
    """Return what was measured, by ID, but for rows that are no longer in the table or have other numbers now."""
    kept: dict[str, Any] = {}
    for page in PAGES.values():
        kept |= json.loads((STORE / f"{page}.json").read_text(encoding="utf-8"))
    found = {name: Found(**kept[name]) for name in all_rows() if name in kept}
    return {
        name: each
        for name, each in found.items()
        if not each.values or each.values.keys() == {number.name for number in all_rows()[name].accepted}
    }


def save(found: dict[str, Found]) -> None:
    """Write what was measured, one file a page, sorted, so that what differs is what was measured again."""
    for level, page in PAGES.items():
        written = {each.name: asdict(found[each.name]) for each in rows_of(level) if each.name in found}
        text = json.dumps(written, indent=1, sort_keys=True, ensure_ascii=False)
        (STORE / f"{page}.json").write_text(f"{text}\n", encoding="utf-8")


def commit() -> str:
    """Return the commit that the code is of, with a ``+`` where files of the package differ from it."""
    try:
        words = ["git", "-C", str(ROOT)]
        name = subprocess.run([*words, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True)
        changed = subprocess.run([*words, "status", "--porcelain", "missionplan"], capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return name.stdout.strip() + ("+" if changed.stdout.strip() else "")


def versions(packages: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of Python, the numerical libraries and the peers that are installed."""
    found = {"Python": platform.python_version()}
    for name in (*LIBRARIES, *packages):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _cpu() -> float:
    import os

    used = os.times()
    return time.process_time() + used.children_user + used.children_system


def _rounded(value: float) -> float:
    """Five digits: more are never shown, and the last bits vary from machine to machine."""
    return float(f"{value:.5g}")
