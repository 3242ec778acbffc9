"""The place of a mission: ground, zones and sea level, from the files that its site names."""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem, shown
from missionplan.mission import Mission
from missionplan.mission.schema.place import BathymetryFile, Geographic, TideHeight, to_plane
from missionplan.mission.schema.site import Site
from missionplan.mission.views import required_origin
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.ground import Frame, Ground
from missionplan.phases.place import Place, SeaLevel
from missionplan.phases.zones import Fence, Zone
from missionplan.physics.water import angular_frequencies, nodal_state
from missionplan.scenario import grid_files
from missionplan.scenario.grid_files import Grid
from missionplan.scenario.polygons import DEGREES, LOCAL, Chart, longitude_beside

MAX_BYTES = 2_000_000_000
"""Of a file of depths."""
_HIGHEST, _DEEPEST = 9000.0, 11_500.0
"""Heights and depths beyond which a value is none of this planet: a fill value, or another unit [m]."""
_IRREGULAR = 0.05
"""Share of a step by which nodes may be off an even spacing, as single precision makes them."""


def read_ground(chart: Chart) -> Ground:
    """Read a file of depths.

    Raises InputError when the file cannot be read, is impossible, or holds nothing about the mission.
    """
    readers: dict[tuple[str, ...], Callable[[Chart], Grid]] = {
        (".nc", ".nc4", ".cdf", ".netcdf", ".grd"): grid_files.netcdf,
        (".tif", ".tiff"): grid_files.geotiff,
        (".asc", ".agr", ".grid"): grid_files.esri,
        (".xyz", ".txt", ".csv", ".dat"): grid_files.xyz,
        (".geojson", ".json"): grid_files.contours,
    }
    ending = chart.path.suffix.lower()
    reader = next((reader for endings, reader in readers.items() if ending in endings), None)
    if reader is None:
        expected = ", ".join(ending for endings in readers for ending in endings)
        raise chart.problem(f"given {shown(chart.path.name)}; expected a file that ends in {expected}")
    if chart.path.stat().st_size > MAX_BYTES:
        raise chart.problem(f"is larger than {MAX_BYTES / 1e9:g} GB: cut the mission's part out of it")
    try:
        grid = reader(chart)
    except InputError as error:
        raise InputError([replace(problem, key=problem.key or chart.key) for problem in error.problems]) from None
    except (OSError, ValueError, KeyError, IndexError, ArithmeticError, SyntaxError, TypeError) as error:
        raise chart.problem(f"cannot be read: {type(error).__name__}: {error}") from None
    return ground_of(chart, grid)


def ground_of(chart: Chart, grid: Grid) -> Ground:
    """Turn a grid into the mission's plane: the cells about the mission, depths positive down."""
    system = chart.system(grid.system)
    grid = _ascending(chart, _wrapped(chart, grid) if system == DEGREES else grid)
    places = chart.wanted()
    there = chart.from_plane(places, system)
    rows, columns = (_near(axis, coordinates) for axis, coordinates in ((grid.y, there[1]), (grid.x, there[0])))
    if rows.stop - rows.start < 2 or columns.stop - columns.start < 2:
        covered = f"it covers x from {grid.x[0]:.6g} to {grid.x[-1]:.6g} and y from {grid.y[0]:.6g} to {grid.y[-1]:.6g}"
        hint = f"are site.origin and {chart.key}.projection right?"
        raise chart.problem(f"holds nothing about the mission; {covered}", hint)
    x, y = grid.x[columns], grid.y[rows]
    values = grid.values[rows, columns]
    depth = np.asarray(grid_files.without_fills(-values if grid.is_up else values), dtype=np.float32)
    depths = depth[np.isfinite(depth)]
    if not depths.size:
        raise chart.problem("holds no depth about the mission: all values there are missing")
    if depths.max() > _DEEPEST or depths.min() < -_HIGHEST:
        worst = float(depths[np.argmax(np.abs(depths))])
        message = f"holds a depth of {worst:.6g} m, which is none of this planet"
        raise chart.problem(message, "is it a fill value that the file does not declare, or another unit?")
    if depths.max() <= 0.0:
        other = "down" if chart.written.positive != "down" else "up"
        message = "holds no water about the mission: all of it lies above the datum"
        raise chart.problem(message, f"do its values count {other}wards? {chart.key}.positive says so")
    frame = Frame.fitted(chart.low, chart.high, places, np.stack((_index(x, there[0]), _index(y, there[1]))))
    if frame is None:
        raise chart.problem("its rows or columns are not evenly spaced")
    return Ground(depth, frame)


