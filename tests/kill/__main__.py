"""``python -m tests.kill``: end simulations by signals at random moments, resume them, and compare."""

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from random import Random

from .runs import draw, files_of, killed_and_resumed, undisturbed


def main(words: Sequence[str] | None = None) -> int:
    """Run the harness; return 0 without a finding, else 1."""
    parser = argparse.ArgumentParser(prog="python -m tests.kill", description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    options = parser.parse_args(words)
    random, found = Random(options.seed), 0
    print(f"seed {options.seed}")
    with tempfile.TemporaryDirectory(prefix="missionplan-kill-") as scratch:
        expected, duration = undisturbed(Path(scratch) / "undisturbed" / "out")
        for number in range(options.count):
            kill, folder = draw(random), Path(scratch) / str(number) / "out"
            problems = killed_and_resumed(folder, kill, duration)
            differ = [name for name, content in files_of(folder).items() if content != expected.get(name)]
            problems += [f"differs: {name}" for name in differ]
            found += bool(problems)
            place = f"{number:3} {kill.backend:<8}{kill.signal.name:<8} after {100 * kill.share:3.0f} %"
            print(f"{place}: {'; '.join(problems) or 'same'}", flush=True)
    print(f"{options.count - found} of {options.count} without a finding")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
