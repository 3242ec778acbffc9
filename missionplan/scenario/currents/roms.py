"""Fields on grids of rows and columns that bend: ROMS with staggered velocities, and any with both at one place."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.grids import CurvedGrid
from missionplan.scenario.currents.area import Area, window_of
from missionplan.scenario.currents.attributes import word
from missionplan.scenario.currents.building import assembled, at_columns, layer_depths
from missionplan.scenario.currents.files import FieldFiles, Moments, Window, velocities

_ANGLE_OFF = 0.2
"""By which the angle of a grid may differ from the direction of its rows [rad]."""


@dataclass(frozen=True)
class _Part:
    """The part of a grid that is read: rows and columns of its nodes, a ring of which only the staggered values need.

    Attributes
    ----------
    rows, columns : slice
    dims : tuple of str
        Of the nodes.
    points : array, shape (2, j, i)
        [m]
    longitude, latitude : array, shape (j, i)
        [deg]
    """

    rows: slice
    columns: slice
    dims: tuple[str, str]
    points: Array
    longitude: Array
    latitude: Array

    @property
    def window(self) -> Window:
        """Of the nodes."""
        return dict(zip(self.dims, (self.rows, self.columns), strict=True))


def read_curved(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field whose nodes have a latitude and a longitude each.

    Velocities that are staggered (ROMS) are averaged to the nodes, as ROMS's own ``uv_rotate`` does for what it
    publishes eastward and northward: a face on the coast has no flow through it. They are then turned by ``angle``.

    Raises
    ------
    InputError
        When something is missing or impossible, or lies elsewhere.
    """
    carries = files.carries
    u = files.required(f"the {carries.name} toward east", *carries.east, standard=carries.standard_east)
    v = files.required(f"the {carries.name} toward north", *carries.north, standard=carries.standard_north)
    moments = area.kept(files.moments(u))
    shapes = [files.variable(name).shape[-2:] for name in (u, v)]
    staggered = shapes[0] != shapes[1]
    part = _part(files, area, u, staggered=staggered)
    across = [str(dim) for dim in files.variable(u).dims[1:-2]]
    if staggered:
        velocity = _unstaggered(files, (u, v), moments, part) * _turning(files, part)
        part = _interior(part)
    else:
        order = [*across, *part.dims]
        parts = [files.series(name, moments, part.window, order) for name in (u, v)]
        velocity = velocities(files, (u, v), (parts[0], parts[1]))
        if u in ("u", "u_sur") and files.named("angle"):
            velocity = velocity * _turning(files, part, edge=0)
    mask = files.named("mask_rho", "mask", "wetdry_mask_rho") if files.named("lat_rho") else None
    if mask is not None:
        velocity[..., files.fixed(mask, part.window) < 0.5] = np.nan
    count = part.points.shape[1] * part.points.shape[2]
    at = at_columns(files, moments, part.window, part.dims)
    levels, bottom = layer_depths(files, across, at, moments.size, count)
    flat = velocity.reshape(moments.size, -1, count)
    return assembled(files, area.seconds(moments), CurvedGrid(part.points), levels, flat, bottom)


def _part(files: FieldFiles, area: Area, u: str, *, staggered: bool) -> _Part:
    names = _coordinates(files, u, staggered=staggered)
    x, y = (files.fixed(name) for name in names)
    if x.ndim != 2 or x.shape != y.shape:
        raise files.problem(f"{names[0]} and {names[1]} are not two-dimensional and of one shape")
    known = np.isfinite(x) & np.isfinite(y)
    points, _ = area.placed(files, names, np.where(known, x, 0.0), np.where(known, y, 0.0))
    rows, columns = window_of(area.holds(points) & known, files, 2)
    dims = tuple(str(dim) for dim in files.variable(names[0]).dims)
    if not known[rows, columns].all():
        raise files.problem(f"{names[0]} or {names[1]} has gaps near the mission")
    rows, columns = slice(rows.start, min(rows.stop, x.shape[0])), slice(columns.start, min(columns.stop, x.shape[1]))
    if min(rows.stop - rows.start, columns.stop - columns.start) < 2 + 2 * staggered:
        raise files.problem("has too few rows or columns near the mission to interpolate")
    return _Part(rows, columns, (dims[0], dims[1]), points[:, rows, columns], x[rows, columns], y[rows, columns])


def _coordinates(files: FieldFiles, u: str, *, staggered: bool) -> tuple[str, str]:
    """Names of the nodes' longitudes and latitudes."""
    if staggered or files.named("lon_rho"):
        where = ("lon_rho", "lat_rho") if files.named("lon_rho") else ("x_rho", "y_rho")
        return files.required("the longitude of its nodes", where[0]), files.required("the latitude", where[1])
    longitude = files.required(
        "the longitude", "lon", "longitude", "nav_lon", "Longitude", "x", standard=("longitude",)
    )
    return longitude, files.required(
        "the latitude", "lat", "latitude", "nav_lat", "Latitude", "y", standard=("latitude",)
    )


def _interior(part: _Part) -> _Part:
    """Nodes that have faces on all sides."""
    rows = slice(part.rows.start + 1, part.rows.stop - 1)
    columns = slice(part.columns.start + 1, part.columns.stop - 1)
    inner = slice(1, -1), slice(1, -1)
    points = part.points[:, inner[0], inner[1]]
    return _Part(rows, columns, part.dims, points, part.longitude[inner], part.latitude[inner])


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


def _turning(files: FieldFiles, part: _Part, edge: int = 1) -> NDArray[np.complex64]:
    """Factor that turns velocities along rows and columns toward east and north, at the inner nodes of a part.

    Raises
    ------
    InputError
        When ``angle`` contradicts the direction of the rows: degrees for radians, or another grid's.
    """
    step_east = np.gradient(part.points[0], axis=1), np.gradient(part.points[1], axis=1)
    seen = np.arctan2(step_east[1], step_east[0])
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