def _wrapped(chart: Chart, grid: Grid) -> Grid:
    if np.abs(grid.x).max() > 361.0 or np.abs(grid.y).max() > 90.001:
        hint = f"{chart.key}.projection: EPSG:… names it; `local` is for metres east and north of the origin"
        raise chart.problem("its coordinates are no degrees, and it names no reference system", hint)
    assert chart.origin is not None or chart.written.projection == LOCAL  # the schema asks for one
    return replace(grid, x=longitude_beside(grid.x, chart.origin)) if chart.origin is not None else grid


def _ascending(chart: Chart, grid: Grid) -> Grid:
    """Order columns west to east and rows south to north; nodes that stand twice, as a whole circle's ends, once."""
    if grid.values.shape != (grid.y.size, grid.x.size) or min(grid.values.shape) < 2:
        raise chart.problem(f"expected a grid of two rows and two columns or more, has {grid.values.shape}")
    x, columns = np.unique(grid.x, return_index=True)
    y, rows = np.unique(grid.y, return_index=True)
    return replace(grid, x=_evened(x), y=_evened(y), values=grid.values[np.ix_(rows, columns)])


def _evened(axis: Array) -> Array:
    """Return an axis with even steps where it is so but for rounding."""
    even = np.linspace(axis[0], axis[-1], axis.size)
    return even if np.abs(axis - even).max() <= _IRREGULAR * (even[1] - even[0]) else axis


def _near(axis: Array, wanted: Array) -> slice:
    """Nodes within what is wanted, and two beyond on each side."""
    first, last = np.searchsorted(axis, (wanted.min(), wanted.max()))
    outside = wanted.max() < 1.5 * axis[0] - 0.5 * axis[1] or wanted.min() > 1.5 * axis[-1] - 0.5 * axis[-2]
    return slice(0, 0) if outside else slice(max(int(first) - 2, 0), min(int(last) + 2, axis.size))


def _index(axis: Array, at: Array) -> Array:
    """Fractional index of coordinates along an axis, linear beyond its ends."""
    index = np.interp(at, axis, np.arange(axis.size, dtype=float))
    index = np.where(at < axis[0], (at - axis[0]) / (axis[1] - axis[0]), index)
    beyond = axis.size - 1.0 + (at - axis[-1]) / (axis[-1] - axis[-2])
    return np.asarray(np.where(at > axis[-1], beyond, index))


MARGIN = 5_000.0
"""Of a chart, what is this far beyond the mission's places is read, or farther where these are farther apart [m]."""
_HIGHEST_TIDE = 30.0


def mission_places(mission: Mission) -> Array:
    """Where the transits of a mission begin and end and what lies between, at the means, shape (2, k) [m]."""
    origin = mission.site.origin if mission.site else None
    written = [
        place for phase in mission.transits for place in (phase.start, *phase.ways, phase.to) if place is not None
    ]
    places = []
    for position in written:
        if not isinstance(position, Geographic):
            places.append((float(mean_of(position[0])), float(mean_of(position[1]))))
        elif origin is None:
            raise InputError([Problem("missing; positions by latitude and longitude need it", key="site.origin")])
        else:
            east, north = to_plane(np.array([position.latitude]), np.array([position.longitude]), origin)
            places.append((float(east[0]), float(north[0])))
    return np.array(places or [(0.0, 0.0)]).T


def read_place(mission: Mission) -> Place | None:
    """Read the files of a mission's place; None where it names none.

    What a trial draws of it, clearance and error of the tide, is at its mean; see `drawn_place`. Raises InputError when
    a file cannot be read, is impossible, or holds nothing about the mission.
    """
    site = mission.site
    if site is None or not site.place_files:
        return None
    places = mission_places(mission)
    low, high = places.min(axis=1), places.max(axis=1)
    margin = max(MARGIN, float(np.hypot(*(high - low))))
    box = (*(low - margin).tolist(), *(high + margin).tolist())
    start = None if mission.start is None else mission.start.isoformat()
    origin = None if site.origin is None else (site.origin.latitude, site.origin.longitude)
    charts = tuple(
        (key, file.model_dump_json(), Path(file.file).stat().st_mtime_ns) for key, file in site.place_files.items()
    )
    ground, fence, notices = _read(charts, origin, box, start)
    means = mission.at_means()
    return drawn_place(Place(ground, fence, _sea_level(mission, site), notices=notices), means)


