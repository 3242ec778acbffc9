"""Made-up files that a page's reader would bring along: ``python .ci/doc_data.py NAME`` writes them here."""

import datetime
import json
import math
import sys
from pathlib import Path

import numpy as np


def log() -> None:
    """A table of a vehicle's positions, for `docs/import.md`: ten dives, half an hour under water each."""
    lines, start = ["UTC,Latitude,Longitude,z"], datetime.datetime(2026, 5, 1, 8, tzinfo=datetime.UTC)
    for dive in range(10):
        for step in range(201):  # the last two minutes at the surface
            time = start + datetime.timedelta(seconds=2000 * dive + 10 * step)
            under = step < 180
            depth = 60 * math.sin(math.pi * step / 180) if under else 0
            north = 1.0 * 1800 * dive + 10 * min(step, 180) + (0 if under else 40)
            latitude = 37.2 + (north + 40 * dive) / 111000
            lines.append(f"{time:%Y-%m-%dT%H:%M:%SZ},{latitude:.6f},-76.1,{depth / 0.3048:.1f}")
    _write("log.csv", lines)


def bay() -> None:
    """Depths, a point of land and a ferry lane, for `docs/place.md`."""
    across, along = range(-1500, 2001, 50), range(-1500, 1501, 50)
    _write("bay.xyz", [f"{x} {y} {-(12 + 0.012 * (x + 1500)):.2f}" for x in across for y in along])
    lane = {"name": "ferry lane", "from": "2026-06-01T09:00Z", "to": "2026-06-01T12:00Z", "above": "10 m"}
    feature = {"type": "Feature", "properties": lane, "geometry": _box(600, -500, 700, 800)}
    _write("coast.geojson", [json.dumps(_box(400, -300, 520, 120))])
    _write("lane.geojson", [json.dumps(feature)])


def mooring() -> None:
    """A month of a current meter, for `docs/tide.md`."""
    rng = np.random.default_rng(1)
    t = np.arange(0, 30 * 86400, 1200.0)
    lines = ["t_s,depth_m,east_m_s,north_m_s"]
    for depth in (2, 28):
        tide = 0.4 * np.cos(2 * np.pi * t / 44714.16) + 0.1 * np.cos(2 * np.pi * t / 43200)
        east, north = 0.02 + tide + rng.normal(0, 0.03, (2, t.size))
        times = np.datetime_as_string(np.datetime64("2026-05-01T00:00:00") + t.astype("timedelta64[s]"))
        lines += [f"{time}Z,{depth},{e:.3f},{n:.3f}" for time, e, n in zip(times, east, north, strict=True)]
    _write("mooring.csv", lines)


def legs() -> None:
    """The data set of the leg in `docs/data-sets.md`, with seven more."""
    _write("legs/dataset.yaml", ["kind: transit", "file: legs.csv"])
    times = ((n, f"2026-05-01T0{n}:10:00Z,2026-05-01T0{n}:14:26Z") for n in range(2, 9))
    _append("legs/legs.csv", [f"{n},{time},-200.1,200.3,200.0,200.0,20{n}.3,214.9,0,2" for n, time in times])


def dives() -> None:
    """The rest of the dives of which `docs/data-sets.md` shows the first readings."""
    readings = [0.5 * step for step in range(2, 60)]
    _append("dives/dives.csv", [f"dive-{n},{t},{min(t, 24.0)}" for n in (1, 2) for t in readings])


def _box(west: float, south: float, east: float, north: float) -> dict[str, object]:
    corners = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    return {"type": "Polygon", "coordinates": [corners]}


def _write(name: str, lines: list[str]) -> None:
    Path(name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _append(name: str, lines: list[str]) -> None:
    _write(name, [Path(name).read_text(encoding="utf-8").rstrip("\n"), *lines])


if __name__ == "__main__":
    {"log": log, "bay": bay, "mooring": mooring, "legs": legs, "dives": dives}[sys.argv[1]]()
