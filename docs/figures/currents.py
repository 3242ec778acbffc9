"""Make the figure of `docs/currents.md`: `python docs/figures/currents.py` (seconds; needs missionplan[netcdf])."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from missionplan import load
from missionplan.phases.currents import Current
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.simulate import simulate

FOLDER = Path(__file__).parent
WINDOW = (3500.0, 7600.0, -800.0, 800.0)
"""West, east, south and north end of the map [m]."""


def main() -> None:
    """Draw the field with a track, and a section along the course."""
    mission = load(FOLDER.parents[1] / "missions" / "estuary.yaml")
    current = recorded_current(mission)
    if current is None:
        raise SystemExit("the mission has no current")
    tracks = simulate(mission, trials=300).tracks
    figure, (plan, section) = plt.subplots(2, 1, figsize=(7.0, 6.4), height_ratios=(1.6, 1.0), layout="constrained")
    _map(plan, current, tracks.position, tracks.phase)
    _section(section, current)
    plt.rcParams["svg.hashsalt"] = "missionplan"
    figure.savefig(FOLDER / "currents-estuary.svg", metadata={"Date": None})


def _map(axes: plt.Axes, current: Current, position: np.ndarray, phase: np.ndarray) -> None:
    west, east, south, north = WINDOW
    x, y = np.meshgrid(np.linspace(west, east, 34), np.linspace(south, north, 22))
    place = np.stack((x.ravel(), y.ravel()))
    velocity = np.where(current.holds(place), current.velocity(900.0, 3.0, place), np.nan)
    speed = np.hypot(*velocity)
    arrows = axes.quiver(*place / 1e3, *velocity, speed, cmap="viridis", scale=22.0, width=0.0022)
    axes.figure.colorbar(arrows, ax=axes, label="current 3 m down (m/s)")
    for trial in range(30):
        way = position[phase == 0, :, trial] / 1e3
        axes.plot(way[:, 0], way[:, 1], color="tab:red", linewidth=0.6, alpha=0.5)
    axes.plot([4.7, 7.0], [-0.15, 0.1], "o", color="tab:red", markersize=4)
    axes.set(xlabel="east of the origin (km)", ylabel="north (km)", aspect="equal", xlim=(3.5, 7.6), ylim=(-0.8, 0.8))
    axes.set_title("A quarter of an hour after the start, and the way there of thirty trials", fontsize=10)


def _section(axes: plt.Axes, current: Current) -> None:
    share, depth = np.meshgrid(np.linspace(0.0, 1.0, 120), np.linspace(0.0, 12.0, 60))
    place = np.stack((4700.0 + 2300.0 * share.ravel(), -150.0 + 250.0 * share.ravel()))
    velocity = current.velocity(900.0, depth.ravel(), place)
    along = (velocity[0] * 2300.0 + velocity[1] * 250.0) / np.hypot(2300.0, 250.0)
    drawn = axes.contourf(share * 2.313, depth, along.reshape(share.shape), levels=14, cmap="viridis")
    axes.figure.colorbar(drawn, ax=axes, label="along the course (m/s)")
    axes.axhline(3.0, color="tab:red", linewidth=1.0)
    axes.set(xlabel="distance along the course (km)", ylabel="depth (m)", ylim=(12.0, 0.0))
    axes.set_title("Section along the course; the line is the depth of the transit", fontsize=10)


if __name__ == "__main__":
    main()
