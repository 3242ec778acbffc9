"""From a model's values to the current that a mission takes: depths of the layers, and how deep each column is good."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.grids import Grid
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.files import FieldFiles, Moments, Window
from missionplan.scenario.currents.vertical import SKIN, SLevels, depth_axis, good_down_to

BOTTOM = ("h", "depth", "bathymetry", "deptho")
SURFACE = ("zeta", "elev", "elevation", "ssh", "zos")


@dataclass(frozen=True)
class Layers:
    """What the layers of a field are read from.

    Attributes
    ----------
    files : FieldFiles
    moments : array of datetime64
    along : sequence of str
        Dimension of the layers; none where the field holds the surface alone.
    window : mapping of str to slice
        Part of each horizontal dimension.
    dims : sequence of str
        Horizontal dimensions of the columns.
    """

    files: FieldFiles
    moments: Moments
    along: Sequence[str]
    window: Window
    dims: Sequence[str]

    def read(self, columns: int) -> tuple[Array, Array]:
        """Depths of the layers, shape (d,) or (t, c, d), and to what depth each column is good, shape (c,) [m]."""
        if not self.along:
            return np.zeros(1), np.full(columns, SKIN)
        along = self.along[0]
        if self.files.named("Cs_r") and (along in ("s_rho", "sc_r") or self.files.named("s_rho")):
            bottom, surface = self._column_of_water()
            return SLevels.of(self.files, along).depths(bottom, surface), good_down_to(bottom + surface.max(axis=0))
        depth = depth_axis(self.files, along)
        if depth.ndim != 1 or depth.size != self.files.variable(along).size:
            raise self.files.problem(f"the depths along {along} are not one a layer")
        return depth, np.full(columns, np.nan)

    def _column_of_water(self) -> tuple[Array, Array]:
        """Depth of the bottom below the datum, shape (c,), and the surface's height above it, shape (t, c) [m]."""
        bottom = self.files.fixed(self.files.required("the depth of the bottom", *BOTTOM), self.window).ravel()
        name = self.files.named(*SURFACE)
        if name is None:
            return bottom, np.zeros((self.moments.size, bottom.size))
        surface = self.files.series(name, self.moments, self.window, self.dims).reshape(self.moments.size, -1)
        return bottom, np.nan_to_num(surface.astype(float))


def gridded(area: Area, layers: Layers, grid: Grid, velocity: NDArray[np.complex64]) -> GriddedCurrent:
    """Return the current.

    Parameters
    ----------
    area : Area
    layers : Layers
    grid : Grid
        c columns.
    velocity : array of complex, shape (t, d, c)
        Toward east and north; nan where there is no water [m/s].

    Raises
    ------
    InputError
        When nothing near the mission is water.
    """
    levels, bottom = layers.read(velocity.shape[2])
    return assembled(layers.files, area.seconds(layers.moments), grid, levels, velocity, bottom)


def assembled(
    files: FieldFiles, time: Array, grid: Grid, levels: Array, velocity: NDArray[np.complex64], bottom: Array
) -> GriddedCurrent:
    """Return the current of levels in either order; where `bottom` is nan it is that of the deepest value.

    Raises
    ------
    InputError
        When nothing near the mission is water.
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
    known: NDArray[np.bool_] = np.any(np.isfinite(values), axis=0)
    last = levels.size - 1 - np.argmax(known[:, ::-1], axis=1)
    below = levels[np.minimum(last + 1, levels.size - 1)]
    if levels.size == 1 and float(levels[0]) <= SKIN:
        return np.full(known.shape[0], SKIN)
    return np.asarray(np.maximum(good_down_to(levels[last]), below))
