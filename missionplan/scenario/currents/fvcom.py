"""Fields of FVCOM: sigma layers on triangles, velocities at their middles with a gradient in each."""

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.phases.fields.grids import Grid
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.building import assembled
from missionplan.scenario.currents.files import FieldFiles, Moments, velocities
from missionplan.scenario.currents.unstructured import Mesh
from missionplan.scenario.currents.vertical import SKIN, SURFACE, good_down_to


def read_fvcom(files: FieldFiles, area: Area) -> GriddedCurrent:
    """Read a field of FVCOM.

    The depth of a layer in a triangle is -sigma (h + zeta) by the means of its three nodes.

    Raises
    ------
    InputError
        When something is missing or impossible, or lies elsewhere.
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
        levels, bottom = _levels(files, mesh, moments)
    return assembled(files, area.seconds(moments), _grid(files, area, mesh), levels, velocity, bottom)


def _coordinates(files: FieldFiles, *names: str) -> tuple[str, str]:
    """Longitude and latitude, or x and y where these are missing or, as in a Cartesian run, all zero."""
    longitude, latitude, x, y = names
    if files.named(longitude) and (files.named(x) is None or np.any(files.fixed(longitude))):
        return longitude, latitude
    return files.required("the longitude of its nodes", longitude, x), files.required("the latitude", latitude, y)


def _levels(files: FieldFiles, mesh: Mesh, moments: Moments) -> tuple[Array, Array]:
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
