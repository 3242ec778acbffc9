"""What part of a field a mission needs: its box with a margin, from its start on; and where things are in its plane.

From a model's values to the current that a mission takes: depths of the layers, and how deep each column is good.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError
from missionplan.mission.schema.place import Geographic, to_plane
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.grids import Grid
from missionplan.scenario.currents.attributes import is_degrees
from missionplan.scenario.currents.files import FieldFiles, Moments, Window
from missionplan.scenario.currents.vertical import SKIN, At, good_down_to, level_depths

Turning = NDArray[np.complex128]
"""Factor that turns velocities, complex, from a field's axes toward east and north."""
MARGIN = 20_000.0
"""Of a field, what is this far beyond the mission's places is read, or farther where these are farther apart [m]."""
LOCAL = "local"
"""Projection of a field whose coordinates are metres from the site's origin."""


@dataclass(frozen=True)
class Area:
    """Place and time of a mission."""

    origin: Geographic
    """Of the plane."""
    start: np.datetime64
    """Of the mission, UTC."""
    places: Array
    """Of the mission, shape (2, k) [m]."""
    projection: str | None = None
    """Of coordinates in metres: ``EPSG:32610``, or `LOCAL`."""

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """South-west and north-east corner of what is read, shape (2,) each [m]."""
        places = self.places if self.places.size else np.zeros((2, 1))
        low, high = places.min(axis=1), places.max(axis=1)
        margin = max(MARGIN, float(np.hypot(*(high - low))))
        return low - margin, high + margin

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Whether points, shape (2, ...), are in the box."""
        low, high = (corner.reshape(2, *(1,) * (points.ndim - 1)) for corner in self.box)
        return np.asarray(np.all((low <= points) & (points <= high), axis=0))

    def seconds(self, moments: Moments) -> Array:
        """Times since the mission's start [s]."""
        return np.asarray((moments - self.start) / np.timedelta64(1, "s"), dtype=float)

    def kept(self, moments: Moments) -> Moments:
        """Times of a field that matter: from the last before the mission's start on."""
        before = int(np.searchsorted(moments, self.start, side="right")) - 1
        return moments[max(min(before, moments.size - 1), 0) :]

    def placed(self, files: FieldFiles, names: tuple[str, str], x: Array, y: Array) -> tuple[Array, Turning]:
        """Place points of a field in the plane.

        Raises InputError when the coordinates are of a projection that nobody names, or of none.

        `names`: of the variables that hold x and y. `x`, `y`: longitude and latitude [deg], or a projection's [m].

        Returns
        -------
        points, turning : array of shape (2, ...), array of complex
            East and north of the origin [m]; the factor that turns velocities along x and y toward east and north.
        """
        if in_degrees(files, names, x, y):
            # about the origin's meridian, so that neither the date line nor the convention of the file matters
            east = (np.radians(x) - self.origin.longitude + np.pi) % (2.0 * np.pi) - np.pi
            return np.stack(to_plane(np.radians(y), self.origin.longitude + east, self.origin)), np.ones(
                x.shape, dtype=complex
            )
        if self.projection is None:
            hint = "site.current.projection: EPSG:… names it; `local` places them from the site's origin"
            raise files.problem(f"{names[0]} and {names[1]} are in metres of a projection that the file lacks", hint)
        x, y = (axis * files.height_factor(name, otherwise="m") for name, axis in zip(names, (x, y), strict=True))
        if self.projection == LOCAL:
            return np.stack((x, y)), np.ones(x.shape, dtype=complex)
        from pyproj import Transformer
        from pyproj.exceptions import ProjError

        try:
            to_degrees = Transformer.from_crs(self.projection, "EPSG:4326", always_xy=True)
        except ProjError as error:
            raise files.problem(f"site.current.projection: {str(error).partition(':')[0]}") from None
        longitude, latitude = np.radians(to_degrees.transform(x, y))
        ahead = np.radians(to_degrees.transform(x + 10.0, y))
        if not (np.isfinite(longitude) & np.isfinite(ahead[0])).all():
            raise files.problem(f"its coordinates are not of {self.projection}")
        along = (ahead[0] - longitude) * np.cos(latitude) + 1j * (ahead[1] - latitude)
        return np.stack(to_plane(latitude, longitude, self.origin)), along / np.abs(along)


def in_degrees(files: FieldFiles, names: tuple[str, str], x: Array, y: Array) -> bool:
    """Whether coordinates are longitudes and latitudes, by what the file says of them, else by their sizes."""
    said = [is_degrees(files.variable(name), east=not number) for number, name in enumerate(names)]
    if True in said and False in said:
        raise files.problem(f"of {names[0]} and {names[1]} one is in degrees, the other is not")
    if True in said or False in said:
        return True in said
    return bool(np.nanmax(np.abs(y)) <= 90.0 and np.nanmax(np.abs(x)) <= 360.0)


