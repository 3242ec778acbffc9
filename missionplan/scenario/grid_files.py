"""Grids of depths as files have them, and a reader for each format."""

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from missionplan.arrays import Array, without_nines
from missionplan.errors import did_you_mean
from missionplan.scenario.currents.attributes import COARSEST, FINEST, FieldAttributeError, counts_up, factor, word
from missionplan.scenario.currents.files import FieldFiles, standard_name
from missionplan.scenario.currents.regular import LATITUDE, LONGITUDE
from missionplan.scenario.polygons import DEGREES, LOCAL, Chart, features

_UP = ("elevation", "Elevation", "z", "topo", "topography", "altitude", "height", "Band1", "band_data")
_DOWN = ("depth", "Depth", "bathymetry", "Bathymetry", "bathy", "deptho", "h", "water_depth")
_STANDARD_UP = ("height_above_reference_ellipsoid", "height_above_mean_sea_level", "surface_altitude", "altitude")
_STANDARD_DOWN = (
    "sea_floor_depth_below_geoid",
    "sea_floor_depth_below_mean_sea_level",
    "sea_floor_depth_below_geopotential_datum",
    "sea_floor_depth_below_reference_ellipsoid",
    "sea_floor_depth",
    "depth",
)
_X = ("x", "X", "easting", *LONGITUDE)
_Y = ("y", "Y", "northing", *LATITUDE)
_SCALE, _TIE_POINT, _MATRIX, _KEYS, _NO_DATA = 33550, 33922, 34264, 34735, 42113
"""Tags of GeoTIFF 1.1, and GDAL's for missing values."""
_GEOGRAPHIC, _PROJECTED, _RASTER_TYPE, _USER_DEFINED = 2048, 3072, 1025, 32767
"""Keys of GeoTIFF 1.1: EPSG codes of both kinds of reference systems; 2 where a pixel is a point."""
_ALONE = 0.1
"""Share of its size within which no other value lies beside one that stands for none."""
_MOST_CELLS = 1_000_000
"""Of the grid that is made of soundings."""


@dataclass(frozen=True)
class Grid:
    """Heights or depths at the centres of cells, as a file has them."""

    x: Array
    y: Array
    """Shape (columns,) and (rows,). Coordinates, in either direction."""
    values: Array
    """nan where missing, shape (rows, columns) [m]."""
    is_up: bool
    """Whether values count up."""
    system: str | None = None
    """Reference system that the file names."""


def netcdf(chart: Chart) -> Grid:
    """Read GEBCO's layout and CF grids: rows and columns along one axis each."""
    from missionplan.scenario.currents.reading import opened  # pandas: slow

    with opened([str(chart.path)], str(chart.path)) as files:
        try:
            return _netcdf(chart, files)
        except FieldAttributeError as error:
            raise chart.problem(str(error)) from None


def _netcdf(chart: Chart, files: FieldFiles) -> Grid:
    name = _depth_variable(chart, files)
    variable = files.variable(name)
    while variable.ndim > 2 and variable.sizes[variable.dims[0]] == 1:
        variable = variable.isel({variable.dims[0]: 0})
    if variable.ndim != 2:
        raise chart.problem(
            f"{name} has the dimensions {', '.join(map(str, variable.dims))}; expected rows and columns"
        )
    axes: dict[str, str] = {}
    for dim in map(str, variable.dims):
        if dim not in files.variable(name).coords and dim not in files.datasets[0].variables:
            raise chart.problem(f"{name} has no coordinates along {dim}", "a curved grid is to be made regular first")
        standard = standard_name(files.variable(dim))
        east = dim in _X or standard in ("longitude", "projection_x_coordinate", "grid_longitude")
        axes["x" if east else "y"] = dim
    if len(axes) != 2:
        raise chart.problem(f"cannot tell rows from columns of {name}: {', '.join(map(str, variable.dims))}")
    values = np.asarray(variable.transpose(axes["y"], axes["x"]).to_numpy(), dtype=float)
    values = values * files.height_factor(name, otherwise="m")
    x, y = (files.fixed(axes[side]) for side in ("x", "y"))
    system = _grid_mapping(files, name)
    if system is None and word(files.variable(axes["x"]), "units").lower() in ("km", "kilometers", "kilometres"):
        x, y = 1000.0 * x, 1000.0 * y
    return Grid(x, y, values, _counts_up(chart, files, name, values), system)


