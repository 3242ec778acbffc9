"""Cost of a trial in a field of the current against layers: ``python -m benchmarks.currents``.

The estuary mission with its field, and with one layer of the field's size; processor time of blocks of 4096 trials, in
alternation, the least of five.
"""

import time
from pathlib import Path

from missionplan.mission import Mission, load
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.task import BlockTask

ROUNDS = 5
LAYER = [{"down_to": "12 m", "speed": "0.5 m/s", "toward": "87 deg"}]


def main() -> None:
    """Print the times and their ratio."""
    field = load(Path(__file__).parents[1] / "missions" / "estuary.yaml")
    site = {**field.raw["site"], "current": LAYER}
    layers = Mission.from_data({**field.raw, "site": site})
    tasks = [BlockTask(Scenario.at_means(each, recorded_current(each)), seed=1) for each in (layers, field)]
    least = [float("inf")] * 2
    for _ in range(ROUNDS):
        for number, task in enumerate(tasks):
            started = time.process_time()
            task((1, 4096))
            least[number] = min(least[number], time.process_time() - started)
    print(f"layers {1e3 * least[0]:.0f} ms, field {1e3 * least[1]:.0f} ms: {least[1] / least[0]:.2f} times")


if __name__ == "__main__":
    main()
