"""Draw the figures of `docs/adaptive-legs.md`: `python docs/figures/adaptive_legs.py`."""

from importlib.resources import files
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from missionplan.phases.transit.expectation import expected_transit
from missionplan.phases.transit.policy import best_legs

FOLDER = Path(__file__).parent
DISTANCE, SPEED, ARRIVAL_RADIUS, SURFACING_TIME = 7408.0, 1.25, 50.0, 90.0


def teeth() -> None:
    """Cost and expected legs against d_max."""
    ratios = np.linspace(0.18, 1.06, 353)
    figure, (cost, legs) = plt.subplots(2, 1, sharex=True, figsize=(6.0, 5.4))
    for sigma in (0.015, 0.035, 0.055):
        transits = [
            expected_transit(DISTANCE, ratio * DISTANCE, SPEED, ARRIVAL_RADIUS, sigma, SURFACING_TIME)
            for ratio in ratios
        ]
        (line,) = cost.plot(ratios, [100.0 * transit.cost for transit in transits])
        cost.annotate(f"{sigma:g} m/s", (ratios[-1], 100.0 * transits[-1].cost), color=line.get_color(), va="bottom")
        legs.plot(ratios, [transit.surfacings for transit in transits])
    for axes in (cost, legs):
        for a in range(1, 6):
            axes.axvline(1.0 / a, color="0.7", linewidth=0.8, linestyle=":", zorder=0)
    cost.set(ylabel="cost [%]", ylim=(0.0, 8.5), xlim=(0.18, 1.14))
    legs.set(ylabel="expected legs", xlabel="d_max / distance")
    figure.savefig(FOLDER / "teeth.svg", metadata={"Date": None})
    plt.close(figure)


def policy() -> None:
    """Aim of the best legs against the distance left, and their cost compared with a fixed d_max."""
    figure, (aims, costs) = plt.subplots(1, 2, figsize=(8.0, 3.7))
    left = np.geomspace(ARRIVAL_RADIUS, DISTANCE, 400)
    for sigma in (0.015, 0.035, 0.055):
        legs = best_legs(DISTANCE, SPEED, ARRIVAL_RADIUS, sigma, SURFACING_TIME).legs
        (line,) = aims.plot(left, left - legs(left))
        label = (1.05 * left[-1], left[-1] - legs(left[-1:])[0])
        aims.annotate(f"{sigma:g} m/s", label, color=line.get_color(), va="center")
    aims.axhline(ARRIVAL_RADIUS, color="0.5", linewidth=0.8, linestyle=":")
    aims.annotate("arrival radius", (ARRIVAL_RADIUS, ARRIVAL_RADIUS), color="0.4", va="bottom", fontsize=8)
    aims.set(
        xscale="log",
        yscale="log",
        xlim=(45.0, 3e4),
        xlabel="distance left [m]",
        ylabel="leg falls short of the target by [m]",
    )

    sigmas = np.linspace(0.005, 0.08, 16)
    ratios = np.linspace(0.1, 1.0, 91)
    fixed = [
        min(expected_transit(DISTANCE, r * DISTANCE, SPEED, ARRIVAL_RADIUS, s, SURFACING_TIME).cost for r in ratios)
        for s in sigmas
    ]
    best = [best_legs(DISTANCE, SPEED, ARRIVAL_RADIUS, s, SURFACING_TIME).bound for s in sigmas]
    one_leg = [expected_transit(DISTANCE, DISTANCE, SPEED, ARRIVAL_RADIUS, s, SURFACING_TIME).cost for s in sigmas]
    for name, values, place in (
        ("one leg", one_leg, "bottom"),
        ("best fixed d_max", fixed, "bottom"),
        ("best legs", best, "top"),
    ):
        (line,) = costs.plot(sigmas, 100.0 * np.array(values))
        costs.annotate(name, (sigmas[-3], 100.0 * values[-3]), color=line.get_color(), ha="right", va=place)
    costs.set(xlabel="σ_v [m/s]", ylabel="cost [%]", ylim=(0.0, None))
    figure.savefig(FOLDER / "best-legs.svg", metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    with plt.style.context(str(files("missionplan.report") / "style.mplstyle")):
        teeth()
        policy()