def _depth_variable(chart: Chart, files: FieldFiles) -> str:
    asked = chart.written.variable
    holders = [str(key) for dataset in files.datasets for key, grid in dataset.variables.items() if grid.ndim >= 2]
    if asked is not None:
        if asked not in holders:
            raise chart.problem(
                f"has no grid {asked!r}", did_you_mean(asked, holders) or f"it has {', '.join(holders)}"
            )
        return asked
    names = [name for name in (*_UP, *_DOWN) if name in holders]
    named = names[0] if names else files.named(standard=(*_STANDARD_UP, *_STANDARD_DOWN))
    if named is None and len(holders) == 1:
        named = holders[0]
    if named is None:
        have = f"it has {', '.join(holders) or 'no grid'}"
        raise chart.problem("cannot tell which variable holds the depths", f"{chart.key}.variable names it; {have}")
    return named


def _counts_up(chart: Chart, files: FieldFiles, name: str, values: Array) -> bool:
    """Whether values count up: by the mission, the attributes, the name, and at last their sign."""
    if chart.written.positive is not None:
        return chart.written.positive == "up"
    variable = files.variable(name)
    standard = word(variable, "standard_name").lower()
    if not word(variable, "positive"):
        if standard in (*_STANDARD_UP, *_STANDARD_DOWN):
            return standard in _STANDARD_UP
        if not standard and name in ("elevation", "Elevation", *_DOWN):
            return name not in _DOWN
    try:
        return counts_up(variable, values)
    except FieldAttributeError as error:
        raise chart.problem(str(error), f"{chart.key}.positive: up or down says it") from None


def _grid_mapping(files: FieldFiles, name: str) -> str | None:
    """Return the reference system that CF's grid mapping spells out; None where there is none."""
    mapping = word(files.variable(name), "grid_mapping")
    mapping = mapping or str(files.variable(name).encoding.get("grid_mapping", ""))
    if not mapping or all(mapping not in dataset.variables for dataset in files.datasets):
        return None
    said = files.variable(mapping)
    if word(said, "grid_mapping_name") == "latitude_longitude":
        return DEGREES
    if written := word(said, "crs_wkt") or word(said, "spatial_ref"):
        return written
    from pyproj import CRS

    return str(CRS.from_cf(dict(said.attrs)).to_wkt())


def geotiff(chart: Chart) -> Grid:
    """Read the first band of a GeoTIFF, north up or south up, pixels areas or points."""
    from PIL.TiffImagePlugin import TiffImageFile

    with TiffImageFile(chart.path) as picture:
        tags: Any = picture.tag_v2
        if picture.mode not in ("I", "I;16", "I;16B", "F", "L"):
            raise chart.problem(f"is a picture ({picture.mode}); expected one band of heights")
        values = np.asarray(picture, dtype=float)
        across, up, system = placed_pixels(chart, tags)
        missing = str(tags.get(_NO_DATA, "")).strip("\0 ")
    if missing:
        values = np.where(np.isclose(values, float(missing), rtol=1e-6, atol=0.0), np.nan, values)
    rows, columns = values.shape
    x, y = across[0] + across[1] * (np.arange(columns) + 0.5), up[0] + up[1] * (np.arange(rows) + 0.5)
    return Grid(np.asarray(x, dtype=float), np.asarray(y, dtype=float), values, chart.asked_up, system)


def placed_pixels(chart: Chart, tags: Any) -> tuple[tuple[float, float], tuple[float, float], str | None]:
    """First coordinate and step of columns and of rows, at the corner of the first pixel, and the reference system.

    Raises InputError when a GeoTIFF is turned, or does not say where it lies.
    """
    keys = tags.get(_KEYS, ())
    entries = {keys[place]: keys[place + 3] for place in range(4, len(keys), 4)}
    code = entries.get(_PROJECTED) or entries.get(_GEOGRAPHIC)
    system = None if code in (None, _USER_DEFINED) else f"EPSG:{code}"
    if _MATRIX in tags:
        matrix = tags[_MATRIX]
        if matrix[1] or matrix[4]:
            raise chart.problem("is turned; expected rows along one axis of its reference system")
        (x, wide), (y, high) = (matrix[3], matrix[0]), (matrix[7], matrix[5])
    elif _SCALE not in tags or _TIE_POINT not in tags:
        raise chart.problem("says not where it lies: expected a GeoTIFF with a scale and a tie point")
    else:
        scale, tie = tags[_SCALE], tags[_TIE_POINT]
        (x, wide), (y, high) = (tie[3] - tie[0] * scale[0], scale[0]), (tie[4] + tie[1] * scale[1], -scale[1])
    back = 0.5 if entries.get(_RASTER_TYPE) == 2 else 0.0  # the tags place the middle of a pixel that is a point
    return (x - back * wide, wide), (y - back * high, high), system


