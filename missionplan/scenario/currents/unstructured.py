"""Fields on unstructured meshes: FVCOM, SCHISM, and those that describe their mesh by UGRID.

Fields of FVCOM: sigma layers on triangles, velocities at their middles with a gradient in each.

Fields on meshes that are described by UGRID: SCHISM's, and those of other models.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.grids import CellMesh, Grid, TriangleMesh
from missionplan.phases.lattice import Indices, slopes_by_least_squares
from missionplan.scenario.currents.area import Area, Turning, assembled, layer_depths, outside_of
from missionplan.scenario.currents.files import FieldFiles, Moments, standard_name, velocities
from missionplan.scenario.currents.vertical import SKIN, SURFACE, good_down_to


@dataclass(frozen=True)
class Mesh:
    """The part of a mesh that is read."""

    points: Array
    """Nodes, shape (2, p) [m]."""
    faces: Indices
    """Nodes of each face, -1 where it has fewer, shape (m, 3 or more)."""
    nodes: Indices
    numbers: Indices
    """Shapes (p,) and (m,). Which of the file's nodes and faces these are."""
    turning: Turning
    """Factor that turns velocities along the file's axes toward east and north, shape (p,)."""
    whole: int
    """Nodes of the file."""

    @classmethod
    def of(cls, files: FieldFiles, area: Area, names: tuple[str, str], faces: Indices) -> "Mesh":
        """Cut the faces that touch the mission's box out of a mesh.

        Raises InputError when none does, or they name nodes that there are not.
        """
        x, y = (files.fixed(name) for name in names)
        points, turning = area.placed(files, names, x, y)
        there = faces >= 0
        if faces.max(initial=-1) >= x.size or there.sum(axis=1).min(initial=3) < 3:
            raise files.problem("its faces name nodes that it does not have")
        if not np.isfinite(points).all():
            raise files.problem(f"{names[0]} or {names[1]} has gaps")
        touching = np.any(area.holds(points)[np.maximum(faces, 0)] & there, axis=1)
        if not touching.any():
            raise outside_of(files)
        kept = np.flatnonzero(touching)
        nodes = np.unique(faces[kept][there[kept]])
        new = np.full(x.size + 1, -1)
        new[nodes] = np.arange(nodes.size)
        return cls(points[:, nodes], new[faces[kept]], nodes, kept, turning[nodes], x.size)

    @property
    def triangles(self) -> tuple[Indices, Indices]:
        """Triangles of which the faces consist, four-sided ones of two, and the face of each."""
        triangles, owners = [], []
        for corner in range(1, self.faces.shape[1] - 1):
            triangle = self.faces[:, [0, corner, corner + 1]]
            whole = np.flatnonzero((triangle >= 0).all(axis=1))
            triangles.append(triangle[whole])
            owners.append(whole)
        return np.concatenate(triangles), np.concatenate(owners)

    @property
    def beside(self) -> Indices:
        """The faces beside each across its sides, in the order of the sides, -1 where there is none: (k, m)."""
        count, sides = self.faces.shape
        number = (self.faces >= 0).sum(axis=1)
        ends = np.where(np.arange(sides) + 1 < number[:, None], np.roll(self.faces, -1, axis=1), self.faces[:, :1])
        real = self.faces >= 0
        pairs = np.sort(np.stack((self.faces, ends), axis=2), axis=2)[real]
        owner, side = np.nonzero(real)
        order = np.lexsort((pairs[:, 0], pairs[:, 1]))
        same = np.all(pairs[order][1:] == pairs[order][:-1], axis=1)
        first, second = order[:-1][same], order[1:][same]
        neighbours = np.full((sides, count), -1)
        neighbours[side[first], owner[first]] = owner[second]
        neighbours[side[second], owner[second]] = owner[first]
        return neighbours

    def at_nodes(self) -> Grid:
        """Grid of values at the nodes."""
        return TriangleMesh(self.points, self.triangles[0])

    def at_faces(self, middles: Array, slopes: Array | None = None, beside: Indices | None = None) -> Grid:
        """Grid of values at the middles of the faces.

        `middles`, shape (2, m) [m]. `slopes`, `beside`: see `CellMesh`; default: the faces beside each, and the
        gradient that fits them best.
        """
        triangles, owners = self.triangles
        if slopes is None or beside is None:
            beside = self.beside
            if self.faces.shape[1] > 3:  # a triangle among four-sided faces has three beside it
                number = (self.faces >= 0).sum(axis=1)
                spare = np.arange(self.faces.shape[1])[:, None] >= number
                beside = np.where(spare & (beside[:1] >= 0), beside[:1], beside)
            slopes = slopes_by_least_squares(middles, beside)
        return CellMesh(middles, self.points, triangles, owners, beside, slopes)

    def mean_over_faces(self, values: Array) -> Array:
        """Mean over the nodes of each face, along the last axis."""
        there = self.faces >= 0
        return np.asarray((values[..., np.maximum(self.faces, 0)] * there).sum(axis=-1) / there.sum(axis=1))

    @property
    def turning_of_faces(self) -> Turning:
        """`turning` at the faces: that of their first nodes."""
        return self.turning[self.faces[:, 0]]