@lru_cache(maxsize=4)
def _read(
    charts: tuple[tuple[str, str, int], ...],
    origin: tuple[float, float] | None,
    box: tuple[float, float, float, float],
    start: str | None,
) -> tuple[Ground | None, Fence | None, tuple[str, ...]]:
    """Read each file once, however many studies of a mission ask for it, and tabulate distances once."""
    from missionplan.moments import moment_of  # readers load what reads files, which most missions have none of
    from missionplan.scenario.polygons import Chart, read_zones

    about = None if origin is None else Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    ground: Ground | None = None
    zones: list[Zone] = []
    notices: list[str] = []
    for key, written, _ in charts:
        file = BathymetryFile.model_validate_json(written)
        chart = Chart(f"site.{key}", file, about, np.array(box[:2]), np.array(box[2:]))
        if key == "bathymetry":
            ground = read_ground(chart)
        else:
            polygons, away = read_zones(chart, moment_of(start) if start else None, is_land=key == "land")
            zones += polygons
            if not polygons:
                notices.append(f"site.{key}: no polygon is near the mission; the nearest is {away / 1e3:.3g} km away.")
    return ground, Fence(tuple(zones)) if zones else None, tuple(notices)


def drawn_place(place: Place, drawn: Mission[Scalars]) -> Place:
    """Return a place with what a mission's trials draw of it: clearance, draught, level of the sea."""
    site, vehicle = drawn.site, drawn.vehicle
    if site is None:
        return place
    tide = site.tide_height
    level: Scalars = 0.0 if tide is None else tide.level + tide.error if isinstance(tide, TideHeight) else tide
    draught = 0.0 if vehicle is None else 0.5 * vehicle.hull.diameter
    sea_level = replace(place.sea_level, level=level)
    return replace(place, sea_level=sea_level, draught=draught, clearance=site.clearance)


def _sea_level(mission: Mission, site: Site) -> SeaLevel:
    tide = site.tide_height
    if not isinstance(tide, TideHeight):
        return SeaLevel()
    if tide.file is not None:
        return _record(Path(tide.file), mission)
    if mission.start is None:
        message = "missing; a tide with phases at Greenwich needs it (UTC)"
        raise InputError([Problem(message, mission.file, key="start")])
    origin = required_origin(mission, "the tide's nodal corrections depend on its latitude")
    names = [wave.name for wave in tide.constituents]
    try:
        state = nodal_state(names, mission.start.timestamp(), origin.latitude)
    except KeyError as error:
        message = f"given {error.args[0]!r}, which is no constituent that UTide knows"
        raise InputError([Problem(message, mission.file, key="site.tide_height.constituents")]) from None
    size = np.array([wave.amplitude for wave in tide.constituents]) * state.factor
    angle = state.argument + state.angle - np.array([wave.phase for wave in tide.constituents])
    return SeaLevel(0.0, angular_frequencies(names), size * np.cos(angle), -size * np.sin(angle))


def _record(path: Path, mission: Mission) -> SeaLevel:
    """Read a record of the sea level: CSV with ``t_s``, from the mission's start, or dates, and ``height_m``."""
    import pandas as pd

    from missionplan.datasets.table import plain_table, times_from

    frame = plain_table(path, ("t_s", "height_m"), MAX_BYTES)
    if len(frame) < 2:
        message = "has fewer than two rows; a record of the tide has t_s, height_m"
        raise InputError([Problem(message, str(path), 1, key="site.tide_height.file")])
    zero = None if mission.start is None else mission.start.timestamp()
    time = times_from(frame["t_s"], zero, str(path))
    table = np.stack((time.to_numpy(dtype=float), pd.to_numeric(frame["height_m"], errors="coerce").to_numpy(float)))
    wrong = np.flatnonzero(~np.isfinite(table).all(axis=0) | (np.abs(table[1]) > _HIGHEST_TIDE))
    problems = [
        Problem("expected a time and a height within 30 m of the datum", str(path), int(frame.index[row]))
        for row in wrong[:20]
    ]
    if problems:
        raise InputError(problems)
    order = np.argsort(table[0], kind="stable")
    again = order[1:][np.diff(table[0, order]) == 0.0]
    if again.size:
        raise InputError([Problem("this row has the time of an earlier one", str(path), int(frame.index[again[0]]))])
    return SeaLevel(time=table[0, order], height=table[1, order])
