"""Fields on meshes that are described by UGRID: SCHISM's, and those of other models."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.triangles import Indices
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.building import assembled, layer_depths
from missionplan.scenario.currents.files import FieldFiles, Moments, velocities
from missionplan.scenario.currents.unstructured import Mesh
from missionplan.scenario.currents.vertical import good_down_to

_X = ("horizontalVelX", "u", "mesh2d_ucx", "ucx")
_Y = ("horizontalVelY", "v", "mesh2d_ucy", "ucy")
_STANDARD_X = ("eastward_sea_water_velocity", "sea_water_x_velocity")
_STANDARD_Y = ("northward_sea_water_velocity", "sea_water_y_velocity")
_HEIGHTS = ("zCoordinates", "zcor")


def topology(files: FieldFiles) -> str | None:
    """Name of the variable that describes a two-dimensional mesh; None where there is none."""
    for dataset in files.datasets:
        for name in dataset.variables:
            attributes = dataset[name].attrs
            if attributes.get("cf_role") == "mesh_topology" and "face_node_connectivity" in attributes:
                return str(name)
    return None


def read_ugrid(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field on a mesh that is described by UGRID, with velocities at its nodes or its faces.

    Raises
    ------
    InputError
        When something is missing or impossible, or lies elsewhere.
    """
    described = topology(files)
    if described is None:
        raise files.problem("describes no mesh")
    attributes = files.variable(described).attrs
    x, y = str(attributes["node_coordinates"]).split()
    faces = _faces(files, str(attributes["face_node_connectivity"]))
    mesh = Mesh.of(files, area, (x, y), faces)
    names = (
        files.required("the velocity toward east", *_X, standard=_STANDARD_X),
        files.required("the velocity toward north", *_Y, standard=_STANDARD_Y),
    )
    node = str(files.variable(x).dims[0])
    moments, dims = area.kept(files.moments(names[0])), [str(dim) for dim in files.variable(names[0]).dims[1:]]
    at_nodes = node in dims
    columns = mesh.nodes if at_nodes else mesh.numbers
    across = node if at_nodes else next((dim for dim in dims if files.variable(names[0]).sizes[dim] == len(faces)), "")
    if across not in dims:
        raise files.problem(f"{names[0]} is neither at the nodes nor at the faces of its mesh")
    order = [*(dim for dim in dims if dim != across), across]
    parts = [files.series(name, moments, {}, order)[..., columns] for name in names]
    turning = mesh.turning if at_nodes else mesh.turning_of_faces
    velocity = velocities(files, names, (parts[0], parts[1])) * turning.astype(np.complex64)
    velocity = _dried(files, velocity.reshape(moments.size, -1, columns.size), moments, columns, at_nodes=at_nodes)
    grid = mesh.at_nodes() if at_nodes else mesh.at_faces(mesh.mean_over_faces(mesh.points))
    levels, bottom = _levels(files, order[:-1], moments, (mesh, columns), at_nodes=at_nodes)
    return assembled(files, area.seconds(moments), grid, levels, velocity, bottom)


def _faces(files: FieldFiles, name: str) -> Indices:
    """Nodes of each face, counted from 0, -1 where it has fewer than others."""
    first = int(files.variable(name).attrs.get("start_index", 0))
    found = files.fixed(name)
    kept = np.isfinite(found) & (found >= first) & (found < 1e9)
    return np.where(kept, np.nan_to_num(found) - first, -1).astype(np.intp)


def _dried(
    files: FieldFiles, velocity: NDArray[np.complex64], moments: Moments, columns: Indices, *, at_nodes: bool
) -> NDArray[np.complex64]:
    """Take the values of columns away that are dry for the moment."""
    name = files.named("dryFlagNode", "wetdry_node") if at_nodes else files.named("dryFlagElement", "wetdry_elem")
    if name is None:
        return velocity
    dims = [str(dim) for dim in files.variable(name).dims[1:]]
    dry = files.series(name, moments, {}, dims)[:, columns] > 0.5
    return np.where(dry[:, None, :], np.complex64(np.nan), velocity)


def _levels(
    files: FieldFiles, along: Sequence[str], moments: Moments, part: tuple[Mesh, Indices], *, at_nodes: bool
) -> tuple[Array, Array]:
    """Depths of the layers, shape (d,) or (t, c, d), and to what depth each column is good, shape (c,) [m]."""
    mesh, columns = part
    heights = files.named(*_HEIGHTS)
    if along and heights is not None and at_nodes:
        dims = [str(dim) for dim in files.variable(heights).dims[1:]]
        order = [*(dim for dim in dims if dim not in along), *along]
        height = files.series(heights, moments, {}, order)[:, columns].astype(float) * files.height_factor(heights, "m")
        depth = np.nanmax(height, axis=2, keepdims=True, initial=-np.inf) - height
        deepest = np.nanmax(depth, axis=(0, 2), initial=0.0)
        return _gapless(depth), good_down_to(deepest)

    def at(name: str) -> Array:
        dims = [str(dim) for dim in files.variable(name).dims[1:]]
        moving = files.has_times(name)
        values = files.series(name, moments, {}, dims).astype(float) if moving else files.fixed(name)
        return _at_columns(files, name, values, mesh, at_nodes=at_nodes)

    return layer_depths(files, along, at, moments.size, columns.size)


def _gapless(depth: Array) -> Array:
    """Levels below the bottom, which have no depth, at the depth of the one beside them."""
    count = depth.shape[2]
    known = np.isfinite(depth)
    if known.all():
        return depth
    steps = np.where(known, np.arange(count), count)
    first = np.minimum.accumulate(steps[:, :, ::-1], axis=2)[:, :, ::-1]
    filled = np.take_along_axis(depth, np.minimum(first, count - 1), axis=2)
    return np.nan_to_num(filled)


def _at_columns(files: FieldFiles, name: str, values: Array, mesh: Mesh, *, at_nodes: bool) -> Array:
    """Values at nodes or faces of the file as values at the columns of the field."""
    if values.shape[-1] == mesh.whole:
        part = values[..., mesh.nodes]
        return part if at_nodes else mesh.mean_over_faces(part)
    if at_nodes:
        raise files.problem(f"{name} is at the faces of its mesh, the velocity at the nodes")
    return values[..., mesh.numbers]