def read_fvcom(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field of FVCOM.

    The depth of a layer in a triangle is -sigma (h + zeta) by the means of its three nodes. Raises InputError when
    something is missing or impossible, or lies elsewhere.
    """
    faces = files.fixed(files.required("the triangles", "nv")).T.astype(np.intp) - 1
    if np.any(faces < 0) or faces.shape[1] != 3:
        raise files.problem("nv is not three nodes a triangle, counted from 1")
    names = _coordinates(files, "lon", "lat", "x", "y")
    mesh = Mesh.of(files, area, names, faces)
    moments = area.kept(files.moments("u"))
    order = [str(dim) for dim in files.variable("u").dims[1:]]
    span = slice(int(mesh.numbers[0]), int(mesh.numbers[-1]) + 1)
    window, picked = {order[-1]: span}, mesh.numbers - span.start
    u, v = (files.series(name, moments, window, order)[..., picked] for name in ("u", "v"))
    turning = mesh.turning_of_faces.astype(np.complex64)
    velocity = (velocities(files, ("u", "v"), (u, v)) * turning).reshape(moments.size, -1, picked.size)
    wet = files.named("wet_cells")
    if wet is not None:
        is_wet = files.series(wet, moments, window, order[-1:])[:, picked] > 0.5
        velocity = np.where(is_wet[:, None, :], velocity, np.complex64(np.nan))
    if len(order) == 1:
        levels, bottom = np.zeros(1), np.full(picked.size, SKIN)
    else:
        levels, bottom = _sigma_levels(files, mesh, moments)
    return assembled(files, area.seconds(moments), _grid(files, area, mesh), levels, velocity, bottom)


def _coordinates(files: FieldFiles, *names: str) -> tuple[str, str]:
    """Longitude and latitude, or x and y where these are missing or, as in a Cartesian run, all zero."""
    longitude, latitude, x, y = names
    if files.named(longitude) and (files.named(x) is None or np.any(files.fixed(longitude))):
        return longitude, latitude
    return files.required("the longitude of its nodes", longitude, x), files.required("the latitude", latitude, y)


def _sigma_levels(files: FieldFiles, mesh: Mesh, moments: Moments) -> tuple[Array, Array]:
    """Depths of the layers in each triangle, shape (t, c, d), and to what depth it is good, shape (c,) [m]."""
    sigma = files.fixed(files.required("the sigma layers", "siglay"))
    sigma = np.repeat(sigma[:, None], mesh.nodes.size, axis=1) if sigma.ndim == 1 else sigma[:, mesh.nodes]
    if np.any(sigma > 0.0) or np.any(sigma < -1.0):
        raise files.problem("siglay does not lie between -1 and 0")
    bottom = mesh.mean_over_faces(
        files.depths(files.required("the depth of the bottom", "h"), otherwise="m")[mesh.nodes]
    )
    name, surface = files.named(*SURFACE), np.zeros((moments.size, mesh.nodes.size))
    if name is not None:
        dims = [str(dim) for dim in files.variable(name).dims[1:]]
        surface = files.series(name, moments, {}, dims)[:, mesh.nodes].astype(float) * files.height_factor(name, "m")
    height = mesh.mean_over_faces(surface)
    layers = mesh.mean_over_faces(sigma).T
    return -(bottom + height)[:, :, None] * layers, good_down_to(bottom + height.max(axis=0))


def _grid(files: FieldFiles, area: Area, mesh: Mesh) -> Grid:
    """Middles of the triangles, with the gradients of the file where it has them."""
    if files.named("lonc") or files.named("xc"):
        names = _coordinates(files, "lonc", "latc", "xc", "yc")
        middles, _ = area.placed(files, names, *(files.fixed(name)[mesh.numbers] for name in names))
    else:
        middles = mesh.mean_over_faces(mesh.points)
    if not (files.named("a1u") and files.named("a2u") and files.named("nbe")):
        return mesh.at_faces(middles)
    slopes = np.stack([files.fixed(name)[:, mesh.numbers] for name in ("a1u", "a2u")])
    new = np.full(files.variable("nbe").shape[1] + 1, -1)
    new[mesh.numbers] = np.arange(mesh.numbers.size)
    beside = files.fixed("nbe").astype(np.intp)[:, mesh.numbers] - 1
    return mesh.at_faces(middles, slopes, np.where(beside >= 0, new[beside], -1))


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

    Raises InputError when something is missing or impossible, or lies elsewhere.
    """
    described = topology(files)
    if described is None:
        raise files.problem("describes no mesh")
    attributes = files.variable(described).attrs
    places = str(attributes["node_coordinates"]).split()
    x, y = sorted(places, key=lambda name: standard_name(files.variable(name)) == "latitude")
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
    levels, bottom = _ugrid_levels(files, order[:-1], moments, (mesh, columns), at_nodes=at_nodes)
    return assembled(files, area.seconds(moments), grid, levels, velocity, bottom)


def _faces(files: FieldFiles, name: str) -> Indices:
    """Nodes of each face, counted from 0, -1 where it has fewer than others."""
    first = int(files.variable(name).attrs.get("start_index", 0))
    nodes = files.fixed(name)
    kept = np.isfinite(nodes) & (nodes >= first) & (nodes < 1e9)
    return np.where(kept, np.nan_to_num(nodes) - first, -1).astype(np.intp)


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


def _ugrid_levels(
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

    def at(name: str, *along: str) -> Array:
        moving = files.has_times(name)
        dims = [str(dim) for dim in files.variable(name).dims[moving:]]
        order = [*along, *(dim for dim in dims if dim not in along)]
        if moving:
            values = files.series(name, moments, {}, order).astype(float)
        else:
            values = files.fixed(name).transpose([dims.index(dim) for dim in order])
        # values at nodes or faces of the file as values at the columns of the field
        if values.shape[-1] == mesh.whole:
            part = values[..., mesh.nodes]
            return part if at_nodes else mesh.mean_over_faces(part)
        if at_nodes:
            raise files.problem(f"{name} is at the faces of its mesh, the velocity at the nodes")
        return values[..., mesh.numbers]

    return layer_depths(files, along, at, moments.size, columns.size)


def _gapless(depth: Array) -> Array:
    """Levels below the bottom, which have no depth, at the depth of the one beside them."""
    count = depth.shape[2]
    is_finite = np.isfinite(depth)
    if is_finite.all():
        return depth
    steps = np.where(is_finite, np.arange(count), count)
    first = np.minimum.accumulate(steps[:, :, ::-1], axis=2)[:, :, ::-1]
    filled = np.take_along_axis(depth, np.minimum(first, count - 1), axis=2)
    return np.nan_to_num(filled)
