"""``python -m tests.fuzz``: damage many examples, and keep those that break something."""

import argparse
import hashlib
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from random import Random

from .attempts import Finding, attempt
from .targets import TARGETS

CASES = Path(__file__).parent / "cases"


def run(name: str, count: int, seed: int, keep: Path | None) -> tuple[Counter[str], dict[str, tuple[str, Finding]]]:
    """Try a number of cases of one target: how they ended, and one finding of each name with its case."""
    target, endings, findings = TARGETS[name], Counter(), {}
    for number in range(count):
        random = Random(f"{name} {seed} {number}")
        with tempfile.TemporaryDirectory(prefix="missionplan-fuzz-") as scratch:
            folder = Path(scratch)
            target.draw(folder, random)
            ending, finding = attempt(lambda folder=folder: target.act(folder), target.limit)
            endings[ending] += 1
            if finding is not None and finding.name not in findings:
                findings[finding.name] = (f"{name} {seed} {number}", finding)
                if keep is not None:
                    _keep(folder, name, finding, keep)
    return endings, findings


def _keep(folder: Path, name: str, finding: Finding, keep: Path) -> None:
    place = keep / f"{name}-{hashlib.sha256(finding.name.encode()).hexdigest()[:8]}"
    if not place.exists():
        shutil.copytree(folder, place, symlinks=True)


def _parse(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("targets", nargs="*", choices=[*TARGETS, []], help="default: all")
    parser.add_argument("--count", type=int, default=300, help="cases of each target")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--no-keep", action="store_true", help=f"do not keep failing cases in {CASES.name}/")
    parser.add_argument("--details", action="store_true", help="print tracebacks")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Run the harness; return 0 without a finding, else 1."""
    options = _parse(words)
    found = 0
    print(f"seed {options.seed}")
    for name in options.targets or TARGETS:
        start = time.monotonic()
        endings, findings = run(name, options.count, options.seed, None if options.no_keep else CASES)
        counts = ", ".join(f"{count} {ending}" for ending, count in sorted(endings.items()))
        print(f"{name:<9} {options.count:6} cases in {time.monotonic() - start:5.0f} s: {counts}", flush=True)
        for case, finding in findings.values():
            lines = finding.details if options.details else finding.details.strip().splitlines()[-1][:150]
            print(f"  {finding.name} ({case}): {lines}", flush=True)
        found += len(findings)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
