"""``python -m tests.hidden_effects``: draw cases, run the tool on them, print the figures."""

import argparse
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict
from functools import partial
from pathlib import Path

from . import score
from .cases import KINDS, draw_case, plan
from .tool import Outcome, diagnose, unavailable_reason


def _one(folder: Path, truths: Path, in_process: bool, jobs: int, arguments: tuple[int, str, str]) -> Outcome:
    return diagnose(draw_case(*arguments), folder, truths, in_process, jobs)


def _strength(arguments: tuple[int, str, str]) -> tuple[str, str, str, float]:
    case = draw_case(*arguments)
    return case.kind, case.scenario, " + ".join(case.truth) or case.outside or "nothing", case.strength


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_effects", description=__doc__)
    parser.add_argument("--cases", type=int, default=400)
    parser.add_argument(
        "--seed", type=int, default=1_000_000, help="seed of the first case; the others are consecutive"
    )
    parser.add_argument("--kind", choices=KINDS, help="only this kind")
    parser.add_argument("--scenario", help="only this scenario (fewer cases then)")
    parser.add_argument("--jobs", type=int, default=2, help="cases at a time; with 1 a case uses every core")
    parser.add_argument("--in-process", action="store_true", help="run the command line without a new process per case")
    parser.add_argument("--keep", type=Path, help="keep cases, reports and truths in this new folder")
    parser.add_argument("--json", type=Path, help="also write the figures to this file")
    parser.add_argument("--strengths", action="store_true", help="only print the strength of each case's effect")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return 0 if no target is refuted, else 1."""
    options = _parse(words)
    drawn = plan(options.cases, options.seed, options.kind)
    drawn = [each for each in drawn if options.scenario in (None, each[2])]
    with tempfile.TemporaryDirectory() as scratch, ExitStack() as stack:
        each_of = map if options.jobs == 1 else stack.enter_context(ProcessPoolExecutor(options.jobs)).map
        if options.strengths:
            for kind, scenario, name, value in sorted(each_of(_strength, drawn)):
                print(f"{kind:<8} {scenario:<8} {name:<44} {value:8.1f}")
            return 0
        if reason := unavailable_reason():
            print(reason, file=sys.stderr)
            return 2
        outcomes = _diagnose_all(options, drawn, each_of, options.keep or Path(scratch))
    return _judge(options, outcomes)


def _diagnose_all(
    options: argparse.Namespace, drawn: Sequence[tuple[int, str, str]], each_of: Callable, root: Path
) -> list[Outcome]:
    cases, truths = root / "cases", root / "truths"
    cases.mkdir(parents=True)
    outcomes = []
    tool_jobs = 0 if options.jobs == 1 else 1
    for outcome in each_of(partial(_one, cases, truths, options.in_process, tool_jobs), drawn):
        outcomes.append(outcome)
        print(f"\r{len(outcomes)}/{len(drawn)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return outcomes


def _judge(options: argparse.Namespace, outcomes: Sequence[Outcome]) -> int:
    print(score.page(outcomes))
    by_kind = {kind: score.figures([o for o in outcomes if o.case.kind == kind]) for kind in KINDS}
    if options.json:
        options.json.write_text(json.dumps({kind: [asdict(f) for f in fs] for kind, fs in by_kind.items()}, indent=1))
    return int(any(figure.refuted for figures in by_kind.values() for figure in figures))


if __name__ == "__main__":
    sys.exit(main())