def esri(chart: Chart) -> Grid:
    """Read an ESRI ASCII grid, with the reference system of a ``.prj`` beside it."""
    words = chart.path.read_text(encoding="utf-8-sig").split()
    header: dict[str, float] = {}
    while len(words) > 2 * len(header) + 1 and re.fullmatch(r"[A-Za-z_]+", words[2 * len(header)]):
        header[words[2 * len(header)].lower()] = float(words[2 * len(header) + 1])
    missing = [key for key in ("ncols", "nrows") if key not in header]
    step = header.get("cellsize", header.get("dx"))
    if missing or step is None or not {"xllcorner", "xllcenter"} & set(header):
        raise chart.problem("lacks ncols, nrows, xllcorner or cellsize at its head")
    columns, rows, up = int(header["ncols"]), int(header["nrows"]), header.get("dy", step)
    numbers = words[2 * len(header) :]
    if len(numbers) != rows * columns:
        raise chart.problem(f"has {len(numbers)} values; its head says {rows} × {columns} = {rows * columns}")
    values = np.array(numbers, dtype=float).reshape(rows, columns)
    values[values == header.get("nodata_value")] = np.nan
    west = header["xllcenter"] if "xllcenter" in header else header["xllcorner"] + 0.5 * step
    south = header["yllcenter"] if "yllcenter" in header else header["yllcorner"] + 0.5 * up
    beside = chart.path.with_suffix(".prj")
    system = beside.read_text(encoding="utf-8").strip() if beside.is_file() else None
    x = np.asarray(west + step * np.arange(columns), dtype=float)
    y = np.asarray(south + up * np.arange(rows)[::-1], dtype=float)
    return Grid(x, y, values, chart.asked_up, system)


def without_fills(values: Array) -> Array:
    """Put nan for 9999, -999 and the like, of either sign, where they stand for no height or depth: far from others."""
    size = np.abs(values)
    is_nine = np.isnan(without_nines(-size)) & np.isfinite(size)
    others = size[np.isfinite(size) & ~is_nine]
    fills = [nine for nine in np.unique(size[is_nine]) if not np.any(np.abs(others - nine) < _ALONE * nine)]
    return np.where(np.isin(size, fills), np.nan, values)


_NAMES = (
    ("lon", "long", "longitude", "east", "easting", "x"),
    ("lat", "latitude", "north", "northing", "y"),
    ("depth", "depths", "sounding", "soundings", "water", "z", "elevation", "elev", "height", "altitude", "alt"),
)
"""First words of headers of x, y and height, of which the first five are of depths."""


def xyz(chart: Chart) -> Grid:
    """Read columns x, y and height: of a grid in any order, or of soundings, which are joined by triangles.

    A header may name them in another order, depths, which count down, and the unit of heights behind their name.
    """
    (x, y, z), name = _numbers(chart)
    words = name.split("_")
    unit = (factor(words[-1], "m") or 1.0) if len(words) > 1 else 1.0
    if not FINEST <= unit <= COARSEST:
        raise chart.problem(f"its heights, {name!r}, are in no unit of depths")
    z, is_up = unit * without_fills(z), chart.asked_up
    if chart.written.positive is None and words[0] in _NAMES[2][:5]:
        is_up = False
    columns, column = np.unique(x, return_inverse=True)
    rows, row = np.unique(y, return_inverse=True)
    if columns.size * rows.size <= 2 * x.size and min(columns.size, rows.size) > 1:
        values = np.full((rows.size, columns.size), np.nan)
        values[row, column] = z
        return Grid(columns, rows, values, is_up)
    mask = np.isfinite(z)
    return _of_soundings(chart.to_plane(x[mask], y[mask], chart.system(None)), -z[mask] if is_up else z[mask])


