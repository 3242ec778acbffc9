"""Run the comparisons and update `validation/measured/speed.json`: ``python -m benchmarks``.

Each comparison alternates with its reference program and gives ratios. On two idle cores all of them
take about eight minutes; name one to run it alone, --quick for a smoke test, --long to add ten million trials.
"""

import argparse
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from benchmarks import choosing, commands, currents, descent, monaco_peer, place, rare, scaling, sweep, table
from benchmarks.common import Comparison, Options, circumstances, load_average

COMPARISONS: dict[str, Comparison] = {
    "sweep": sweep.compare,
    "commands": commands.compare,
    "studies": commands.studies,
    "descent": descent.compare,
    "diagnosis": commands.diagnoses,
    "monaco": monaco_peer.compare,
    "rare": rare.compare,
    "choosing": choosing.compare,
    "currents": currents.compare,
    "place": place.compare,
    "trials": scaling.trials,
    "legs": scaling.legs,
}
QUICK = 8
"""Divisor of the sizes with --quick; a power of 2, which suits monaco's Sobol samples."""


def main() -> None:
    """Run the comparisons asked for, print their tables and write them down."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(COMPARISONS)}; default: all")
    parser.add_argument("--repeats", type=int, default=3, help="times that each side is run; the median counts")
    parser.add_argument("--quick", action="store_true", help=f"sizes divided by {QUICK}, one repeat, nothing written")
    parser.add_argument("--long", action="store_true", help="also ten million trials")
    parser.add_argument("--no-write", action="store_true", help=f"leave {table.STORE.name} as it is")
    asked = parser.parse_args()
    unknown = [name for name in asked.names if name not in COMPARISONS]
    if unknown:
        parser.error(f"no comparison {', '.join(unknown)}; there are {', '.join(COMPARISONS)}")
    options = Options(1, QUICK, asked.long) if asked.quick else Options(asked.repeats, 1, asked.long)
    for name in asked.names or COMPARISONS:
        load = load_average()
        section = COMPARISONS[name](options)
        measured = circumstances(section.packages, load)
        print(f"{name}: {measured.words()}\n{table.as_text(section)}\n", flush=True)
        if not (asked.quick or asked.no_write):
            table.write(name, section, measured)


if __name__ == "__main__":
    main()
