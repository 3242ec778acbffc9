"""Cost of a trial over a grid of a million depths, and past a coast, against the same mission in water of one depth.

Processor time of blocks of the Chesapeake mission in alternation, the least of all. The grids: deep enough all the way,
as a bay is; shoals about the tracks, so that ways have to be looked at closely; and a slope on which the depth changes
by decimetres while the anchor drifts. The coast has a thousand corners, 60 m from the track.
"""

import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.common import ROOT, Options, Row, Section
from missionplan.arrays import Array
from missionplan.mission import Mission, load
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.block_sequence import BlockTask

MOST = 1.3
CELLS = 1000
"""Along each side of the grid."""
BOTTOMS: dict[str, Callable[[Array, Array], Array]] = {
    "a bay 12 m deep": lambda x, y: 12.2 + 0.2 * np.sin(x / 90.0) * np.cos(y / 70.0),
    "shoals of 3 m about the tracks": lambda x, y: 7.7 + 4.5 * np.sin(x / 60.0) * np.cos(y / 60.0),
    "a slope of 1 in 20": lambda x, y: 12.2 + 0.05 * y + 0.0 * x,
}


def compare(options: Options) -> Section:
    """Compare blocks over each grid, and past the coast too, with blocks in water of one depth."""
    flat = load(ROOT / "missions" / "chesapeake.yaml")
    with tempfile.TemporaryDirectory() as folder:
        rows = [_row(name, flat, _over(flat, Path(folder), bottom), options) for name, bottom in BOTTOMS.items()]
        name, bottom = next(iter(BOTTOMS.items()))
        by_coast = _over(flat, Path(folder), bottom, has_coast=True)
        rows.append(_row(f"{name}, past a coast", flat, by_coast, options))
    return Section(tuple(rows), packages=("numpy", "scipy", "shapely"))


def _over(flat: Mission, folder: Path, bottom: Callable[[Array, Array], Array], *, has_coast: bool = False) -> Mission:
    """The mission over a grid of depths, and past a coast."""
    import xarray

    x = np.linspace(-5000.0, 7000.0, CELLS)
    depth = bottom(x[None, :], x[:, None]) + 0.0 * x[:, None]
    xarray.Dataset({"depth": (("y", "x"), depth, {"units": "m"})}, coords={"x": x, "y": x}).to_netcdf(folder / "sea.nc")
    turn = np.linspace(0.0, 2.0 * np.pi, 1001)
    radius = 500.0 + 10.0 * np.sin(37.0 * turn)
    ring = np.stack((800.0 + radius * np.cos(turn), 570.0 + radius * np.sin(turn)), axis=1)
    (folder / "land.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring.tolist()]}))
    site = {key: value for key, value in flat.raw["site"].items() if key != "depth"}
    site["current"] = [*site["current"][:-1], {**site["current"][-1], "down_to": "200 m"}]
    files = {"bathymetry": "sea.nc"} | ({"land": "land.geojson"} if has_coast else {})
    placed = {key: {"file": str(folder / name), "projection": "local"} for key, name in files.items()}
    return Mission.from_data({**flat.raw, "site": {**site, **placed}})


def _row(name: str, flat: Mission, over: Mission, options: Options) -> Row:
    size = 4096 // options.shrink
    tasks = [BlockTask(Scenario.at_means(each), seed=1) for each in (flat, over)]
    least = [float("inf")] * 2
    for _ in range(options.repeats + 2):
        for number, task in enumerate(tasks):
            started = time.process_time()
            task((1, size))
            least[number] = min(least[number], time.process_time() - started)
    plain, grid = least
    what = f"{size} trials of the Chesapeake mission over 10⁶ cells: {name} (beside: one depth)"
    ratio = grid / plain
    return Row(
        what, f"{1e3 * grid:.0f} ms", f"{1e3 * plain:.0f} ms", f"{ratio:.2f} × as long", f"≤ {MOST}", ratio <= MOST
    )