_BETWEEN = re.compile(r"\s*;\s*|\s*,\s+|\s+,\s*|\s+")
"""Separators of cells, of which a comma within a number is none."""


def _numbers(chart: Chart) -> tuple[Array, str]:
    """Return x, y and height, shape (3, n), of rows of cells, and the name of the heights, where a header has one.

    Cells are separated by blanks, commas, semicolons or tabs; between other separators commas are decimal.
    """
    lines = chart.path.read_text(encoding="utf-8-sig").splitlines()
    rows = [(number, line) for number, line in enumerate(lines, start=1) if line.strip() and line.lstrip()[0] != "#"]
    chosen, name = [0, 1, 2], ""
    if rows and not re.match(r"\s*[-+.\d]", rows[0][1]):
        chosen, name = _columns(chart, rows.pop(0)[1].strip().lower())
    first = _BETWEEN.split(rows[0][1].strip()) if rows else []
    comma = "." if len(first) > 2 and any("," in cell for cell in first) else " "
    cells: list[list[float]] = []
    for number, line in rows:
        row = line.replace(";", " ").replace(",", comma).split()
        try:
            cells.append([float(row[k]) for k in chosen])
        except (ValueError, IndexError):
            raise chart.problem(f"line {number}: expected three numbers: x, y, height; has {line[:40]!r}") from None
    table = np.array(cells).reshape(-1, 3)
    if len(table) < 4:
        raise chart.problem(f"has {len(table)} points; expected four or more")
    return table[np.isfinite(table[:, :2]).all(axis=1)].T, name


def _columns(chart: Chart, header: str) -> tuple[list[int], str]:
    """Which columns are x, y and height by a header in small letters, else the first three; and the heights' name."""
    names = [
        re.sub(r"\W+", "_", cell).strip("_")
        for cell in re.split(r"[,;\t]" if re.search(r"[,;\t]", header) else r"\s+", header)
    ]
    columns = [[k for k, name in enumerate(names) if name.split("_")[0] in words] for words in _NAMES]
    chosen = [places[0] for places in columns if places]
    if len(chosen) < 3 and len(names) > 3:
        raise chart.problem(f"cannot tell which of its columns are x, y and height: {header[:80]!r}")
    chosen = chosen if len(chosen) == 3 else [0, 1, 2]
    return chosen, names[chosen[2]] if len(names) > chosen[2] else ""


def contours(chart: Chart) -> Grid:
    """Read lines, polygons or points with a property `depth`, positive down, and join them by triangles."""
    import shapely

    shapes, system = features(chart)
    places: list[Array] = []
    depths: list[Array] = []
    for geometry, properties in shapes:
        depth = next((value for key, value in properties.items() if str(key).lower() == "depth"), None)
        if depth is None:
            continue
        if isinstance(depth, bool) or not isinstance(depth, int | float | np.number):
            raise chart.problem(f"given a depth of {depth!r}, expected a number of metres")
        points = shapely.get_coordinates(geometry)
        places.append(chart.to_plane(points[:, 0], points[:, 1], system))
        depths.append(np.full(len(points), float(depth)))
    if not places or len({float(contour[0]) for contour in depths}) < 2:
        raise chart.problem("expected contours of two depths or more, each with a property `depth`")
    joined, unique = np.unique(np.concatenate(places, axis=1), axis=1, return_index=True)
    return _of_soundings(joined, np.concatenate(depths)[unique])


def _of_soundings(places: Array, depths: Array) -> Grid:
    """Make a grid of scattered depths: linear within Delaunay's triangles of them, missing outside.

    `places`, shape (2, k): east and north of the origin [m]. `depths`, shape (k,) [m].
    """
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import cKDTree

    span = places.max(axis=1) - places.min(axis=1)
    nearest = np.asarray(cKDTree(places.T).query(places.T, k=2)[0])[:, 1]
    step = max(float(np.median(nearest[nearest > 0.0])), math.sqrt(float(np.prod(span)) / _MOST_CELLS))
    x, y = (np.arange(low, high + step, step) for low, high in zip(places.min(axis=1), places.max(axis=1), strict=True))
    fit = LinearNDInterpolator(places.T, depths)
    return Grid(x, y, np.asarray(fit(*np.meshgrid(x, y)), dtype=float), is_up=False, system=LOCAL)
