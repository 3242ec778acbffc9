"""Fields on rows of latitude and columns of longitude: CF, the layout of operational forecasts, and surface radars."""

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.geodesy import curvature_of_parallel, to_plane
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.grids import RegularGrid
from missionplan.phases.fields.triangles import Indices
from missionplan.scenario.currents.area import Area, in_degrees
from missionplan.scenario.currents.building import assembled, at_columns, layer_depths
from missionplan.scenario.currents.files import FieldFiles, velocities

LATITUDE = ("latitude", "lat", "Latitude")
LONGITUDE = ("longitude", "lon", "Longitude")
REACH = np.radians(8.0)
"""Of a field, what is this far from the origin is looked at [rad]: 890 km, farther than a mission may go."""


def read_regular(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field whose latitudes and longitudes are one axis each.

    Rows have the north coordinates of their points on the origin's meridian, columns the east coordinates of theirs on
    the origin's parallel; elsewhere parallels and meridians bend (`RegularGrid`).

    Raises
    ------
    InputError
        When something is missing or impossible, or the axes are not one-dimensional.
    """
    latitude, longitude = (
        files.required(what, *names, standard=(what,))
        for what, names in (("latitude", LATITUDE), ("longitude", LONGITUDE))
    )
    carries = files.carries
    u = files.required(f"the {carries.name} toward east", *carries.east, standard=carries.standard_east)
    v = files.required(f"the {carries.name} toward north", *carries.north, standard=carries.standard_north)
    dims = [str(dim) for dim in files.variable(u).dims]
    rows, columns = (str(files.variable(name).dims[0]) for name in (latitude, longitude))
    across = [dim for dim in dims[1:] if dim not in (rows, columns)]
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
    found, window, picked = [], {}, []
    for number, (axis, index, name) in enumerate(((north, near[0], names[0]), (east, near[1], names[1]))):
        order = np.unique(axis, return_index=True)[1]
        first, last = np.searchsorted(axis[order], (low[1 - number], high[1 - number]))
        kept = order[max(first - 1, 0) : last + 1]  # and one node beyond on each side
        kept = kept if kept.size else order[-1:]
        start = int(index[kept].min())
        window[str(files.variable(name).dims[0])] = slice(start, int(index[kept].max()) + 1)
        found.append(axis[kept])
        picked.append(index[kept] - start)
    return found[0], found[1], window, (picked[0][:, None], picked[1][None, :])


def _near(offset: Array, reach: float) -> Indices:
    """Which nodes are within reach, in order, and one beyond on each side; a node that stands twice counts once."""
    order = np.unique(offset, return_index=True)[1]
    first, last = np.searchsorted(offset[order], (-reach, reach))
    return np.asarray(order[max(first - 1, 0) : last + 1])
