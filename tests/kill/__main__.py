"""``python -m tests.kill``: end simulations by signals at random moments, resume them, and compare.

``--target together`` starts eight at once instead, to folders of their own and to one; ``--target other-code`` resumes
killed runs by a copy of the package with another gravity.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from random import Random

from .runs import draw, files_of, killed_and_resumed, resumed_by_other_code, started_together, undisturbed


def main(words: Sequence[str] | None = None) -> int:
    """Run the harness; return 0 without a finding, else 1."""
    parser = argparse.ArgumentParser(prog="python -m tests.kill", description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--target", choices=("kill", "together", "other-code"), default="kill")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    options = parser.parse_args(words)
    print(f"seed {options.seed}")
    with tempfile.TemporaryDirectory(prefix="missionplan-kill-") as scratch:
        found = _TARGETS[options.target](Path(scratch), options.count, Random(options.seed))
    print(f"{options.count - found} of {options.count} without a finding")
    return 1 if found else 0


def _killed(scratch: Path, count: int, random: Random) -> int:
    found = 0
    expected, duration = undisturbed(scratch / "undisturbed" / "out")
    for number in range(count):
        kill, folder = draw(random), scratch / str(number) / "out"
        problems = killed_and_resumed(folder, kill, duration) + _unlike(folder, expected)
        found += bool(problems)
        place = f"{number:3} {kill.backend:<8}{kill.signal.name:<8} after {100 * kill.share:3.0f} %"
        print(f"{place}: {'; '.join(problems) or 'same'}", flush=True)
    return found


def _together(scratch: Path, count: int, random: Random) -> int:
    found = 0
    for number in range(count):
        shared, work = random.random() < 0.5, scratch / str(number)
        work.mkdir()
        problems = started_together(work, 8, shared=shared)
        found += bool(problems)
        print(f"{number:3} {'one folder' if shared else 'their own'}: {'; '.join(problems) or 'none lost'}", flush=True)
    return found


def _other_code(scratch: Path, count: int, random: Random) -> int:
    expected, duration = undisturbed(scratch / "undisturbed" / "out")
    found = 0
    for number in range(count):
        share, folder = random.uniform(0.5, 0.95), scratch / str(number) / "out"
        problems = resumed_by_other_code(folder, share, duration) + _unlike(folder, expected)
        found += bool(problems)
        print(f"{number:3} after {100 * share:3.0f} %: {'; '.join(problems) or 'refused, then same'}", flush=True)
    return found


def _unlike(folder: Path, expected: Mapping[str, object]) -> list[str]:
    return [f"differs: {name}" for name, content in files_of(folder).items() if content != expected.get(name)]


_TARGETS = {"kill": _killed, "together": _together, "other-code": _other_code}

if __name__ == "__main__":
    sys.exit(main())