def window_of(inside: NDArray[np.bool_], files: FieldFiles, ring: int = 1) -> tuple[slice, ...]:
    """Rows and columns of a grid that hold what is inside the box, with a ring of nodes beyond.

    Raises InputError when nothing is.
    """
    if not inside.any():
        raise outside_of(files)
    spans = []
    for axis in range(inside.ndim):
        there = np.flatnonzero(inside.any(axis=tuple(other for other in range(inside.ndim) if other != axis)))
        spans.append(slice(max(int(there[0]) - ring, 0), int(there[-1]) + 1 + ring))
    return tuple(spans)


def outside_of(files: FieldFiles) -> InputError:
    """Return the error of a field that lies elsewhere."""
    return files.problem("holds nothing within 20 km of the mission", "is site.origin right?")


def at_columns(
    files: FieldFiles,
    moments: Moments,
    window: Window,
    dims: Sequence[str],
    picked: tuple[Array, Array] | tuple[()] = (),
) -> At:
    """Return what reads a variable at the columns of a grid of rows and columns.

    `window`: part of each horizontal dimension. `dims`: horizontal dimensions of the columns. `picked`: rows and
    columns of that part; default: all.
    """

    def read(name: str, *along: str) -> Array:
        order, wanted = [str(dim) for dim in files.variable(name).dims], (*along, *dims)
        if set(wanted) > set(order) or len(order) > len(wanted) + files.has_times(name):
            raise files.problem(f"{name} has the dimensions {', '.join(order)}; expected {', '.join(wanted)}")
        if files.has_times(name):
            values = files.series(name, moments, window, wanted).astype(float)
        else:
            values = files.fixed(name, window).transpose([order.index(dim) for dim in wanted])
        values = values[(..., *picked)]
        return values.reshape(*values.shape[:-2], -1)

    return read


def layer_depths(files: FieldFiles, along: Sequence[str], at: At, times: int, columns: int) -> tuple[Array, Array]:
    """Depths of the layers, shape (d,) or (t, c, d), and to what depth each column is good, shape (c,) [m].

    Raises what `vertical.level_depths` does.

    `along` has the dimensions of the layers; none where the field holds the surface alone.
    """
    along = [dim for dim in along if files.size(dim) > 1] or list(along[:1])  # one run of a forecast is no axis
    if len(along) > 1:
        raise files.problem(f"cannot tell which of {', '.join(along)} is the depth")
    levels, bottom = level_depths(files, along[0], at, times) if along else (files.one_depth(), None)
    if bottom is not None:
        return levels, bottom
    alone = levels.size == 1 and float(levels[0]) <= SKIN
    return levels, np.full(columns, SKIN if alone else np.nan)


def assembled(
    files: FieldFiles, time: Array, grid: Grid, levels: Array, velocity: NDArray[np.complex64], bottom: Array
) -> GriddedCurrent:
    """Return the current of levels in either order; where `bottom` is nan it is that of the deepest value.

    Raises InputError when nothing near the mission is water.
    """
    values = np.ascontiguousarray(velocity.transpose(0, 2, 1))
    if levels.shape[-1] > 1 and float(np.nanmean(levels[..., 0])) > float(np.nanmean(levels[..., -1])):
        levels, values = np.ascontiguousarray(levels[..., ::-1]), np.ascontiguousarray(values[..., ::-1])
    if np.isnan(bottom).any():
        bottom = np.where(np.isnan(bottom), _deepest(levels, values), bottom)
    try:
        return GriddedCurrent.of(time, grid, levels, values, bottom)
    except InputError as error:
        raise files.problem(str(error)) from None


def _deepest(levels: Array, values: NDArray[np.complex64]) -> Array:
    """Depth to which columns are good that have values down to some of the fixed levels [m].

    The bottom lies between the deepest level with a value and the next one.
    """
    is_finite: NDArray[np.bool_] = np.any(np.isfinite(values), axis=0)
    last = levels.shape[-1] - 1 - np.argmax(is_finite[:, ::-1], axis=1)
    if levels.size == 1 and float(levels[0]) <= SKIN:
        return np.full(is_finite.shape[0], SKIN)
    column = np.broadcast_to(levels if levels.ndim == 1 else levels.max(axis=0), is_finite.shape)
    deepest, below = (
        np.take_along_axis(column, np.minimum(last + more, column.shape[1] - 1)[:, None], axis=1)[:, 0]
        for more in (0, 1)
    )
    return np.asarray(np.maximum(good_down_to(deepest), below))
