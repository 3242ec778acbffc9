"""Interpolation in the fields of ocean models the slow way, which imports nothing of the package: one point at a time.

Vertically in each column at each of the two times about the moment, then across, then in time; all of it linear.
"""

import numpy as np
from scipy.optimize import fsolve


def in_column(depths, values, depth):
    """Linear between levels, held above and below them."""
    order = np.argsort(depths)
    return np.interp(depth, np.asarray(depths)[order], np.asarray(values)[order])


def in_time(times, t, at):
    """Linear between the values `at(k)` of the two times about t."""
    after = int(np.clip(np.searchsorted(times, t), 1, len(times) - 1))
    share = (t - times[after - 1]) / (times[after] - times[after - 1])
    return (1.0 - share) * at(after - 1) + share * at(after)


def triangle_about(nodes, triangles, point):
    """Number of the triangle about a point and the shares of its corners; None where there is none."""
    corners = nodes[np.asarray(triangles)].transpose(0, 2, 1)
    matrix = np.concatenate((corners, np.ones((len(corners), 1, 3))), axis=1)
    shares = np.linalg.solve(matrix, np.broadcast_to(np.append(point, 1.0)[:, None], (len(corners), 3, 1)))[..., 0]
    number = int(np.argmax(shares.min(axis=1)))
    return (number, shares[number]) if shares[number].min() >= 0.0 else None


def quad_about(x, y, point):
    """Row and column of the four-sided cell about a point, and the place in it; None where there is none."""
    near = np.argsort(np.hypot(x - point[0], y - point[1]), axis=None)[:6]
    for row, column in zip(*np.unravel_index(near, x.shape), strict=True):
        for j, i in ((row, column), (row - 1, column), (row, column - 1), (row - 1, column - 1)):
            if not (0 <= j < x.shape[0] - 1 and 0 <= i < x.shape[1] - 1):
                continue

            def miss(place, j=j, i=i):
                a, b = place
                weights = ((1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b)
                cells = ((j, i), (j, i + 1), (j + 1, i), (j + 1, i + 1))
                return [
                    sum(w * z[c] for w, c in zip(weights, cells, strict=True)) - p
                    for z, p in ((x, point[0]), (y, point[1]))
                ]

            place, _, solved, _ = fsolve(miss, (0.5, 0.5), full_output=True)
            if solved == 1 and place.min() >= -1e-9 and place.max() <= 1.0 + 1e-9:
                return j, i, place
    return None


def rho_points(u, v, angle):
    """East and north at the inner nodes from staggered u and v of one level: means of the faces, turned; nan is no flow."""
    u, v = np.nan_to_num(u), np.nan_to_num(v)
    rows, columns = angle.shape
    east, north = np.full(angle.shape, np.nan), np.full(angle.shape, np.nan)
    for j in range(1, rows - 1):
        for i in range(1, columns - 1):
            along, up = 0.5 * (u[j, i - 1] + u[j, i]), 0.5 * (v[j - 1, i] + v[j, i])
            east[j, i] = along * np.cos(angle[j, i]) - up * np.sin(angle[j, i])
            north[j, i] = along * np.sin(angle[j, i]) + up * np.cos(angle[j, i])
    return east, north


def s_level_depths(s, stretching, critical, transform, bottom, surface):
    """Depths below the surface of ROMS's levels in one column, by the formulas of the manual (z up from the datum)."""
    depths = []
    for level, stretched in zip(s, stretching, strict=True):
        if transform == 1:
            unmoved = critical * level + (bottom - critical) * stretched
            z = unmoved + surface * (1.0 + unmoved / bottom)
        else:
            unmoved = (critical * level + bottom * stretched) / (critical + bottom)
            z = surface + (surface + bottom) * unmoved
        depths.append(surface - z)
    return np.array(depths)
