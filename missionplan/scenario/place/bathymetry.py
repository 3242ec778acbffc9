"""Depth of the seafloor in the mission's plane, from a `Grid` that a format's reader returns as its file has it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, shown
from missionplan.phases.place.ground import Frame, Ground
from missionplan.scenario.place import grid_files
from missionplan.scenario.place.grid_files import Grid
from missionplan.scenario.place.positions import DEGREES, LOCAL, Chart, longitude_beside

MAX_BYTES = 2_000_000_000
"""Of a file of depths."""
_HIGHEST, _DEEPEST = 9000.0, 11_500.0
"""Heights and depths beyond which a value is none of this planet: a fill value, or another unit [m]."""
_IRREGULAR = 0.05
"""Share of a step by which nodes may be off an even spacing, as single precision makes them."""


def read_ground(chart: Chart) -> Ground:
    """Read a file of depths.

    Raises
    ------
    InputError
        When the file cannot be read, is impossible, or holds nothing about the mission.
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
    rows, columns = (_near(axis, each) for axis, each in ((grid.y, there[1]), (grid.x, there[0])))
    if rows.stop - rows.start < 2 or columns.stop - columns.start < 2:
        covered = f"it covers x from {grid.x[0]:.6g} to {grid.x[-1]:.6g} and y from {grid.y[0]:.6g} to {grid.y[-1]:.6g}"
        hint = f"are site.origin and {chart.key}.projection right?"
        raise chart.problem(f"holds nothing about the mission; {covered}", hint)
    x, y = grid.x[columns], grid.y[rows]
    values = grid.values[rows, columns]
    depth = np.asarray(-values if grid.is_up else values, dtype=np.float32)
    _check_depths(chart, depth)
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


def _check_depths(chart: Chart, depth: np.ndarray) -> None:
    known = depth[np.isfinite(depth)]
    if not known.size:
        raise chart.problem("holds no depth about the mission: all values there are missing")
    if known.max() > _DEEPEST or known.min() < -_HIGHEST:
        worst = float(known[np.argmax(np.abs(known))])
        message = f"holds a depth of {worst:.6g} m, which is none of this planet"
        raise chart.problem(message, "is it a fill value that the file does not declare, or another unit?")
    if known.max() <= 0.0:
        other = "down" if chart.written.positive != "down" else "up"
        message = "holds no water about the mission: all of it lies above the datum"
        raise chart.problem(message, f"do its values count {other}wards? {chart.key}.positive says so")
