"""Fields on rows of latitude and columns of longitude: CF, the layout of operational forecasts, and surface radars.

Fields on grids of rows and columns that bend: ROMS with staggered velocities, and any with both at one place.
"""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission.schema.place import curvature_of_parallel, to_plane
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.grids import CurvedGrid, RegularGrid
from missionplan.phases.lattice import Indices
from missionplan.scenario.currents.area import Area, assembled, at_columns, in_degrees, layer_depths, window_of
from missionplan.scenario.currents.attributes import word
from missionplan.scenario.currents.files import FieldFiles, Moments, Window, standard_name, velocities

LATITUDE = ("latitude", "lat", "Latitude")
LONGITUDE = ("longitude", "lon", "Longitude")
TO_THE_MIDDLES = "bring both to the middles of the cells first"
REACH = np.radians(8.0)
"""Of a field, what is this far from the origin is looked at [rad]: 890 km, farther than a mission may go."""


def read_regular(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field whose latitudes and longitudes are one axis each.

    Rows have the north coordinates of their points on the origin's meridian, columns the east coordinates of theirs on
    the origin's parallel; elsewhere parallels and meridians bend (`RegularGrid`). Raises InputError when something is
    missing or impossible, or the axes are not one-dimensional.
    """
    latitude, longitude = (
        files.required(what, *names, standard=(what,))
        for what, names in (("latitude", LATITUDE), ("longitude", LONGITUDE))
    )
    u, v = files.components()
    dims = [str(dim) for dim in files.variable(u).dims]
    rows, columns = (str(files.variable(name).dims[0]) for name in (latitude, longitude))
    across = [dim for dim in dims[1:] if dim not in (rows, columns)]
    if not all({rows, columns} <= set(files.variable(name).dims) for name in (u, v)):
        raise files.problem(f"{u} and {v} do not both lie along {rows} and {columns}", TO_THE_MIDDLES)
    north, east, window, picked = _axes(files, area, (latitude, longitude))
    moments = area.kept(files.moments(u))
    order = [*across, rows, columns]
    parts = [files.series(name, moments, window, order)[..., picked[0], picked[1]] for name in (u, v)]
    velocity = velocities(files, (u, v), (parts[0], parts[1])).reshape(moments.size, -1, north.size * east.size)
    at = at_columns(files, moments, window, (rows, columns), picked)
    levels, bottom = layer_depths(files, across, at, moments.size, velocity.shape[2])
    grid = RegularGrid(north, east, curvature_of_parallel(area.origin.latitude))
    return assembled(files, area.seconds(moments), grid, levels, velocity, bottom)


def _axes(
    files: FieldFiles, area: Area, names: tuple[str, str]
) -> tuple[Array, Array, dict[str, slice], tuple[Array, Array]]:
    """North and east coordinates of rows and columns near the mission, where they are, and in which order."""
    latitude, longitude = (files.fixed(name) for name in names)
    if latitude.size and longitude.size and not in_degrees(files, names[::-1], longitude, latitude):
        raise files.problem(f"{names[0]} and {names[1]} are in metres; expected rows and columns in degrees")
    latitude, longitude = np.radians(latitude), np.radians(longitude)
    if latitude.ndim != 1 or longitude.ndim != 1:
        raise files.problem("expected one-dimensional time, depth, latitude and longitude")
    if not latitude.size or not longitude.size:
        raise files.problem("has no times, depths or positions")
    origin, low, high = area.origin, *area.box
    # about the origin's meridian, so that neither the date line nor the convention of the file matters
    beside = (longitude - origin.longitude + np.pi) % (2.0 * np.pi) - np.pi
    reach = min(REACH / max(np.cos(origin.latitude), 0.1), 0.5 * np.pi)
    near = _near(latitude - origin.latitude, REACH), _near(beside, reach)
    here = np.full_like
    _, north = to_plane(latitude[near[0]], here(latitude[near[0]], origin.longitude), origin)
    east, _ = to_plane(here(beside[near[1]], origin.latitude), origin.longitude + beside[near[1]], origin)
    coordinates, window, picked = [], {}, []
    for number, (axis, index, name) in enumerate(((north, near[0], names[0]), (east, near[1], names[1]))):
        order = np.unique(axis, return_index=True)[1]
        first, last = np.searchsorted(axis[order], (low[1 - number], high[1 - number]))
        kept = order[max(first - 1, 0) : last + 1]  # and one node beyond on each side
        kept = kept if kept.size else order[-1:]
        start = int(index[kept].min())
        window[str(files.variable(name).dims[0])] = slice(start, int(index[kept].max()) + 1)
        coordinates.append(axis[kept])
        picked.append(index[kept] - start)
    return coordinates[0], coordinates[1], window, (picked[0][:, None], picked[1][None, :])


def _near(offset: Array, reach: float) -> Indices:
    """Which nodes are within reach, in order, and one beyond on each side; a node that stands twice counts once."""
    order = np.unique(offset, return_index=True)[1]
    first, last = np.searchsorted(offset[order], (-reach, reach))
    return np.asarray(order[max(first - 1, 0) : last + 1])


_ANGLE_OFF = 0.2
"""By which the angle of a grid may differ from the direction of its rows [rad]."""
_SAME = 1e-5
"""Difference of longitudes of one place, a metre [deg]."""
_TURNED = 0.05
"""Direction of rows from which on a velocity has to say whether it is toward east or along them [rad]."""


@dataclass(frozen=True)
class _Part:
    """The part of a grid that is read: rows and columns of its nodes, a ring of which only staggered values need."""

    rows: slice
    columns: slice
    dims: tuple[str, str]
    """Of the nodes."""
    points: Array
    """Points, shape (2, j, i) [m]."""

    @property
    def window(self) -> Window:
        """Of the nodes."""
        return dict(zip(self.dims, (self.rows, self.columns), strict=True))


def read_curved(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field whose nodes have a latitude and a longitude each.

    Velocities that are staggered (ROMS) are averaged to the nodes, as ROMS's own ``uv_rotate`` does for what it
    publishes eastward and northward: a face on the coast has no flow through it. They are then turned by ``angle``.
    Raises InputError when something is missing or impossible, or lies elsewhere.
    """
    u, v = files.components()
    moments = area.kept(files.moments(u))
    shapes = [files.variable(name).shape[-2:] for name in (u, v)]
    staggered = shapes[0] != shapes[1]
    part = _part(files, area, u, staggered=staggered)
    if not staggered:
        _check_one_place(files, _coordinates(files, u, staggered=False)[0], (u, v))
    across = [str(dim) for dim in files.variable(u).dims[1:-2]]
    if staggered:
        velocity = _unstaggered(files, (u, v), moments, part) * _turning(files, part)
        # nodes that have faces on all sides
        rows = slice(part.rows.start + 1, part.rows.stop - 1)
        columns = slice(part.columns.start + 1, part.columns.stop - 1)
        part = _Part(rows, columns, part.dims, part.points[:, 1:-1, 1:-1])
    else:
        order = [*across, *part.dims]
        parts = [files.series(name, moments, part.window, order) for name in (u, v)]
        velocity = velocities(files, (u, v), (parts[0], parts[1]))
        if _is_along_rows(files, u, part):
            velocity = velocity * _turning(files, part, edge=0)
    mask = files.named("mask_rho", "mask", "wetdry_mask_rho") if files.named("lat_rho") else None
    if mask is not None:
        velocity[..., files.fixed(mask, part.window) < 0.5] = np.nan
    count = part.points.shape[1] * part.points.shape[2]
    at = at_columns(files, moments, part.window, part.dims)
    levels, bottom = layer_depths(files, across, at, moments.size, count)
    flat = velocity.reshape(moments.size, -1, count)
    return assembled(files, area.seconds(moments), CurvedGrid(part.points), levels, flat, bottom)


def _check_one_place(files: FieldFiles, longitude: str, names: tuple[str, str]) -> None:
    """Refuse velocities at other places in a file each, as NEMO's grids U and V are."""
    datasets = [next(dataset for dataset in files.datasets if name in dataset.variables) for name in names]
    if datasets[0] is not datasets[1] and all(longitude in dataset.variables for dataset in datasets):
        first, second = (dataset[longitude].to_numpy() for dataset in datasets)
        if first.shape != second.shape or not np.allclose(first, second, atol=_SAME, equal_nan=True):
            message = f"{names[0]} and {names[1]} are at other places: {longitude} is another"
            raise files.problem(message, TO_THE_MIDDLES)


def _part(files: FieldFiles, area: Area, u: str, *, staggered: bool) -> _Part:
    names = _coordinates(files, u, staggered=staggered)
    x, y = (files.fixed(name) for name in names)
    if files.variable(names[1]).dims == files.variable(names[0]).dims[::-1]:
        y = y.T
    if x.ndim != 2 or x.shape != y.shape:
        raise files.problem(f"{names[0]} and {names[1]} are not two-dimensional and of one shape")
    is_finite = np.isfinite(x) & np.isfinite(y)
    points, _ = area.placed(files, names, np.where(is_finite, x, 0.0), np.where(is_finite, y, 0.0))
    rows, columns = window_of(area.holds(points) & is_finite, files, 2)
    dims = tuple(str(dim) for dim in files.variable(names[0]).dims)
    if not is_finite[rows, columns].all():
        raise files.problem(f"{names[0]} or {names[1]} has gaps near the mission")
    rows, columns = slice(rows.start, min(rows.stop, x.shape[0])), slice(columns.start, min(columns.stop, x.shape[1]))
    if min(rows.stop - rows.start, columns.stop - columns.start) < 2 + 2 * staggered:
        raise files.problem("has too few rows or columns near the mission to interpolate")
    return _Part(rows, columns, (dims[0], dims[1]), points[:, rows, columns])


def _coordinates(files: FieldFiles, u: str, *, staggered: bool) -> tuple[str, str]:
    """Names of the nodes' longitudes and latitudes."""
    if staggered or files.named("lon_rho"):
        where = ("lon_rho", "lat_rho") if files.named("lon_rho") else ("x_rho", "y_rho")
        return files.required("the longitude of its nodes", where[0]), files.required("the latitude", where[1])
    said = [name for name in files.variable(u).encoding.get("coordinates", "").split() if files.named(name)]
    usual = {"longitude": (*LONGITUDE, "nav_lon", "x"), "latitude": (*LATITUDE, "nav_lat", "y")}
    names = [[name for name in said if standard_name(files.variable(name)) == kind][:1] for kind in usual]
    first, second = (
        files.required(f"the {kind}", *its, *usual[kind], standard=(kind,))
        for kind, its in zip(usual, names, strict=True)
    )
    return first, second


def _unstaggered(files: FieldFiles, names: tuple[str, str], moments: Moments, part: _Part) -> NDArray[np.complex64]:
    """Velocity along rows and columns at the inner nodes of a part; nan where no face about a node has a value."""
    whole = files.variable("lon_rho" if files.named("lon_rho") else "x_rho").shape
    faces = []
    for name, axis in zip(names, (1, 0), strict=True):
        variable = files.variable(name)
        expected = (whole[0] - (axis == 0), whole[1] - (axis == 1))
        if variable.shape[-2:] != expected:
            raise files.problem(f"{name} has {variable.shape[-2:]} values across; its staggered grid has {expected}")
        dims = [str(dim) for dim in variable.dims]
        rows, columns = part.rows, part.columns
        window = {
            dims[-2]: slice(rows.start, rows.stop - (axis == 0)),
            dims[-1]: slice(columns.start, columns.stop - (axis == 1)),
        }
        faces.append(files.series(name, moments, window, dims[1:]))
    along = np.stack((faces[0][..., 1:-1, :-1], faces[0][..., 1:-1, 1:]))
    up = np.stack((faces[1][..., :-1, 1:-1], faces[1][..., 1:, 1:-1]))
    dry = np.isnan(along).all(axis=0) & np.isnan(up).all(axis=0)
    velocity = velocities(files, names, (np.nan_to_num(along).mean(axis=0), np.nan_to_num(up).mean(axis=0)))
    velocity[dry] = np.nan
    return velocity


def _is_along_rows(files: FieldFiles, u: str, part: _Part) -> bool:
    """Whether a velocity at the nodes is along rows and columns: by its standard name, its name, or the file's `angle`.

    Raises InputError when none says it of rows that do not run east.
    """
    standard = word(files.variable(u), "standard_name").lower()
    if re.search(r"(^|_)x_(wind|velocity|sea_water)|^grid_east", standard):
        return True
    if "east" in standard + u.lower() or u == "water_u":
        return False
    if files.named("angle") is None and np.nanmedian(np.abs(_rows_from_east(part))) > _TURNED:
        degrees = np.degrees(np.nanmedian(_rows_from_east(part)))
        hint = "its attribute `standard_name` says it"
        raise files.problem(f"is {u} toward east, or along its rows, which run {degrees:.1f}° from east?", hint)
    return files.named("angle") is not None


def _rows_from_east(part: _Part) -> Array:
    """Direction of the rows at the nodes of a part, counter-clockwise from east [rad]."""
    step_east = np.gradient(part.points[0], axis=1), np.gradient(part.points[1], axis=1)
    return np.asarray(np.arctan2(step_east[1], step_east[0]))


def _turning(files: FieldFiles, part: _Part, edge: int = 1) -> NDArray[np.complex64]:
    """Factor that turns velocities along rows and columns toward east and north, at the inner nodes of a part.

    Raises InputError when ``angle`` contradicts the direction of the rows: degrees for radians, or another grid's.
    """
    seen = _rows_from_east(part)
    name = files.named("angle")
    angle = seen
    if name is not None:
        angle = files.fixed(name, part.window)
        if word(files.variable(name), "units").lower().startswith("deg"):
            angle = np.radians(angle)
        off = np.abs((angle - seen + np.pi) % (2.0 * np.pi) - np.pi)
        if not np.nanmedian(off) < _ANGLE_OFF:
            message = f"its rows run {np.degrees(np.nanmedian(seen)):.1f}° from east, `angle` says"
            hint = "are its units, degrees or radians, as its attribute says?"
            raise files.problem(f"{message} {np.degrees(np.nanmedian(angle)):.5g}°", hint)
    kept = slice(edge, angle.shape[0] - edge), slice(edge, angle.shape[1] - edge)
    return np.asarray(np.exp(1j * angle[kept]), dtype=np.complex64)
