"""Make the figure and the tables of `docs/drift-filter.md`: `python docs/figures/drift_filter.py` (some minutes).

The tables go to standard output.
"""

from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import yaml

from missionplan import Mission
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.policy import best_legs
from missionplan.studies.leg_length import SweepScenario
from missionplan.studies.leg_length.analytic_transit import replace_first_leg
from missionplan.studies.leg_length.paired_trials import LegsAtSpeed, run_plans

FOLDER = Path(__file__).parent
MODES = ("none", "forecast", "last-leg", "mean", "filter")
CURRENTS = (0.0, 0.1, 0.2, 0.3)
TIMES = (60.0, 600.0, 3600.0, 21600.0, 1e7)
SHARES = np.linspace(0.1, 1.0, 19)
SIGMAS = (0.01, 0.02, 0.035, 0.06, 0.1)
TRIALS = 4096
MISSION = """
name: An unknown mean current and a persistent error
navigation:
  velocity_error: {{mean: [{component}, {component}], sigma: 0.02 m/s}}
  surfacing_time: 90 s
  fix_error: 3 m
  drift_compensation: {mode}
phases:
  - transit: {{from: [0 m, 0 m], to: [8 km, 0 m], speed: 1 m/s, d_max: 2 km, arrival_radius: 50 m}}
effects:
  - persistent-error: {{sigma: 0.05 m/s, time: {time} s}}
"""


@dataclass(frozen=True)
class Cell:
    """Costs of each mode with its own best legs, and the filter's excess over the best other mode [%]."""

    costs: tuple[float, ...]
    excess: float
    excess_error: float


def cell(current: float, time: float, trials: int = TRIALS, *, fixed: bool = False) -> Cell:
    """Run every compensation mode on the same trials.

    Parameters
    ----------
    current : float
        Root mean square of the unknown mean current, normal on each axis, truncated at 2.5 sd [m/s].
    time : float
        Correlation time of the persistent error [s].
    trials : int
    fixed : bool
        Whether only fixed d_max are allowed.
    """
    best = [_best(mode, current, time, trials, fixed) for mode in MODES]
    others = min(best[:-1], key=lambda costs: float(costs.mean()))
    excess = best[-1] - others
    return Cell(
        tuple(float(costs.mean()) for costs in best),
        float(excess.mean()),
        float(excess.std(ddof=1) / np.sqrt(trials)),
    )


def family(scenario: SweepScenario, fixed: bool) -> list[LegsAtSpeed]:
    """Fixed d_max and, unless `fixed`, adaptive legs for several errors with first legs of several lengths."""
    lengths = [float(share * scenario.distance) for share in SHARES]
    plans: list[float | LegTable] = [*lengths]
    if fixed:
        return [LegsAtSpeed(plan) for plan in plans]
    for table in tables(scenario.distance, scenario.speed, scenario.arrival_radius, scenario.surfacing_time):
        plans += [table, *(replace_first_leg(table, scenario.distance, length) for length in lengths)]
    return [LegsAtSpeed(plan) for plan in plans]


@cache
def tables(distance: float, speed: float, arrival_radius: float, surfacing_time: float) -> list[LegTable]:
    """Best legs for several velocity errors, with the spread due to fix errors of 3 m."""
    base = 3.0 * np.sqrt(2.0)
    return [best_legs(distance, speed, arrival_radius, sigma, surfacing_time, base).legs for sigma in SIGMAS]


def _best(mode: str, current: float, time: float, trials: int, fixed: bool) -> np.ndarray:
    """Costs of the trials with the best legs of a mode [%]."""
    sd = current / np.sqrt(2.0)
    spread = f"{{mean: 0 m/s, sd: {sd:.6f} m/s, low: {-2.5 * sd:.6f} m/s, high: {2.5 * sd:.6f} m/s}}"
    component = spread if current else "0 m/s"
    mission = Mission.from_data(yaml.safe_load(MISSION.format(component=component, mode=mode, time=time)))
    scenario = replace(SweepScenario.of(mission), sigmas=(None,))
    runs = run_plans(scenario, family(scenario, fixed), seed=1, block=0, size=trials)
    costs = [100.0 * run.cost for run in runs if run.arrived.all()]
    return min(costs, key=lambda values: float(values.mean()))


def main() -> None:
    """Run the grid with the best legs and with the best fixed d_max, print the tables, draw the figure of the first."""
    grid = {(current, time): cell(current, time) for current in CURRENTS for time in TIMES}
    print_table(grid)
    draw(grid)
    print_table({(current, time): cell(current, time, fixed=True) for current in CURRENTS for time in TIMES})


def print_table(grid: dict[tuple[float, float], Cell]) -> None:
    """Print a grid as Markdown."""
    print("| mean current, m/s | persists for, s | " + " | ".join(MODES) + " | filter less the best other |")
    print("|" + "---|" * (len(MODES) + 3))
    for (current, time), found in grid.items():
        costs = " | ".join(f"{cost:.2f} %" for cost in found.costs)
        print(f"| {current:g} | {time:g} | {costs} | {found.excess:+.3f} ± {found.excess_error:.3f} % |")


def draw(grid: dict[tuple[float, float], Cell]) -> None:
    """Draw the excess cost of each mode over the filter against persistence, a panel for each mean current."""
    figure, panels = plt.subplots(1, len(CURRENTS), sharey=True, figsize=(9.0, 3.4))
    for axes, current in zip(panels, CURRENTS, strict=True):
        filtered = np.array([grid[current, time].costs[-1] for time in TIMES])
        for number, mode in enumerate(MODES[:-1]):
            costs = np.array([grid[current, time].costs[number] for time in TIMES])
            axes.plot(TIMES, costs - filtered, ".-" if mode != "forecast" else ".:", label=mode)
        axes.axhline(0.0, color="0.3", linewidth=1.0)
        axes.annotate(f"filter {filtered.min():.1f} to {filtered.max():.1f} %", (60.0, -0.055), fontsize=8)
        axes.set(title=f"mean current {current:g} m/s", xscale="log", xlabel="error persists for [s]")
    panels[0].set(ylabel="cost less the filter's, best legs of each [%]", ylim=(-0.08, 0.55))
    panels[0].legend(fontsize=8)
    figure.savefig(FOLDER / "drift-filter.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    with plt.style.context(str(files("missionplan.report") / "style.mplstyle")):
        main()
