"""Cost of a trial in a field of the current against layers: the estuary mission, with its field and with one layer.

Processor time of blocks in alternation, the least of all.
"""

import time

from benchmarks.common import ROOT, Options, Row, Section
from missionplan.mission import Mission, load
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.block_sequence import BlockTask

SIZES = 2000, 4096
"""Trials of a block: those of a cell of an exploration, and those of a block of a simulation."""
LAYER = [{"down_to": "12 m", "speed": "0.5 m/s", "toward": "87 deg"}]
MOST = 1.5


def compare(options: Options) -> Section:
    """Compare blocks in the field with blocks in the layer."""
    field = load(ROOT / "missions" / "estuary.yaml")
    layers = Mission.from_data({**field.raw, "site": {**field.raw["site"], "current": LAYER}})
    tasks = [BlockTask(Scenario.at_means(each, recorded_current(each)), seed=1) for each in (layers, field)]
    return Section(tuple(_row(tasks, size // options.shrink, options.repeats + 2) for size in SIZES))


def _row(tasks: list[BlockTask], size: int, rounds: int) -> Row:
    least = [float("inf")] * len(tasks)
    for _ in range(rounds):
        for number, task in enumerate(tasks):
            started = time.process_time()
            task((1, size))
            least[number] = min(least[number], time.process_time() - started)
    layer, field = least
    return Row(
        f"{size} trials of the estuary in its field (beside: in one layer)",
        f"{1e3 * field:.0f} ms",
        f"{1e3 * layer:.0f} ms",
        f"{field / layer:.1f} × as long",
        f"≤ {MOST}",
        field <= MOST * layer,
    )
