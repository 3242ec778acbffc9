"""Fields on unstructured meshes: FVCOM, SCHISM, and those that describe their mesh by UGRID."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.fields.grids import CellMesh, Grid, TriangleMesh, slopes_by_least_squares
from missionplan.phases.fields.triangles import Indices
from missionplan.scenario.currents.area import Area, Turning, outside_of
from missionplan.scenario.currents.files import FieldFiles


@dataclass(frozen=True)
class Mesh:
    """The part of a mesh that is read.

    Attributes
    ----------
    points : array, shape (2, p)
        Nodes [m].
    faces : array of int, shape (m, 3 or more)
        Nodes of each face, -1 where it has fewer.
    nodes, numbers : array of int, shapes (p,) and (m,)
        Which of the file's nodes and faces these are.
    turning : array of complex, shape (p,)
        Factor that turns velocities along the file's axes toward east and north.
    whole : int
        Nodes of the file.
    """

    points: Array
    faces: Indices
    nodes: Indices
    numbers: Indices
    turning: Turning
    whole: int

    @classmethod
    def of(cls, files: FieldFiles, area: Area, names: tuple[str, str], faces: Indices) -> "Mesh":
        """Cut the faces that touch the mission's box out of a mesh.

        Raises
        ------
        InputError
            When none does, or they name nodes that there are not.
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
        found, owners = [], []
        for corner in range(1, self.faces.shape[1] - 1):
            triangle = self.faces[:, [0, corner, corner + 1]]
            whole = np.flatnonzero((triangle >= 0).all(axis=1))
            found.append(triangle[whole])
            owners.append(whole)
        return np.concatenate(found), np.concatenate(owners)

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
        found = np.full((sides, count), -1)
        found[side[first], owner[first]] = owner[second]
        found[side[second], owner[second]] = owner[first]
        return found

    def at_nodes(self) -> Grid:
        """Grid of values at the nodes."""
        return TriangleMesh(self.points, self.triangles[0])

    def at_faces(self, middles: Array, slopes: Array | None = None, beside: Indices | None = None) -> Grid:
        """Grid of values at the middles of the faces.

        Parameters
        ----------
        middles : array, shape (2, m)
            [m]
        slopes, beside : array, optional
            See `CellMesh`; default: the faces beside each, and the gradient that fits them best.
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
