"""Measure the rows of the validation table and write `validation/measured`: ``python -m validation``.

Without IDs every row is measured that costs less than a minute of CPU; --costly adds the others, an ID measures that
row alone, whatever it costs. Peer programs come with ``pip install 'missionplan[validation]'``; a row whose peer or
record is not here says so, and what it measured before stands. Ends with 1 if a row fails.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from missionplan.mission import load
from missionplan.studies.judgement import ledger
from validation import pages, record, sea_records
from validation.rows import CHEAP, PAGES, ROOT, Options, Row, all_rows

DATA = ROOT.parent / "shared" / "data"
SHOWN = ("index", *PAGES.values(), "speed")
"""The pages with tables."""


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m validation", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "ids", nargs="*", metavar="ID", help="rows, or beginnings of their IDs; default: all cheap ones"
    )
    parser.add_argument("--list", action="store_true", help="print the rows and measure none")
    parser.add_argument("--costly", action="store_true", help=f"also rows of more than {CHEAP:g} s of CPU")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of records of real vehicles")
    parser.add_argument(
        "--work", type=Path, help="folder in which long rows keep what they have done, and go on from it"
    )
    parser.add_argument(
        "--records", type=Path, metavar="FOLDER", help="print the numbers of every log of legs below it"
    )
    parser.add_argument(
        "--assumptions", action="store_true", help="print what each shipped mission takes for granted, and its worth"
    )
    parser.add_argument(
        "--show", metavar="PAGE", choices=SHOWN, help=f"print a page with its tables: {', '.join(SHOWN)}"
    )
    parser.add_argument("--no-write", action="store_true", help="leave validation/measured as it is")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Measure; return 1 if a row fails, 2 if there is no such row, else 0."""
    asked, rows = _parse(words), all_rows()
    unknown = [each for each in asked.ids if not any(name.startswith(each) for name in rows)]
    if unknown:
        print(f"no row {', '.join(unknown)}; --list prints them", file=sys.stderr)
        return 2
    chosen = [each for each in rows.values() if _is_asked(each, asked)]
    if asked.show:
        print(pages.page(asked.show))
        return 0
    if asked.records:
        return _records(asked.records)
    if asked.assumptions:
        return _assumptions()
    if asked.list:
        for each in chosen if asked.ids else rows.values():
            print(f"{each.name:<32} {each.cost:>6g} s  {each.claim}: {each.case}")
        return 0
    with tempfile.TemporaryDirectory(prefix="missionplan-validation-") as scratch:
        options = Options(asked.data, asked.work or Path(scratch))
        options.work.mkdir(parents=True, exist_ok=True)
        failed = [each.name for each in chosen if not _measure(each, options, write=not asked.no_write)]
    print(f"{len(chosen) - len(failed)} of {len(chosen)} rows without a failure" + "".join(f"; {x}" for x in failed))
    return int(bool(failed))


def _records(folder: Path) -> int:
    """Print what every data set of legs below a folder shows that has a mission beside it; 2 if there is none."""
    found = list(sea_records.data_sets_below(folder))
    for name, data, mission in found:
        numbers, diagnosis = sea_records.numbers_of(data, load(mission))
        names = [f"{each.name} [{each.unit}]" if each.unit else each.name for each in sea_records.NUMBERS]
        said = zip([*names, "next legs in 90 % intervals"], map(pages.shown, numbers), strict=True)
        causes = " + ".join(diagnosis.causes) or "no cause"
        print(f"{name}: {diagnosis.verdict}, {causes}; {'; '.join(f'{a} {b}' for a, b in said)}", flush=True)
    if not found:
        print(f"no data set of legs with a mission beside it below {folder}", file=sys.stderr)
    return 0 if found else 2


def _assumptions() -> int:
    """Print the ledger of every mission in `missions`: P(success) and its change with each assumption put off."""
    columns = ("mission", "taken for granted", "instead", "success then", "change", "could turn the answer")
    print(f"| {' | '.join(columns)} |\n{'|---' * len(columns)}|")
    for path in sorted((ROOT / "missions").glob("*.yaml")):
        for each in ledger(load(path), seed=1):
            shares = f"{100.0 * each.success:.1f} % | {100.0 * each.worth:+.1f} %"
            turned = ", ".join(each.missed) or "success" if each.turns else ""
            print(f"| {path.stem} | {each.what} | {each.otherwise} | {shares} | {turned} |", flush=True)
    return 0


def _is_asked(row: Row, asked: argparse.Namespace) -> bool:
    if asked.ids:
        return any(row.name == each or row.name.startswith(f"{each}.") for each in asked.ids) or any(
            row.name.startswith(each) for each in asked.ids if each not in all_rows()
        )
    return asked.costly or row.cost <= CHEAP


def _measure(row: Row, options: Options, *, write: bool) -> bool:
    """Measure a row, print it, and write it down; False if it fails."""
    found = record.measured(row, options, figures=record.FIGURES if write else None)
    numbers = (f"{name} {pages.shown(value)}" for name, value in found.values.items())
    print(f"{row.name}: {found.verdict} {found.why}; {'; '.join(numbers)} ({found.cpu_s:g} s)", flush=True)
    if write:
        known = record.load()
        if found.verdict != record.NOT_MEASURED or row.name not in known:
            known[row.name] = found
        record.save(known)
    return found.verdict != record.FAILS


if __name__ == "__main__":
    sys.exit(main())
